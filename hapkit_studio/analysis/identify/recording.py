"""What was recorded, whatever it was recorded by: columns over time, and what had been set."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
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

    @property
    def seconds(self) -> float:
        """Return how long the recording is, in s."""
        return float(self.time[-1] - self.time[0]) if len(self) else 0.0

    def between(self, begin: float | None, end: float | None) -> "Recording":
        """Return the piece from begin to end, in the recording's own time in s; raise ParameterError."""
        first, last = self.time[0], self.time[-1]
        low, high = first if begin is None else begin, last if end is None else end
        if not (low < high and low <= last and high >= first):
            raise ParameterError(
                f"The piece from {low:g} s to {high:g} s is not in the recording, {first:g} s to {last:g} s."
            )
        return self._only((self.time >= low) & (self.time <= high))

    def _only(self, chosen: np.ndarray) -> "Recording":
        columns = ("time", "position", "velocity", "asked", "applied", "flags", "hand_force", "hand_held")
        only = {name: getattr(self, name)[chosen] for name in columns}
        return replace(self, **only, target=None if self.target is None else self.target[chosen])

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
    return Recording(
        table[:, rows.BOARD_TIME],
        table[:, rows.POSITION],
        table[:, rows.VELOCITY],
        table[:, rows.ASKED],
        table[:, rows.APPLIED],
        table[:, rows.FLAGS].astype(int),
        *hand,
        setup,
        table[:, rows.HAND_TARGET],
    ).check()


def of_run(run: Any, setup: Setup, target: np.ndarray | None = None) -> Recording:
    """Return the recording of a headless run; target (n,) in m is where its hand pulled to, if known."""
    return Recording(
        run.time,
        run.position,
        run.velocity,
        run.force,
        run.applied_force,
        np.asarray(run.flags).astype(int),
        *hand_parts(run.hand_force, target, setup),
        setup,
        target,
    ).check()


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
