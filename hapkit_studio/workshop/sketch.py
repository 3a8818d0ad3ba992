"""Export an environment with its values as an Arduino sketch that renders without the studio.

The sketch contains the law in C, its values as named constants, and the helpers that it needs. The Arduino
IDE requires a folder with the same name.
"""

import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from string import Template

from hapkit_studio import lab, resources
from hapkit_studio.devices import profiles
from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.estimators import USUAL, Spec
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.files import is_special
from hapkit_studio.haptics.board_plan import ESTIMATORS, coefficients
from hapkit_studio.laws import c_source
from hapkit_studio.laws.c_source import Source, mangled, number
from hapkit_studio.parameters import Choice
from hapkit_studio.protocol.messages import Board, MotorMap, Pins, Sensor


def translated(environment: Environment, values: Mapping[str, float]) -> Source:
    """Return a law in C; raise LawError if it is outside the law language."""
    return c_source.translate(environment.force, [values[p.key] for p in environment.force.parameters])


def constants(environment: Environment, values: Mapping[str, float], law: Source) -> str:
    """Return the used values as named constants with unit and label; a choice is given by its name."""
    rows, lines = [], []
    for place, parameter in enumerate(environment.force.parameters):
        if isinstance(parameter, Choice):
            chosen = parameter.text(values[parameter.key])
            lines.append(f"// {one_line(parameter.label)}: {chosen}")
        elif place in law.parameters:
            about = ": ".join(filter(None, (parameter.unit, parameter.label)))
            code = f"  float {mangled(parameter.key)} = {number(values[parameter.key])};"
            rows.append((code, one_line(about)))
    width = max((len(code) for code, _ in rows), default=0)
    if rows:
        commented = [f"{code:<{width}}  // {about}" for code, about in rows]
        lines += ["constexpr struct {", *commented, "} p = {};"]
    return "\n".join(lines) or "// This environment has nothing to tune."


def one_line(message: str) -> str:
    """Return a text on one line that cannot end a C comment or continue on the next line."""
    return " ".join(message.split()).replace("\\", "/").replace("·", "*")


def law_text(law: Source) -> str:
    """Return the law in its namespace, after the helpers that it needs."""
    pieces = re.split(r"^=== (.*)\n", resources.path("sketch", "helpers.txt").read_text("utf-8"), flags=re.M)
    known = zip(pieces[1::2], pieces[2::2], strict=True)
    helpers = [code.strip() for names, code in known if law.helpers & set(names.split())]
    return "\n\n".join(["namespace law {", *helpers, law.text, "}  // namespace law\n"])


RATES = (250, 500, 1000, 2000)
"""Rates in Hz that a sketch can use."""
USUAL_RATE = 1000
SLOWER = {"rk4": 500, "implicit_euler": 500, "trapezoid": 500, "exact": 250}
"""Highest rates in Hz for slow methods, measured in the simulated chip."""
MOST_PRINTS, _WIDTH = 50, 105
_LEVER = """\
// N*m on the motor for 1 N on the handle: the gear multiplies the motor's torque, the handle divides it.
constexpr float kLever = kHandleRadius * kPulleyRadius / kSectorRadius;"""

_SENSORS = {Sensor.MAGNETORESISTIVE: "a2", Sensor.AS5048A: "as5048a", Sensor.QUADRATURE: "encoder"}
_MAPS = {MotorMap.SQUARE: "square", MotorMap.LINEAR: "linear", MotorMap.TABLE: "table"}
_MOTORS = {Pins.D5_D8: "d5", Pins.D3_D12: "d3"}
_UPRIGHT = (
    "Before the board starts, hold the handle at the place of its zero, usually upright: each time "
    "the board starts, it takes this position as 0. Then connect the motor's power supply."
)
_NEAR = (
    "Before the board starts, hold the handle near zero, within {reach:.0f} mm: the sensor's reading "
    "repeats as the motor turns, so the board uses the nearest zero. Then connect the motor's power supply."
)


