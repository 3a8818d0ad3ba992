"""The friction laws by themselves: what they hold, what they let go, that they never give energy."""

import numpy as np
import pytest

from hapkit_studio.dynamics.friction import projected, stribeck, tether


@pytest.mark.parametrize(
    ("velocity", "limit", "left"),
    [
        (0.3, 0.1, 0.2),
        (-0.3, 0.1, -0.2),
        (0.1, 0.1, 0.0),
        (-0.05, 0.1, 0.0),
        (0.2, 0.0, 0.2),
        (0.0, 0.0, 0.0),
    ],
)
def test_projection_shrinks_the_velocity_or_stops_it(velocity, limit, left):
    assert projected(velocity, limit) == pytest.approx(left, abs=1e-16)
    if abs(velocity) <= limit:
        assert projected(velocity, limit) == 0.0


def test_a_tether_pulls_back_up_to_its_limit_and_is_dragged_beyond_it():
    force, anchor = tether(0.999e-3, 0.0, 1000.0, 1.0)
    assert force == pytest.approx(-0.999)
    assert anchor == 0.0
    force, anchor = tether(1.5e-3, 0.0, 1000.0, 1.0)
    assert force == -1.0
    assert anchor == pytest.approx(0.5e-3)
    force, anchor = tether(-1.5e-3, 0.0, 1000.0, 1.0)
    assert force == 1.0
    assert anchor == pytest.approx(-0.5e-3)


def test_a_tether_without_limit_or_stiffness_pulls_nowhere():
    assert tether(0.3, 0.1, 500.0, 0.0) == (0.0, 0.3)
    assert tether(0.3, 0.1, 0.0, 0.0) == (0.0, 0.1)


def test_a_tether_holds_without_drift_and_never_gives_energy(rng):
    """Random walk: work done on the handle never exceeds the spring's, and a held anchor is the same bits."""
    x, anchor, stiffness, limit = 0.02, 0.02, 700.0, 0.5
    work = 0.0
    for step in rng.normal(0.0, 2e-4, 5000):
        before, held = anchor, abs(stiffness * (anchor - x - step)) <= limit
        start = stiffness * (anchor - x)
        x += step
        force, anchor = tether(x, anchor, stiffness, limit)
        assert abs(force) <= limit
        assert (anchor == before) == held
        # the pull changes along a straight line up to the limit; the mean is its least
        work += 0.5 * (start + force) * step
    assert work < 0.0


def test_stribeck_falls_from_static_to_kinetic():
    assert stribeck(0.0, 1.5, 1.0, 0.02) == 1.5
    assert stribeck(0.02, 1.5, 1.0, 0.02) == pytest.approx(1.0 + 0.5 * np.exp(-1.0))
    assert stribeck(3.0, 1.5, 1.0, 0.001) == 1.0
