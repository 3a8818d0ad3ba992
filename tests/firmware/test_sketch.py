"""Sketches and firmware, built as by the Arduino IDE, give forces at the pins like the Python law's."""

import itertools
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.devices import profiles, virtual_board
from hapkit_studio.dynamics.estimators import estimate_velocity
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.laws.machine import ARENA
from hapkit_studio.parameters import Choice
from hapkit_studio.protocol.messages import MotorMap
from hapkit_studio.workshop import own, reading, sketch, source
from tests.firmware.board_runs import program, render
from tests.firmware.test_firmware import FREE, SKETCH, stack_counted
from tests.firmware.vb import QUANTUM, duty_step, opened, run
from tests.laws import clock_law, table_law
from tests.wide import wide

ARDUINO = Path("/usr/share/arduino/hardware/arduino/avr")
CORE, VARIANT = ARDUINO / "cores" / "arduino", ARDUINO / "variants" / "standard"
needs_ide = pytest.mark.skipif(
    not (virtual_board.built() and shutil.which("avr-g++") and CORE.is_dir()),
    reason="no virtual board, no avr-gcc or no Arduino core",
)

_BOARD = ("=10819", "_AVR_UNO", "_ARCH_AVR")
_CHIP = ["-mmcu=atmega328p", "-DF_CPU=16000000L", *(f"-DARDUINO{name}" for name in _BOARD)]
# these are the options of the core's platform.txt
_COMMON = ["-c", "-Os", "-ffunction-sections", "-fdata-sections", "-flto", f"-I{CORE}", f"-I{VARIANT}"]
_CXX = ["-std=gnu++11", "-fpermissive", "-fno-exceptions", "-fno-threadsafe-statics"]
_LANGUAGES = {
    ".c": ["avr-gcc", "-std=gnu11", "-fno-fat-lto-objects"],
    ".S": ["avr-gcc", "-x", "assembler-with-cpp"],
    ".cpp": ["avr-g++", *_CXX],
    ".ino": ["avr-g++", *_CXX, "-x", "c++", "-include", "Arduino.h"],
}
_STRICT = ["-Wall", "-Wextra", "-Werror"]
FADE = 0.5  # duration in s of a sketch's fade-in


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """Return the Arduino core, which is compiled once."""
    folder = tmp_path_factory.mktemp("core")
    # avr-libc 2.0 hides this macro from C++ before 2011
    options = ["-w", "-DDECIMAL_DIG=9"]
    made = [_compiled(s, folder, options) for s in sorted([*CORE.glob("*.c"), *CORE.glob("*.cpp")])]
    archive = folder / "core.a"
    subprocess.run(["avr-gcc-ar", "rcs", archive, *made], check=True)
    return archive


def build(text: str, archive: Path, folder: Path) -> Path:
    """Compile a sketch with warnings as errors; return its .elf."""
    ino = folder / "sketch.ino"
    ino.write_text(text, encoding="utf-8")
    return linked([ino], archive, folder)


def linked(sources: Sequence[Path], archive: Path, folder: Path) -> Path:
    """Compile sources with warnings as errors; return their .elf."""
    elf, objects = folder / "sketch.elf", [_compiled(source, folder, _STRICT) for source in sources]
    options = ["-w", "-Os", "-flto", "-fuse-linker-plugin", "-Wl,--gc-sections"]
    subprocess.run(["avr-gcc", *options, *_CHIP, "-o", elf, *objects, archive, "-lm"], check=True)
    return elf


def _compiled(source: Path, folder: Path, options: Sequence[str]) -> Path:
    made = folder / f"{source.name}.o"
    subprocess.run([*_LANGUAGES[source.suffix], *_COMMON, *_CHIP, *options, "-o", made, source], check=True)
    return made


