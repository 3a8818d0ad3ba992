"""The hand on the handle: mass, damper and spring with a moving target, and named movements."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import check_number


@dataclass(frozen=True)
class Hand:
    """A hand with the force k (target - x) + b (target' - v); its mass is added to that of the handle.

    ``mass`` is in kg, ``damping`` in N·s/m, ``stiffness`` in N/m. ``target(t)`` is in m; if ``vectorised`` is
    true, it also accepts arrays of times. ``release`` is the time in s at which the hand lets go.
    """

    mass: float = 0.0
    damping: float = 0.0
    stiffness: float = 0.0
    target: Callable[[float], float] = lambda t: 0.0 * t
    release: float = math.inf
    summary: str = ""
    vectorised: bool = False

    def __post_init__(self) -> None:
        for name, unit in (("mass", "kg"), ("damping", "N·s/m"), ("stiffness", "N/m")):
            check_number(getattr(self, name), f"hand's {name}", unit)
        if not (isinstance(self.release, int | float | np.number) and self.release >= 0.0):
            raise ParameterError(f"The hand releases the handle at 0 s or later, not {self.release!r} s.")


@dataclass(frozen=True)
class Prescribed:
    """A motion that is imposed on the handle with any force necessary: position(t) in m."""

    position: Callable[[float], float]


@dataclass(frozen=True)
class Grip:
    """The impedance of a hand: mass in kg, damping in N·s/m, stiffness in N/m."""

    mass: float
    damping: float
    stiffness: float


GRIPS: dict[str, Grip | None] = {
    "released": None,
    "light": Grip(0.02, 2.0, 100.0),
    "medium": Grip(0.05, 4.0, 200.0),
    "firm": Grip(0.10, 8.0, 400.0),
}
"""How people hold the handle."""
RUBBER_BAND = "rubber band"
# The damper gives the band on a handle of 44 g a loss factor of 0.07, as in rubber. With 1 N·s/m, there is no
# stick-slip at 10 mm/s.
ALL_GRIPS: dict[str, Grip | None] = GRIPS | {RUBBER_BAND: Grip(0.0, 0.2, 200.0)}
"""The grips of a simulated hand, and a rubber band whose end follows the pointer."""

# m/s: the speed at which a hand approaches the pointer, and the speed at which it then follows the pointer
ARRIVES, LEADS = 0.10, 1.0


def grip_named(name: str) -> Grip | None:
    """Return a grip by its name, None for "released"; raise ParameterError for an unknown name."""
    if name not in ALL_GRIPS:
        raise ParameterError(f"The grip must be one of {', '.join(ALL_GRIPS)}, not {name!r}.")
    return ALL_GRIPS[name]


# every movement function accepts one time in s or an array of times


def _ramp(t, start: float, seconds: float):
    """Rise from 0 to 1 as a cosine, with a level start and end."""
    return 0.5 - 0.5 * np.cos(math.pi * np.clip((t - start) / seconds, 0.0, 1.0))


def _there_and_back(t, reach: float, speed: float):
    """Return a triangle wave between -reach and +reach at constant speed; it starts by rising from 0."""
    quarter = reach / speed
    phase = np.fmod(t + quarter, 4.0 * quarter) / quarter
    return reach * np.where(phase < 2.0, phase - 1.0, 3.0 - phase)


def _tap(t):
    """Tap every 0.8 s: move 15 mm to the right and back at 0.1 m/s."""
    since = np.fmod(t, 0.8) - 0.1
    return np.minimum(np.maximum(0.0, 0.1 * since), np.maximum(0.0, 0.1 * (0.3 - since)))


def _sweep(t):
    """Move to the left end within 0.5 s, then across at 0.07 m/s, then rest."""
    return -0.035 * _ramp(t, 0.0, 0.5) + np.clip(0.07 * (t - 0.6), 0.0, 0.070)


def _shake(t):
    """Oscillate at 0.5 Hz first; the frequency rises by 1 Hz per second up to 6 Hz."""
    rising = np.minimum(t, 5.5)
    cycles = 0.5 * rising + 0.5 * rising * rising + 6.0 * (t - rising)
    return 0.012 * np.sin(2.0 * math.pi * cycles)


def _fur(t, speed: float):
    """Move from the middle to the cat's head, 30 mm to the left, then stroke 60 mm to and fro."""
    return _there_and_back(t + 2.0 * 0.030 / speed, 0.030, speed)


def gripping(
    target: Callable[[float], float] = lambda t: 0.0 * t,
    summary: str = "",
    grip: str = "medium",
    release: float = math.inf,
) -> Hand:
    """Return a hand with a named grip that follows target(t) in m; t is a time in s or an array of times."""
    g = grip_named(grip) or Grip(0.0, 0.0, 0.0)
    return Hand(g.mass, g.damping, g.stiffness, target, release, summary, vectorised=True)


SCRIPTS: dict[str, Hand] = {
    "press": gripping(lambda t: 0.020 * _ramp(t, 0.1, 0.9), "Pushes slowly to 20 mm on the right and stays"),
    "tap": gripping(_tap, "Taps 15 mm to the right and off again at 0.1 m/s, every 0.8 s"),
    "stroke": gripping(lambda t: _there_and_back(t, 0.030, 0.05), "Strokes 30 mm to both sides at 5 cm/s"),
    "sweep": gripping(_sweep, "Goes to the left end, then across at 7 cm/s"),
    "hold": gripping(
        lambda t: 0.010 * _ramp(t, 0.0, 0.3), "Goes to 10 mm on the right and keeps still", "firm"
    ),
    "push": gripping(lambda t: 0.030 * _ramp(t, 0.1, 0.9), "Pushes hard to 30 mm on the right", "firm"),
    "pluck": gripping(
        lambda t: 0.020 * _ramp(t, 0.1, 0.6),
        "Pulls to 20 mm on the right and releases after 1 s",
        release=1.0,
    ),
    "shake": gripping(_shake, "Shakes by 12 mm, from 0.5 Hz up to 6 Hz", "firm"),
    "pet": gripping(lambda t: _fur(t, 0.05), "Pets 60 mm there and back at 5 cm/s"),
    "rub": gripping(lambda t: _fur(t, 0.20), "Rubs 60 mm there and back at 20 cm/s", "firm"),
    "released": Hand(release=0.0, summary="No hand: the handle is free"),
}


def hand_named(name: str) -> Hand:
    """Return a named movement; raise ParameterError for an unknown name."""
    if name not in SCRIPTS:
        raise ParameterError(f"The hand must be one of {', '.join(SCRIPTS)}, not {name!r}.")
    return SCRIPTS[name]
