"""Exact limits agree with tables, with each other, and with simulation."""

import math
import time

import numpy as np
import pytest
from scipy.linalg import expm

from hapkit_studio import environments
from hapkit_studio.analysis.stability.limits import checked_loop, stable_stiffnesses, stiffness_limit
from hapkit_studio.analysis.stability.rendered import measured_stiffness_limit
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.hand import GRIPS, Grip, Hand
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.dynamics.sampled_loop import stiffness_limits
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import headless, rows


def test_batched_dampings_equal_single_ones():
    damping = np.array([0.0, 0.3, 2.0, 9.0, 60.0, 300.0])
    for delay, estimator in ((0.0, "difference"), (0.4e-3, ("iir", {"cutoff": 20.0})), (7.7e-3, "kalman")):
        loop = {"delay": delay, "estimator": estimator, "hand": "light"}
        together = stiffness_limits(
            checked_loop(0.044, 0.5, 0.0, 1000.0, *loop.values()), np.tile(damping, 7)
        )
        assert list(together) == [stiffness_limit(0.044, 0.5, damping=b, **loop) for b in damping] * 7


VIRTUAL = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0)
# columns: mass, viscous, period in ms, delay in periods, limit for each virtual damping of VIRTUAL, damping
# limit
WITH_DAMPING = [
    (0.05, 0.5, 1, 0, (1001.7, 1983.5, 2945.8, 4812.9, 9974, 17228, 27440, 34959), 100.67),
    (0.05, 0.5, 1, 1, (334.3, 661.1, 980.6, 1597.4, 3268.7, 5448, 7457, 1282), 41.80),
    (0.05, 0.5, 1, 2, (200.9, 396.2, 585.8, 948.0, 1892.2, 2952.5, 2741.5, 0), 27.14),
    (0.05, 1.0, 2, 0, (1006.7, 1480.8, 1936.0, 2792.3, 4962, 7447, 9254, 5098), 51.35),
    (0.05, 0.5, 4, 0, (251.7, 484.0, 698.1, 1075.5, 1861.9, 2313.5, 1274.5, 0), 25.67),
    (0.05, 0.5, 4, 1, (84.2, 161.2, 230.9, 348.0, 515.7, 132.6, 0, 0), 10.73),
    (0.03, 0.5, 1, 0, (1002.8, 1972.7, 2910.5, 4693.1, 9347, 15087, 20699, 16641), 60.67),
    (0.10, 1.0, 1, 0, (2003.3, 2990.1, 3967.0, 5891.6, 11437, 19948, 34457, 54879), 201.3),
]
FILTERED = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0)
WITH_FILTER = [
    ("difference", 0, (1002, 2946, 4813, 9974, 17228, 27440)),
    (("iir", {"cutoff": 100.0}), 0, (1002, 2665, 4020, 7002, 10068, 12989)),
    ("iir", 0, (1002, 1983, 2612, 3784, 4822, 5666)),
    (("iir", {"cutoff": 20.0}), 0, (1002, 1563, 1910, 2544, 3095, 3524)),
    (("butterworth", {"cutoff": 20.0}), 1, (334, 410, 382, 188, 0, 0)),
    ("difference", 1, (334, 981, 1597, 3269, 5448, 7457)),
    ("iir", 1, (334, 772, 1064, 1552, 1805, 1492)),
]
HANDS = [
    (None, 1001.7, 334),
    (Grip(0.0, 1.0, 50.0), 3015, 1009),
    (Grip(0.02, 2.0, 100.0), 5031, 1684),
    (Grip(0.05, 4.0, 200.0), 9070, 3040),
    (Grip(0.10, 8.0, 400.0), 17166, 5761),
]


def rounded(value, digits_of):
    """Return True if a value agrees with a printed number to within its last digit."""
    text = f"{digits_of:g}"
    last = 10.0 ** -(len(text.split(".")[1]) if "." in text else 0)
    return value == pytest.approx(digits_of, abs=1.01 * last, rel=1e-5)


