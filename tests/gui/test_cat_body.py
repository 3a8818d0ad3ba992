"""The cat's body: hair under the hand, a flank that breathes, all of it in the picture and cheap."""

import math
import time

import numpy as np
import pytest
from PySide6.QtGui import QColor, QPixmap

from hapkit_studio.environments import discover
from hapkit_studio.gui.scenes import cat, cat_body, cat_head
from hapkit_studio.gui.scenes.base import Motion
from hapkit_studio.gui.scenes.cat_body import COAT, color
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.palette import MODES
from tests.gui.cat_support import SIZES, box, cat_view, count, show, state


@pytest.fixture
def view(qtbot):
    view = cat_view()
    qtbot.addWidget(view)
    return view


def test_hair_lies_with_the_nap_and_gives_way_under_the_pad():
    place = np.linspace(-30.0, 34.0, 129)
    motion = Motion(position=-11.0)
    still, along, against = (cat.angles(place, cat_body.Mood(bend=b), motion) for b in (0.0, 0.6, -1.0))
    pad, far = np.argmin(np.abs(place + 11.0)), np.abs(place + 11.0) > 15.0
    for each in (still, along, against):
        assert each[far] == pytest.approx(math.radians(38.0), abs=1e-3)
    assert math.degrees(along[pad]) < 15.0
    assert math.degrees(against[pad]) > 120.0


def test_hair_stands_where_it_was_just_rubbed_the_wrong_way():
    place = np.array([-10.0, 5.0, 15.0, 30.0])
    for way, behind in ((-1.0, 2), (1.0, 1)):
        motion = Motion(position=10.0 + 12.0 * way)
        motion.trail.extend([10.0 - 12.0 * way, 10.0, 10.0 + 12.0 * way])
        turned = np.degrees(cat.angles(place, cat_body.Mood(), motion)) - 38.0
        assert turned[0] == pytest.approx(0.0, abs=2.0)
        assert turned[behind] > 15.0 if way < 0.0 else turned[behind] < -4.0


def test_hair_moves_in_the_picture_only_where_the_pad_is(view):
    first, second = show(view, 0.005, bend=0.0017), show(view, 0.005, bend=-0.003)
    near, far = box(view, -2.0, 12.0, 0.7, 0.95), box(view, -25.0, -15.0, 0.7, 0.95)
    assert first.copy(near) != second.copy(near)
    assert first.copy(far) == second.copy(far)


def top_of_back(image, view, mm):
    stage = Stage(view.width(), view.height())
    column = [image.pixelColor(int(stage.x(mm)), y) == color("fur") for y in range(view.height())]
    return column.index(True)


def test_the_flank_breathes_by_1_2_percent_either_way(view):
    view.resize(880, 330)
    rows = [top_of_back(show(view, -0.02, breath=b), view, 2.7) for b in (0.0, math.pi / 2, math.pi)]
    stage = Stage(880, 330)
    full = 0.0245 * 0.755 * stage.band
    assert rows[2] - rows[0] == pytest.approx(full, abs=1.01)
    assert rows[0] < rows[1] < rows[2]


def test_the_pad_rests_on_the_cat_without_a_jump():
    stage = Stage(880, 236)
    heights = [cat_body.pad_height(mm, cat_body.Mood()) * stage.band for mm in np.arange(-60.0, 60.0, 0.1)]
    assert np.abs(np.diff(heights)).max() < 0.5 * 0.1 * stage.per_mm * 6.0
    assert cat_body.pad_height(0.0, cat_body.Mood()) == pytest.approx(0.755 * 1.012 - 0.055, abs=1e-6)


@pytest.mark.parametrize("size", SIZES)
def test_tail_and_ears_stay_in_the_picture(view, size):
    view.resize(*size)
    ground = theme.color("scene")
    for breath in np.linspace(0.0, 6.2, 13):
        image = show(view, -0.01, contentment=-1.0, breath=breath)
        stage = Stage(*size)
        for x in (1, size[0] - 2):
            for y in range(8, int(stage.rail) - 4):
                assert image.pixelColor(x, y) == ground


@pytest.mark.parametrize("mode", MODES)
def test_coat_is_its_own_in_every_theme(view, mode):
    theme.set_mode(mode)
    image = show(view, -0.01)
    assert count(image, box(view, 20.0, 24.0, 0.5, 0.6), QColor(COAT["fur"][MODES.index(mode)])) > 20


def cost(view, key, frames=40):
    """Return the least time in s of this thread to paint a frame while handle and mood change."""
    environment, picture, least = discover()[key], QPixmap(view.size()), math.inf
    view.set_environment(environment, environment.values())
    for k in range(frames):
        x = 0.03 * math.sin(0.1 * k)
        mood = state(x, bend=0.003 * math.cos(0.1 * k), contentment=0.5 * math.cos(0.05 * k), breath=0.1 * k)
        view.update_state(x, 0.4, 0.4, x + 0.002, False, False, mood)
        begin = time.thread_time()
        view.render(picture)
        least = min(least, time.thread_time() - begin)
    return least


def test_a_cat_costs_no_more_than_six_handles(view):
    """60 times a second, beside plots that have to be drawn too."""
    view.resize(880, 272)
    assert min(cost(view, "cat") for _ in range(2)) < 6.0 * cost(view, "free")


def test_a_face_is_painted_once_for_many_frames(view):
    cat_head._picture.cache_clear()
    for k in range(200):
        x = 0.03 * math.sin(0.05 * k)
        show(view, x, contentment=0.001 * k, breath=0.04 * k)
    seen = cat_head._picture.cache_info()
    assert seen.hits + seen.misses == 200
    assert 10 < seen.misses < 80
