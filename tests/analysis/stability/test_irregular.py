"""The mean-square limit of loops with drawn periods and delays: 2 % inside and outside, by the tick."""

import math

import numpy as np
import pytest

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability.irregular import (
    Timing,
    growth,
    late_by,
    mean_square_limit,
    measured_limit,
)
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.errors import ParameterError
from hapkit_studio.sessions.lateness import recorded
from tests.wide import wide

FILTERS = ("difference", ("iir", {"cutoff": 100.0}), "kalman", "butterworth")


def some_loop(rng):
    """Return a setting, a damping, and a timing: periods, delays or both, in two or many sizes."""
    rate = 10 ** rng.uniform(2.7, 3.3)
    setting = Setting(
        rng.uniform(0.02, 0.1), rng.uniform(0.3, 2.0), 0.0, 0.0, rate, 0.0, FILTERS[rng.integers(4)]
    )
    spread = [
        rng.random(400),
        rng.choice([0.0, 1.0], 400, p=(0.8, 0.2)),
        rng.exponential(0.3, 400).clip(0, 1),
    ]
    periods = (1.0 + rng.uniform(0.0, 1.5) * spread[rng.integers(3)]) / rate
    late = rng.choice([0.0, 0.95]) * periods * rng.permutation(spread[rng.integers(3)])
    return setting, rng.choice([0.0, 0.5]), Timing(periods, late)


def both_sides(rng):
    setting, damping, timing = some_loop(rng)
    limit = mean_square_limit(setting, damping, timing)
    return [growth(setting, damping, share * limit, timing, seed=5) for share in (0.98, 1.02)]


def test_the_tick_calms_inside_and_grows_outside():
    rng = np.random.default_rng(731)
    for _ in range(3):
        inside, outside = both_sides(rng)
        assert inside < 0.0 < outside


@pytest.mark.slow
def test_the_tick_agrees_on_fifty_loops():
    rng = np.random.default_rng(732)
    for _ in range(50):
        inside, outside = both_sides(rng)
        assert inside < 0.0 < outside


@pytest.mark.parametrize(
    "estimator", wide(["difference", "kalman", "butterworth"], lambda estimator: estimator == "kalman")
)
def test_a_steady_loop_has_its_exact_limit(estimator):
    setting = Setting(viscous=0.5, delay=1.3e-3, estimator=estimator)
    steady = late_by(setting, np.zeros(3))
    for damping in (0.0, 1.0):
        exact = stiffness_limit(0.044, 0.5, damping=damping, delay=1.3e-3, estimator=estimator)
        assert mean_square_limit(setting, damping, steady) == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize(
    ("rate", "delay", "hand"),
    wide(
        [(700.0, 5 / 700.0, "released"), (1000.0, 2.4e-3, "medium"), (1000.0, 0.0, "light")],
        lambda _rate, _delay, hand: hand == "medium",
    ),
)
def test_whole_periods_of_delay_and_a_hand_count_in_theory_and_measurement(rate, delay, hand):
    """On time both have the exact limit; late at random the tick calms 2 % inside and grows 2 % outside."""
    setting = Setting(rate=rate, delay=delay, hand=hand, viscous=0.6)
    exact = stiffness_limit(0.044, 0.6, rate=rate, delay=delay, hand=hand)
    assert mean_square_limit(setting, 0.0, late_by(setting, np.zeros(1))) == pytest.approx(exact, rel=1e-5)
    assert measured_limit(setting, 0.0, late_by(setting, np.zeros(1))) == pytest.approx(exact, rel=0.005)
    timing = late_by(setting, np.random.default_rng(733).choice([0.0, 0.9e-3], 400, p=(0.7, 0.3)))
    limit = mean_square_limit(setting, 0.0, timing)
    assert limit < 0.98 * exact
    inside, outside = (growth(setting, 0.0, share * limit, timing, seed=6) for share in (0.98, 1.02))
    assert inside < 0.0 < outside


def test_energy_of_a_held_force_says_the_limit_of_drawn_periods():
    """Per period the damper takes b v² T, the held spring adds k v² T²/2: k = 2 b E[T] / E[T²].

    Two periods, one four times the other; at 20 kHz what the formula leaves out is small.
    """
    setting = Setting(mass=0.5, viscous=0.05, rate=20_000.0)
    periods = np.array([1.0, 1.0, 1.0, 4.0]) / 20_000.0
    limit = mean_square_limit(setting, 0.0, Timing(periods, np.zeros(4)))
    assert limit == pytest.approx(2.0 * 0.05 * periods.mean() / np.square(periods).mean(), rel=0.01)


def test_a_recording_is_read_and_what_it_cannot_say_is_said(tmp_path):
    file = tmp_path / "late.csv"
    file.write_text("# {}\ntime (s),lateness (s)\n0,0.0001\n0.001,nan\n0.002,0.0003\n")
    assert recorded(file).tolist() == [0.0001, 0.0003]
    late = late_by(Setting(delay=0.2e-3), np.array([0.1e-3, 5e-3, -1.0]))
    assert late.late == pytest.approx([0.3e-3, 0.999e-3, 0.2e-3])
    file.write_text("time (s)\n0\n")
    with pytest.raises(ParameterError, match="no column lateness"):
        recorded(file)
    assert math.isfinite(mean_square_limit(Setting(), 0.0, late))