@pytest.mark.parametrize(("mass", "viscous", "period_ms", "late", "limits", "most"), WITH_DAMPING)
def test_limits_with_virtual_damping_agree_with_the_table(mass, viscous, period_ms, late, limits, most):
    loop = {"rate": 1e3 / period_ms, "delay": late * period_ms * 1e-3}
    for damping, limit in zip(VIRTUAL, limits, strict=True):
        assert rounded(stiffness_limit(mass, viscous, damping=damping, **loop), limit)
    assert stiffness_limit(mass, viscous, damping=0.999 * most, **loop) > 0.0
    assert stiffness_limit(mass, viscous, damping=1.001 * most, **loop) == 0.0


@pytest.mark.parametrize(("estimator", "late", "limits"), WITH_FILTER)
def test_limits_with_a_velocity_filter_agree_with_the_table(estimator, late, limits):
    for damping, limit in zip(FILTERED, limits, strict=True):
        got = stiffness_limit(0.05, 0.5, damping=damping, delay=late * 1e-3, estimator=estimator)
        assert rounded(got, limit)


@pytest.mark.parametrize(("hand", "prompt", "late"), HANDS)
def test_limits_with_a_hand_agree_with_the_table(hand, prompt, late):
    assert rounded(stiffness_limit(0.05, 0.5, hand=hand), prompt)
    assert rounded(stiffness_limit(0.05, 0.5, hand=hand, delay=1e-3), late)


def test_the_limit_of_a_spring_without_delay_agrees_with_the_closed_form(rng):
    """Jury's criterion on (z - 1) (z - E) + K (n1 z + n0) gives two conditions.

    Roots leave the unit circle at E + K n0 = 1, or through -1 at K (n1 - n0) = 2 (1 + E).
    """
    for _ in range(40):
        m, b, period = 10 ** rng.uniform(-2, 0), 10 ** rng.uniform(-1, 1.5), 10 ** rng.uniform(-3.5, -2)
        e, leak = math.exp(-b * period / m), -math.expm1(-b * period / m)
        n0, n1 = (m * leak - b * period * e) / b**2, (b * period - m * leak) / b**2
        pair, flip = leak / n0, 2.0 * (1.0 + e) / (n1 - n0)
        lost = 1e-15 * m / abs(n0) * leak / b**2 + 1e-15 * m / b**2 / abs(n1 - n0)
        want = min(pair, flip)
        assert stiffness_limit(m, b, rate=1 / period) == pytest.approx(want, rel=1e-9 + lost)


def closed_loop(mass, viscous, damping, rate, delay, estimator, hand):
    """Return a function that maps stiffnesses (n,) to the loop's matrices (n, s, s) of one period.

    States are x, v, the estimator's recursion and past commands; the matrix exponential gives the plant.
    """
    period = 1.0 / rate
    m, c, k = mass + hand.mass, viscous + hand.damping, hand.stiffness
    a = np.array([[0.0, 1.0, 0.0], [-k / m, -c / m, 1.0 / m], [0.0, 0.0, 0.0]])
    whole = int(delay / period)
    rest = delay - whole * period
    first, second = expm(a * rest), expm(a * (period - rest))
    code, coefs = estimators.design(estimator, rate, estimators.USUAL_QUANTUM)

    def after(state, stiffness):
        memory = np.zeros(estimators.MEMORY)
        memory[:6] = state[2:8]
        velocity = estimators.step(code, coefs, memory, state[0], period)
        commands = [-stiffness * state[0] - damping * velocity, *state[8:]]
        moved = first @ [*state[:2], commands[whole + 1]]
        moved[2] = commands[whole]
        return [*(second @ moved)[:2], *memory[:6], *commands[:-1]]

    units = np.eye(9 + whole)
    free, sprung = (np.column_stack([after(unit, k) for unit in units]) for k in (0.0, 1.0))
    used = np.flatnonzero((sprung != units).any(axis=0))  # some estimators leave parts of the memory unused
    free, sprung = (matrix[np.ix_(used, used)] for matrix in (free, sprung))
    return lambda stiffness: free + np.multiply.outer(stiffness, sprung - free)


