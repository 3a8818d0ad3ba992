"""The pointing experiment recovers the law of a virtual subject; its plans are balanced."""

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.analysis import pointing
from hapkit_studio.analysis.pointing import CONDITIONS, Interval, Subject, Target, Trial
from hapkit_studio.environments import named
from hapkit_studio.errors import FileError

QUANTUM = 20.7e-6
NONE = CONDITIONS[0]


def run(subject, seed, rate, conditions=CONDITIONS[:1]):
    """Return the trials of a complete plan, measured from the sensor's counts."""
    chance, found = np.random.default_rng(seed), []
    for target in pointing.plan(conditions, seed=seed):
        time, place = subject.samples(target, chance, rate=rate)
        found.append(pointing.trial(target, time, QUANTUM * np.floor(place / QUANTUM)))
    return found


def recovered(runs, rate):
    """Return in how many runs the interval contains the subject's intercept, and in how many the slope."""
    subject = Subject(intercept=0.15, slope=0.16, noise=0.03)
    found = [pointing.evaluate(run(subject, seed, rate))[0] for seed in range(runs)]
    return sum(one.intercept.holds(0.15) for one in found), sum(one.slope.holds(0.16) for one in found)


def test_a_virtual_subject_is_recovered_in_most_runs():
    """An interval is right in 95 % of runs, so the probability of fewer than 10 in 12 is 2 %."""
    assert min(recovered(12, rate=250.0)) >= 10


@pytest.mark.slow
def test_a_virtual_subject_is_recovered_in_90_of_100_runs():
    assert min(recovered(100, rate=1000.0)) >= 90


def test_the_shannon_form_is_never_negative():
    """MacKenzie and Buxton's log2(D/W + 1) is 0 for no distance, and 3 bit for D = 7 W."""
    assert pointing.difficulty(0.035, 0.005) == pytest.approx(3.0)
    assert pointing.difficulty(0.0, 0.005) == 0.0
    assert pointing.difficulty(0.001, 0.005) > 0.0


@pytest.mark.parametrize("seconds", [0.25, 0.6, 1.2])
@pytest.mark.parametrize("side", [-1, 1])
def test_a_minimum_jerk_movement_is_timed_from_its_exact_start_to_its_exact_end(seconds, side):
    subject = Subject(intercept=seconds, slope=0.0, noise=0.0)
    target = Target(NONE, 0.040, 0.004, side)
    time, place = subject.samples(target, np.random.default_rng(1))
    found = pointing.movement(time, QUANTUM * np.floor(place / QUANTUM))
    assert found.seconds == pytest.approx(seconds, abs=0.006)
    assert found.begin == pytest.approx(0.3, abs=0.006)
    assert found.end == pytest.approx(place[-1], abs=QUANTUM)


def test_two_submovements_are_timed_together():
    """The handle moves near the target for 0.4 s, rests for 0.05 s, and moves to the target for 0.2 s."""
    share = np.clip(np.arange(1600) / 400.0 - 0.75, 0.0, 1.0)
    late = np.clip(np.arange(1600) / 200.0 - 3.75, 0.0, 1.0)
    place = sum(d * s**3 * (10 - 15 * s + 6 * s**2) for d, s in ((0.030, share), (0.005, late)))
    found = pointing.movement(np.arange(1600) / 1000.0, place)
    assert found.seconds == pytest.approx(0.65, abs=0.02)
    assert found.end == pytest.approx(0.035, abs=1e-6)


@pytest.mark.parametrize("place", [np.zeros(1000), np.full(1000, 0.01), np.zeros(3), np.zeros(0)])
def test_a_handle_that_does_not_move_makes_no_trial(place):
    time = np.arange(len(place)) / 1000.0
    assert pointing.movement(time, place) is None
    assert pointing.trial(Target(NONE, 0.02, 0.004, 1), time, place) is None


def test_the_line_is_exact_for_times_on_a_line():
    """The fit has the line's coefficients, an interval of zero, and r² = 1."""
    x = [1.0, 2.0, 3.0, 4.0]
    intercept, slope, fit = pointing.regression(x, [0.1 + 0.2 * one for one in x])
    assert (intercept.value, slope.value, fit) == pytest.approx((0.1, 0.2, 1.0))
    assert (intercept.half, slope.half) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_the_slopes_interval_has_students_distribution():
    """Calculated by hand for residuals of ±1 about y = x: s² = 4/2, Σ(x − x̄)² = 5, t(0.975, 2) = 4.3027."""
    _, slope, _ = pointing.regression([0.0, 1.0, 2.0, 3.0], [1.0, 0.0, 1.0, 4.0])
    assert slope.value == pytest.approx(1.0)
    assert slope.half == pytest.approx(4.3027 * math.sqrt(4.0 / 2.0 / 5.0), rel=1e-4)


