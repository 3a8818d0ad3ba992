"""Stiffness limits of a rendered spring: exact, by the simple rule, and by quantisation."""

import math
from typing import Any

import numpy as np

from hapkit_studio.analysis import checks
from hapkit_studio.dynamics import sampled_loop
from hapkit_studio.dynamics.estimators import USUAL_QUANTUM, Spec
from hapkit_studio.dynamics.hand import ALL_GRIPS, Grip, Hand, hand_named
from hapkit_studio.dynamics.loop_settings import LoopSettings, check_delay
from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import check_number


def checked_loop(
    mass: float,
    viscous: float,
    damping: float = 0.0,
    rate: float = 1000.0,
    delay: float = 0.0,
    estimator: Spec = "difference",
    hand: Hand | Grip | str | None = None,
    quantum: float = USUAL_QUANTUM,
) -> LoopSettings:
    """Check the settings of a loop and return them; raise ParameterError for an invalid setting."""
    for name, value, unit, above in (
        ("mass", mass, "kg", True),
        ("viscous damping", viscous, "N·s/m", False),
        ("virtual damping", damping, "N·s/m", False),
        ("rate", rate, "Hz", True),
        ("delay", delay, "s", False),
        ("sensor quantum", quantum, "m", False),
    ):
        check_number(value, name, unit, above=above, high=checks.MOST)
    check_delay(rate, delay)
    if isinstance(hand, str):
        hand = ALL_GRIPS[hand] if hand in ALL_GRIPS else hand_named(hand)
    if hand is not None and not isinstance(hand, Hand | Grip):
        raise ParameterError(f"hand must be a Hand, a Grip, a name or None, not {hand!r}.")
    grip = Grip(hand.mass, hand.damping, hand.stiffness) if hand else None
    return LoopSettings(
        rate, delay, estimator, mass=mass, viscous=viscous, coulomb=0.0, quantum=quantum, own_grip=grip
    )


def stable_stiffnesses(mass: float, viscous: float, **loop: Any) -> sampled_loop.Intervals:
    """Return all intervals (low, high) in N/m of stable virtual stiffness, exact, lowest first.

    The arguments are those of ``stiffness_limit``, which returns the end of the first interval. Raise
    ParameterError for an invalid argument.
    """
    checked = checked_loop(mass, viscous, **loop)
    return sampled_loop.stable_intervals(checked, np.array([loop.get("damping", 0.0)]))[0]


def stiffness_limit(
    mass: float,
    viscous: float,
    *,
    damping: float = 0.0,
    rate: float = 1000.0,
    delay: float = 0.0,
    estimator: Spec = "difference",
    hand: Hand | Grip | str | None = None,
    quantum: float = USUAL_QUANTUM,
) -> float:
    """Return the exact stiffness limit in N/m: every softer virtual spring is stable. It may be 0.

    ``mass`` is in kg, ``viscous`` and the virtual ``damping`` are in N·s/m, ``rate`` is in Hz, and ``delay``
    in s. ``hand`` is a Hand, a Grip, a name, or None for a released handle. ``quantum`` in m is that of the
    sensor for which the velocity estimator is designed. Raise ParameterError for an invalid argument.
    """
    loop = checked_loop(mass, viscous, damping, rate, delay, estimator, hand, quantum)
    return sampled_loop.stiffness_limit(loop, damping)


def simple_rule(setting: LoopSettings, damping: np.ndarray) -> np.ndarray:
    """Return (b₀ + b) / (T/2 + td) in N/m, the rule of Gil et al. (2009), which is optimistic for large b."""
    own = setting.total_viscous
    return (own + np.asarray(damping)) / (0.5 * setting.period + setting.delay)


def coulomb_line(setting: LoopSettings) -> float:
    """Return the stiffness 2 f_c/Δ in N/m above which friction no longer hides the sensor's steps.

    Abbott & Okamura, T-RO 21(5), 2005.
    """
    return 2.0 * setting.coulomb / setting.quantum if setting.quantum > 0.0 else math.inf
