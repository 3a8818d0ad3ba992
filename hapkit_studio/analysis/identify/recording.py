"""Recordings from runs and files: columns over time, and the settings that were valid at each time."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hapkit_studio import environments, settings_log, tables
from hapkit_studio.dynamics import nominal
from hapkit_studio.dynamics.hand import SCRIPTS, Grip, Hand
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import FileError, ParameterError, StudioError
from hapkit_studio.formatting import compact
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.signals import BY_NAME
from hapkit_studio.settings_log import Log
from hapkit_studio.tables import TableColumn, TableColumns, UnknownColumnsError

FEWEST_SAMPLES = 32
# A gap is irregular if it differs from a whole number of periods by more than _UNEVEN periods. _MOST_UNEVEN
# is the largest accepted fraction of irregular gaps.
_UNEVEN, _MOST_UNEVEN = 0.25, 0.1
_MOST_FLAGS = 255
_LISTED_CHANGES = 5  # number of changes listed in a message
# s: time excluded before and after a settings change. The log may state the change 0.1 s too late, and
# afterwards the values ramp for 30 ms.
_BEFORE_CHANGE, _AFTER_CHANGE = 0.1, 0.05


@dataclass(frozen=True)
class Handle:
    """The true parameters of a simulated handle: mass kg, viscous friction N·s/m, Coulomb friction N."""

    mass: float
    viscous: float
    coulomb: float


@dataclass(frozen=True)
class Setup:
    """The settings of a recording: environment and values, rate in Hz, delay in s, sensor quantum in m.

    ``environment`` is None if it is unknown. ``handle`` is None on a real device. ``grip`` is that of the
    hand, None if no hand is known. ``hold_known`` is False if a hand held the handle and its grip is unknown.
    ``foreign`` marks a file written by another program, in which the force may be a measurement.
    """

    environment: Environment | None = None
    values: dict[str, float] = field(default_factory=dict)
    rate: float = 1000.0
    delay: float = 0.0
    quantum: float = nominal.QUANTUM
    handle: Handle | None = None
    grip: Grip | None = None
    hold_known: bool = True
    foreign: bool = False


@dataclass(frozen=True)
class Recording:
    """Columns (n,) in SI units: position and velocity as the loop measured them, and two forces.

    ``asked`` is the law's force, and ``applied`` the force after all limits. ``flags`` are those of telemetry
    rows. ``hand_held`` is the part of the hand's force in N that the target's speed causes in the hand's
    damper; it is constant between samples. ``hand_force`` is the rest of the hand's force in N at the sample,
    NaN if unknown. ``target`` is the position in m towards which the hand pulls, None if unknown. ``setup``
    contains the settings at the start. ``later`` contains each change as a time in s and the settings from
    then on.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    applied_force: np.ndarray
    flags: np.ndarray
    hand_force: np.ndarray
    hand_held: np.ndarray
    setup: Setup
    target: np.ndarray | None = None
    later: tuple[tuple[float, Setup], ...] = ()

    def __len__(self) -> int:
        return len(self.time)

    def between(self, begin: float | None, end: float | None) -> "Recording":
        """Return the part from ``begin`` to ``end``, in s of the recording's time.

        Raise ParameterError if the recording has no such part.
        """
        first, last = self.time[0], self.time[-1]
        low, high = first if begin is None else begin, last if end is None else end
        if not (low < high and low <= last and high >= first):
            raise ParameterError(
                f"The chosen part, {low:g} s to {high:g} s, must lie in the recording, {first:g} s to "
                f"{last:g} s."
            )
        chosen = (self.time >= low) & (self.time <= high)
        pieces: dict[str, Any] = {k: x[chosen] for k, x in vars(self).items() if isinstance(x, np.ndarray)}
        setups = [self.setup, *(setup for when, setup in self.later if when <= low)]
        later = tuple(pair for pair in self.later if low < pair[0] <= high)
        return replace(self, **pieces, setup=setups[-1], later=later)

    @property
    def change_times(self) -> str:
        """List the times in s of the first settings changes."""
        times = [compact(when, 3) for when, _ in self.later]
        return ", ".join([*times[:_LISTED_CHANGES], *["…"][: len(times) - _LISTED_CHANGES]])

    def longest(self) -> "Recording":
        """Return the longest part with constant settings; raise ParameterError if no part is long enough."""
        changes = [when for when, _ in self.later]
        begins = [float(self.time[0]), *(when + _AFTER_CHANGE for when in changes)]
        ends = [*(when - _BEFORE_CHANGE for when in changes), float(self.time[-1])]
        begin, end = max(zip(begins, ends, strict=True), key=lambda piece: piece[1] - piece[0])
        if not begin < end:
            least = _BEFORE_CHANGE + _AFTER_CHANGE
            raise ParameterError(
                f"The settings changed {len(changes)} times, but {least:g} s without a change are needed."
            )
        return self.between(begin, end)

    def check(self) -> "Recording":
        """Return self; raise ParameterError if the recording is short or irregular, or settings change."""
        if len(self) < FEWEST_SAMPLES:
            raise ParameterError(
                f"The chosen part must have at least {FEWEST_SAMPLES} samples, not {len(self)}."
            )
        if self.later:
            raise ParameterError(
                f"The settings changed at {self.change_times} s: choose a part without a change."
            )
        gaps = np.diff(self.time)
        periods = gaps / np.median(gaps)
        if np.mean(np.abs(periods - np.rint(periods)) > _UNEVEN) > _MOST_UNEVEN:
            low, high = 1e3 * np.percentile(gaps, (10.0, 90.0))
            gap = f"{compact(low, 2)} to {compact(high, 2)} ms apart"
            raise ParameterError(f"The samples are {gap}, but identification needs equal intervals.")
        return self


