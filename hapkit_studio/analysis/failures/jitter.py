"""A loop with periodic jitter, and its limits at the nominal rate and at the longest period."""

import math
from dataclasses import replace
from itertools import groupby

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.checks import bisected
from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.simulated_handle import simulated_handle
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.haptics import headless, rows

_NEAR, _POINTS = np.array([0.96, 0.98, 0.99, 1.0, 1.01, 1.02, 1.04, 1.06]), 24
_HALVINGS = 50
# amplitude relative to the start below which rounding errors dominate
DEAD = 1e-12
_SCAN = 200


def pattern(case: base.Case) -> tuple[float, ...]:
    """Return the repeating pattern of periods in s: several usual periods, then a long one."""
    period = 1.0 / case["rate"]
    return (period,) * round(case["usual"]) + (case["long"] * period,)


def exact(stiffness: float, case: base.Case, periods: tuple[float, ...]) -> float:
    """Return the growth in 1/s from the exact map over all periods of the pattern."""
    whole = np.eye(4)
    for period, times in _runs(periods):
        one = spring.step_matrix(case["mass"], case["viscous"], stiffness, 0.0, period, 0.0)
        whole = np.linalg.matrix_power(one, times) @ whole
    return spring.largest_root(whole, sum(periods)).real


def _runs(periods: tuple[float, ...]) -> list[tuple[float, int]]:
    """Run-length encode the periods: (period in s, count)."""
    return [(period, len(list(same))) for period, same in groupby(periods)]


def worst(case: base.Case) -> float:
    """Return the limit in N/m of a loop in which every period is the longest one."""
    return stiffness_limit(case["mass"], case["viscous"], rate=1.0 / max(pattern(case)))


def nominal(case: base.Case) -> float:
    """Return the limit in N/m at the nominal rate."""
    return stiffness_limit(case["mass"], case["viscous"], rate=case["rate"])


@base.remembered
def limit(case: base.Case) -> float:
    """Return the exact limit in N/m: the smallest stiffness at which motions grow with this pattern."""
    periods = pattern(case)
    scan = np.linspace(worst(case), 1.001 * nominal(case), _SCAN)
    grows = [exact(k, case, periods) > 0.0 for k in scan]
    if grows[0] or not any(grows):
        return float(scan[0 if grows[0] else -1])
    first = int(np.argmax(grows))
    return bisected(lambda k: exact(k, case, periods) <= 0.0, scan[first - 1], scan[first], _HALVINGS)[0]


def swing(stiffness: float, case: base.Case) -> np.ndarray:
    """Return the simulated position and speed (n, 2) of a released handle, one sample per pattern."""
    where, periods = spring.setting(case), pattern(case)
    device = simulated_handle(where, real=False, position=spring.START)
    values = {"stiffness": stiffness, "damping": 0.0, "center": 0.0}
    r, body = headless.Scene(environments.named("spring"), values, device, where).prepare()
    runs = _runs(periods)
    longest = max(times for _, times in runs)
    room, still = headless.new_rows(longest), np.zeros(longest + 1)
    letting_go, no_hand = np.zeros(longest, dtype=np.int64), np.zeros(3)
    seen = np.empty((math.ceil(spring.SECONDS / sum(periods)), 2))
    for index in range(len(seen)):
        for number, (period, times) in enumerate(runs):
            r.block.settings.period = period
            headless.run_batch(r, body, no_hand, still, letting_go, room[:times])
            if number == 0:
                seen[index] = room[0, [rows.TRUE_POSITION, rows.TRUE_VELOCITY]]
        if not abs(seen[index, 0]) < spring.REACH:
            return seen[: index + 1]
    return seen


def rate_of(stiffness: float, case: base.Case, seen: np.ndarray) -> float:
    """Return the growth in 1/s of a motion from its position and speed (n, 2), sampled once per pattern."""
    size = np.hypot(seen[:, 0], seen[:, 1] * math.sqrt(case["mass"] / stiffness))
    half = base.alive(size, DEAD * spring.START) // 2
    if not half:
        return math.inf
    # The samples are one pattern apart, so their phase is arbitrary: compare the maxima of both halves.
    first, second = size[:half].max(), size[half : 2 * half].max()
    return float(np.log(second / first) / (half * sum(pattern(case))))


def probe(stiffness: float, case: base.Case) -> base.Evidence:
    """Release the handle 1 mm from the centre of a spring in a loop with jitter."""
    seen = swing(stiffness, case)
    place = 1e3 * seen[: base.before_lost(seen[:, 0], spring.REACH), 0]
    return base.growth_evidence(place, sum(pattern(case)), rate_of(stiffness, case, seen))


def charted(case: base.Case) -> np.ndarray:
    """Return the stiffnesses (n,) in N/m of the chart."""
    even = np.linspace(0.5 * worst(case), 1.05 * nominal(case), _POINTS)
    return np.union1d(limit(case) * _NEAR, even)


def always_late(stiffness: float, case: base.Case) -> float:
    """Return the growth in 1/s if every period is the longest one; NaN beyond the chart's range."""
    rate = exact(stiffness, case, (max(pattern(case)),))
    return rate if rate <= 2.05 * max(exact(k, case, pattern(case)) for k in charted(case)) else math.nan


def live(stiffness: float, case: base.Case) -> base.Live:
    """Return the live settings of the spring, in a loop that always has the longest period."""
    loop = {**spring.loop_of(case), "rate": base.live_rate(1.0 / max(pattern(case)))}
    found = spring.live(stiffness, limit(case), spring.STIFFNESS, {}, loop)
    return replace(found, advice=f"In the window, every period is as long as the long one. {found.advice}")


FAILURE = base.Failure(
    key="jitter",
    title="A loop that is sometimes late",
    summary="A stiffness that is stable at the nominal rate becomes unstable when some samples come late",
    formula="Safe: k < 2 b₀/T, with stiffness k, damping b₀ of the handle and the longest period T. The "
    "exact limit is computed from a whole cycle: the usual periods and one long period",
    explanation="The force of a spring stays constant in each period T. At a speed v this adds the energy "
    "½ k v² T², so a period that is five times as long adds 25 times as much. The handle's damping removes "
    "b₀ v² T, only five times as much. In the worst case, a long period comes each time the handle is "
    "fastest. A stiffness is safe in every case if k < 2 b₀/T, where T is the longest period.",
    knob=replace(spring.STIFFNESS, default=500.0, high=50_000.0),
    limit=limit,
    probe=probe,
    plot=base.Plot(
        "stiffness, N/m",
        charted,
        (
            base.Curve("theory", lambda k, case: exact(k, case, pattern(case)), base.THEORY),
            base.Curve("simulation"),
            base.Curve(
                "theory, never late", lambda k, case: exact(k, case, (1.0 / case["rate"],)), base.OTHER
            ),
            base.Curve("theory, always late", always_late, base.OTHER),
        ),
        "exact limit",
        lambda case: {"limit of the longest period": worst(case), "limit of the usual period": nominal(case)},
    ),
    options=(
        base.Parameter(
            "usual", "Usual periods", "", 24.0, 1.0, 500.0, "Number of usual periods between two long periods"
        ),
        base.Parameter(
            "long", "Long period", "periods", 5.0, 1.0, 20.0, "Long period divided by the usual period"
        ),
        spring.MASS,
        spring.VISCOUS,
        spring.RATE,
    ),
    live=live,
    order=6,
)
