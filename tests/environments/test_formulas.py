"""Each simple environment agrees with its formula."""

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.dynamics.hand import Prescribed
from tests.environments.calling import force


def test_free_has_no_force():
    assert force("free", 0.03, 2.0) == 0.0


def test_spring_force_is_proportional_to_the_distance(rng):
    for k, b, x0, x, v in rng.uniform(-1, 1, (50, 5)) * (0, 0, 0.04, 0.05, 2) + (700, 20, 0, 0, 0):
        got = force("spring", x, v, stiffness=k, damping=b, center=x0)
        assert got == pytest.approx(-k * (x - x0) - b * v, rel=1e-13)


def test_damping_steps_by_one_count_per_period():
    """F = -b v of a quantised position has steps of b quantum / T, which are not filtered out."""
    assert force("damping", 0.01, 0.3, damping=7.0) == pytest.approx(-2.1)
    run = hs.simulate("damping", {"damping": 10.0}, hand=Prescribed(lambda t: 0.0305 * t), seconds=0.3)
    step = 10.0 * 20.7e-6 * 1000.0
    steps = run.force[1:] / step
    assert np.allclose(steps, np.round(steps), atol=1e-9)
    assert set(np.round(steps)) == {-1.0, -2.0}


@pytest.mark.parametrize("side", ["right", "left"])
def test_wall_is_continuous_at_its_surface(side):
    for inside in (1e-9, 1e-6):
        x = 0.005 + inside if side == "right" else 0.005 - inside
        outside = 0.005 - inside if side == "right" else 0.005 + inside
        assert force("wall", outside, 1.0, side=side, damping=30.0) == 0.0
        assert abs(force("wall", x, side=side, stiffness=5000)) == pytest.approx(5000 * inside, rel=1e-6)
    assert force("wall", 0.005, 1.0, side=side, damping=30.0) == 0.0


def test_walls_of_both_sides_are_mirror_images(rng):
    for x, v in rng.uniform(-1, 1, (200, 2)) * (0.04, 2.0):
        for mode in ("into", "both", "none"):
            given = {"stiffness": 400.0, "damping": 5.0, "damping_mode": mode}
            right = force("wall", x, v, side="right", position=0.01, **given)
            left = force("wall", -x, -v, side="left", position=-0.01, **given)
            assert left == pytest.approx(-right, abs=1e-12)
            assert right <= 0.0 or mode == "both"


@pytest.mark.parametrize(
    ("mode", "going_in", "going_out"), [("into", -3.5, -2.5), ("both", -3.5, -1.5), ("none", -2.5, -2.5)]
)
def test_wall_damping_acts_as_its_mode_says(mode, going_in, going_out):
    given = {"stiffness": 250.0, "damping": 10.0, "position": 0.005, "damping_mode": mode}
    assert force("wall", 0.015, 0.1, **given) == pytest.approx(going_in)
    assert force("wall", 0.015, -0.1, **given) == pytest.approx(going_out)
    assert force("wall", 0.015, 0.0, **given) == pytest.approx(-2.5)