def of_rows(table: np.ndarray, setup: Setup) -> Recording:
    """Return the recording of telemetry rows (n, ROW_WIDTH), oldest first, in device time.

    If the device clock jumps back, the rows before the jump belong to an earlier connection and are ignored.
    Raise ParameterError if the rows have a wrong shape, are too few or are irregular.
    """
    table = np.asarray(table, dtype=float)
    if table.ndim != 2 or table.shape[1] != rows.ROW_WIDTH:
        raise ParameterError(
            f"Each row of the recording must have {rows.ROW_WIDTH} numbers; this table has the size "
            f"{' × '.join(map(str, table.shape))}."
        )
    back = np.flatnonzero(np.diff(table[:, rows.BOARD_TIME]) <= 0.0)
    table = table[back[-1] + 1 :] if len(back) else table
    hand = hand_parts(table[:, rows.HAND_FORCE], table[:, rows.HAND_TARGET], setup)
    time, *motion = table[
        :, [rows.BOARD_TIME, rows.POSITION, rows.VELOCITY, rows.FORCE, rows.APPLIED_FORCE]
    ].T
    flags, target = table[:, rows.FLAGS].astype(int), table[:, rows.HAND_TARGET]
    return Recording(time, *motion, flags, *hand, setup, target).check()  # type: ignore[call-arg]


def hand_parts(force: np.ndarray, target: np.ndarray | None, setup: Setup) -> tuple[np.ndarray, np.ndarray]:
    """Split the hand's force (n,) into a smooth part at the samples and a part (n,) constant between samples.

    The target is piecewise linear. Its speed, and with it the damper's force, therefore has steps. The
    recorded force of a sample is computed with the target's speed in the interval before the sample.
    """
    steps = np.zeros(len(force))
    if setup.grip is None or target is None or len(force) < 3:
        return force, steps
    holds = (force != 0.0) & np.isfinite(target)
    place = np.where(holds, np.nan_to_num(target), 0.0)
    after = np.append(np.diff(place), 0.0) * setup.grip.damping * setup.rate
    before = np.insert(after[:-1], 0, after[0])
    bend = np.zeros(len(force))
    # The spring's force on a piecewise linear target has an interpolation error of one twelfth of the second
    # difference.
    bend[1:-1] = setup.grip.stiffness * np.diff(place, 2) / 12.0
    return np.where(holds, force - before + bend, force), np.where(holds, after, 0.0)


