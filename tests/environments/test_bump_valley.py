"""Bump and valley: work, symmetry, edges, equilibria, and a drawing that may contradict the force."""

import itertools

import numpy as np
import pytest
from scipy.integrate import quad

import hapkit_studio as hs
from hapkit_studio.environments.bump_valley import height
from tests.environments.calling import LIBRARY, force, forces

BUMP, VALLEY = -0.025, 0.025
shapes = pytest.mark.parametrize("profile", ["gaussian", "cosine"])


def relief(x, **given):
    return height(LIBRARY["bump_valley"].values(given), np.atleast_1d(x))


@shapes
@pytest.mark.parametrize("centre", [BUMP, VALLEY])
@pytest.mark.parametrize("width", [0.004, 0.02, 0.04])
def test_crossing_costs_no_work(profile, centre, width):
    def pushed(x):
        return force("bump_valley", x, profile=profile, width=width)

    half = 0.5 * width
    up, down = quad(pushed, centre - half, centre)[0], quad(pushed, centre, centre + half)[0]
    assert abs(up) > 1e-4
    assert abs(up + down) < 1e-9


@shapes
@pytest.mark.parametrize("law", ["gradient", "height"])
def test_peak_edges_and_slopes(profile, law):
    """The peak is the parameter's value; the force is nearly 0 at 1 nm inside the edge, and 0 outside."""
    given = {"profile": profile, "law": law, "peak_force": 2.0, "width": 0.01}
    x = np.linspace(BUMP - 0.005, BUMP + 0.005, 20_001)
    got = forces("bump_valley", x, **given)
    assert np.abs(got).max() == pytest.approx(2.0, rel=1e-6)
    steepest, _ = LIBRARY["bump_valley"].impedance(LIBRARY["bump_valley"].values(given))
    assert np.abs(np.diff(got) / np.diff(x)).max() == pytest.approx(steepest, rel=1e-3)
    for edge in (BUMP - 0.005, BUMP + 0.005, VALLEY - 0.005, VALLEY + 0.005):
        assert all(abs(force("bump_valley", edge + d, **given)) < 2e-6 for d in (-1e-9, 0.0, 1e-9))
    outside = (-0.06, BUMP - 0.00505, BUMP + 0.00505, 0.0, VALLEY - 0.00505, VALLEY + 0.00505, 0.06)
    assert not forces("bump_valley", outside, **given).any()


def test_gaussian_is_a_gaussian_of_a_sixth_of_the_width():
    """The force is the slope of exp(−u²/2σ²) minus its value at 3 σ, scaled to its peak."""
    t = np.linspace(-3.0, 3.0, 2001)
    slope = t * (np.exp(-0.5 * t**2) - np.exp(-4.5))
    got = forces("bump_valley", BUMP + t * 0.02 / 6.0)
    assert got == pytest.approx(0.7 * slope / slope.max(), abs=1e-6)
    assert got == pytest.approx(0.7 * t * np.exp(0.5 - 0.5 * t**2), abs=0.06 * 0.7)


@shapes
def test_the_relief_is_the_potential_of_the_force_for_a_weight_of_1_n(profile):
    given = {"profile": profile, "peak_force": 1.3, "width": 0.014}
    x = np.concatenate([c + np.linspace(-0.0069, 0.0069, 50) for c in (BUMP, VALLEY)])
    slope = (relief(x + 1e-7, **given) - relief(x - 1e-7, **given)) / 2e-7
    assert forces("bump_valley", x, **given) == pytest.approx(-slope, abs=1e-6)
    assert relief([BUMP - 0.007, BUMP + 0.007, 0.0, VALLEY + 0.007], **given) == pytest.approx(0.0, abs=1e-12)


@shapes
def test_the_drawing_is_independent_of_the_force(profile):
    x = np.linspace(-0.05, 0.05, 201)
    same, opposite, flat = (
        (forces("bump_valley", x, profile=profile, picture=p), relief(x, profile=profile, picture=p))
        for p in ("same", "opposite", "flat")
    )
    assert np.array_equal(same[0], opposite[0])
    assert np.array_equal(same[0], flat[0])
    assert same[1][50] > 1e-3
    assert same[1][150] < -1e-3
    assert np.array_equal(opposite[1], -same[1])
    assert not flat[1].any()


@shapes
def test_the_height_law_is_in_proportion_to_height(profile):
    """The force opposes motion to the right on the bump, and assists it in the valley."""
    given = {"profile": profile, "law": "height", "peak_force": 0.9}
    assert force("bump_valley", BUMP, **given) == pytest.approx(-0.9)
    assert force("bump_valley", VALLEY, **given) == pytest.approx(0.9)
    x = np.linspace(-0.05, 0.05, 301)
    drawn = relief(x, **given)
    assert forces("bump_valley", x, **given) == pytest.approx(-0.9 * drawn / drawn.max(), abs=1e-3)


@pytest.mark.parametrize(("centre", "stays"), [(BUMP, False), (VALLEY, True)])
def test_the_valley_attracts_and_the_bump_repels(centre, stays):
    for profile, off in itertools.product(("gaussian", "cosine"), (-1e-4, 1e-4)):
        device = hs.SimulatedHapkit(initial_position=centre + off, coulomb_force=0.0, quantum=0.0)
        run = hs.simulate("bump_valley", {"profile": profile}, device=device, seconds=2.0)
        left = abs(run.true_position[-1] - centre)
        assert left < 1e-6 if stays else left > 0.01
