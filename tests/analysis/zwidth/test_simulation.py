"""The simulated Z-width and its search agree with published tables and with an independent program."""

import math
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np
import pytest

from hapkit_studio.analysis.zwidth import simulation
from hapkit_studio.analysis.zwidth.result import (
    BUZZES,
    HIGHEST,
    Point,
    Protocol,
    TrialOutcome,
    band_trials,
    stiffest,
    text,
    with_band,
)
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import ParameterError
from tests.wide import wide

M, VISCOUS, COULOMB, QUANTUM, T = 0.05, 0.5, 0.1, 15e-6, 1e-3
SPEED, PUSH = 0.1, 1.0


def slide(v, force, t):
    """Return distance and speed after a time t, from the solution of m v' = force - b v."""
    end = force / VISCOUS
    fall = math.exp(-VISCOUS / M * t)
    return end * t + (v - end) * (1.0 - fall) * M / VISCOUS, end + (v - end) * fall


def period(x, v, force):
    """Return (x, v) after a period with a constant force and Coulomb friction, with at most one stop."""
    left = T
    for _ in range(2):
        if v == 0.0:
            if abs(force) <= COULOMB:
                return x, 0.0
            sign = math.copysign(1.0, force)
        else:
            sign = math.copysign(1.0, v)
        net = force - sign * COULOMB
        end = net / VISCOUS
        stops = v != 0.0 and end * sign < 0.0
        stop = M / VISCOUS * math.log((v - end) / -end) if stops else math.inf
        if stop >= left:
            way, v = slide(v, net, left)
            return x + way, v
        x, v, left = x + slide(v, net, stop)[0], 0.0, left - stop
    return x, v


def rests(stiffness, damping, phase):
    """Return True if the handle stays near the wall and ends within two counts."""
    x, v = -phase * SPEED * T, SPEED
    before = QUANTUM * math.floor(x / QUANTUM)
    low, high = math.inf, -math.inf
    for k in range(4000):
        seen = QUANTUM * math.floor(x / QUANTUM)
        wall = -(stiffness * seen + damping * (seen - before) / T) if seen > 0.0 else 0.0
        before = seen
        if k >= 3500:
            low, high = min(low, x), max(high, x)
        x, v = period(x, v, PUSH + wall)
        if abs(x) > 0.2:
            return False
    return high - low <= 2.0 * QUANTUM


def plain_holds(stiffness, damping):
    """Return True if the wall passes at three sampling phases."""
    return all(rests(stiffness, damping, phase) for phase in (1 / 6, 3 / 6, 5 / 6))


DAMPING = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
ALPHA_02 = ("iir", {"cutoff": -math.log(0.8) / (2.0 * math.pi * 1e-3)})
CAPPED = 200.0 * 1.3**22  # upper end of the reference's search in N/m


def device(coulomb=0.1, quantum=15e-6, rate=1000.0, **more):
    return LoopSettings(rate, mass=0.05, viscous=0.5, coulomb=coulomb, quantum=quantum, **more)


REFERENCE = {
    "f_c 0": (device(0.0), (709, 1655, 2452, 3927, 6951, 11002, 17176)),
    "f_c 0.1": (device(), (3834, 5162, 6411, 8681, 14580, 22461, 34284)),
    "60 µm": (device(quantum=60e-6), (3824, 5105, 6256, 8404, 13601, 19918, 23420)),
    "iir": (device(estimator=ALPHA_02), (3834, 4365, 4802, 5523, 6964, 8373, 9647)),
    "td = T": (device(delay=1e-3), (827, 1243, 1627, 2340, 4192, 6630, 9222)),
    "T 0.5 ms": (device(rate=2000.0), (10884, 13745, 16240, 21111, 33784, 50795, CAPPED)),
}


@cache
def measured(name):
    """Return the Z-width of a device in REFERENCE, computed by threads of normal priority."""
    with ThreadPoolExecutor(2) as threads:
        return simulation.compute(REFERENCE[name][0], DAMPING, executor=threads)


@pytest.mark.parametrize("name", wide(REFERENCE, lambda name: name == "f_c 0.1"))
def test_the_result_agrees_with_the_reference_table(name):
    (setting, expected), found = REFERENCE[name], measured(name)
    # from the first wall that fails to the last that passes, both outcomes occur, and the reference's search
    # may end anywhere in this range
    high = np.array([max(p.stiffness, p.last_held) for p in found.points]) / np.array(expected)
    share = np.clip(1.0, found.stiffness / np.array(expected), high)
    # without friction, the motion after 4 s is random: other sampling phases change the same two cells of 56
    loose = np.array([setting.coulomb == 0.0 and b in (2.0, 5.0) for b in DAMPING])
    assert np.abs(share[:-1] - 1.0)[~loose[:-1]].max() < 0.025
    assert np.abs(share - 1.0)[loose].max(initial=0.0) < 0.06
    if expected[-1] == CAPPED:
        assert high[-1] > 1.0
    else:
        assert abs(share[-1] - 1.0) < 0.03


@pytest.mark.parametrize("damping", [0.0, 1.0])
def test_the_result_agrees_with_a_plain_program(damping):
    limit = measured("f_c 0.1").stiffness[DAMPING.index(damping)]
    assert plain_holds(0.99 * limit, damping)
    assert not plain_holds(1.01 * limit, damping)