def test_two_pairs_of_distance_and_width_have_no_line():
    found = [pointing.regression([1.0, 2.0], [0.3, 0.4]), pointing.regression([2.0] * 4, [0.3] * 4)]
    assert all(math.isnan(part.value) for one in found for part in one[:2])


def trials_about(widths_apart, count=4000):
    """Return trials of one distance and width, with normally distributed end points."""
    ends = 0.010 + widths_apart * np.random.default_rng(5).standard_normal(count)
    return [
        Trial("none", "tether", 0.0, 0.020, 0.004, -0.010, 0.010, 0.5, end, 0.0, 1.0) for end in ends.tolist()
    ]


def test_the_effective_width_of_a_normal_distribution_contains_96_percent():
    """The standard deviation is W/4.133, so the effective width is W, and 3.9 % miss (2 Φ(−4.133/2))."""
    (line,) = pointing.evaluate(trials_about(0.004 / 4.133))
    (cell,) = line.cells
    assert cell.effective_width == pytest.approx(0.004, rel=0.03)
    assert cell.effective_difficulty == pytest.approx(math.log2(0.020 / 0.004 + 1.0), rel=0.02)
    assert line.missed / line.count == pytest.approx(0.0388, abs=0.009)
    assert line.throughput.value == pytest.approx(math.log2(6.0) / 0.5, rel=0.02)


def test_the_effective_width_of_few_trials_is_unbiased():
    """The mean logarithm of the width from four trials equals the logarithm of the true width."""
    many = trials_about(0.001, 4000)
    found = [pointing._cell(0.020, 0.004, many[at : at + 4]).effective_width for at in range(0, 4000, 4)]
    assert np.mean(np.log(found)) == pytest.approx(math.log(0.004133), abs=0.04)


def test_a_slower_condition_is_compared_pair_by_pair():
    """Every movement takes 1.5 times as long, so the change is +50 % with an interval of zero."""
    fast = [
        Trial("none", "tether", 0.0, d, w, -d / 2, d / 2, 0.1 + d + w, d / 2, 0.0, 1.0)
        for d in pointing.DISTANCES for w in pointing.WIDTHS for _ in range(2)
    ]  # fmt: skip
    slow = [replace(trial, condition="high", force=1.5, seconds=1.5 * trial.seconds) for trial in fast]
    none, high = pointing.evaluate(slow + fast)
    assert (none.condition, high.condition) == ("none", "high")
    assert high.change == pytest.approx(Interval(0.5, 0.0), abs=1e-9)
    assert math.isnan(none.change.value)


def test_a_plan_is_balanced_and_in_random_order():
    """In each round, every condition, distance, width and side occurs equally often."""
    found = pointing.plan(seed=3)
    cells = len(pointing.DISTANCES) * len(pointing.WIDTHS)
    block = cells * len(CONDITIONS)
    assert len(found) == pointing.ROUNDS * block
    rounds = [found[at : at + block] for at in range(0, len(found), block)]
    for one in rounds:
        assert len({(t.condition, t.distance, t.width) for t in one}) == block
    assert set(Counter(found).values()) == {pointing.ROUNDS // 2}
    assert {target.side for target in found} == {-1, 1}
    assert found != pointing.plan(seed=4)
    assert found == pointing.plan(seed=3)
    orders = {tuple(t.condition.name for t in one[::cells]) for one in rounds}
    assert len(orders) > 1


def test_start_and_target_lie_within_the_travel_and_the_distance_apart():
    for target in pointing.plan(seed=0):
        assert target.side * (target.middle - target.start) == pytest.approx(target.distance)
        assert abs(target.middle) + target.width <= 0.03


@pytest.mark.parametrize("condition", {*CONDITIONS, *pointing.BY_MODEL})
def test_every_condition_can_be_rendered(condition):
    values = named(pointing.ENVIRONMENT).values(condition.values)
    assert values["kinetic_force"] == values["static_force"] == condition.force


GOOD = pointing.event(Trial("low", "tether", 0.5, 0.02, 0.004, -0.01, 0.01, 0.5, 0.0101, 3.0, 4.5))


def test_a_trial_is_restored_from_its_event():
    (found,) = pointing.trials([GOOD])
    assert pointing.event(found) == GOOD
    assert found.deviation == pytest.approx(0.0001)
    assert not found.missed


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("seconds", 0.0), ("seconds", math.nan), ("seconds", "1"), ("distance", -1.0), ("width", 0.0),
        ("end", 1e9), ("begin", None), ("condition", 3),
        ("stop", 34.0), ("stop", 2.0), ("model", "a\nb"), ("force", True), ("stop", [1.0]),
    ],
)  # fmt: skip
def test_a_damaged_trial_is_refused_in_one_line_that_names_the_value(name, value):
    with pytest.raises(FileError, match=rf"^a\.hapkit: pointing trial 2: [^\n]*{name} is [^\n]*$"):
        pointing.trials([GOOD, {**GOOD, name: value}], "a.hapkit")