@dataclass(frozen=True)
class Kit:
    """The kit of a sketch: its settings, and whether these are calibrated."""

    board: Board = profiles.default().board
    calibrated: bool = False


def text(
    environment: Environment,
    values: Mapping[str, float],
    kit: Kit | None = None,
    rate: int | None = None,
    estimator: Spec = USUAL,
    prints: int = 10,
    remark: str = "",
) -> str:
    """Return the sketch.

    ``values`` contains the values that differ from the defaults. ``rate`` is in Hz, by default
    ``usual_rate``. ``prints`` is the number of lines per second on the serial monitor. ``remark`` is a text
    for the reader at the top. Raise ParameterError for options that a sketch does not support, LawError
    for an invalid law, and DeviceError for a mistake in the lab's file.
    """
    kit, values = kit or Kit(), environment.values(values)
    rate = usual_rate(environment, values) if rate is None else rate
    check(rate, estimator, prints)
    law, board = translated(environment, values), kit.board
    reach = 500.0 * board.counts_per_flip * board.quantum
    before_start = _NEAR.format(reach=reach) if _zero_known(kit) else _UPRIGHT
    zero = "zero-known" if _zero_known(kit) else "zero-start"
    table = ", ".join(number(t / 255.0) for t in (0, *board.table))
    return _template("sketch").substitute(
        title=one_line(environment.title),
        about=_comment(one_line(environment.summary)),
        version=version("hapkit-studio"),
        before_start="\n//\n".join(_comment(note) for note in (remark, before_start) if note),
        rate=rate,
        loop=_loop(rate, prints),
        parameters=constants(environment, values, law),
        kit=_kit(kit),
        law=law_text(law),
        sensor=_template(f"sensor-{_SENSORS[Sensor(board.sensor)]}").template + _template(zero).template,
        velocity=_velocity(estimator, rate, board.quantum),
        motor_map=_template(f"map-{_MAPS[MotorMap(board.motor_map)]}").safe_substitute(table=table),
        motor=_template(f"motor-{_MOTORS[Pins(board.pins)]}").template,
        call=law.call,
    )


def usual_rate(environment: Environment, values: Mapping[str, float]) -> int:
    """Return USUAL_RATE in Hz, or a lower rate if the law would be too slow for it."""
    chosen = [p.text(values[p.key]) for p in environment.parameters if isinstance(p, Choice)]
    return min([USUAL_RATE, *(SLOWER[name] for name in chosen if name in SLOWER)])


def check(rate: int, estimator: Spec, prints: int) -> None:
    """Raise ParameterError for options that a sketch does not support."""
    if rate not in RATES:
        raise ParameterError(
            f"The rate of a sketch must be {', '.join(f'{r:,}' for r in RATES)} Hz, not {rate:,g} Hz."
        )
    if not 0 <= prints <= MOST_PRINTS:
        raise ParameterError(f"A sketch must print between 0 and {MOST_PRINTS} lines a second, not {prints}.")
    key = estimators.parse(estimator)[0].key
    if key not in ESTIMATORS:
        known = ", ".join(ESTIMATORS)
        raise ParameterError(f"The velocity filter of a sketch must be one of {known}, not {key}.")


def _template(name: str) -> Template:
    return Template(resources.path("sketch", f"{name}.txt").read_text("utf-8"))


def _comment(text: str) -> str:
    return "\n".join(f"// {line}" for line in textwrap.wrap(text.replace("×", "times"), _WIDTH))


def _zero_known(kit: Kit) -> bool:
    return kit.calibrated and kit.board.sensor != Sensor.QUADRATURE


