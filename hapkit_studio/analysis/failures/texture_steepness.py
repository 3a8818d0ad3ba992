"""Ridges that are too steep for the loop: near a stable point a grating acts as a stiff spring."""

import math

import numpy as np

from hapkit_studio.analysis.failures import base, spring, stroking
from hapkit_studio.analysis.failures.in_window import pulled
from hapkit_studio.analysis.simulated_handle import simulated_handle
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.haptics import rows

# Displacements in wavelengths: the initial one, and the largest at which the valley acts as a linear spring.
START, REACH = 1e-5, 1e-3
# amplitude relative to the start below which rounding errors dominate
DEAD = 1e-6
_POINTER = 0.01  # m: position at which the mouse lets go


def stiffness(amplitude: float, case: base.Case) -> float:
    """Return 2π A/λ in N/m, the steepest slope."""
    return math.tau * amplitude / case["wavelength"]


def limit(case: base.Case) -> float:
    """Return the exact amplitude in N whose steepest slope equals the largest stable stiffness."""
    most = stiffness_limit(case["mass"], case["viscous"], rate=case["rate"])
    return most * case["wavelength"] / math.tau


def probe(amplitude: float, case: base.Case) -> base.Evidence:
    """Release the handle beside the middle of a valley."""
    where, wavelength = spring.setting(case), case["wavelength"]
    device = simulated_handle(where, real=False, position=(0.5 + START) * wavelength)
    count = round(spring.SECONDS * case["rate"])
    out = base.render("texture", stroking.grating(wavelength, amplitude), device, where, count)
    place = out[:, rows.TRUE_POSITION] - 0.5 * wavelength
    n = base.alive(np.abs(place[: base.before_lost(place, REACH * wavelength)]), DEAD * START * wavelength)
    rate = spring.rate_of(where, stiffness(amplitude, case), out[:n])
    return base.growth_evidence(
        1e6 * place[:n],
        where.period,
        rate,
        "position in the valley",
        "µm",
        spring.IDEAL,
    )


def live(amplitude: float, case: base.Case) -> base.Live:
    """Return the live settings of the grating."""
    bound = limit(case)

    def make(value: float) -> base.Live:
        values = stroking.grating(case["wavelength"], base.short(value, bound))
        return base.Live("texture", base.within("texture", values), {"rate": case["rate"], "delay": 0.0})

    return pulled(make, amplitude, bound, "amplitude", "N", _POINTER)


FAILURE = base.Failure(
    key="texture_steepness",
    title="Ridges too steep for the loop",
    summary="Between two ridges, the force acts like a spring; if the ridges are too strong, this spring is "
    "too stiff and buzzes",
    formula="A < b₀ λ/(π T), from 2π A/λ < 2 b₀/T, with amplitude A, damping b₀ of the handle, wavelength λ "
    "and period T",
    explanation="The force of equal ridges with amplitude A and wavelength λ changes by up to 2π A/λ per "
    "metre. This slope acts like the stiffness of a spring, so it must stay below 2 b₀/T. Finer "
    "ridges must be weaker: at most 0.8 N for λ = 5 mm and 0.16 N for λ = 1 mm, with a damping b₀ of "
    "0.5 N·s/m at 1 kHz. Beyond the limit the texture buzzes even under a finger that does not move.",
    knob=base.Parameter("amplitude", "Amplitude", "N", 0.8, 1e-4, 50.0, "Largest force of a ridge", "A"),
    limit=limit,
    probe=probe,
    plot=base.Plot(
        "amplitude, N",
        np.linspace(0.5, 1.5, 21),
        (
            base.Curve("theory", lambda a, case: spring.exact(case, stiffness(a, case)).real, base.THEORY),
            base.Curve("simulation"),
        ),
        "exact limit",
        lambda case: {"b₀ λ/(π T)": case["viscous"] * case["wavelength"] * case["rate"] / math.pi},
    ),
    options=(stroking.WAVELENGTH, spring.MASS, spring.VISCOUS, spring.RATE),
    live=live,
    order=10,
)
