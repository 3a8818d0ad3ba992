"""What a scene is judged by: one number of a run each, and the scale on which a change of it is felt.

Fingers hold a force to 0.3 N at best and know a length to 0.4 mm (Ho 1996); energy is measured by what went
to and fro, restitution by 1, and a count is right or wrong.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import rows

FORCE = 0.3
LENGTH = 0.4e-3
COUNT = "count:"
# Slower than this is standing still, in m/s: what trembles while it sticks has not turned.
STANDING = 1e-3
# What is no number any more has changed more than anything that is.
MOST = 1e6


@dataclass(frozen=True)
class Outcome:
    """A run's number, taken from its rows (n, ROW_WIDTH), and the scale of a change beside a reference run.

    thrown: it means something only where the handle flies by itself.
    """

    key: str
    unit: str
    value: Callable[[np.ndarray], float]
    scale: Callable[[np.ndarray], float]
    thrown: bool = False

    def change(self, reference: np.ndarray, other: np.ndarray) -> float:
        """Return how far the other run's number is from the reference's, as a share of the scale."""
        moved = abs(self.value(other) - self.value(reference)) / self.scale(reference)
        return min(moved, MOST) if math.isfinite(moved) else MOST


def peak_force(table: np.ndarray) -> float:
    """Return the largest force in N that was applied, either way."""
    return float(np.abs(table[:, rows.APPLIED]).max())


def final_position(table: np.ndarray) -> float:
    """Return where the handle is in the end, in m."""
    return float(table[-1, rows.TRUE_POSITION])


def peak_position(table: np.ndarray) -> float:
    """Return how far from the middle the handle came, in m."""
    return float(np.abs(table[:, rows.TRUE_POSITION]).max())


def restitution(table: np.ndarray) -> float:
    """Return the highest speed of a thrown handle on its way back over that on its way in, 0 if it stays.

    For a mass that meets a spring and damper it is exp(-2 zeta phi / sqrt(1 - zeta^2)), cos phi = zeta.
    """
    velocity = table[:, rows.TRUE_VELOCITY]
    way = velocity * np.sign(velocity[np.argmax(np.abs(velocity) > STANDING)])
    if not (way < -STANDING).any():
        return 0.0
    turn = int(np.argmax(way < -STANDING))
    return float(-way[turn:].min() / way[:turn].max())


def energy(table: np.ndarray) -> float:
    """Return the energy in J that the device has given to handle and hand; negative: it took that much."""
    return float(table[-1, rows.ENERGY])


def exchanged(table: np.ndarray) -> float:
    """Return the energy in J that went to and fro, at least that of a force and a length nobody feels."""
    return max(float(np.abs(np.diff(table[:, rows.ENERGY])).sum()), FORCE * LENGTH)


OUTCOMES: dict[str, Outcome] = {
    o.key: o
    for o in (
        Outcome("peak_force", "N", peak_force, lambda table: max(FORCE, peak_force(table))),
        Outcome("final_position", "m", final_position, lambda table: LENGTH),
        Outcome("peak_position", "m", peak_position, lambda table: LENGTH),
        Outcome("restitution", "", restitution, lambda table: 1.0, thrown=True),
        Outcome("energy", "J", energy, exchanged),
    )
}


def named(key: str, state_names: tuple[str, ...] = ()) -> Outcome:
    """Return an outcome by its key, "count:NAME" for the last value of a state; raise ParameterError."""
    if key in OUTCOMES:
        return OUTCOMES[key]
    name = key.removeprefix(COUNT)
    if name == key or name not in state_names:
        known = [*OUTCOMES, *(COUNT + state for state in state_names)]
        raise ParameterError(f"An outcome is one of {', '.join(known)}, not {key!r}.")
    column = rows.STATE + state_names.index(name)
    return Outcome(key, "", lambda table: float(table[-1, column]), lambda table: 1.0)
