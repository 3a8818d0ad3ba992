"""Exported sketches, built as the Arduino IDE does: what the pins render against the Python law."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.devices import profiles
from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import Choice
from hapkit_studio.protocol.messages import MotorMap
from hapkit_studio.workshop import reading, sketch, source
from tests.firmware import sketches
from tests.firmware.sketches import needs_ide
from tests.firmware.vb import QUANTUM
from tests.wide import wide

ARITHMETIC = 2e-3
"""N between single and double precision."""
SWEEP = ("0.1 position 0.012 0.1", "0.25 position -0.03 0.2", "0.47 position 0.02 0.2")
SECONDS = 0.7
# the ones with most arithmetic, and one of each kind of branch
OPTIONS = (
    ("mass_spring_damper", {"integrator": "exact"}),
    ("puck", {"integrator": "trapezoid"}),
    ("friction", {"model": "lugre"}),
    ("bump_valley", {"law": "height"}),
    ("wall", {"stiffness": 400.0, "damping": 3.0, "side": "left", "damping_mode": "both"}),
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


def compare(found, wanted):
    """Hold the force in effect at each reading against what the reading before asked for."""
    error = np.abs(found.motor_force[1:] - wanted[:-1])
    assert np.abs(wanted).max() > 0.3
    assert np.all(error <= sketches.pwm_step(found.duty[1:]) + ARITHMETIC)


def check(environment, values, archive, folder, rate=None, spec="kalman"):
    text = sketch.text(environment, values, None, rate, spec)
    rate = rate or sketch.usual_rate(environment, values)
    truth = sketches.rendered(sketches.build(text, archive, folder), folder, SWEEP, SECONDS)
    assert len(truth) == pytest.approx(SECONDS * rate, abs=2)  # no tick was left out
    position = sketches.positions(truth)
    assert np.ptp(position - truth.position) <= 1.01 * QUANTUM  # flips are counted
    return truth, sketches.asked(environment, values, position, rate, spec)


@needs_ide
@pytest.mark.parametrize("key", [k for k in environments.discover() if k != "free"])
def test_a_sketch_renders_the_law(key, archive, tmp_path):
    environment = environments.named(key)
    compare(*check(environment, environment.values(), archive, tmp_path))


@needs_ide
@pytest.mark.parametrize(("key", "given"), OPTIONS, ids=[key for key, _ in OPTIONS])
def test_it_renders_what_was_tuned(key, given, archive, tmp_path):
    environment = environments.named(key)
    compare(*check(environment, environment.values(given), archive, tmp_path))


def own(folder, text):
    """Return the environment that a person wrote."""
    return reading.load_source(source.typed(folder / "ramp.py", text))


@needs_ide
def test_a_persons_own_law_with_memory_is_rendered(archive, tmp_path):
    environment = own(tmp_path, OWN)
    compare(*check(environment, {"slope": 55.0}, archive, tmp_path))


@needs_ide
@pytest.mark.parametrize(("rate", "spec"), [(2000, "difference"), (500, ("iir", {"cutoff": 20.0}))])
def test_rate_and_velocity_are_as_chosen(rate, spec, archive, tmp_path):
    environment = environments.named("damping")
    compare(*check(environment, environment.values({"damping": 6.0}), archive, tmp_path, rate, spec))


EVERY_MS = ("--log-period", "0.001")
HELD = 0.016
STIFFNESS = 90.0
HOLD = ("0.02 position 0.016 0.3",)
LAST = 0.8


def held(kit, archive, folder, *options, script=HOLD):
    """Return the duty that a spring ends up with where the handle is held."""
    text = sketch.text(environments.named("spring"), {"stiffness": STIFFNESS, "damping": 0.0}, kit)
    elf = sketches.build(text, archive, folder)
    return sketches.rendered(elf, folder, script, LAST, *EVERY_MS, *options)[-1].duty


def expected(board, at=HELD, power=0.5):
    """Return the duty by the kit's numbers: torque = force * rh * rp / rs, duty = (torque / full) ^ power."""
    torque = STIFFNESS * at * board.handle_radius * board.pulley_radius / board.sector_radius
    return -255.0 * (torque / board.motor_constant) ** power


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


@needs_ide
def test_a_measured_motor_is_undone_by_its_table(archive, tmp_path):
    board = replace(
        profiles.default().board,
        motor_map=MotorMap.TABLE,
        table=(0, 10, 30, 60, 100, 150, 200, 255),
        dead_band=20,
    )
    share = expected(board, power=1.0) / -255.0 * 255.0
    duty = np.interp(share, (0, *board.table), np.linspace(20.0, 255.0, 9))
    assert held(sketch.Kit(board), archive, tmp_path) == pytest.approx(-duty, abs=1.0)


@needs_ide
def test_a_calibrated_kit_keeps_its_zero_and_its_senses(archive, tmp_path):
    # the board counts the other way round and pushes the other way round; it starts 4 mm left of its zero
    board = replace(profiles.default().board, zero=51 + 300 + 2 * 921, sense=-1, direction=-1)
    options = ("--sensor-sign", "-1", "--direction", "-1", "--position", "-0.004")
    duty = held(sketch.Kit(board, calibrated=True), archive, tmp_path, *options)
    assert duty == pytest.approx(expected(board), abs=1.5)
    started_here = held(sketch.Kit(board), archive, tmp_path, *options)
    assert started_here == pytest.approx(expected(board, HELD + 0.004), abs=1.5)


