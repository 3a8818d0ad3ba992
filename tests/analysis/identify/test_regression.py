import numpy as np
import pytest

from hapkit_studio.analysis.identify.regression import solve

TRUTH = np.array([2.0, -1.0])
ALL = np.ones(300, bool)


def motion(random):
    t = np.arange(300) / 300.0
    phases = random.uniform(0.0, 6.28, 2)
    return np.column_stack([np.sin(40.0 * t + phases[0]) + np.sin(95.0 * t + phases[1]), np.ones(300)])


def correlated(random, count):
    """Return errors of which each keeps 0.6 of the one before."""
    error = random.normal(size=count)
    for k in range(1, count):
        error[k] += 0.6 * error[k - 1]
    return error


def test_plain_least_squares_where_columns_are_exact():
    random = np.random.default_rng(1)
    x = motion(random)
    y = x @ TRUTH + random.normal(size=300)
    fit = solve(x, x, y, ALL)
    assert fit.beta == pytest.approx(np.linalg.lstsq(x, y, rcond=None)[0])
    assert fit.explained == pytest.approx(1.0 - np.var(y - x @ fit.beta) / np.var(y), abs=1e-3)


def test_errors_in_columns_bias_one_measurement_but_not_two():
    biased, unbiased = [], []
    for seed in range(200):
        random = np.random.default_rng(seed)
        x = motion(random)
        one, two = (x + np.column_stack([random.normal(0.0, 0.5, 300), np.zeros(300)]) for _ in range(2))
        y = x @ TRUTH + 0.1 * random.normal(size=300)
        biased.append(solve(one, one, y, ALL).beta[0])
        unbiased.append(solve(one, two, y, ALL).beta[0])
    # one measurement: 2 / (1 + 0.25 / var x), var x = 1
    assert np.mean(biased) == pytest.approx(2.0 / 1.25, rel=0.02)
    assert np.mean(unbiased) == pytest.approx(2.0, abs=4.0 * np.std(unbiased) / np.sqrt(200))


def test_intervals_hold_the_truth_although_residuals_are_alike():
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


def test_windows_left_out_change_nothing_else():
    random = np.random.default_rng(5)
    x = motion(random)
    y = x @ TRUTH
    kept = ALL.copy()
    kept[50:90] = False
    y[50:90] = 1e6
    assert solve(x, x, y, kept).beta == pytest.approx(TRUTH)


def test_what_does_not_vary_or_is_too_little_gives_nothing():
    x = motion(np.random.default_rng(6))
    twice = np.column_stack([x, x[:, 0]])
    few = np.zeros(300, bool)
    few[:8] = True
    assert solve(twice, twice, x[:, 0], ALL) is None
    assert solve(x, x, x[:, 0], few) is None
    assert solve(0.0 * x, 0.0 * x, x[:, 0], ALL) is None