# the studio's own column names, by the fields of Recording
_STUDIO_COLUMNS = {
    "time": TableColumn(BY_NAME["time"].column_name, "s"),
    "position": TableColumn(BY_NAME["position"].column_name, "m"),
    "velocity": TableColumn(BY_NAME["velocity"].column_name, "m/s"),
    "force": TableColumn(BY_NAME["applied_force"].column_name, "N"),
}
# columns that a file may lack
_OPTIONAL_COLUMNS = {
    "asked": BY_NAME["force"].column_name,
    "flags": BY_NAME["flags"].column_name,
    "hand_force": BY_NAME["hand_force"].column_name,
    "target": BY_NAME["hand_target"].column_name,
}
# names of hands that have no grip
_NO_GRIP = ("released", "Prescribed")


class Motion(NamedTuple):
    """The columns (n,) that every recording has."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    applied_force: np.ndarray


def from_run(run: Any, hand: Hand | None = None) -> Recording:
    """Return the recording of a run of ``simulate``; ``hand`` is the run's hand, if the hand has no name."""
    motion = Motion(np.asarray(run.time), run.position, run.velocity, run.force, run.applied_force)
    log = getattr(run, "settings_log", ()) or ((0.0, run.settings),)
    return _recording(motion, run.flags, run.hand_force, getattr(run, "hand_target", None), log, hand)


def from_csv(path: str | Path, columns: TableColumns | None = None) -> Recording:
    """Return the recording in a file of ``Run.save``, or in a table of another program.

    ``columns`` contains the column names of a table of another program; its keys are tables.NEEDED and
    "velocity". Forces act on the handle and are positive to the right. Raise FileError for an invalid file,
    and UnknownColumnsError if ``columns`` is needed.
    """
    if not isinstance(path, str | Path):
        raise ParameterError(f"A recording must be the path of a file, not {path!r}.")
    table = tables.read(path)
    named = dict(columns or {})
    for quantity, own in _STUDIO_COLUMNS.items():
        if quantity not in named and own.name in table.names:
            named[quantity] = own
        elif quantity not in named and quantity in tables.NEEDED:
            raise UnknownColumnsError(table, own.name)
    for quantity, column in named.items():
        if column.name not in table.names:
            raise UnknownColumnsError(table, f"{column.name} for the {quantity}")
    more = {key: name for key, name in _OPTIONAL_COLUMNS.items() if name in table.names}
    values = table.values([*(column.name for column in named.values()), *more.values()]).T
    found = dict(zip((*named, *more), values, strict=True))
    for quantity, column in named.items():
        found[quantity] = found[quantity] * tables.UNITS[quantity][column.unit]
    _check_times(table, found["time"], [found[quantity] for quantity in named])
    time, position, applied = (found[quantity] for quantity in tables.NEEDED)
    if "velocity" not in found:
        found["velocity"] = np.gradient(position, time) if len(time) > 1 else np.zeros(len(time))
    motion = Motion(time, position, found["velocity"], found.get("asked", applied), applied)
    log = settings_log.read(table.comments, table.file) or [(0.0, {})]
    log = [(when, {"quantum_m": _smallest_step(position), **settings}) for when, settings in log]
    flags = np.clip(np.nan_to_num(found.get("flags", np.zeros(len(time)))), 0, _MOST_FLAGS)
    unknown = np.full(len(time), math.nan)
    read = _recording(motion, flags, found.get("hand_force", unknown), found.get("target"), log)
    return replace(read, setup=replace(read.setup, foreign=named["force"] != _STUDIO_COLUMNS["force"]))


def _check_times(table: tables.Table, time: np.ndarray, columns: Sequence[np.ndarray]) -> None:
    """Raise FileError unless times increase and all values are finite."""
    finite = np.isfinite(columns).all(axis=0)
    if not finite.all():
        line = table.line_of(int(np.argmin(finite)))
        raise FileError(f"{table.file} has values that are not numbers, first in line {line}.")
    back = np.diff(time) <= 0.0
    if back.any():
        row = int(np.argmax(back)) + 1
        late, early = compact(time[row - 1], 6), compact(time[row], 6)
        times = f"{early} s comes after {late} s in line {table.line_of(row)}"
        raise FileError(f"{table.file} has times that decrease or repeat: {times}.")