def rendered(elf: Path, folder: Path, script: tuple[str, ...], seconds: float, *options: str) -> np.ndarray:
    """Return the truth log of a sketch, with one row per tick."""
    outcome = run(elf, folder, "--seconds", str(seconds), *options, script=script)
    assert (outcome.code, outcome.errors) == (0, "")
    return outcome.truth[1:]  # the first row is dropped, because setup() also reads the sensor


def asked(environment: Environment, values, position: np.ndarray, rate: float, spec) -> np.ndarray:
    """Return the forces of the Python law, with the sketch's fade-in and limit."""
    velocity = estimate_velocity(position, rate, spec, QUANTUM)
    law = environment.force.compiled()
    state, fault = own.law_memory(law)
    p = np.array([values[q.key] for q in environment.parameters] + [0.0])
    force = np.empty(len(position))
    assert own.call_law(law.address, p, state, position, velocity, 1.0 / rate, fault, force) == own.NO_FAULT
    fade = np.minimum(np.arange(len(force)) / rate / FADE, 1.0)
    return np.clip(force * fade, -3.0, 3.0)


ARITHMETIC = 2e-3  # difference in N between single and double precision
SWEEP = ("0.1 position 0.012 0.1", "0.25 position -0.03 0.2", "0.47 position 0.02 0.2")
SECONDS = 0.7
# laws with state, with branches, with other rates and estimators; then the most expensive ones
FEW = (
    ("cat", {}, ()),
    ("friction", {"model": "lugre"}, ()),
    ("wall", {"stiffness": 400.0, "damping": 3.0, "side": "left", "damping_mode": "both"}, ()),
    ("damping", {"damping": 6.0}, (2000, "difference")),
    ("damping", {"damping": 6.0}, (500, ("iir", {"cutoff": 20.0}))),
)
MORE = (
    ("mass_spring_damper", {"integrator": "exact"}, ()),
    ("puck", {"integrator": "trapezoid"}, ()),
    ("bump_valley", {"law": "height"}, ()),
    *((key, {}, ()) for key in environments.discover() if key not in ("free", "cat")),
)
OWN = '''"""A ramp."""
from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter


@law(state={"far": 0.0})
def force(p, s, x, v, dt):
    if x > s.far:
        s.far = x
    return -p.slope * (x + s.far) - 2.0 * v


ENVIRONMENT = Environment(
    key="ramp", title="Ramp", summary="Remembers", force=force,
    parameters=(Parameter("slope", "Slope", "N/m", default=40.0, low=0.0, high=100.0),),
)
'''


def compare(environment, values, archive, folder, rate=None, spec="kalman"):
    """Compare the force in effect at each reading with the Python law's force for the reading before it."""
    text = sketch.text(environment, values, None, rate, spec)
    rate = rate or sketch.usual_rate(environment, values)
    truth = rendered(build(text, archive, folder), folder, SWEEP, SECONDS)
    # the number of rows shows that no tick was skipped
    assert len(truth) == pytest.approx(SECONDS * rate, abs=2)
    steps = np.diff(truth.converter)
    steps -= 921 * np.round(steps / 921)
    position = QUANTUM * np.concatenate([[0.0], np.cumsum(steps)])
    # the sketch counts the jumps of the sensor's signal, so its position follows the true position
    assert np.ptp(position - truth.position) <= 1.01 * QUANTUM
    wanted = asked(environment, values, position, rate, spec)
    assert np.abs(wanted).max() > 0.2
    error = np.abs(truth.motor_force[1:] - wanted[:-1])
    assert np.all(error <= duty_step(truth.duty[1:]) + ARITHMETIC)


@pytest.mark.slow
@needs_ide
@pytest.mark.parametrize(("key", "given", "how"), wide(FEW + MORE, lambda *case: case in FEW))
def test_a_sketch_renders_the_law_with_its_values_rate_and_estimator(key, given, how, archive, tmp_path):
    environment = environments.named(key)
    compare(environment, environment.values(given), archive, tmp_path, *how)


def written(folder, text):
    """Return the environment of a file with this text in a user's folder."""
    return reading.load_source(source.typed(folder / "ramp.py", text))