def _kit(kit: Kit) -> str:
    b = kit.board
    most = min(b.max_force, lab.force_limit())
    turn = "turn" if b.sensor != Sensor.MAGNETORESISTIVE else "half turn"
    rows = [
        ("float kMaxForce", number(most), "N, the largest force of motor and cable"),
        ("float kMotorConstant", number(b.motor_constant), "N*m at full duty"),
        ("float kHandleRadius", number(b.handle_radius), "m from the sector's axis to the handle"),
        ("float kPulleyRadius", number(b.pulley_radius), "m, the motor's pulley (not its diameter)"),
        ("float kSectorRadius", number(b.sector_radius), "m, of the drum with the cable"),
        ("int32_t kCountsPerRepeat", str(b.counts_per_flip), f"of the sensor in a {turn} of the motor"),
        ("float kTravelPerCount", number(b.quantum), "m of the handle"),
        ("float kSense", number(float(b.sense)), "1: counts increase to the right, -1: to the left"),
        ("bool kHighIsRight", str(b.direction > 0).lower(), "direction pin is high for a force to the right"),
        ("uint8_t kDeadBand", str(b.dead_band), "PWM value of 255 below which the motor does not turn"),
    ]
    if _zero_known(kit):
        rows.append(("int32_t kZero", str(b.zero), "the count at the handle's zero"))
    known = profiles.numbered(b.profile)
    name = one_line(b.label) or (known.title if known else "Hapkit")
    sure = "as calibrated" if kit.calibrated else "with the usual values of this type: measure your own"
    return f"{_comment(f'{name}, {sure}.')}\n{_rows(rows)}\n{_LEVER}"


def _loop(rate: int, prints: int) -> str:
    rows = [
        ("uint16_t kRate", str(rate), "Hz"),
        ("float kPeriod", "1.0f / kRate", "s from one tick to the next"),
        ("float kFadeIn", "0.5f", "s, during which the force rises after a start"),
        ("float kMaxSpeed", "3.0f", "m/s; a hand is slower, so a larger value is an error"),
        ("uint8_t kPrintsPerSecond", str(prints), "lines on the serial monitor at 115200 baud; 0: none"),
    ]
    return _rows(rows)


def _rows(rows: Sequence[tuple[str, str, str]]) -> str:
    """Return constants with aligned comments."""
    codes = [f"constexpr {name} = {value};" for name, value, _ in rows]
    width = max(len(code) for code in codes)
    return "\n".join(f"{code:<{width}}  // {row[2]}" for code, row in zip(codes, rows, strict=True))


def _velocity(estimator: Spec, rate: int, quantum: float) -> str:
    method, options = estimators.parse(estimator)
    _, first, second = coefficients(estimator, rate, quantum)
    comment = f"corner frequency {options['cutoff']:g} Hz" if "cutoff" in options else method.label
    return _template(f"velocity-{method.key}").safe_substitute(
        first=number(first), second=number(second), comment=comment
    )


ENDING = ".ino"
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,62}")


def sketch_path(wanted: str | Path) -> Path:
    """Return the path of a sketch in its folder: wall/wall.ino for "wall", "wall.ino" or "wall/wall.ino".

    Raise ParameterError if the Arduino IDE rejects the name.
    """
    path = Path(wanted).expanduser()
    if is_special(path):
        return path
    if path.suffix and path.suffix != ENDING and not path.suffix[1:].isdigit():
        raise ParameterError(f"A sketch's name must end in {ENDING} or have no ending, not {path.suffix!r}.")
    name = path.name.removesuffix(ENDING)
    if not _NAME.fullmatch(name):
        raise ParameterError(f"A sketch's name must have at most 63 letters, digits, _ and -, not {name!r}.")
    folder = path.parent if path.parent.resolve().name == name else path.parent / name
    return folder / f"{name}{ENDING}"


def write_sketch(wanted: str | Path, text: str, over: bool = False) -> Path:
    """Write a sketch and return its path.

    Raise ParameterError if the sketch exists and ``over`` is false, and OSError if the file cannot be
    written.
    """
    path = sketch_path(wanted)
    if path.exists() and not over and not is_special(path):
        raise ParameterError(f"{path} exists already. Choose another name, or overwrite it with --force.")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path
