"""Window averages agree with theory; instrumental-variable intervals contain the truth as often as stated."""

import numpy as np
import pytest

from hapkit_studio.analysis.identify.regression import repetitions, solve
from hapkit_studio.analysis.identify.windows import PIECES, Windows

TRUTH = np.array([2.0, -1.0])
ALL = np.ones(300, bool)


def motion(random):
    t = np.arange(300) / 300.0
    phases = random.uniform(0.0, 6.28, 2)
    return np.column_stack([np.sin(40.0 * t + phases[0]) + np.sin(95.0 * t + phases[1]), np.ones(300)])


def correlated(random, count):
    """Return errors of a first-order autoregressive process with coefficient 0.6."""
    error = random.normal(size=count)
    for k in range(1, count):
        error[k] += 0.6 * error[k - 1]
    return error


def test_errors_in_columns_bias_one_measurement_but_not_two():
    biased, unbiased = [], []
    for seed in range(200):
        random = np.random.default_rng(seed)
        x = motion(random)
        one, two = (x + np.column_stack([random.normal(0.0, 0.5, 300), np.zeros(300)]) for _ in range(2))
        y = x @ TRUTH + 0.1 * random.normal(size=300)
        biased.append(solve(one, one, y, ALL).beta[0])
        unbiased.append(solve(one, two, y, ALL).beta[0])
    # one noisy measurement attenuates the slope: 2 / (1 + 0.25 / var x), with var x = 1
    assert np.mean(biased) == pytest.approx(2.0 / 1.25, rel=0.02)
    assert np.mean(unbiased) == pytest.approx(2.0, abs=4.0 * np.std(unbiased) / np.sqrt(200))


def test_intervals_contain_the_truth_with_autocorrelated_residuals():
    inside, naive = [], []
    for seed in range(300):
        random = np.random.default_rng(seed)
        t = np.arange(300) / 300.0
        x = np.column_stack([np.sin(60.0 * t + random.uniform(0.0, 6.28)), np.ones(300)])
        fit = solve(x, x, x @ TRUTH + correlated(random, 300), ALL)
        inside.append(abs(fit.beta[0] - TRUTH[0]) < fit.half[0])
        plain = np.linalg.inv(x.T @ x)[0, 0] * np.var(fit.residual)
        naive.append(abs(fit.beta[0] - TRUTH[0]) < 1.96 * np.sqrt(plain))
    assert 0.92 < np.mean(inside) < 0.985
    assert np.mean(naive) < 0.75


def test_repetitions_of_residuals_are_counted():
    random = np.random.default_rng(3)
    once = random.normal(size=100)
    for times in (2, 3, 4):
        count = 100 * times
        assert repetitions(np.tile(once, times), np.ones(count, bool)) == pytest.approx(times)
        assert repetitions(random.normal(size=count), np.ones(count, bool)) == 1.0
    # half of the variance repeats, so the correlation is a half
    half = np.mean(
        [
            repetitions(np.tile(random.normal(size=400), 3) + random.normal(size=1200), np.ones(1200, bool))
            for _ in range(20)
        ]
    )
    assert half == pytest.approx(1.0 + 2.0 * 0.5, rel=0.1)


def test_intervals_contain_the_truth_if_a_motion_repeats_its_errors():
    """Repeating the same hundred errors four times adds no information."""
    inside: dict[bool, list[bool]] = {True: [], False: []}
    for seed in range(200):
        random = np.random.default_rng(seed)
        turn = 0.06 * np.pi * np.arange(400)  # the sine has three cycles per hundred windows
        x = np.column_stack([np.sin(turn + random.uniform(0.0, 6.28)), np.ones(400)])
        y = x @ TRUTH + np.tile(correlated(random, 100), 4)
        for again, found in inside.items():
            fit = solve(x, x, y, np.ones(400, bool), again=again)
            found.append(abs(fit.beta[0] - TRUTH[0]) < fit.half[0])
    assert 0.92 < np.mean(inside[True]) < 0.985
    assert np.mean(inside[False]) < 0.7


def test_excluded_windows_do_not_affect_the_others():
    random = np.random.default_rng(5)
    x = motion(random)
    y = x @ TRUTH
    kept = ALL.copy()
    kept[50:90] = False
    y[50:90] = 1e6
    assert solve(x, x, y, kept).beta == pytest.approx(TRUTH)


def test_constant_or_too_few_windows_give_no_fit():
    x = motion(np.random.default_rng(6))
    twice = np.column_stack([x, x[:, 0]])
    few = np.zeros(300, bool)
    few[:8] = True
    assert solve(twice, twice, x[:, 0], ALL) is None
    assert solve(x, x, x[:, 0], few) is None
    assert solve(0.0 * x, 0.0 * x, x[:, 0], ALL) is None


PERIOD = 1e-3


def window(t, start, piece):
    """Return a quintic B-spline over 6 segments, of mean weight 1: a box convolved with itself 5 times."""
    u = (t - start) / (piece * PERIOD)
    signs = [
        (-1) ** k * np.prod([7 - j for j in range(1, k + 1)]) / np.prod(range(1, k + 1)) for k in range(7)
    ]
    return sum(s * max(u - k, 0.0) ** 5 for k, s in enumerate(signs)) / 120.0 / (piece * PERIOD)


@pytest.mark.parametrize("piece", [2, 8])
def test_a_window_averages_a_cubic_and_its_derivatives(piece):
    windows = Windows(200, piece, PERIOD, 0.0)
    t = PERIOD * np.arange(200)
    middle = PERIOD * (windows.starts + PIECES * piece / 2)
    spread = PIECES / 12.0 * (piece * PERIOD) ** 2  # the window's variance is that of six boxes
    cubic = 2.0 * t**3 - 0.3 * t**2 + t
    wanted = (
        2.0 * (middle**3 + 3.0 * middle * spread) - 0.3 * (middle**2 + spread) + middle,
        6.0 * (middle**2 + spread) - 0.6 * middle + 1.0,
        12.0 * middle - 0.6,
    )
    for order, value in enumerate(wanted):
        assert np.allclose(windows.derivative(cubic, order), value, rtol=1e-9, atol=1e-9)
        if piece > 2:
            for part in (0, 1):
                assert np.allclose(windows.derivative(cubic, order, part), value, rtol=1e-6, atol=1e-6)


def test_a_held_delayed_force_is_integrated_exactly():
    commands, delay = np.random.default_rng(2).normal(size=60), 2.6e-3
    windows = Windows(60, 4, PERIOD, delay)
    found = windows.zero_order_hold(commands)
    for number, start in ((0, windows.starts[0]), (3, windows.starts[3])):
        total = 0.0
        for k, command in enumerate(commands):
            low, high = k * PERIOD + delay, (k + 1) * PERIOD + delay
            middles = low + (np.arange(20) + 0.5) * (high - low) / 20
            total += command * sum(window(t, start * PERIOD, 4) for t in middles) * (high - low) / 20
        assert found[number] == pytest.approx(total, abs=1e-3)
