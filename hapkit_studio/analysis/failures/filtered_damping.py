"""Damping that reduces stability: a slow second-order velocity filter lowers the largest stable stiffness."""

import math

import numpy as np

from hapkit_studio.analysis.checks import bisected
from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.failures.filters import bound, over_damping
from hapkit_studio.dynamics.estimators import Spec

# N·s/m: largest damping that is tried
MOST = 20.0
_SCAN = np.linspace(0.0, MOST, 41)
_HALVINGS = 25


def spec(case: base.Case) -> Spec:
    """Return the Butterworth filter of a case."""
    return ("butterworth", {"cutoff": case["cutoff"]})


@base.remembered
def limit(case: base.Case) -> float:
    """Return the damping in N·s/m up to which the spring is stable; 0 if it never is, inf if it always is."""

    def stable(damping: float) -> bool:
        return bound(case, damping, spec(case)) >= case["stiffness"]

    holding = np.flatnonzero([stable(damping) for damping in _SCAN])
    if not len(holding):
        return 0.0
    last = int(holding[-1])
    if last == len(_SCAN) - 1:
        return math.inf
    return bisected(stable, _SCAN[last], _SCAN[last + 1], _HALVINGS)[0]


def live(damping: float, case: base.Case) -> base.Live:
    """Return the live settings of a spring with this damping and the case's filter."""
    given = {"stiffness": case["stiffness"]}
    return spring.live(damping, limit(case), spring.DAMPING, given, spring.loop_of(case, spec(case)))


FAILURE = base.Failure(
    key="filtered_damping",
    title="Damping that reduces stability",
    summary="With a slow velocity filter (20 Hz), more virtual damping makes a spring less stable",
    formula="Example with 0.05 kg, 0.5 N·s/m, 1 kHz and a Butterworth filter of 20 Hz: the stiffness limit "
    "is 1,002 N/m with virtual damping b = 0, and 760 N/m with b = 1 N·s/m",
    explanation="A spring near its limit oscillates at 150 rad/s, 24 Hz. At this frequency the output of a "
    "second-order low-pass of 20 Hz is more than a quarter of a period late. The damping force then adds "
    "energy instead of removing it, so every added N·s/m makes the spring less stable. With an unfiltered "
    "backward difference the same damping would triple the limit.",
    knob=base.Parameter(
        "damping",
        "Virtual damping",
        "N·s/m",
        0.5,
        0.0,
        MOST,
        "Virtual damping, computed from the filtered velocity",
        "b",
    ),
    limit=limit,
    probe=lambda b, case: spring.evidence(spring.setting(case, spec(case)), b, case["stiffness"]),
    plot=over_damping(
        lambda case: np.linspace(0.0, min(2.5 * limit(case) or 2.0, MOST), 41),
        4,
        spec,
        boundary="limit",
        level=lambda case: case["stiffness"],
        level_label="stiffness of the spring",
    ),
    options=(
        base.Parameter(
            "stiffness", "Stiffness", "N/m", 900.0, 10.0, 20_000.0, "Stiffness of the rendered spring", "k"
        ),
        base.Parameter(
            "cutoff",
            "Corner frequency",
            "Hz",
            20.0,
            5.0,
            200.0,
            "Corner frequency of the Butterworth filter",
            "f",
        ),
        *spring.HANDLE,
    ),
    live=live,
    span=(0.0, 2.0),
    order=5,
)
