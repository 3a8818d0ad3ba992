"""A spring and damper with a velocity filter: the largest stable stiffness with each linear estimator."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.analysis.stability.rendered import measured_stiffness_limit
from hapkit_studio.dynamics.estimators import Spec

ESTIMATORS: dict[str, tuple[str, Spec]] = {
    "difference": ("None", "difference"),
    "iir_100": ("Low-pass 100 Hz", ("iir", {"cutoff": 100.0})),
    "iir": ("Low-pass 35.5 Hz", "iir"),
    "iir_20": ("Low-pass 20 Hz", ("iir", {"cutoff": 20.0})),
    "butterworth": ("Butterworth 60 Hz", "butterworth"),
    "butterworth_20": ("Butterworth 20 Hz", ("butterworth", {"cutoff": 20.0})),
    "kalman": ("Kalman", "kalman"),
}


def chosen(case: base.Case) -> Spec:
    """Return the estimator of a case."""
    return list(ESTIMATORS.values())[int(case["estimator"])][1]


def bound(
    case: base.Case, damping: float, estimator: Spec, find: Callable[..., float] = stiffness_limit
) -> float:
    """Return the limit in N/m of a case whose virtual damping and estimator are replaced."""
    arguments = {"rate": case["rate"], "delay": case["delay"], "estimator": estimator}
    return find(case["mass"], case["viscous"], damping=damping, **arguments)


def limit(case: base.Case) -> float:
    """Return the case's exact limit in N/m; 0 if the damping alone makes the loop unstable."""
    return bound(case, case["damping"], chosen(case))


def over_damping(
    dampings: Callable[[base.Case], np.ndarray], every: int, spec: Callable[[base.Case], Spec], **more: Any
) -> base.Plot:
    """Return a plot of the limit over damping with three curves: without a filter, exact, and simulated.

    Every ``every``-th value is simulated.
    """

    def exact(damping: float, case: base.Case) -> float:
        return bound(case, damping, spec(case))

    def rendered(damping: float, case: base.Case) -> float:
        return bound(case, damping, spec(case), measured_stiffness_limit)

    curves = (
        base.Curve(
            "theory without filter", lambda damping, case: bound(case, damping, "difference"), base.OTHER
        ),
        base.Curve("theory with filter", exact, base.THEORY),
        base.Curve("simulation with filter", rendered, at=lambda case: dampings(case)[::every]),
    )
    y_label = "largest stable stiffness, N/m"
    return base.Plot("virtual damping, N·s/m", dampings, curves, y_label=y_label, **more)


def live(stiffness: float, case: base.Case) -> base.Live:
    """Return the live settings of a spring and damper with the case's filter."""
    loop = spring.loop_of(case, chosen(case))
    return spring.live(stiffness, limit(case), spring.STIFFNESS, {"damping": case["damping"]}, loop)


FAILURE = base.Failure(
    key="filters",
    title="A velocity filter inside the loop",
    summary="A filter that smooths the velocity also delays it, and lowers the largest stable stiffness",
    formula="The limit is the smallest stiffness k at which an oscillation neither grows nor decays: "
    "1 + (k + b H(z)) P(z) = 0 has a solution with |z| = 1, with virtual damping b, filter H and handle P",
    explanation="The damping force is computed from a filtered velocity. The filter removes noise, but its "
    "output is late, by about 1/(2π f) for a first-order low-pass with corner frequency f. Late damping "
    "removes less energy, and if it is late by more than a quarter of a period, it adds energy. So a filter "
    "with a lower corner frequency lowers the stiffness limit, and a second-order filter lowers it more than "
    "a first-order filter.",
    knob=replace(spring.STIFFNESS, default=2000.0),
    limit=limit,
    probe=lambda k, case: spring.evidence(spring.setting(case, chosen(case)), case["damping"], k),
    plot=over_damping(
        lambda case: np.linspace(0.0, 10.0, 21),
        2,
        chosen,
        marks=lambda case: {"present damping": case["damping"]},
        level=None,
    ),
    options=(
        base.Choice(
            "estimator",
            "Velocity filter",
            tuple(ESTIMATORS),
            "iir",
            labels=tuple(label for label, _ in ESTIMATORS.values()),
        ),
        base.Parameter(
            "damping", "Virtual damping", "N·s/m", 2.0, 0.0, 20.0, "Damping of the rendered spring", "b"
        ),
        *spring.HANDLE,
    ),
    live=live,
    order=4,
)