def some_loop(rng):
    """Return the arguments of a loop with any filter; half of the loops have a slow second-order filter."""
    mass, viscous, rate = 10 ** rng.uniform(-2, 0), 10 ** rng.uniform(-1, 1), 10 ** rng.uniform(2.3, 4)
    slow = ("butterworth", {"cutoff": 10 ** rng.uniform(0, 2)})
    filters = ["difference", ("iir", {"cutoff": 10 ** rng.uniform(0, 2)}), "kalman", slow, slow, slow]
    return {
        "mass": mass,
        "viscous": viscous,
        "damping": rng.choice([0.0, 10 ** rng.uniform(-2, 0) * mass * rate]),
        "rate": rate,
        "delay": rng.choice([0.0, 1.0, rng.random(), 6.0 * rng.random()]) / rate,
        "estimator": filters[rng.integers(len(filters))],
        "hand": [Grip(0, 0, 0), Grip(0.05, 4.0, 200.0), Grip(0.0, 0.0, 500.0)][rng.integers(3)],
    }


def largest_root(loop, stiffness):
    return np.abs(np.linalg.eigvals(closed_loop(**loop)(np.asarray(stiffness)))).max(axis=-1)


def intervals_checked_by_roots(loop):
    """Return the stable intervals after checking them.

    They agree with the roots of 300 springs, and of springs 0.1 % beside each end.
    """
    found = stable_stiffnesses(**loop)
    ends = np.array([end for interval in found for end in interval if end > 0.0])
    assert largest_root(loop, ends) == pytest.approx(np.ones(ends.size), abs=1e-9)
    most = ends.max() if ends.size else 4.0 * loop["mass"] * loop["rate"] ** 2
    springs = np.r_[np.geomspace(1e-4 * most, 4.0 * most, 300), 0.999 * ends, 1.001 * ends]
    inside = [any(low < k <= high for low, high in found) for k in springs]
    assert ((largest_root(loop, springs) < 1.0) == inside).all(), loop
    assert stiffness_limit(**loop) == (found[0][1] if found and found[0][0] == 0.0 else 0.0)
    return found


@pytest.mark.parametrize("count", [20, pytest.param(150, marks=pytest.mark.slow)])
def test_interval_ends_are_root_crossings(rng, count):
    for _ in range(count):
        intervals_checked_by_roots(some_loop(rng))


BUTTERWORTH = {"mass": 0.03133, "viscous": 0.82441, "damping": 3.2, "rate": 1430.93, "delay": 0.0}
BUTTERWORTH |= {"estimator": ("butterworth", {"cutoff": 10.81613}), "hand": Grip(0.0, 0.0, 0.0)}


@pytest.mark.slow
def test_a_slow_filter_leaves_two_intervals_and_the_limit_is_the_end_of_the_first():
    first, second = intervals_checked_by_roots(BUTTERWORTH)
    assert first[0] == 0.0
    assert first[1] < 0.8 * second[0] < 0.2 * second[1]
    assert measured_stiffness_limit(**BUTTERWORTH) == pytest.approx(first[1], rel=5e-4)


def test_excessive_damping_may_be_stabilised_by_a_spring():
    loop = BUTTERWORTH | {
        "mass": 0.05,
        "viscous": 1.0,
        "damping": 5.4,
        "estimator": ("butterworth", {"cutoff": 5.0}),
    }
    ((low, high),) = intervals_checked_by_roots(loop)
    assert 0.0 < low < high
    assert stiffness_limit(**loop) == measured_stiffness_limit(**loop) == 0.0


@pytest.mark.parametrize("part", [0.99, 1.01])
@pytest.mark.parametrize(
    ("mass", "viscous", "rate", "late", "damping", "hand"),
    [
        (0.05, 0.5, 1000.0, 0.5, 2.0, None),
        (0.044, 1.3, 230.0, 0.25, 0.0, None),
        (0.1, 1.0, 500.0, 2.7, 1.0, None),
        (0.03, 0.2, 2000.0, 1.4, 5.0, None),
        (0.05, 0.5, 1000.0, 0.0, 100.0, None),
        (0.05, 0.5, 1000.0, 0.6, 0.0, GRIPS["medium"]),
    ],
)
def test_one_percent_inside_decays_and_outside_grows(part, mass, viscous, rate, late, damping, hand):
    """The tick renders the linear spring with an ideal sensor, no friction and no force limit.

    The largest amplitudes at 2 to 4 s and at 14 to 16 s are compared.
    """
    loop = LoopSettings(rate, late / rate)
    limit = stiffness_limit(mass, viscous, damping=damping, rate=rate, delay=loop.delay, hand=hand)
    device = SimulatedHapkit(mass, viscous, 0.0, 0.0, math.inf, initial_position=1e-6)
    values = {"stiffness": part * limit, "damping": damping, "center": 0.0}
    grip = Hand(hand.mass, hand.damping, hand.stiffness) if hand else None
    scene = headless.Scene(environments.named("spring"), values, device, loop)
    out, _ = headless.render(scene, grip, int(16 * rate))
    x = np.abs(out[:, rows.TRUE_POSITION])
    early, late_peak = x[int(2 * rate) : int(4 * rate)].max(), x[int(14 * rate) :].max()
    assert early > 0.0
    assert (late_peak < 0.95 * early) if part < 1.0 else (late_peak > 1.05 * early)