def test_a_handle_is_at_rest_after_a_time_without_motion():
    time = np.arange(400) / 1000.0
    assert not pointing.rests(time[:250], np.zeros(250))
    assert pointing.rests(time, np.zeros(400))
    assert not pointing.rests(time, np.linspace(0.0, 0.004, 400))


def fed(run, place, begin=0.0, step=16):
    """Feed a run with positions (n,) at 1 kHz, ``step`` of them per frame; return the trials."""
    time, found = begin + np.arange(len(place)) / 1000.0, []
    for at in range(0, len(place), step):
        found.append(run.feed(time[at : at + step], place[at : at + step]))
    return [trial for trial in found if trial is not None]


def path_to(target, seconds=0.4, wait=1300, after=400):
    share = np.clip((np.arange(wait + round(1000 * seconds) + after) - wait) / (1000.0 * seconds), 0.0, 1.0)
    return target.start + (target.middle - target.start) * share**3 * (10 - 15 * share + 6 * share**2)


TARGETS = [Target(NONE, 0.020, 0.004, 1), Target(NONE, 0.030, 0.004, -1)]


def test_a_run_shows_the_target_once_the_start_is_held_and_ends_at_rest():
    run = pointing.Run(TARGETS, seed=0)
    assert not fed(run, np.full(550, TARGETS[0].start))
    assert not run.going  # the start was held too briefly
    assert not fed(run, np.full(700, TARGETS[0].start), begin=0.55)
    assert run.going
    place = path_to(TARGETS[0], wait=100)
    (first,) = fed(run, place, begin=1.25)
    assert first.seconds == pytest.approx(0.4, abs=0.01)
    assert (first.start, first.end) == pytest.approx((-0.010, 0.010), abs=1e-4)
    assert run.target == TARGETS[1]
    assert not run.going
    (second,) = fed(run, path_to(TARGETS[1]), begin=3.0)
    assert second.deviation == pytest.approx(0.0, abs=1e-4)
    assert run.target is None
    assert run.done == [first, second]


def test_a_run_waits_if_the_handle_leaves_the_start_too_soon():
    run = pointing.Run(TARGETS, seed=0)
    place = np.full(3000, TARGETS[0].start)
    place[::500] += 0.003  # every 500 samples the handle is 3 mm aside, beyond the half width of 2 mm
    fed(run, place)
    assert not run.going


def test_a_trial_that_takes_too_long_is_repeated_at_the_end():
    run = pointing.Run(TARGETS, seed=0)
    fed(run, np.full(round(1000 * (pointing.LONGEST + 1.5)), TARGETS[0].start))
    assert run.target == TARGETS[1]
    assert run.done == []
    fed(run, path_to(TARGETS[1]), begin=20.0)
    assert run.target == TARGETS[0]


def test_a_trial_with_missing_samples_begins_again():
    run = pointing.Run(TARGETS, seed=0)
    fed(run, np.full(1300, TARGETS[0].start))
    assert run.going
    run.feed(np.array([2.0]), np.array([TARGETS[0].start]))
    assert not run.going
    assert run.target == TARGETS[0]


def test_a_small_first_movement_does_not_count():
    """The handle moves a tenth of the way and rests, and the trial goes on."""
    run = pointing.Run(TARGETS, seed=0)
    fed(run, np.full(1300, TARGETS[0].start))
    assert not fed(run, np.full(600, TARGETS[0].start + 0.002), begin=1.3)
    assert run.going
