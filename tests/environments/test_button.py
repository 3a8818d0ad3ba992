"""Button: its reference curve, hysteresis, clicks, continuity and passivity."""

import numpy as np
import pytest

from hapkit_studio.errors import ParameterError
from tests.environments.calling import LIBRARY, along, forces, warned

BUTTON = LIBRARY["button"]
STIFFNESS, FADE = 1500.0, 0.5e-3
# theory §8. Columns: F1, F2 in N; s1, s2 in m; first slope and steepest drop in N/m; energy up to s2 in J
REFERENCE = [
    ((0.6, 0.4, 1.6e-3, 2.2e-3), 750.0, -500.0, 0.94e-3),
    ((2.0, 0.8, 3e-3, 5e-3), 1333.0, -900.0, 6.8e-3),
    ((1.0, 0.5, 4e-3, 7e-3), 500.0, -250.0, 4.9e-3),
]


def named(numbers, **more):
    names = ("peak_force", "snap_force", "snap_start", "travel")
    return {**dict(zip(names, numbers, strict=True)), "position": 0.0, **more}


def pushed(places, **given):
    """Return the static force (n,) in N against the handle while it is pressed to places (n,) in m."""
    return -forces("button", places, **given)


@pytest.mark.parametrize(("numbers", "first", "drop", "energy"), REFERENCE)
def test_follows_the_reference_curve(numbers, first, drop, energy):
    peak, snap, start, travel = numbers
    given = named(numbers)
    assert pushed([0.0, start, travel, travel + 1e-3], **given) == pytest.approx([0, peak, snap, snap + 0.5])
    s = np.linspace(0.0, travel, 4001)
    got = pushed(s, **given)
    slope = np.diff(got) / np.diff(s)
    assert slope[0] == pytest.approx(first, rel=1e-3)
    assert slope.min() == pytest.approx(drop, rel=1e-3)
    assert got.max() == pytest.approx(peak, rel=1e-6)
    assert np.sum(0.5 * (got[1:] + got[:-1])) * s[1] == pytest.approx(energy, rel=0.01)


@pytest.mark.parametrize("position", [-0.03, 0.005])
def test_press_and_release_differ_by_twice_the_hysteresis(position):
    """The forces while pressing and releasing are the two curves that the window plots.

    After a reversal, the force reaches the other curve within a distance of 2 h / (1500 N/m).
    """
    given = {"hysteresis": 0.3, "position": position}
    there = position + np.arange(-200, 1000) * 1e-5
    got, _ = along("button", np.concatenate([there, there[::-1]]), **given)
    way_in, way_out = got[:1200], got[1200:][::-1]
    drawn = BUTTON.over_position(BUTTON.values(given), there)
    assert way_in[1:] == pytest.approx(drawn[0][1:], abs=1e-9)
    turned = there < there[-1] - 2.0 * 0.3 / STIFFNESS
    assert way_out[turned] == pytest.approx(drawn[1][turned], abs=1e-9)
    deep = (there > position + FADE) & turned
    assert (way_out - way_in)[deep] == pytest.approx(0.6)
    assert not drawn[:, there <= position].any()


def paths(rng, count):
    """Return random paths (n,) in m around a button at 0, with small steps, pauses and jumps."""
    for scale in np.geomspace(1e-6, 5e-3, count):
        steps = rng.normal(0.0, scale, 600) * (rng.random(600) > 0.2)
        yield 0.004 + 0.011 * np.sin(np.cumsum(steps) / 0.011)


@pytest.mark.parametrize("hysteresis", [0.0, 0.1, 0.5])
@pytest.mark.parametrize("numbers", [r[0] for r in REFERENCE])
def test_is_continuous_on_every_path(numbers, hysteresis, rng):
    """No step changes the force by more than the steepest slopes of curve, stop and hysteresis allow."""
    peak, snap, start, travel = numbers
    slope = max(2.0 * peak / start, 1.5 * (peak - snap) / (travel - start), 500.0)
    bound = slope + STIFFNESS + hysteresis / FADE
    for path in paths(rng, 12):
        got, _ = along("button", path, **named(numbers, hysteresis=hysteresis))
        assert (np.abs(np.diff(got)) <= bound * np.abs(np.diff(path)) + 1e-12).all()


def dissipated(path, got):
    return -np.sum(0.5 * (got[1:] + got[:-1]) * np.diff(path))


@pytest.mark.parametrize("hysteresis", [0.0, 0.1, 0.5])
def test_no_closed_path_gains_energy(hysteresis, rng):
    """On a path that starts and ends outside the button, the button gives no more energy than it takes."""
    for reach in (2e-4, 6e-4, 2e-3, 5e-3, 1e-2):
        knots = np.append(rng.uniform(-0.2 * reach, reach, 9), -2e-3)
        path = np.array([-2e-3])
        for knot in knots:
            n = int(abs(knot - path[-1]) / 4e-6) + 2
            path = np.append(path, np.linspace(path[-1], knot, n)[1:])
        got, _ = along("button", path, hysteresis=hysteresis, position=0.0)
        lost = dissipated(path, got)
        assert lost > -1e-8
        assert lost < 1e-8 or hysteresis > 0.0


def counts(travels, **given):
    """Return (pressed, number of clicks down, number of clicks up) after each travel in m."""
    _, states = along("button", 0.005 + np.array(travels), **given)
    return [tuple(int(n) for n in row[-3:]) for row in states]


def test_clicks_on_press_past_the_middle_of_the_snap_and_on_release_below_half_of_its_start():
    middle, half = 5.5e-3, 2e-3
    assert counts([0.0, 0.99 * middle, 1.01 * middle]) == [(0, 0, 0), (0, 0, 0), (1, 1, 0)]
    pressed = [0.0, 6e-3, 1.01 * half, 0.99 * half]
    assert counts(pressed) == [(0, 0, 0), (1, 1, 0), (1, 1, 0), (0, 1, 1)]


def test_a_snap_that_starts_after_its_end_is_rejected():
    BUTTON.values({"snap_start": 0.99 * 0.007})
    for start in (0.007, 1.01 * 0.007):
        with pytest.raises(ParameterError, match=r"snap start must be less than .* 7 mm, not 7"):
            BUTTON.values({"snap_start": start})


def test_a_snap_without_drop_gets_a_warning():
    assert not warned("button", snap_force=0.99)
    for snap in (1.0, 1.01):
        (line,) = warned("button", snap_force=snap)
        assert "does not click" in line