@pytest.mark.slow
@needs_ide
@pytest.mark.parametrize("text", [table_law.TEXT, clock_law.TEXT], ids=["tables", "clock"])
def test_a_sketch_renders_its_tables_and_its_clock(text, archive, tmp_path):
    environment = written(tmp_path, text)
    compare(environment, environment.values(), archive, tmp_path)


EVERY_MS = ("--log-period", "0.001")
HELD = 0.016
STIFFNESS = 90.0
HOLD = ("0.02 position 0.016 0.3",)
LAST = 0.8


def held(kit, archive, folder, *options, script=HOLD):
    """Return the duty at the end of a sketch's run in which the handle is held against a spring."""
    text = sketch.text(environments.named("spring"), {"stiffness": STIFFNESS, "damping": 0.0}, kit)
    elf = build(text, archive, folder)
    return rendered(elf, folder, script, LAST, *EVERY_MS, *options)[-1].duty


def expected(board, at=HELD, power=0.5):
    """Return the duty by the kit's numbers.

    The torque is force * handle radius * pulley radius / sector radius, and the duty is
    (torque / full torque) ^ power.
    """
    torque = STIFFNESS * at * board.handle_radius * board.pulley_radius / board.sector_radius
    return -255.0 * (torque / board.motor_constant) ** power


@pytest.mark.slow
@needs_ide
@pytest.mark.parametrize(
    ("key", "options"),
    [
        ("hapkit3", ()),
        ("hapkit2013", ("--pins", "3")),
        ("hapkit-hall", ("--sensor", "as5048a")),
        ("hapkit-encoder", ("--sensor", "quadrature")),
    ],
)
def test_every_kit_pushes_with_its_own_numbers(key, options, archive, tmp_path):
    board = profiles.named(key).board
    for name in ("handle", "pulley", "sector"):
        options += (f"--{name}-radius", str(getattr(board, f"{name}_radius")))
    power = 1.0 if board.motor_map == MotorMap.LINEAR else 0.5
    duty = held(sketch.Kit(board), archive, tmp_path, *options)
    a_count = abs(expected(board, HELD + board.quantum, power) - expected(board, HELD, power))
    assert duty == pytest.approx(expected(board, HELD, power), abs=1.0 + a_count)


@pytest.mark.slow
@needs_ide
def test_the_table_of_a_measured_motor_is_inverted(archive, tmp_path):
    board = replace(
        profiles.default().board,
        motor_map=MotorMap.TABLE,
        table=(0, 10, 30, 60, 100, 150, 200, 255),
        dead_band=20,
    )
    share = expected(board, power=1.0) / -255.0 * 255.0
    duty = np.interp(share, (0, *board.table), np.linspace(20.0, 255.0, 9))
    assert held(sketch.Kit(board), archive, tmp_path) == pytest.approx(-duty, abs=1.0)


@pytest.mark.slow
@needs_ide
def test_a_calibrated_kit_keeps_its_zero_and_its_directions(archive, tmp_path):
    # counts and motor are reversed; the board starts 4 mm to the left of its zero
    board = replace(profiles.default().board, zero=51 + 300 + 2 * 921, sense=-1, direction=-1)
    options = ("--sensor-sign", "-1", "--direction", "-1", "--position", "-0.004")
    duty = held(sketch.Kit(board, calibrated=True), archive, tmp_path, *options)
    assert duty == pytest.approx(expected(board), abs=1.5)
    started_here = held(sketch.Kit(board), archive, tmp_path, *options)
    assert started_here == pytest.approx(expected(board, HELD + 0.004), abs=1.5)


