"""What was recorded, out of runs and files: columns over time, and what had been set."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from hapkit_studio import environments
from hapkit_studio.dynamics.hand import SCRIPTS, Grip, Hand
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError, StudioError
from hapkit_studio.haptics import rows

FEWEST_SAMPLES = 32


@dataclass(frozen=True)
class Handle:
    """What a simulated handle is: mass kg, viscous friction N·s/m, Coulomb friction N."""

    mass: float
    viscous: float
    coulomb: float


@dataclass(frozen=True)
class Setup:
    """What had been set: environment and its values, the loop in Hz and s, the sensor's quantum in m.

    environment None where it is not known; handle None on a real device; grip None where no hand is known;
    hold_known False where a hand held of which the recording does not say how.
    """

    environment: Environment | None = None
    values: dict[str, float] = field(default_factory=dict)
    rate: float = 1000.0
    delay: float = 0.0
    quantum: float = 20.7e-6
    handle: Handle | None = None
    grip: Grip | None = None
    hold_known: bool = True


@dataclass(frozen=True)
class Recording:
    """Columns (n,) in SI units: position and velocity as the loop saw them, commands as asked and applied.

    flags are those of telemetry rows; hand_force is the hand's force at the sample, NaN where it is unknown,
    but for hand_held: what its damper adds as the target moves, in N, the same from the sample to the next.
    target is where the hand pulls to, in m, None where it is unknown.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    asked: np.ndarray
    applied: np.ndarray
    flags: np.ndarray
    hand_force: np.ndarray
    hand_held: np.ndarray
    setup: Setup
    target: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.time)

    def between(self, begin: float | None, end: float | None) -> "Recording":
        """Return the piece from begin to end, in the recording's own time in s; raise ParameterError."""
        first, last = self.time[0], self.time[-1]
        low, high = first if begin is None else begin, last if end is None else end
        if not (low < high and low <= last and high >= first):
            raise ParameterError(
                f"The piece from {low:g} s to {high:g} s is not in the recording, {first:g} s to {last:g} s."
            )
        chosen = (self.time >= low) & (self.time <= high)
        pieces: dict[str, Any] = {k: x[chosen] for k, x in vars(self).items() if isinstance(x, np.ndarray)}
        return replace(self, **pieces)

    def check(self) -> "Recording":
        """Return this; raise ParameterError where it is too short for anything."""
        if len(self) < FEWEST_SAMPLES:
            raise ParameterError(f"A piece has at least {FEWEST_SAMPLES} samples, not {len(self)}.")
        return self


def of_rows(table: np.ndarray, setup: Setup) -> Recording:
    """Return the recording of telemetry rows (n, ROW_WIDTH), oldest first, by the device's own clock.

    Where that clock went back, a connection began: only what follows counts. Raise ParameterError.
    """
    table = np.asarray(table, dtype=float)
    if table.ndim != 2 or table.shape[1] != rows.ROW_WIDTH:
        raise ParameterError(f"Telemetry rows are {rows.ROW_WIDTH} numbers each, not {table.shape}.")
    back = np.flatnonzero(np.diff(table[:, rows.BOARD_TIME]) <= 0.0)
    table = table[back[-1] + 1 :] if len(back) else table
    hand = hand_parts(table[:, rows.HAND_FORCE], table[:, rows.HAND_TARGET], setup)
    time, *motion = table[:, [rows.BOARD_TIME, rows.POSITION, rows.VELOCITY, rows.ASKED, rows.APPLIED]].T
    flags, target = table[:, rows.FLAGS].astype(int), table[:, rows.HAND_TARGET]
    return Recording(time, *motion, flags, *hand, setup, target).check()  # type: ignore[call-arg]


def hand_parts(force: np.ndarray, target: np.ndarray | None, setup: Setup) -> tuple[np.ndarray, np.ndarray]:
    """Return the hand's force (n,) at the samples without its steps, and those (n,), held sample by sample.

    The target goes in lines from sample to sample, so its speed, and what the damper makes of it, has steps;
    what was recorded at a sample has the speed of the line before.
    """
    steps = np.zeros(len(force))
    if setup.grip is None or target is None or len(force) < 3:
        return force, steps
    holds = (force != 0.0) & np.isfinite(target)
    place = np.where(holds, np.nan_to_num(target), 0.0)
    after = np.append(np.diff(place), 0.0) * setup.grip.damping * setup.rate
    before = np.insert(after[:-1], 0, after[0])
    bend = np.zeros(len(force))
    # a spring to lines instead of the arcs through the same points: a twelfth of the bend
    bend[1:-1] = setup.grip.stiffness * np.diff(place, 2) / 12.0
    return np.where(holds, force - before + bend, force), np.where(holds, after, 0.0)


# Column of the file, field of a run; without the last ones a piece tells less, but something.
_COLUMNS = {
    "time_s": "time",
    "position_m": "position",
    "velocity_m_per_s": "velocity",
    "force_applied_N": "applied_force",
    "force_asked_N": "force",
    "flags": "flags",
    "hand_force_N": "hand_force",
    "hand_target_m": "hand_target",
}
# Hands that need no more words: none, and one whose force is what the motion takes.
_NO_GRIP = ("released", "Prescribed")
_NEEDED = ("time_s", "position_m", "velocity_m_per_s", "force_applied_N")


