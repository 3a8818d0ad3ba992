"""Robust stability: the limit for all hands in a box around measured hands.

A hand is modelled as a mass that moves with the handle, with a damper and a spring to the ground. The ranges
in the table of measured hands span the box. Its corners, such as 3.5 g with 40 N·s/m, do not occur in people.
All hands have some damping, so the limit is several times the passive stiffness.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

import numpy as np

from hapkit_studio.dynamics.hand import GRIPS, Grip
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.dynamics.sampled_loop import stiffness_limits
from hapkit_studio.formatting import compact

Range = tuple[float, float]
# number of values tried within each range; the worst one is usually at an end
_TRIED = 7


@dataclass(frozen=True)
class Known:
    """A measured kind of hand: ranges of mass in kg, damping in N·s/m, stiffness in N/m, and the source.

    If ``read`` is true, the numbers were checked in the source; otherwise they are quoted from memory.
    """

    what: str
    mass: Range
    damping: Range
    stiffness: Range
    source: str
    read: bool


_LIGHT, *_, _FIRM = (grip for grip in GRIPS.values() if grip is not None)
KNOWN = (
    Known(
        "an index finger, pressing", (0.0035, 0.0087), (2.0, 7.4), (200.0, 1255.0),
        "Hajian and Howe, J. Biomechanical Engineering 119(1), 1997", False,
    ),
    Known(
        "an arm that keeps its position, one trial", (0.554, 0.554), (6.45, 6.45), (135.0, 135.0),
        "van Beek and others, Scientific Reports 5:18004, 2015, fig. 3", True,
    ),
    Known(
        "an arm, relaxed to tense", (0.5, 2.0), (5.0, 40.0), (50.0, 800.0),
        "Tsuji and others, Biological Cybernetics 72, 1995", False,
    ),
    Known(
        "the grips in this program, light to firm",
        (_LIGHT.mass, _FIRM.mass), (_LIGHT.damping, _FIRM.damping), (_LIGHT.stiffness, _FIRM.stiffness),
        "chosen for this studio", True,
    ),
)  # fmt: skip


def _ends(of: Callable[[Known], Range]) -> Range:
    return min(of(hand)[0] for hand in KNOWN), max(of(hand)[1] for hand in KNOWN)


MASS, DAMPING, STIFFNESS = (
    _ends(of) for of in (lambda hand: hand.mass, lambda hand: hand.damping, lambda hand: hand.stiffness)
)


def ranges_text(mass: Range, damping: Range, stiffness: Range) -> str:
    """Describe hands by their ranges, which may be single numbers: "0.02 to 0.1 kg, 2 N·s/m, 400 N/m"."""
    parts = (mass, "kg"), (damping, "N·s/m"), (stiffness, "N/m")
    return ", ".join(
        " to ".join(compact(end, 5) for end in dict.fromkeys(ends)) + f" {unit}" for ends, unit in parts
    )


PEOPLE = ranges_text(MASS, DAMPING, STIFFNESS)


@dataclass(frozen=True)
class Family:
    """The lowest limit in N/m over all hands, for damping (n,) in N·s/m, and the hand with this limit."""

    damping: np.ndarray
    people: np.ndarray
    worst: tuple[Grip, ...]


def family(setting: LoopSettings, damping: np.ndarray) -> Family:
    """Return the lowest limits over damping (n,); raise ParameterError for a nonlinear estimator."""
    grips = _people()
    limits = np.array([stiffness_limits(replace(setting, own_grip=grip), damping) for grip in grips])
    worst = tuple(grips[k] for k in limits.argmin(axis=0))
    return Family(damping, limits.min(axis=0), worst)


@lru_cache(maxsize=1)
def _people() -> list[Grip]:
    masses, stiffnesses = np.geomspace(*MASS, _TRIED).tolist(), np.geomspace(*STIFFNESS, _TRIED).tolist()
    return [Grip(m, b, k) for m, b, k in product(masses, DAMPING, stiffnesses)]