@needs_ide
def test_a_non_finite_force_and_over_speed_switch_the_motor_off(archive, tmp_path):
    broken = written(tmp_path, OWN.replace("* (x + s.far)", "* (1.0 / (x - x))"))
    elf = build(sketch.text(broken, broken.values()), archive, tmp_path)
    assert not rendered(elf, tmp_path, SWEEP, 0.3).duty.any()
    elf = build(sketch.text(environments.named("spring"), {}, estimator="difference"), archive, tmp_path)
    fast = ("0.4 position 0.02 0.1", "0.7 position -0.02 0.01")
    truth = rendered(elf, tmp_path, fast, 0.9)
    assert truth.duty[truth.time < 0.69].any()
    assert not truth.duty[truth.time > 0.712].any()


# --- tests that need no board
@pytest.mark.parametrize("key", environments.discover())
def test_a_sketch_contains_the_values_and_is_self_contained(key):
    environment = environments.named(key)
    text = sketch.text(environment, environment.values())
    for parameter in environment.parameters:
        chosen = isinstance(parameter, Choice) and parameter.key != "picture"
        assert parameter.label in text or not (chosen or f"p.{parameter.key}" in text)
    assert text.count("#include") == 1
    assert text.startswith("//")
    assert "// Name:\n// Date:\n" in text
    assert "p[" not in text
    assert "·" not in text  # plain ASCII, so that any text editor can show it
    assert max(map(len, text.split("\n"))) <= 110
    assert sketch.text(environment, {}) == text


@pytest.mark.parametrize(
    ("how", "text"),
    [
        ({"rate": 4000}, "250, 500, 1,000, 2,000 Hz, not 4,000 Hz"),
        ({"prints": 51}, "between 0 and 50 lines a second, not 51"),
        ({"estimator": "foaw"}, "one of difference, iir, kalman, not foaw"),
        ({"values": {"stiffness": 9e9}}, "N/m"),
    ],
)
def test_unsupported_sketch_options_are_rejected(how, text):
    with pytest.raises(ParameterError, match=text):
        sketch.text(environments.named("wall"), **({"values": {}} | how))


def test_a_sketch_is_in_a_folder_of_its_name(tmp_path):
    for wanted in ("wall", "wall.ino", "wall/wall", "wall/wall.ino"):
        assert sketch.sketch_path(tmp_path / wanted) == tmp_path / "wall" / "wall.ino"
    made = sketch.write_sketch(tmp_path / "wall", "text")
    with pytest.raises(ParameterError, match="exists already"):
        sketch.write_sketch(tmp_path / "wall", "other")
    assert made.read_text() == "text"
    sketch.write_sketch(tmp_path / "wall", "other", over=True)
    assert made.read_text() == "other"


@pytest.mark.parametrize("name", ["my wall", "-x", "wände", "x" * 64, "wall.txt", "wall.ino.bak", "wall.cpp"])
def test_a_name_that_the_ide_rejects_and_other_suffixes_are_refused(name, tmp_path):
    with pytest.raises(ParameterError, match=r"A sketch's name|ends in \.ino, or has no ending"):
        sketch.write_sketch(tmp_path / name, "text")
    assert not list(tmp_path.iterdir())


@needs_ide
def test_user_text_cannot_leave_its_comment(archive, tmp_path):
    nasty = OWN.replace('"Ramp"', r'"Ramp \\\n#error"').replace('"Remembers"', r'"a \\\n#error b\\"')
    nasty = nasty.replace('"Slope"', r'"Slope\n#error \\"')
    environment = written(tmp_path, nasty)
    assert "\n" in environment.title
    kit = sketch.Kit(replace(profiles.default().board, label="a\n#error\\"))
    build(sketch.text(environment, {}, kit), archive, tmp_path)


def choices(environment):
    """Return every combination of an environment's choices, except the choice of its drawing."""
    asked = [p for p in environment.parameters if isinstance(p, Choice) and p.key != "picture"]
    return [
        {p.key: o for p, o in zip(asked, options, strict=True)}
        for options in itertools.product(*(p.options for p in asked))
    ]


LINES = {"exact": 500}  # this sketch is longer than others, because it locates events


