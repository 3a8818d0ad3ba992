"""The friction laws, tested without a loop, stick, slide, and never add energy."""

import numpy as np
import pytest

from hapkit_studio.dynamics.friction import banded, bristle, projected, sticking_tether, stribeck, tether


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
def test_projection_reduces_the_velocity_or_stops_it(velocity, limit, left):
    assert projected(velocity, limit) == pytest.approx(left, abs=1e-16)
    if abs(velocity) <= limit:
        assert projected(velocity, limit) == 0.0


def test_a_tether_is_dragged_beyond_its_limit():
    force, anchor = tether(0.999e-3, 0.0, 1000.0, 1.0)
    assert force == pytest.approx(-0.999)
    assert anchor == 0.0
    force, anchor = tether(1.5e-3, 0.0, 1000.0, 1.0)
    assert force == -1.0
    assert anchor == pytest.approx(0.5e-3)
    force, anchor = tether(-1.5e-3, 0.0, 1000.0, 1.0)
    assert force == 1.0
    assert anchor == pytest.approx(-0.5e-3)


def test_a_tether_sticks_without_drift_and_never_gives_energy(rng):
    """In a random walk, the work on the handle is at most the spring's energy.

    A sticking anchor does not move.
    """
    x, anchor, stiffness, limit = 0.02, 0.02, 700.0, 0.5
    work = 0.0
    for step in rng.normal(0.0, 2e-4, 5000):
        before, held = anchor, abs(stiffness * (anchor - x - step)) <= limit
        start = stiffness * (anchor - x)
        x += step
        force, anchor = tether(x, anchor, stiffness, limit)
        assert abs(force) <= limit
        assert (anchor == before) == held
        # the force is linear up to the limit, so the mean of both ends is a lower bound
        work += 0.5 * (start + force) * step
    assert work < 0.0


def test_stribeck_friction_decreases_from_static_to_kinetic():
    assert stribeck(0.0, 1.5, 1.0, 0.02) == 1.5
    assert stribeck(0.02, 1.5, 1.0, 0.02) == pytest.approx(1.0 + 0.5 * np.exp(-1.0))
    assert stribeck(3.0, 1.5, 1.0, 0.001) == 1.0


def test_a_bristle_approaches_its_end_and_never_exceeds_it():
    """The step is exact for any size: two steps equal one of their total length. At first, z = x."""
    end = 0.4 / 800.0
    whole = bristle(0.0, 0.3e-3, 0.4, 800.0)
    assert whole == pytest.approx(end * (1.0 - np.exp(-800.0 * 0.3e-3 / 0.4)))
    assert bristle(bristle(0.0, 0.1e-3, 0.4, 800.0), 0.2e-3, 0.4, 800.0) == pytest.approx(whole, rel=1e-12)
    assert bristle(0.0, 1e-9, 0.4, 800.0) == pytest.approx(1e-9, rel=1e-5)
    assert bristle(0.0, -1.0, 0.4, 800.0) == -end
    assert bristle(1e-3, 0.0, 0.4, 800.0) == 1e-3
    assert bristle(1e-3, 0.1, 0.0, 800.0) == 0.0


def follow(path, stiffness, damping, static, kinetic, dt=1e-3):
    """Return the force, anchor and sliding flag (n,) of a tether that sticks at first, along a path (n,)."""
    anchor, slides, before, rows = path[0], 0.0, path[0], []
    for x in path:
        force, anchor, slides = sticking_tether(
            x, before, anchor, slides, stiffness, damping, static, kinetic, dt
        )
        rows.append((force, anchor, slides))
        before = x
    return np.array(rows).T


def test_break_away_at_static_and_sliding_at_kinetic_force():
    path = np.arange(2001) * 1e-6
    force, anchor, slides = follow(path, 500.0, 0.0, 0.6, 0.4)
    off = np.flatnonzero(slides)[0]
    assert path[off] == pytest.approx(0.6 / 500.0, abs=1.1e-6)
    assert force[off - 1] == pytest.approx(-0.6, abs=1e-3)
    assert (force[off:] == -0.4).all()
    assert not anchor[:off].any()
    assert slides[off:].all()


def test_it_sticks_again_with_the_static_force_after_reversing():
    """The handle moves out, back by half a millimetre, and out again, which needs the static force again."""
    path = np.concatenate([np.arange(0, 2000), np.arange(2000, 1500, -1), np.arange(1500, 3500)]) * 1e-6
    force, _, slides = follow(path, 500.0, 0.0, 0.6, 0.4)
    assert not slides[2001:3400].any()
    again = 2500 + np.flatnonzero(slides[2500:])[0]
    assert force[again - 1] == pytest.approx(-0.6, abs=1e-3)
    assert path[again] == pytest.approx(2.0e-3 + 0.2 / 500.0, abs=3e-6)


@pytest.mark.parametrize("damping", [0.0, 0.5])
def test_quantised_sliding_does_not_alternate_with_sticking(damping):
    """The position changes by a count in every other period only, but the tether continues to slide."""
    path = 20.7e-6 * np.repeat(np.arange(200), 2)
    force, _, slides = follow(path, 500.0, damping, 0.6, 0.4)
    off = np.flatnonzero(slides)[0]
    assert slides[off:].all()
    assert (force[off:] == -0.4).all()


@pytest.mark.parametrize("damping", [0.0, 20.0])
def test_sticking_never_adds_energy(rng, damping):
    """The work on the handle, by forces held over each step, is at most the energy that sampling adds."""
    path = 0.02 + np.cumsum(rng.normal(0.0, 1e-4, 20_000))
    force, anchor, _ = follow(path, 500.0, damping, 0.6, 0.4)
    moved = np.diff(path)
    assert np.abs(force).max() <= 0.6
    assert np.isfinite(anchor).all()
    assert np.sum(0.5 * (force[1:] + force[:-1]) * moved) < 0.0


def test_karnopp_sticks_inside_its_band_and_slides_outside():
    assert banded(1e-3, 0.02, 0.0, 500.0, 0.6, 0.4, 0.03) == (-0.5, 0.0, 0.0)
    force, anchor, slides = banded(2e-3, -0.0297, 0.0, 500.0, 0.6, 0.4, 0.03)
    assert (force, slides) == (-0.6, -1.0)
    assert anchor == pytest.approx(0.8e-3)
    assert banded(2e-3, 0.0303, 0.0, 500.0, 0.6, 0.4, 0.03) == (-0.4, 2e-3, -1.0)
    assert banded(2e-3, -0.5, 0.0, 500.0, 0.6, 0.4, 0.03) == (0.4, 2e-3, 1.0)