def from_run(run: Any, hand: Hand | None = None) -> Recording:
    """Return the recording of a run of ``simulate``; hand: the Hand that moved it, if none by name."""
    setup, target = _setup_of(run.settings, np.asarray(run.time), hand)
    recorded = getattr(run, "hand_target", None)
    if target is None and setup.grip is not None and recorded is not None and np.isfinite(recorded).all():
        target = np.asarray(recorded, dtype=float)
    if setup.grip is not None and target is None:
        setup = replace(setup, hold_known=False)
    hand_force = hand_parts(run.hand_force, target, setup)
    columns = run.time, run.position, run.velocity, run.force, run.applied_force
    return Recording(*columns, np.asarray(run.flags).astype(int), *hand_force, setup, target).check()


def from_csv(path: str | Path) -> Recording:
    """Return the recording in a file that ``Run.save`` wrote; raise ParameterError with one line."""
    try:
        text = Path(path).read_text(encoding="utf-8", errors="replace")
    except TypeError:
        raise ParameterError(f"A recording is the path of a file, not {path!r}.") from None
    except OSError as error:
        raise ParameterError(f"Cannot read {path}: {error.strerror}.") from None
    name, (header, heads, *lines) = Path(path).name, (text + "\n\n").split("\n")
    try:
        settings = json.loads(header.removeprefix("#")) if header.startswith("#") else None
    except json.JSONDecodeError:
        settings = None
    if not isinstance(settings, dict):
        raise ParameterError(f"{name} does not begin with the settings of a run: save one with run --csv.")
    names = heads.strip().split(",")
    lacking = [column for column in _NEEDED if column not in names]
    if lacking:
        raise ParameterError(f"{name} has no column {lacking[0]}: it is no recording of the studio.")
    table = _numbers([line for line in lines if line], names, name)
    columns = {field: table[:, names.index(key)] for key, field in _COLUMNS.items() if key in names}
    unknown = np.full(len(table), math.nan)
    defaults = {"force": columns["applied_force"], "flags": np.zeros(len(table)), "hand_force": unknown}
    return from_run(SimpleNamespace(**{**defaults, **columns}, settings=settings))


def _numbers(lines: list[str], names: list[str], name: str) -> np.ndarray:
    """Return a table's lines as numbers (n, names); raise ParameterError."""
    if not lines:
        raise ParameterError(f"{name} has 0 rows under its names: it is no recording of the studio.")
    try:
        table = np.loadtxt(lines, delimiter=",", ndmin=2)
    except ValueError as error:
        raise ParameterError(f"{name} is not a table of numbers: {error}.") from None
    if table.shape[1] != len(names):
        shape = f"{len(table)} rows of {table.shape[1]} numbers for {len(names)} names"
        raise ParameterError(f"{name} has {shape}: it is no recording of the studio.")
    needed = table[:, [names.index(column) for column in _NEEDED]]
    if not np.isfinite(needed).all() or not (np.diff(needed[:, 0]) > 0.0).all():
        raise ParameterError(f"{name} has values that are no numbers, or times that go back.")
    return table


def _setup_of(settings: Mapping, times: np.ndarray, hand: Hand | None) -> tuple[Setup, np.ndarray | None]:
    """Return the setup that settings describe and the hand's target (n,) in m where it is known."""
    device = settings.get("device")
    device = device if isinstance(device, Mapping) else {}
    name = settings.get("hand")
    hand = hand or SCRIPTS.get(name if isinstance(name, str) else "")
    grip = Grip(hand.mass, hand.damping, hand.stiffness) if hand else _grip(settings.get("hand_grip"))
    gaps = np.diff(times)
    usual = 1.0 / float(np.median(gaps)) if len(gaps) else 1000.0
    rate = _number(settings, "rate_Hz", usual)
    environment, values = _scene(settings)
    numbers = [_number(device, key) for key in ("mass", "damping", "coulomb_force")]
    setup = Setup(
        environment,
        values,
        rate if rate > 0.0 else usual,
        max(_number(settings, "delay_s", 0.0), 0.0),
        max(_number(device, "quantum", 20.7e-6), 0.0),
        Handle(*numbers) if device else None,
        grip,
        hold_known=grip is not None or not isinstance(name, str) or name in _NO_GRIP,
    )
    if hand is None:
        return setup, None
    target: Any = hand.target
    return setup, np.array(target(times) if hand.vectorised else [target(t) for t in times.tolist()], float)


def _grip(numbers: Any) -> Grip | None:
    """Return the hand that a run's settings keep, None where they do not say."""
    if not isinstance(numbers, Mapping):
        return None
    found = [_number(numbers, key) for key in ("mass", "damping", "stiffness")]
    return Grip(*found) if all(math.isfinite(x) for x in found) else None


def _scene(settings: Mapping) -> tuple[Any, dict[str, float]]:
    """Return the environment and its values; (None, {}) for one that the library does not know."""
    try:
        environment = environments.named(settings["environment"])
        return environment, environment.values(settings.get("parameters"))
    except (StudioError, KeyError, TypeError, AttributeError):
        return None, {}


def _number(settings: Mapping, key: str, default: float = math.nan) -> float:
    try:
        value = float(settings.get(key, default))
    except (TypeError, ValueError):
        return default
    return value if math.isfinite(value) else default
