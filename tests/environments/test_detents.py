"""Detents attract at each multiple of the pitch, and exert no force in between."""

import numpy as np
import pytest

import hapkit_studio as hs
from tests.environments.calling import force, forces

SMOOTH = {"coulomb_force": 0.0, "quantum": 0.0}


def released(start, **given):
    device = hs.SimulatedHapkit(initial_position=start, **SMOOTH)
    return hs.simulate("detents", given, device=device, seconds=1.5).true_position[-1]


@pytest.mark.parametrize("centre", [-0.04, -0.02, 0.0, 0.02, 0.04])
def test_a_handle_in_a_notch_moves_to_its_centre(centre):
    for side in (-1, 1):
        assert released(centre + side * 0.99 * 0.003) == pytest.approx(centre, abs=1e-7)


@pytest.mark.parametrize("centre", [-0.02, 0.0, 0.02])
def test_a_handle_outside_a_notch_stays_at_rest(centre):
    for side in (-1, 1):
        start = centre + side * 1.01 * 0.003
        assert released(start) == start


@pytest.mark.parametrize("pitch", [0.005, 0.013, 0.04])
def test_centres_are_the_multiples_of_the_pitch(pitch):
    for n in range(-3, 4):
        inside = n * pitch + 1e-3
        assert force("detents", n * pitch, pitch=pitch) == pytest.approx(0.0, abs=1e-12)
        assert force("detents", inside, pitch=pitch) == pytest.approx(-0.4, rel=1e-9)


def test_damping_acts_only_inside():
    assert force("detents", 0.02, 0.3, damping=5.0) == pytest.approx(-1.5)
    assert force("detents", 0.02 + 0.99 * 0.003, 0.3, stiffness=0.0, damping=5.0) == pytest.approx(-1.5)
    assert force("detents", 0.02 + 1.01 * 0.003, 0.3, damping=5.0) == 0.0


def test_notches_wider_than_the_pitch_meet_halfway():
    """Every position belongs to the nearest centre, without a gap, and the force is at most k pitch / 2."""
    x = np.linspace(-0.02, 0.02, 1601)
    nearest = 0.006 * np.round(x / 0.006)
    between = np.abs(np.abs(x - nearest) - 0.003) > 1e-9
    got = forces("detents", x, pitch=0.006, half_width=0.005)
    assert got[between] == pytest.approx(-400.0 * (x - nearest)[between], abs=1e-9)
