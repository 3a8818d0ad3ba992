"""Changes of settings ramp or cross-fade, keep the state, and cause no step of the force."""

import math

import numpy as np
import pytest

from hapkit_studio.haptics import rows
from tests.haptics.support import CONSTANT, COUNTING, FADE, LoopHarness


def level(value, place="a"):
    return {"level": value, "place": place}


def asked(out):
    return out[:, rows.FORCE]


@pytest.mark.parametrize("rate", [100.0, 1000.0, 10_000.0])
@pytest.mark.parametrize(
    ("new", "force", "flag"), [(level(2.5), 2.5, 0), (level(1.0, "d"), -1.0, rows.FADING)]
)
def test_a_number_ramps_and_a_choice_fades_linearly_over_30_ms(new, force, flag, rate):
    harness = LoopHarness(CONSTANT, level(1.0), rate)
    harness.tick()
    harness.set(CONSTANT, new)
    out, steps = harness.ticks(0.05), round(FADE * rate)
    share = np.minimum((1.0 + np.arange(len(out))) / steps, 1.0)
    np.testing.assert_allclose(asked(out), 1.0 + (force - 1.0) * share, rtol=1e-9, atol=1e-12)
    assert abs(asked(out)[steps - 2] - force) > 1.0 / steps
    np.testing.assert_array_equal(asked(out)[steps - 1 :], force)
    np.testing.assert_array_equal(out[: steps - 1, rows.FLAGS], flag)
    np.testing.assert_array_equal(out[steps - 1 :, rows.FLAGS], 0)


def test_a_change_during_a_ramp_starts_from_the_present_value():
    harness = LoopHarness(CONSTANT, level(1.0))
    harness.tick()
    harness.set(CONSTANT, level(4.0))
    assert asked(harness.ticks(0.010))[-1] == pytest.approx(2.0, rel=1e-12)
    harness.set(CONSTANT, level(-1.0))
    out = asked(harness.ticks(0.031))
    np.testing.assert_allclose(out[:30], 2.0 - 3.0 * np.arange(1, 31) / 30.0, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(out[29:], -1.0)


def test_other_settings_do_not_affect_a_ramp():
    harness = LoopHarness(CONSTANT, level(1.0))
    harness.tick()
    harness.set(CONSTANT, level(4.0))
    out = []
    for _ in range(3):
        out.extend(asked(harness.ticks(0.010)))
        harness.set(CONSTANT, level(4.0), target=0.01)
    np.testing.assert_allclose(out, 1.0 + np.arange(1, 31) / 10.0, rtol=1e-9)


def test_laws_fade_each_with_its_own_state():
    harness = LoopHarness(COUNTING, {"gain": 0.01})
    harness.ticks(0.1)
    harness.set(CONSTANT, level(2.0))
    out = harness.ticks(0.03)
    share = np.arange(1, 31) / 30.0
    old = 0.01 * (100.0 + np.arange(1, 31))
    np.testing.assert_allclose(asked(out)[:-1], (share * 2.0 + (1.0 - share) * old)[:-1], rtol=1e-9)
    assert asked(out)[-1] == 2.0
    harness.set(COUNTING, {"gain": 0.01})
    out = harness.ticks(0.03)
    np.testing.assert_array_equal(out[:, rows.STATE], np.arange(1.0, 31.0))
    np.testing.assert_allclose(asked(out), share * 0.01 * np.arange(1, 31) + (1.0 - share) * 2.0, rtol=1e-9)


def test_the_state_survives_changes_of_a_number_and_a_choice():
    harness = LoopHarness(COUNTING, {"gain": 0.01})
    counts = list(harness.ticks(0.02)[:, rows.STATE])
    harness.set(COUNTING, {"gain": 0.02})
    counts += list(harness.ticks(0.04)[:, rows.STATE])
    harness.set(COUNTING, {"gain": 0.02, "sign": "minus"})
    counts += list(harness.ticks(0.04)[:, rows.STATE])
    np.testing.assert_array_equal(counts, np.arange(1.0, 101.0))
    assert harness.tick()[rows.FORCE] == pytest.approx(-0.02 * 101.0, rel=1e-12)


def test_a_second_switch_waits_and_the_newest_wins():
    harness = LoopHarness(CONSTANT, level(1.0))
    harness.tick()
    harness.set(CONSTANT, level(1.0, "b"))
    first = asked(harness.ticks(0.010))
    harness.set(CONSTANT, level(1.0, "c"))
    second = asked(harness.ticks(0.005))
    harness.set(CONSTANT, level(1.0, "d"))
    third = asked(harness.ticks(0.045))
    out = np.concatenate((first, second, third))
    share = np.arange(1, 31) / 30.0
    np.testing.assert_allclose(out[:30], 1.0 + 2.0 * share, rtol=1e-9)
    np.testing.assert_allclose(out[30:], 3.0 - 4.0 * share, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("rate", [100.0, 1000.0, 10_000.0])
def test_random_changes_never_cause_a_step_of_the_force(rate):
    random = np.random.default_rng(5)
    harness = LoopHarness(CONSTANT, level(0.0), rate, max_force=5.0)
    out = [harness.tick()]
    for _ in range(60):
        harness.set(CONSTANT, level(random.uniform(-2.0, 2.0), random.choice(["a", "d"])))
        out.extend(harness.ticks(max(random.uniform(0.0, 0.05), 1.0 / rate)))
    steps = np.abs(np.diff(np.array(out)[:, rows.APPLIED_FORCE]))
    assert 0.0 < steps.max() <= 4.0 / (FADE * rate) * (1.0 + 1e-9)


def test_a_block_being_written_is_read_in_the_next_tick():
    harness = LoopHarness(CONSTANT, level(1.0))
    harness.ticks(0.002)
    sequence, settings, _ = harness.block
    settings.params[0], sequence[0] = math.nan, sequence[0] + 1
    assert harness.tick()[rows.FORCE] == 1.0
    assert harness.r.settings.params[0] == 1.0
    settings.params[0], sequence[0] = 2.0, sequence[0] + 1
    assert asked(harness.ticks(0.03))[-1] == 2.0


@pytest.mark.parametrize("change", [("difference", "iir"), ("iir", "difference")])
def test_a_change_of_estimator_causes_no_jump_in_the_velocity(change):
    """While the handle moves at a constant speed, a change of method leaves the estimate constant."""
    speed = 0.1
    harness = LoopHarness(CONSTANT, level(1.0), estimator=change[0])
    before = harness.run(1e-3 * speed * np.arange(200))
    harness.set(CONSTANT, level(1.0), estimator=change[1])
    after = harness.run(1e-3 * speed * np.arange(200, 400))
    assert before[-1, rows.VELOCITY] == pytest.approx(speed, rel=1e-6)
    np.testing.assert_allclose(after[:, rows.VELOCITY], speed, rtol=1e-6)


def test_settings_are_accepted_when_they_are_in_force():
    harness = LoopHarness(CONSTANT, level(1.0), generation=7)
    harness.tick()
    assert harness.r.control.accepted[0] == 7
    harness.set(COUNTING, generation=8)
    harness.ticks(0.029)
    assert harness.r.control.accepted[0] == 7
    harness.ticks(0.002)
    assert harness.r.control.accepted[0] == 8
