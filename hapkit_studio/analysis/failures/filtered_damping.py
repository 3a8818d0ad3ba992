"""Damping that makes it worse: behind a slow second-order filter it lowers the stable stiffness."""

import math
from functools import lru_cache

import numpy as np

from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.failures.filters import bound, options_of
from hapkit_studio.analysis.failures.in_window import pulled
from hapkit_studio.analysis.stability.rendered import measured_stiffness_limit
from hapkit_studio.dynamics.estimators import Spec

# No damping beyond this is looked at.
MOST = 20.0
_SCAN = np.linspace(0.0, MOST, 41)
_HALVINGS = 25


def spec(case: base.Case) -> Spec:
    """Return the Butterworth filter of a case."""
    return ("butterworth", {"cutoff": case["cutoff"]})


def limit(case: base.Case) -> float:
    """Return the damping in N·s/m up to which the spring is stable: 0 if it never is, inf if always."""
    return _limit(tuple(case.items()))


@lru_cache(maxsize=64)
def _limit(numbers: tuple) -> float:
    case = dict(numbers)
    stable = np.array([bound(case, b, spec(case)) >= case["stiffness"] for b in _SCAN])
    if not stable.any():
        return 0.0
    last = int(np.flatnonzero(stable)[-1])
    if last == len(_SCAN) - 1:
        return math.inf
    low, high = _SCAN[last], _SCAN[last + 1]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if bound(case, middle, spec(case)) >= case["stiffness"] else (low, middle)
    return float(low)


def probe(damping: float, case: base.Case) -> base.Evidence:
    """Let the handle go 1 mm from the centre of the rendered spring with this much damping."""
    return spring.evidence(spring.setting(case, spec(case)), damping, case["stiffness"])


def curve(case: base.Case, progress: base.Progress) -> base.Chart:
    """Return the largest stable stiffness over the virtual damping, exact and rendered."""
    most = min(2.5 * limit(case) or 2.0, MOST)
    damping = np.linspace(0.0, most, 41)
    points, measured = damping[::4], []
    for done, b in enumerate(points, 1):
        measured.append(bound(case, float(b), spec(case), measured_stiffness_limit))
        progress(done, len(points))
    exact = np.array([bound(case, float(b), spec(case)) for b in damping])
    plain = np.array([bound(case, float(b), "difference") for b in damping])
    lines = (
        base.Line("no filter", damping, plain, "other"),
        base.Line("exact", damping, exact, base.THEORY),
        base.Line("rendered", points, np.array(measured)),
    )
    marks = (base.Mark("limit", limit(case)),)
    return base.Chart(
        "virtual damping, N·s/m",
        "largest stable stiffness, N/m",
        lines,
        marks,
        case["stiffness"],
        "the spring",
    )


def live(damping: float, case: base.Case) -> base.Live:
    """Return the spring in the window with this damping behind the filter."""
    most = limit(case)
    loop_ = {"rate": case["rate"], "delay": case["delay"], **options_of(spec(case))}

    def make(value: float) -> base.Live:
        arguments = {"stiffness": case["stiffness"], "damping": base.short(value, most), "center": 0.0}
        return base.Live("spring", base.within("spring", arguments), loop_)

    return pulled(make, damping, most, "damping", "N·s/m")


FAILURE = base.Failure(
    key="filtered_damping",
    title="Damping that makes it worse",
    summary="Behind a second-order filter of 20 Hz, more virtual damping leaves less stable stiffness",
    formula="0.05 kg, 0.5 N·s/m, 1 kHz, Butterworth 20 Hz: 1002 N/m at B = 0, 760 N/m at B = 1 N·s/m",
    explanation="A spring near its limit swings at 150 rad/s, 24 Hz. A second-order low-pass of 20 Hz "
    "shows the velocity there more than a quarter of a swing late, so the damping force points along "
    "the motion as often as against it and a little more. It no longer takes energy, it gives some. "
    "Every N·s/m added makes the spring less stable; a plain difference with the same damping would "
    "triple its limit.",
    knob=base.Parameter("damping", "Virtual damping", "N·s/m", 0.5, 0.0, MOST, "Behind the filter", "B"),
    limit=limit,
    probe=probe,
    curve=curve,
    options=(
        base.Parameter("stiffness", "Stiffness", "N/m", 900.0, 10.0, 20_000.0, "Of the rendered spring", "K"),
        base.Parameter("cutoff", "Corner", "Hz", 20.0, 5.0, 200.0, "Of the Butterworth filter", "f"),
        spring.MASS,
        spring.VISCOUS,
        spring.RATE,
        spring.DELAY,
    ),
    live=live,
    span=(0.0, 2.0),
    order=5,
)