@needs_ide
def test_a_force_that_is_no_number_and_a_handle_too_fast_switch_the_motor_off(archive, tmp_path):
    broken = own(tmp_path, OWN.replace("* (x + s.far)", "* (1.0 / (x - x))"))
    elf = sketches.build(sketch.text(broken, broken.values()), archive, tmp_path)
    assert not sketches.rendered(elf, tmp_path, SWEEP, 0.3).duty.any()
    elf = sketches.build(
        sketch.text(environments.named("spring"), {}, estimator="difference"), archive, tmp_path
    )
    fast = ("0.4 position 0.02 0.1", "0.7 position -0.02 0.01")
    truth = sketches.rendered(elf, tmp_path, fast, 0.9)
    assert truth.duty[truth.time < 0.69].any()
    assert not truth.duty[truth.time > 0.712].any()


# --- without a board
@pytest.mark.parametrize("key", environments.discover())
def test_a_sketch_names_what_was_tuned_and_stands_alone(key):
    environment = environments.named(key)
    text = sketch.text(environment, environment.values())
    for parameter in environment.parameters:
        chosen = isinstance(parameter, Choice) and parameter.key != "picture"
        assert parameter.label in text or not (chosen or f"p.{parameter.key}" in text)
    assert text.count("#include") == 1
    assert "p[" not in text
    assert max(map(len, text.split("\n"))) <= 110


def test_it_is_readable_by_hand_in_and_by_a_plain_editor():
    text = sketch.text(environments.named("wall"), {"damping_mode": "both"})
    assert "// Name:\n// Date:\n" in text
    assert "N*s/m" in text
    assert "·" not in text
    assert "// Damping acts: both\n" in text
    assert "  return -(p.stiffness * depth + p.damping * v);" in text


def test_the_same_settings_give_the_same_sketch():
    environment = environments.named("texture")
    assert sketch.text(environment, {}) == sketch.text(environment, environment.values())


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"rate": 4000}, "250, 500, 1000, 2000 Hz, not at 4000 Hz"),
        ({"prints": 51}, "0 to 50 lines a second, not 51"),
        ({"estimator": "foaw"}, "difference, iir, kalman, not by foaw"),
        ({"values": {"stiffness": 9e9}}, "N/m"),
    ],
)
def test_what_a_sketch_does_not_do_is_said(how, words):
    with pytest.raises(ParameterError, match=words):
        sketch.text(environments.named("wall"), **({"values": {}} | how))


@pytest.mark.parametrize("wanted", ["wall", "wall.ino", "wall/wall", "wall/wall.ino"])
def test_the_file_stands_in_a_folder_of_its_name(wanted, tmp_path):
    made = sketch.write_sketch(tmp_path / wanted, "text")
    assert made == tmp_path / "wall" / "wall.ino"
    with pytest.raises(ParameterError, match="there already"):
        sketch.write_sketch(tmp_path / wanted, "other")
    assert made.read_text() == "text"
    sketch.write_sketch(tmp_path / wanted, "other", over=True)
    assert made.read_text() == "other"


@pytest.mark.parametrize("name", ["my wall", "-x", "wände", "x" * 64])
def test_a_name_that_the_ide_refuses_is_refused(name, tmp_path):
    with pytest.raises(ParameterError, match="A sketch's name"):
        sketch.sketch_path(tmp_path / name)


@pytest.mark.parametrize("name", ["wall.txt", "wall.ino.bak", "wall.cpp"])
def test_another_ending_is_refused(name, tmp_path):
    with pytest.raises(ParameterError, match=r"ends in \.ino, or has no ending"):
        sketch.write_sketch(tmp_path / name, "text")
    assert not list(tmp_path.iterdir())


@needs_ide
def test_a_persons_words_stay_comments(archive, tmp_path):
    nasty = OWN.replace('"Ramp"', r'"Ramp \\\n#error"').replace('"Remembers"', r'"a \\\n#error b\\"')
    nasty = nasty.replace('"Slope"', r'"Slope\n#error \\"')
    environment = own(tmp_path, nasty)
    assert "\n" in environment.title
    kit = sketch.Kit(replace(profiles.default().board, label="a\n#error\\"))
    sketches.build(sketch.text(environment, {}, kit), archive, tmp_path)


def choices(environment):
    """Return every combination of an environment's choices but that of its picture."""
    asked = [p for p in environment.parameters if isinstance(p, Choice) and p.key != "picture"]
    return [
        {p.key: o for p, o in zip(asked, options, strict=True)}
        for options in itertools.product(*(p.options for p in asked))
    ]


LINES = {"exact": 500}
"""More than others: a motion is parted at events there, each searched for."""


@needs_ide
@pytest.mark.parametrize("key", wide(environments.discover(), lambda key: key in ("wall", "detents")))
def test_every_choice_is_a_short_sketch_without_a_warning(key, archive, tmp_path):
    environment = environments.named(key)
    for given in choices(environment):
        text = sketch.text(environment, environment.values(given))
        assert text.count("\n") < LINES.get(given.get("integrator", ""), 350), given
        assert max(map(len, text.split("\n"))) <= 110
        sketches.build(text, archive, tmp_path)


ENDLESS = """    n = 0.0
    if x > 0.01:
        for i in range(10000):
            n += math.sin(i * x)
    return n - 40.0 * x
"""


@needs_ide
def test_a_law_that_turns_in_circles_is_ended_by_the_watchdog(archive, tmp_path):
    text = OWN[: OWN.index("    if x > s.far")] + ENDLESS + OWN[OWN.index("\n\nENVIRONMENT") :]
    environment = own(tmp_path, text.replace('"""A ramp."""', "import math"))
    elf = sketches.build(sketch.text(environment, {}), archive, tmp_path)
    log = sketches.rendered(
        elf, tmp_path, ("0.1 position 0.008 0.1", "0.3 position 0.02 0.05"), 0.7, *EVERY_MS
    )
    assert log.duty[(log.time > 0.2) & (log.time < 0.3)].all()
    assert not log.duty[log.time > 0.42].any()
