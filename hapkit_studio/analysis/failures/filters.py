"""A spring and damper behind a velocity filter: what each linear estimator leaves of the stable stiffness."""

from collections.abc import Callable

import numpy as np

from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.failures.in_window import pulled
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.analysis.stability.rendered import measured_stiffness_limit
from hapkit_studio.dynamics.estimators import Spec, parse

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
_MEASURED = _DAMPINGS[::2]


def spec(case: base.Case) -> Spec:
    """Return the estimator of a case."""
    return list(ESTIMATORS.values())[int(case["estimator"])][1]


def bound(
    case: base.Case, damping: float, estimator: Spec, find: Callable[..., float] = stiffness_limit
) -> float:
    """Return the limit in N/m of a case with another virtual damping and estimator."""
    arguments = {"rate": case["rate"], "delay": case["delay"], "estimator": estimator}
    return find(case["mass"], case["viscous"], damping=damping, **arguments)


def limit(case: base.Case) -> float:
    """Return the exact limit in N/m with this filter; 0 where the damping alone is unstable."""
    return bound(case, case["damping"], spec(case))


def probe(stiffness: float, case: base.Case) -> base.Evidence:
    """Let the handle go 1 mm from the centre of the rendered spring and damper."""
    return spring.evidence(spring.setting(case, spec(case)), case["damping"], stiffness)


def curve(case: base.Case, progress: base.Progress) -> base.Chart:
    """Return the largest stable stiffness over the virtual damping: exact, rendered, and without a filter."""
    chosen, measured = spec(case), []
    for done, damping in enumerate(_MEASURED, 1):
        measured.append(bound(case, damping, chosen, measured_stiffness_limit))
        progress(done, len(_MEASURED))
    label = list(ESTIMATORS.values())[int(case["estimator"])][0]
    plain = np.array([bound(case, b, "difference") for b in _DAMPINGS])
    lines = (
        base.Line("no filter", _DAMPINGS, plain, base.OTHER),
        base.Line(
            f"{label}, exact", _DAMPINGS, np.array([bound(case, b, chosen) for b in _DAMPINGS]), base.THEORY
        ),
        base.Line("rendered", _MEASURED, np.array(measured)),
    )
    marks = (base.Mark("this damping", case["damping"]),)
    return base.Chart("virtual damping, N·s/m", "largest stable stiffness, N/m", lines, marks)


def options_of(estimator: Spec) -> dict[str, object]:
    """Return an estimator as the window's loop takes it."""
    arguments = () if isinstance(estimator, str) else tuple(estimator[1].items())
    return {"estimator": parse(estimator)[0].key, "options": arguments}


def live(stiffness: float, case: base.Case) -> base.Live:
    """Return the spring and damper in the window behind this filter."""
    most = limit(case)
    loop_ = {"rate": case["rate"], "delay": case["delay"], **options_of(spec(case))}

    def make(value: float) -> base.Live:
        arguments = {"stiffness": base.short(value, most), "damping": case["damping"], "center": 0.0}
        return base.Live("spring", base.within("spring", arguments), loop_)

    return pulled(make, stiffness, most, "stiffness", "N/m")


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
    knob=base.Parameter(
        "stiffness", "Stiffness", "N/m", 2000.0, 1.0, 200_000.0, "Of the rendered spring", "K"
    ),
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
        spring.MASS,
        spring.VISCOUS,
        spring.RATE,
        spring.DELAY,
    ),
    live=live,
    order=4,
)
