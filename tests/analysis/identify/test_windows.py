import numpy as np
import pytest

from hapkit_studio.analysis.identify.windows import PIECES, Windows

PERIOD = 1e-3


def window(t, start, piece):
    """Return a quintic B-spline of mean weight 1 over 6 pieces: the box function convolved with itself."""
    u = (t - start) / (piece * PERIOD)
    signs = [
        (-1) ** k * np.prod([7 - j for j in range(1, k + 1)]) / np.prod(range(1, k + 1)) for k in range(7)
    ]
    return sum(s * max(u - k, 0.0) ** 5 for k, s in enumerate(signs)) / 120.0 / (piece * PERIOD)


@pytest.mark.parametrize("piece", [2, 4, 8])
def test_a_window_averages_a_cubic_and_its_derivatives(piece):
    windows = Windows(200, piece, PERIOD, 0.0)
    t = PERIOD * np.arange(200)
    middle = PERIOD * (windows.starts + PIECES * piece / 2)
    spread = PIECES / 12.0 * (piece * PERIOD) ** 2  # the window's variance: six boxes
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


def test_even_and_odd_samples_share_nothing():
    windows = Windows(200, 4, PERIOD, 0.0)
    noise = np.random.default_rng(1).normal(size=200)
    even, odd = noise.copy(), noise.copy()
    even[1::2] = odd[0::2] = 0.0
    assert np.array_equal(windows.derivative(noise, 2, 0), windows.derivative(even, 2, 0))
    assert np.array_equal(windows.derivative(noise, 2, 1), windows.derivative(odd, 2, 1))
    assert not windows.derivative(odd, 2, 0).any()


@pytest.mark.parametrize("delay", [0.0, 0.3e-3, 1e-3, 2.6e-3])
def test_a_held_delayed_force_is_integrated_exactly(delay):
    commands = np.random.default_rng(2).normal(size=60)
    windows = Windows(60, 4, PERIOD, delay)
    found = windows.held(commands)
    for number, start in ((0, windows.starts[0]), (3, windows.starts[3])):
        total = 0.0
        for k, command in enumerate(commands):
            low, high = k * PERIOD + delay, (k + 1) * PERIOD + delay
            middles = low + (np.arange(20) + 0.5) * (high - low) / 20
            total += command * sum(window(t, start * PERIOD, 4) for t in middles) * (high - low) / 20
        assert found[number] == pytest.approx(total, abs=1e-3)


def test_a_window_counts_only_where_all_its_samples_do():
    windows = Windows(60, 2, PERIOD, 1.5e-3)
    good = np.ones(60, bool)
    good[30] = False
    ends = windows.starts + windows.length
    assert np.array_equal(windows.every(good), (windows.starts > 30) | (ends < 30))
    assert np.array_equal(windows.every(good, 3), (windows.starts - 3 > 30) | (ends < 30))


def test_what_samples_contribute_is_the_transpose():
    windows = Windows(80, 4, PERIOD, 0.0)
    random = np.random.default_rng(3)
    x, values = random.normal(size=80), random.normal(size=(len(windows.starts), 1))
    back = windows.back(values, windows.kernel(2))
    assert float(back[:, 0] @ x) == pytest.approx(float(values[:, 0] @ windows.derivative(x, 2)))
