"""The just-noticeable difference: a virtual observer's threshold is recovered by Levitt's staircase."""

import math

import numpy as np
import pytest

from hapkit_studio.analysis import discrimination
from hapkit_studio.analysis.discrimination import Bounds, Comparison, Observer, Staircase
from hapkit_studio.errors import FileError


@pytest.mark.parametrize("noise", [0.05, 0.20])
def test_a_virtual_observers_threshold_is_recovered_in_90_of_100_runs(noise):
    observer, found = Observer(noise), 0
    for seed in range(100):
        answers = observer.run(200.0, np.random.default_rng(seed))
        (threshold,) = discrimination.evaluate(answers)
        found += threshold.weber.holds(observer.threshold)
    assert found >= 90


def test_the_observer_is_right_in_79_percent_at_its_threshold():
    """The threshold is Δ = σ·√2·0.8194, by the normal distribution at a probability of 2^(−1/3)."""
    observer = Observer(0.1)
    assert observer.share(observer.threshold) == pytest.approx(0.5 ** (1.0 / 3.0))
    assert observer.threshold == pytest.approx(0.1 * math.sqrt(2.0) * 0.81935, rel=1e-3)
    assert observer.share(0.0) == 0.5


def test_the_staircase_goes_down_after_three_right_answers_and_up_after_one_wrong():
    stairs, steps = Staircase(first=0.4), []
    for right in (1, 1, 1, 1, 1, 0, 1, 1, 1, 1, 1, 1, 0, 1, 1, 0):
        steps.append(stairs.step)
        stairs.answer(bool(right))
    fine = math.sqrt(2.0)
    # the factor is 2 up to the first two reversals, then √2
    assert steps == pytest.approx(
        [0.4] * 3 + [0.2] * 3 + [0.4] * 3 + [0.4 / fine] * 3 + [0.4 / fine**2] + [0.4 / fine] * 3
    )
    assert stairs.reversals == pytest.approx([0.2, 0.4, 0.4 / fine**2])
    assert stairs.step == pytest.approx(0.4)


def test_the_staircase_converges_at_its_equilibrium():
    """At equilibrium p³ = 1/2 for three right answers in a row, so the mean is Levitt's 79.4 %."""
    assert pytest.approx(0.794, abs=0.0005) == discrimination.CONVERGES
    observer = Observer(0.1)
    means = []
    for seed in range(100):
        (found,) = discrimination.evaluate(observer.run(1.0, np.random.default_rng(seed)))
        means.append(math.log(found.reversals))
    assert math.exp(np.mean(means)) == pytest.approx(observer.threshold, rel=0.12)


def test_the_staircase_ends_and_stays_within_its_limits():
    for answer in (True, False):
        stairs = Staircase(largest=0.8)
        while not stairs.finished:
            stairs.answer(answer)
            assert discrimination.SMALLEST <= stairs.step <= 0.8
        assert stairs.answers == discrimination.MOST_ANSWERS


def test_the_fitted_function_is_right_at_its_threshold_and_guesses_below():
    for slope in (0.7, 1.3, 4.0):
        assert discrimination.right_share(0.3, 0.3, slope) == pytest.approx(discrimination.CONVERGES)
        assert discrimination.right_share(1e-9, 0.3, slope) == pytest.approx(0.5, abs=1e-5)
        assert 0.98 < discrimination.right_share(1e3, 0.3, slope) < 1.0


def test_more_answers_make_the_interval_narrower():
    observer, chance = Observer(0.1), np.random.default_rng(1)
    steps = chance.choice([0.03, 0.06, 0.12, 0.24, 0.48], 800)
    right = [bool(chance.random() < observer.share(step)) for step in steps]
    few, many = discrimination.fit(steps[:50], right[:50]), discrimination.fit(steps, right)
    assert many.high / many.low < 0.6 * few.high / few.low
    assert many.value == pytest.approx(observer.threshold, rel=0.2)


def test_only_wrong_answers_put_the_threshold_at_the_largest_steps_or_beyond():
    found = discrimination.fit([0.1, 0.2, 0.4, 0.4], [False] * 4)
    assert found.low > 0.2
    assert math.isfinite(found.high)


def test_each_parameter_and_base_has_a_separate_threshold():
    """Thresholds are in the parameter's unit; the Weber fraction is the ratio of threshold to base."""
    one = Observer(0.1).run(200.0, np.random.default_rng(0))
    other = [Comparison("damping", "damping", "N·s/m", 5.0, a.step / 40.0, a.more, a.chosen) for a in one]
    first, second = discrimination.evaluate([*one, *other])
    assert (first.parameter, second.parameter) == ("stiffness", "damping")
    assert first.weber == pytest.approx(second.weber)
    assert first.threshold.value == pytest.approx(200.0 * first.weber.value)
    assert second.threshold == pytest.approx(Bounds(*(5.0 * part for part in second.weber)))


GOOD = discrimination.event(Comparison("spring", "stiffness", "N/m", 200.0, 20.0, 1, 2, True))


def test_an_answer_is_restored_from_its_event():
    (found,) = discrimination.comparisons([GOOD])
    assert discrimination.event(found) == GOOD
    assert not found.right


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("base", 0.0), ("base", math.inf), ("step", -1.0), ("step", "1"), ("more", 3), ("more", True),
        ("chosen", None), ("chosen", 1.0), ("parameter", ["a"]), ("unit", "a\nb"), ("environment", "a" * 101),
        ("reversal", 1),
    ],
)  # fmt: skip
def test_a_damaged_answer_is_refused_in_one_line_that_names_the_value(name, value):
    with pytest.raises(FileError, match=rf"^a\.hapkit: comparison 2: {name} [^\n]*$"):
        discrimination.comparisons([GOOD, {**GOOD, name: value}], "a.hapkit")
