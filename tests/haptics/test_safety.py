"""After every fault the force is zero in the same row, and returns only as specified."""

import numpy as np
import pytest

from hapkit_studio.haptics import arrays, rows, tick
from tests.haptics.support import BROKEN, CONSTANT, LoopHarness

FADED_IN = np.arange(1, 31) / 30.0


def applied(out):
    return out[:, rows.APPLIED_FORCE]


def latched(harness):
    return int(harness.r.control.fault[0])


@pytest.mark.parametrize(
    ("how", "code"),
    [
        ("nan", arrays.NOT_A_NUMBER),
        ("inf", arrays.NOT_A_NUMBER),
        ("minus inf", arrays.NOT_A_NUMBER),
        ("index", arrays.LAW_INDEX),
        ("fuel", arrays.LAW_FUEL),
    ],
)
def test_a_failing_law_stops_the_force_until_cleared(how, code):
    harness = LoopHarness(BROKEN, {"how": how})
    assert applied(harness.run([0.0, 0.001, 0.002]))[-1] == 1.0
    row = harness.tick(0.0055)
    assert row[rows.APPLIED_FORCE] == 0.0
    assert row[rows.FLAGS] == rows.FAULT
    assert latched(harness) == code
    out = harness.run(np.full(200, 0.003))
    assert not applied(out).any()
    np.testing.assert_array_equal(out[:, rows.FLAGS], rows.FAULT)
    harness.clear_fault()
    out = harness.run(np.full(40, 0.003))
    np.testing.assert_allclose(applied(out)[:30], FADED_IN, rtol=1e-9)
    np.testing.assert_array_equal(applied(out)[29:], 1.0)
    np.testing.assert_array_equal(out[:, rows.STATE], np.arange(1.0, 41.0))


@pytest.mark.parametrize("how", ["nan", "index", "fuel"])
def test_a_law_that_still_fails_latches_again_at_once(how):
    harness = LoopHarness(BROKEN, {"how": how})
    harness.tick(0.0055)
    for _ in range(3):
        harness.clear_fault()
        row = harness.tick(0.0055)
        assert row[rows.APPLIED_FORCE] == 0.0
        assert row[rows.FLAGS] == rows.FAULT
        assert latched(harness) != arrays.NO_FAULT


def test_a_law_that_fails_during_a_cross_fade_stops_the_force_and_the_first_fault_remains():
    harness = LoopHarness(BROKEN, {"how": "nan"}, max_speed=3.0)
    harness.tick(0.0)
    harness.set(CONSTANT)
    harness.ticks(0.01)
    assert harness.tick(0.0055)[rows.APPLIED_FORCE] == 0.0
    harness.tick(0.0)
    assert latched(harness) == arrays.NOT_A_NUMBER


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_over_speed_latches_in_its_own_row(sign):
    harness = LoopHarness(CONSTANT, max_speed=3.0)
    assert applied(harness.run([0.0, 0.0029 * sign]))[-1] == 1.0
    row = harness.tick(0.0060 * sign)
    assert abs(row[rows.VELOCITY]) == pytest.approx(3.1)
    assert row[rows.APPLIED_FORCE] == 0.0
    assert latched(harness) == arrays.OVER_SPEED
    assert not applied(harness.run(np.full(100, 0.006 * sign))).any()


def test_the_stop_acts_in_the_next_tick_and_its_release_fades_in():
    harness = LoopHarness(CONSTANT)
    assert harness.tick()[rows.APPLIED_FORCE] == 1.0
    harness.stop()
    out = harness.ticks(0.5)
    assert not applied(out).any()
    np.testing.assert_array_equal(out[:, rows.FLAGS], rows.STOPPED)
    np.testing.assert_array_equal(out[:, rows.FORCE], 1.0)
    harness.clear_fault()
    assert not applied(harness.ticks(0.05)).any()
    harness.stop(False)
    np.testing.assert_allclose(applied(harness.ticks(0.03)), FADED_IN, rtol=1e-9)


def test_a_restart_keeps_stop_and_fault_except_a_disconnected_device():
    harness = LoopHarness(CONSTANT, max_speed=3.0)
    harness.run([0.0, 0.005])
    harness.stop()
    arrays.restart(harness.r, 0.0)
    assert latched(harness) == arrays.OVER_SPEED
    assert harness.r.tick.fault_value == pytest.approx(5.0)
    assert harness.tick()[rows.FLAGS] == rows.STOPPED | rows.FAULT
    harness.r.control.fault[0] = arrays.DEVICE_GONE
    harness.stop(False)
    arrays.restart(harness.r, 0.0)
    np.testing.assert_allclose(applied(harness.ticks(0.03)), FADED_IN, rtol=1e-9)


