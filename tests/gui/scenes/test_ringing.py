"""The hard surface rings in the picture as the law rings: real pitch, decay, cut, and how much is left."""

import math

import numpy as np
import pytest

from hapkit_studio.gui.scenes import hard_surface
from tests.gui.scenes.scene_support import LIBRARY, has, scene_of, shot, state_of

MATERIALS = {"rubber": (5.1, 60.0, 18.0), "wood": (6.6, 80.0, 100.0), "aluminium": (13.2, 90.0, 300.0)}
PER_MM = 2e-3  # s: the bar of 20 ms is as long as 10 mm
FACE = 9.0  # px at u = 1 from the face to the ringing's beginning


def drawn(view, stage, position=-0.03, state=None, surface=5.0):
    """Return times (n,) in s and rows (n,) of the drawn line's middle; the scale is not known here."""
    picture = shot(view, position, state_of("hard_surface", since=-1.0) if state is None else state)
    top, low = int(stage.top) + 6, int(stage.rail - 22 * stage.u)
    line = (has(picture, "matline", 40) | has(picture, "handle", 40))[top:low]
    left = stage.x(surface) + FACE * stage.u
    columns = np.arange(math.ceil(left) + 1, int(stage.x(48.0)) - 1)
    rows = np.array([top + np.flatnonzero(line[:, c]).mean() + 0.5 for c in columns])
    return (columns + 0.5 - left) / stage.per_mm * PER_MM, rows


@pytest.mark.parametrize("frequency", [20.0, 50.0, 90.0])
@pytest.mark.parametrize("decay", [10.0, 60.0])
def test_the_drawn_line_is_the_decaying_sine(qtbot, frequency, decay):
    given = {"frequency": frequency, "decay": decay, "amplitude": 12.0, "limit": 3.0}
    view, stage = scene_of(qtbot, "hard_surface", (1100, 330), given)
    seconds, rows = drawn(view, stage, state=state_of("hard_surface", since=-1.0, speed=0.2))
    newtons = 12.0 * 0.2 * np.exp(-decay * seconds) * np.sin(2 * math.pi * frequency * seconds)
    scale, level = np.polyfit(newtons, rows, 1)
    assert scale < 0.0
    assert np.abs(rows - level - scale * newtons).max() < 0.06 * np.ptp(rows) + 1.5


@pytest.mark.parametrize("material", MATERIALS)
def test_a_material_rings_as_itself(material):
    values = LIBRARY["hard_surface"].values({"material": material})
    assert hard_surface.sound(values) == MATERIALS[material]


def test_a_hard_tap_is_drawn_higher_but_cut_at_the_limit(qtbot):
    view, stage = scene_of(qtbot, "hard_surface", (1100, 330), {"limit": 1.0})
    highest = [
        np.ptp(drawn(view, stage, state=state_of("hard_surface", since=-1.0, speed=speed))[1])
        for speed in (0.02, 0.05, 0.4, 0.8)
    ]
    assert highest[0] == pytest.approx(0.4 * highest[1], rel=0.15)
    assert highest[1] < highest[2] == pytest.approx(highest[3], abs=2.5)
    one_newton = 0.42 * stage.band / 3.0
    assert highest[3] == pytest.approx(2.0 * one_newton, rel=0.12)


@pytest.mark.parametrize("since", [0.005, 0.02, 0.06])
def test_what_is_left_is_dark_and_what_is_over_is_pale(qtbot, since):
    view, stage = scene_of(qtbot, "hard_surface", (1100, 330), {"decay": 10.0})
    picture = shot(view, 0.0051, state_of("hard_surface", since=since, speed=0.1))
    rows = slice(int(stage.top) + 6, int(stage.rail - 22 * stage.u))
    left = stage.x(5.1) + (2.2 + FACE) * stage.u
    dark = has(picture, "handle", 40)[rows].any(axis=0)
    now, end = left + since / PER_MM * stage.per_mm, stage.x(47.5)
    assert dark[int(now) + 3 : int(end)].all()
    assert not dark[int(left) + 1 : int(now) - 3].any()


def test_arcs_tell_of_a_fresh_impact_only(qtbot):
    view, stage = scene_of(qtbot, "hard_surface")

    def arcs(since):
        picture = shot(view, 0.0055, state_of("hard_surface", since=since, speed=0.1))
        before = picture[int(stage.top) : int(stage.rail), : int(stage.x(4.0))]
        return (before[:, :, 0] - before[:, :, 2] > 60).sum()

    fresh = arcs(0.001)
    assert fresh > 40
    assert arcs(0.2) < fresh
    assert arcs(0.3) == arcs(-1.0) == 0


@pytest.mark.parametrize("position", [-0.04, 0.005, 0.04])
def test_the_face_stands_at_the_surface_until_it_is_pressed_in(qtbot, position):
    view, stage = scene_of(qtbot, "hard_surface", given={"position": position})
    row = int(stage.rail - 0.75 * stage.band)
    for handle, face in ((position - 0.01, position), (position + 0.003, position + 0.003)):
        solid = np.flatnonzero(has(shot(view, handle), "mat2", 4)[row])
        assert solid[0] == pytest.approx(stage.x(1e3 * face), abs=5 * stage.u)