def _smallest_step(position: np.ndarray) -> float:
    """Return the smallest difference between positions in m, due to the sensor or to rounding in the file."""
    steps = np.diff(np.unique(np.round(position, 9)))
    return float(steps.min()) if len(steps) else 0.0


def _recording(
    motion: Motion,
    flags: np.ndarray,
    hand_force: np.ndarray,
    target: np.ndarray | None,
    log: Log,
    hand: Hand | None = None,
) -> Recording:
    """Return a recording; ``target`` (n,) in m is the target of a hand without a script name."""
    usual = 1.0 / float(np.median(np.diff(motion.time))) if len(motion.time) > 1 else 1000.0
    hand = hand or _script(log[0][1])
    setup, *others = (_setup_of(settings, usual, hand) for _, settings in log)
    moved = None if hand is None else _target(hand, motion.time)
    if moved is None and setup.grip is not None and target is not None and np.isfinite(target).all():
        moved = np.asarray(target, dtype=float)
    if setup.grip is not None and moved is None:
        setup = replace(setup, hold_known=False)
    later = tuple((when, other) for (when, _), other in zip(log[1:], others, strict=True))
    force, held = hand_parts(hand_force, moved, setup)
    return Recording(
        *motion,
        flags=np.asarray(flags).astype(int),
        hand_force=force,
        hand_held=held,
        setup=setup,
        target=moved,
        later=later,
    )


def _script(settings: settings_log.LoggedSettings) -> Hand | None:
    """Return the scripted hand that the settings name; None if they name no script."""
    name = settings.get("hand")
    return SCRIPTS.get(name) if isinstance(name, str) else None


def _target(hand: Hand, times: np.ndarray) -> np.ndarray:
    """Return the target (n,) in m of a hand."""
    target: Any = hand.target
    return np.array(target(times) if hand.vectorised else [target(t) for t in times.tolist()], float)


def _setup_of(settings: settings_log.LoggedSettings, usual: float, hand: Hand | None) -> Setup:
    """Return the setup that settings describe; ``usual`` is the rate in Hz if they contain no rate."""
    device = settings.get("device")
    device = device if isinstance(device, Mapping) else {}
    name = settings.get("hand")
    grip = Grip(hand.mass, hand.damping, hand.stiffness) if hand else _grip(settings.get("hand_grip"))
    rate = _number(settings, "rate_Hz", usual)
    environment, values = _scene(settings)
    numbers = [_number(device, key) for key in ("mass", "damping", "coulomb_force")]
    return Setup(
        environment,
        values,
        rate if rate > 0.0 else usual,
        max(_number(settings, "delay_s", 0.0), 0.0),
        max(_number(device, "quantum", _number(settings, "quantum_m", nominal.QUANTUM)), 0.0),
        Handle(*numbers) if device else None,
        grip,
        hold_known=grip is not None or not isinstance(name, str) or name in _NO_GRIP,
    )


def _grip(numbers: Any) -> Grip | None:
    """Return the grip in a run's settings; None if it is unknown."""
    if not isinstance(numbers, Mapping):
        return None
    found = [_number(numbers, key) for key in ("mass", "damping", "stiffness")]
    return Grip(*found) if all(math.isfinite(x) for x in found) else None


def _scene(settings: Mapping) -> tuple[Any, dict[str, float]]:
    """Return the environment and its values; (None, {}) if the library does not contain it."""
    try:
        environment = environments.named(settings["environment"])
        return environment, environment.values(settings.get("parameters"))
    except (StudioError, KeyError, TypeError, AttributeError):
        return None, {}


def _number(settings: Mapping, key: str, default: float = math.nan) -> float:
    try:
        value = float(settings.get(key, default))
    except (TypeError, ValueError, OverflowError):
        return default
    return value if math.isfinite(value) else default
