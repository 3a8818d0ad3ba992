"""A spring and damper behind a velocity filter: what each linear estimator leaves of the stable stiffness."""

from collections.abc import Callable
from dataclasses import replace

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
_DAMPINGS = np.linspace(0.0, 10.0, 21)


def chosen(case: base.Case) -> tuple[str, Spec]:
    """Return the label and the estimator of a case."""
    return list(ESTIMATORS.values())[int(case["estimator"])]


def bound(
    case: base.Case, damping: float, estimator: Spec, find: Callable[..., float] = stiffness_limit
) -> float:
    """Return the limit in N/m of a case with another virtual damping and estimator."""
    arguments = {"rate": case["rate"], "delay": case["delay"], "estimator": estimator}
    return find(case["mass"], case["viscous"], damping=damping, **arguments)


def limit(case: base.Case) -> float:
    """Return the exact limit in N/m with this filter; 0 where the damping alone is unstable."""
    return bound(case, case["damping"], chosen(case)[1])


def probe(stiffness: float, case: base.Case) -> base.Evidence:
    """Let the handle go 1 mm from the centre of the rendered spring and damper."""
    return spring.evidence(spring.setting(case, chosen(case)[1]), case["damping"], stiffness)


def limits_over(
    dampings: np.ndarray, every: int, case: base.Case, spec: Spec, label: str, progress: base.Progress
) -> tuple[base.Line, ...]:
    """Return the limits over virtual damping (n,): without a filter, exact; rendered for every so many."""
    plain, exact = (np.array([bound(case, b, one) for b in dampings]) for one in ("difference", spec))
    few = dampings[::every]
    measured = base.swept(few, lambda b: bound(case, b, spec, measured_stiffness_limit), progress)
    return (
        base.Line("no filter", dampings, plain, base.OTHER),
        base.Line(label, dampings, exact, base.THEORY),
        base.Line("rendered", few, measured),
    )


def curve(case: base.Case, progress: base.Progress) -> base.Chart:
    """Return the largest stable stiffness over the virtual damping: exact, rendered, and without a filter."""
    label, spec = chosen(case)
    lines = limits_over(_DAMPINGS, 2, case, spec, f"{label}, exact", progress)
    marks = (base.Mark("this damping", case["damping"]),)
    return base.Chart("virtual damping, N·s/m", "largest stable stiffness, N/m", lines, marks)


def live(stiffness: float, case: base.Case) -> base.Live:
    """Return the spring and damper in the window behind this filter."""
    loop = spring.loop_of(case, chosen(case)[1])
    return spring.live(stiffness, limit(case), spring.STIFFNESS, {"damping": case["damping"]}, loop)


FAILURE = base.Failure(
    key="filters",
    title="A velocity filter inside the loop",
    summary="What smooths the velocity also delays it, and lowers the stiffness that stays stable",
    formula="K of the first root of 1 + (K + B H(z)) P(z) = 0 on |z| = 1, H the filter, P the held handle",
    explanation="The damping force is computed from a filtered velocity. The filter takes the noise out, "
    "but what it shows is the velocity of some time ago, 1/(2π f) for a first-order low-pass. Old "
    "velocity damps less, and beyond a quarter of a swing it pushes. So the same virtual damping B "
    "buys less stiffness the lower the corner, and a second-order filter less than a first-order "
    "one.",
    knob=replace(spring.STIFFNESS, default=2000.0),
    limit=limit,
    probe=probe,
    curve=curve,
    options=(
        base.Choice(
            "estimator",
            "Velocity filter",
            tuple(ESTIMATORS),
            "iir",
            labels=tuple(label for label, _ in ESTIMATORS.values()),
        ),
        base.Parameter("damping", "Virtual damping", "N·s/m", 2.0, 0.0, 20.0, "Of the rendered spring", "B"),
        *spring.HANDLE,
    ),
    live=live,
    order=4,
)