@pytest.mark.slow
@needs_ide
@pytest.mark.parametrize("key", wide(environments.discover(), lambda key: key in ("wall", "detents")))
def test_every_choice_gives_a_short_sketch_without_a_warning(key, archive, tmp_path):
    environment = environments.named(key)
    for given in choices(environment):
        text = sketch.text(environment, environment.values(given))
        assert text.count("\n") < LINES.get(given.get("integrator", ""), 350), given
        assert max(map(len, text.split("\n"))) <= 110
        build(text, archive, tmp_path)


ENDLESS = """    n = 0.0
    if x > 0.01:
        for i in range(10000):
            n += math.sin(i * x)
    return n - 40.0 * x
"""


@needs_ide
def test_an_endless_law_is_ended_by_the_watchdog(archive, tmp_path):
    text = OWN[: OWN.index("    if x > s.far")] + ENDLESS + OWN[OWN.index("\n\nENVIRONMENT") :]
    environment = written(tmp_path, text.replace('"""A ramp."""', "import math"))
    elf = build(sketch.text(environment, {}), archive, tmp_path)
    log = rendered(elf, tmp_path, ("0.1 position 0.008 0.1", "0.3 position 0.02 0.05"), 0.7, *EVERY_MS)
    assert log.duty[(log.time > 0.2) & (log.time < 0.3)].all()
    assert not log.duty[log.time > 0.42].any()


# --- the studio's firmware
FLASH, RAM = 24000, 2048
AT_ZERO = ("--magnet", str(921 - 51))
"""Options that place the magnet so that the sensor flips at the handle's zero."""
WALL_STIFFNESS, WALL = 400.0, 0.004
BOTH_SIDES = [f"{k * 0.1:.1f} position {0.009 if k % 2 else -0.01} 0.08" for k in range(200)]
"""A script that moves the handle to both sides of the wall within every 0.25 s."""
FADED = 0.05


@pytest.fixture(scope="module")
def elf(archive, tmp_path_factory):
    """Return the studio's firmware as the IDE builds it, without the Makefile."""
    sources = [path for path in sorted(SKETCH.iterdir()) if path.suffix in _LANGUAGES]
    return linked(sources, archive, tmp_path_factory.mktemp("ide"))


@needs_ide
@pytest.mark.slow
def test_the_firmware_fits_the_chip(elf):
    output = subprocess.run(["avr-size", "-A", elf], capture_output=True, text=True, check=True).stdout
    size = {line.split()[0]: int(line.split()[1]) for line in output.splitlines() if line.startswith(".")}
    assert 10_000 < size[".text"] + size[".data"] <= FLASH
    assert ARENA < size[".data"] + size[".bss"] + size[".noinit"] <= RAM - stack_counted() - FREE


@pytest.mark.slow
@needs_ide
def test_the_firmware_sends_hello_and_every_sample(elf):
    with opened(firmware=elf) as board:
        assert board.hello.build == "arduino-ide"
        assert board.hello.arena == ARENA


@pytest.mark.slow
@needs_ide
def test_the_firmwares_wall_has_its_stiffness(elf, tmp_path):
    """The wall has 400 N/m from 4 mm on, and no force before; each force is that of the previous reading."""
    values = environments.named("wall").values({"stiffness": WALL_STIFFNESS, "position": WALL})
    law = program(environments.named("wall"), values, 4000, ARENA)
    run = render(tmp_path, law, 4000, 0.45, BOTH_SIDES, options=AT_ZERO, firmware=elf)
    began, ended = (run.telemetry[k].time_us * 1e-6 for k in (0, -1))
    rows = run.truth[(run.truth.time > began + FADED) & (run.truth.time < ended)]
    wanted = np.minimum(0.0, -WALL_STIFFNESS * (rows.position - WALL))[:-1]
    error = np.abs(rows.motor_force[1:] - wanted)
    assert wanted.min() < -1.9
    assert np.mean(wanted == 0.0) > 0.3
    assert np.all(error <= duty_step(rows.duty[1:]) + 1.01 * WALL_STIFFNESS * QUANTUM)
    assert run.skipped == 0