def test_the_force_is_zero_for_a_while_after_connecting():
    harness = LoopHarness(CONSTANT)
    arrays.restart(harness.r, 0.5)
    out = harness.ticks(0.54)
    held = np.count_nonzero(applied(out) == 0.0)
    assert held in (500, 501)
    np.testing.assert_array_equal(out[:held, rows.FLAGS], rows.FADING)
    np.testing.assert_allclose(applied(out)[held : held + 30], FADED_IN, rtol=1e-9)


# --- the sensor is silent
def recovered(out):
    """Return the number of rows whose force is zero before the force returns."""
    zero = np.count_nonzero(out[:, rows.FLAGS].astype(int) & rows.STALE)
    assert not applied(out)[:zero].any()
    np.testing.assert_allclose(applied(out)[zero : zero + 30], FADED_IN, rtol=1e-9)
    return zero


def test_after_a_silent_sensor_the_force_returns_after_100_ms():
    harness = LoopHarness(CONSTANT)
    harness.tick()
    tick.mark_stale(harness.r, 100.0, arrays.NO_SAMPLE)
    assert harness.r.tick.applied == 0.0
    assert recovered(harness.ticks(0.2)) in (100, 101)
    assert harness.r.control.stale_count[0] == 1
    assert latched(harness) == arrays.NO_FAULT


def test_sparse_frames_are_not_a_recovery():
    harness = LoopHarness(CONSTANT)
    harness.tick()
    for k in range(20):
        tick.mark_stale(harness.r, 100.0 + 0.025 * k, arrays.NO_SAMPLE)
        assert harness.tick(period=0.025)[rows.APPLIED_FORCE] == 0.0
    assert harness.r.control.stale_count[0] == 1
    assert recovered(harness.ticks(0.2)) in (99, 100)


def test_the_force_fades_in_after_lost_frames():
    harness = LoopHarness(CONSTANT, full=False)
    assert harness.tick(period=0.019)[rows.APPLIED_FORCE] == pytest.approx(1.0 / 30.0)


@pytest.mark.parametrize(
    ("times", "latches"),
    [
        ((0.0, 4.0, 9.9), True),
        ((0.0, 5.5, 11.0), False),
        ((0.0, 5.5, 11.0, 15.0), True),
        ((0.0, 20.0, 21.0, 40.0, 41.0), False),
    ],
)
def test_three_silent_periods_in_ten_seconds_latch(times, latches):
    harness = LoopHarness(CONSTANT)
    harness.tick()
    for k, when in enumerate(times):
        assert latched(harness) == arrays.NO_FAULT
        tick.mark_stale(harness.r, 100.0 + when, arrays.NO_SAMPLE)
        last = k == len(times) - 1
        assert latched(harness) == (arrays.STALE_SENSOR if latches and last else arrays.NO_FAULT)
        out = harness.ticks(0.15)
    assert harness.r.control.stale_count[0] == len(times)
    assert bool(applied(out)[-1]) is not latches


def test_the_force_limit_applies_while_fading():
    harness = LoopHarness(CONSTANT, {"level": 5.0}, full=False, max_force=2.0)
    out = harness.ticks(0.03)
    np.testing.assert_allclose(applied(out), np.minimum(5.0 * FADED_IN, 2.0), rtol=1e-9)
    assert out[-1, rows.FLAGS] == rows.CLAMPED


def test_no_parameter_that_is_not_finite_reaches_the_loop():
    harness = LoopHarness(CONSTANT)
    before = harness.r.block.settings.tobytes()
    with pytest.raises(ValueError, match="Level"):
        harness.set(CONSTANT, {"level": float("nan")})
    assert harness.r.block.settings.tobytes() == before
    assert harness.r.block.sequence[0] == 2


def test_lost_frames_do_not_count_as_good():
    harness = LoopHarness(CONSTANT)
    harness.tick()
    tick.mark_stale(harness.r, 100.0, arrays.NO_SAMPLE)
    harness.tick(period=0.151)
    assert recovered(harness.ticks(0.2)) in (99, 100)