@pytest.mark.parametrize(
    "loop",
    [
        {"damping": 2.0, "delay": 0.37e-3},
        {"damping": 2.0, "estimator": "iir", "delay": 0.7e-3},
        {"damping": 1.0, "rate": 4000.0, "delay": 2.1e-3},
        {"hand": Grip(0.0, 1.0, 50.0), "rate": 250.0},
        {"rate": 0.1},
        {"damping": 60.0, "estimator": "kalman"},
    ],
)
def test_the_measured_limit_equals_the_exact_one(loop):
    exact = stiffness_limit(0.05, 0.5, **loop)
    assert measured_stiffness_limit(0.05, 0.5, **loop) == pytest.approx(exact, rel=5e-4)


def test_too_much_virtual_damping_leaves_no_stable_spring():
    assert stiffness_limit(0.05, 0.5, damping=110.0) == 0.0
    assert measured_stiffness_limit(0.05, 0.5, damping=110.0) == 0.0


def test_a_nearly_lossless_handle_has_the_passive_limit():
    for mass, viscous in ((0.05, 1e-12), (1e6, 1e-6), (1e6, 1e-9)):
        for late in (0.0, 1e-3):
            want = viscous / (0.5e-3 + late)
            assert stiffness_limit(mass, viscous, delay=late) == pytest.approx(want, rel=1e-9)


def own_seconds(compute):
    """Return the processor time in s of a computation: the minimum of five runs in this thread."""
    took = []
    for _ in range(5):
        start = time.thread_time()
        compute()
        took.append(time.thread_time() - start)
    return min(took)


@pytest.mark.alone
def test_it_is_fast_enough_for_a_status_bar():
    """Computing the limit takes less than four times as long as computing 100,000 squares in Python.

    With 100 ms of delay at 10 kHz, it takes less than 15 times as long as the squares.
    """
    squares = own_seconds(lambda: sum(i * i for i in range(100_000)))
    assert own_seconds(lambda: stiffness_limit(0.05, 0.5, damping=2.0)) < 4.0 * squares
    late = {"rate": 1e4, "delay": 0.1, "damping": 0.1}
    assert own_seconds(lambda: stiffness_limit(0.05, 0.5, **late)) < 15.0 * squares


def test_the_adaptive_window_has_only_a_measured_limit():
    with pytest.raises(ParameterError, match=r"foaw is not linear.*: measured_stiffness_limit finds it") as e:
        stiffness_limit(0.05, 0.5, damping=1.0, estimator="foaw")
    assert "\n" not in str(e.value)


@pytest.mark.parametrize("late", [pytest.param(0.0, marks=pytest.mark.slow), 1e-3])
def test_the_adaptive_window_is_as_stiff_as_others_without_damping_and_softer_with_it(late):
    """Without damping the estimator has no effect; with damping it lags behind the plain difference."""
    alone = measured_stiffness_limit(0.05, 0.5, delay=late, estimator="foaw")
    assert alone == pytest.approx(stiffness_limit(0.05, 0.5, delay=late), rel=0.01)
    limits = [measured_stiffness_limit(0.05, 0.5, damping=b, delay=late, estimator="foaw") for b in (1, 2, 5)]
    plain = [stiffness_limit(0.05, 0.5, damping=b, delay=late) for b in (1, 2, 5)]
    assert alone < limits[0] < limits[1] < limits[2]
    assert all(0.4 * most < limit < most for limit, most in zip(limits, plain, strict=True))