def test_a_constant_push_settles_where_push_and_spring_balance():
    setting, protocol = device(0.0, 0.0), Protocol(push=0.5)
    out = simulation.hit(setting, 400.0, 1.0, 0.5, protocol)
    assert out[0, simulation.rows.TRUE_VELOCITY] == pytest.approx(0.1)
    assert out[0, simulation.rows.TRUE_POSITION] == pytest.approx(-0.5 * 0.1 * 1e-3)
    assert out[-1, simulation.rows.TRUE_POSITION] == pytest.approx(0.5 / 400.0, rel=1e-6)


def test_a_saturated_motor_is_reported():
    weak = simulation.compute(device(), (5.0,), Protocol(max_force=2.0))
    assert weak.points[0].clamped
    assert "with the motor at its limit of 2 N" in text(weak)
    assert "force limit 2 N" in weak.caption


def test_the_result_contains_the_linear_limit():
    found = measured("f_c 0.1")
    assert found.linear[[0, 3]] == pytest.approx([1001.7, 4812.9], abs=0.1)
    assert found.curve[1, [0, -1]] == pytest.approx(found.linear[[0, -1]])
    assert not any(point.clamped for point in found.points)
    numbers = simulation.compute(device(estimator="foaw"), (0.0,), Protocol(halvings=1)).as_json()
    assert numbers["points"][0]["linear_limit"] is None


@pytest.mark.slow
def test_points_arrive_in_order_and_any_executor_finds_the_same():
    seen, done = [], []
    setting = device()
    mine = simulation.compute(
        setting, (5.0, 0.0, 1.0, 1.0), progress=lambda *a: done.append(a),
        arrived=lambda b, point: seen.append((b, point.stiffness)),
    )  # fmt: skip
    assert [b for b, _ in seen] == list(mine.damping) == [0.0, 1.0, 5.0]
    assert [k for _, k in seen] == list(mine.stiffness)
    assert done == sorted(done)
    assert done[-1] == (3, 3)
    assert np.array_equal(measured("f_c 0.1").stiffness[[0, 2, 4]], mine.stiffness)


def test_at_least_one_damping_is_required():
    with pytest.raises(ParameterError, match="at least one value of damping"):
        simulation.compute(device(), ())


def up_to(limit, tried=None, clamped_from=math.inf):
    tried = [] if tried is None else tried

    def held(stiffness):
        tried.append(stiffness)
        return TrialOutcome(BUZZES if stiffness > limit else "", stiffness >= clamped_from)

    return held


def test_search_accuracy_is_that_of_its_bisection():
    for limit in (200.0, 201.0, 700.0, 999.0):
        found = stiffest(up_to(limit), 200.0, 1.3, 1e6, 14)
        assert 0.0 <= limit - found.stiffness <= 0.3 * limit / 2**14
        assert found.ended == BUZZES


def test_search_ends_at_the_highest_stiffness():
    tried = []
    found = stiffest(up_to(1e9, tried, clamped_from=900.0), 200.0, 2.0, 1000.0, 5)
    assert tried == [200.0, 400.0, 800.0, 1000.0]
    assert (found.stiffness, found.ended, found.clamped) == (1000.0, HIGHEST, True)


def test_result_is_the_bands_lower_end():
    tried = []

    def held(stiffness):
        tried.append(stiffness)
        holds = stiffness < 850.0 or 870.0 < stiffness < 900.0 or 960.0 < stiffness < 1020.0
        return TrialOutcome("" if holds else BUZZES)

    point = with_band(held, Point(899.0, BUZZES, True, 900.5, 899.0), 0.01, 200.0, 1e6)
    assert 850.0 <= point.first_failed < 1.01 * 850.0
    assert point.stiffness == pytest.approx(point.first_failed / 1.01), "the last one below that was tried"
    assert point.stiffness in tried
    assert not point.clamped, "the wall named did not need the motor's limit"
    assert 1020.0 / 1.01 < point.last_held < 1020.0
    # the search goes down until ten walls in a row pass, and up until ten in a row fail
    assert min(tried) == pytest.approx(point.first_failed / 1.01**10)
    assert max(tried) == pytest.approx(point.last_held * 1.01**10)


@pytest.mark.slow
def test_all_walls_pass_up_to_the_result_and_some_fail_above():
    (point,) = simulation.compute(LoopSettings(), (20.0,)).points
    below = point.stiffness / 1.01 ** np.arange(band_trials(0.01))
    assert [simulation.trial(LoopSettings(), k, 20.0).why for k in below] == [""] * len(below)
    assert point.stiffness < point.first_failed <= 1.01 * point.stiffness < point.last_held
    assert simulation.trial(LoopSettings(), point.first_failed, 20.0).why == BUZZES
    assert simulation.trial(LoopSettings(), point.last_held, 20.0).why == ""


def test_a_sharp_limit_has_no_band():
    tried = []
    point = with_band(up_to(1000.0, tried), Point(999.0, BUZZES, False, 1001.0, 999.0), 0.01, 1.0, 1e6)
    assert point == Point(999.0, BUZZES, False, 1001.0, 999.0)
    assert point.band == ""
    assert len(tried) == 2 * band_trials(0.01) == 20


def test_the_band_stays_within_the_search_range():
    tried, unlimited = [], Point(1000.0, HIGHEST, False, last_held=1000.0)
    with_band(up_to(1000.0, tried), Point(1000.0, BUZZES, False, 1010.0, 1000.0), 0.05, 980.0, 1049.0)
    assert with_band(up_to(1000.0, tried), unlimited, 0.05, 200.0, 1e6) == unlimited
    assert tried == []
