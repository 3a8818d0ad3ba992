"""The brush of the friction scene: its bristles lean by the tether's stretch, a sign tells that it sticks."""

import numpy as np
import pytest

from tests.gui.scenes.scene_support import each_size, has, scene_of, shot, state_of

ABOVE = 4.5  # px at u = 1: how far above the ground bristles are looked at, so that it does not hide them
# A bristle is a parabola, 13 px high at u = 1, through a point 0.15 of its lean aside at half its height.
T = 1.0 - (ABOVE - 2.0) / 13.0
SEEN = 0.3 * T * (1.0 - T) + T * T


def held(position, stretch, stuck=1.0):
    return state_of("friction", anchor=position + stretch, stuck=stuck, started=1.0)


def ends(picture, stage):
    """Return the columns (n,) of the bristles near their ends."""
    row = int(stage.rail - 0.34 * stage.band - ABOVE * stage.u)
    columns = np.flatnonzero(has(picture, "objline", 60)[row]) + 0.5
    bristles = np.split(columns, np.flatnonzero(np.diff(columns) > 1.0) + 1)
    return np.array([bristle.mean() for bristle in bristles])


@each_size
@pytest.mark.parametrize("stretch", [-0.0015, -0.0006, 0.0, 0.0008, 0.0012])
def test_bristles_end_where_the_anchor_holds_them(qtbot, stretch, size):
    view, stage = scene_of(qtbot, "friction", size, {"kinetic_force": 0.0})
    straight = ends(shot(view, 0.01, held(0.01, 0.0)), stage).mean()
    leaning = ends(shot(view, 0.01, held(0.01, stretch)), stage).mean()
    assert straight == pytest.approx(stage.x(10.0), abs=1.5)
    assert leaning - straight == pytest.approx(SEEN * 1e3 * stretch * stage.per_mm, abs=1.5)


def test_an_anchor_farther_than_bristles_reach_is_shown_at_its_place(qtbot):
    view, stage = scene_of(qtbot, "friction", given={"kinetic_force": 3.0, "tether_stiffness": 100.0})
    picture = shot(view, 0.02, held(0.02, -0.03))
    low = int(stage.rail - 0.34 * stage.band - 2 * stage.u)
    dot = np.flatnonzero(has(picture, "obj", 2)[low]) + 0.5
    assert dot.mean() == pytest.approx(stage.x(-10.0), abs=1.5)


def hatching(picture, stage, mm):
    """Return how many pixels under the ground's surface are drawn like what is fixed."""
    top = int(stage.rail - 0.34 * stage.band + 7 * stage.u)
    columns = slice(int(stage.x(mm) - 20 * stage.u), int(stage.x(mm) + 20 * stage.u))
    return has(picture, "matline", 40)[top : top + int(4 * stage.u), columns].sum()


@each_size
def test_a_sign_tells_that_it_sticks(qtbot, size):
    view, stage = scene_of(qtbot, "friction", size)
    sliding = shot(view, 0.01, held(0.01, 0.001, stuck=0.0))
    words = len(view.text_boxes())
    sticking = shot(view, 0.01, held(0.01, 0.001))
    assert hatching(sliding, stage, 11.0) == 0
    assert hatching(sticking, stage, 11.0) > 20
    assert len(view.text_boxes()) == words + 1


def test_the_word_waits_until_it_can_be_read(qtbot):
    view, _ = scene_of(qtbot, "friction")
    for step in range(12):
        shot(view, 1e-3 * step, held(1e-3 * step, 0.0))
    moving = len(view.text_boxes())
    for _ in range(12):
        shot(view, 0.011, held(0.011, 0.0))
    assert len(view.text_boxes()) == moving + 1


def test_rough_is_what_rubs(qtbot):
    heights = []
    for force in (0.0, 0.1, 0.4, 0.9):
        view, stage = scene_of(qtbot, "friction", given={"kinetic_force": force})
        rows = slice(int(stage.top), int(stage.rail) - 3)
        line = has(shot(view, 0.09), "matline", 60)[rows, int(stage.x(-40)) : int(stage.x(40))]
        heights.append(np.ptp(np.argmax(line, axis=0)))
    assert heights[0] <= 1
    assert heights == sorted(set(heights))


def test_before_the_first_row_nothing_leans_and_nothing_sticks(qtbot):
    view, stage = scene_of(qtbot, "friction")
    nothing, first = shot(view, 0.03, ()), shot(view, 0.03, state_of("friction", stuck=1.0))
    assert (nothing == first).all()
    assert hatching(first, stage, 30.0) == 0
