"""The cat's looks are its mood: eyes, ears, paw and words; all of it in the picture, and cheap."""

import itertools
import math
import time

import numpy as np
import pytest
from PySide6.QtCore import QRect
from PySide6.QtGui import QPixmap

from hapkit_studio.environments import discover
from hapkit_studio.gui.scenes import SceneView, cat_body
from hapkit_studio.gui.scenes.base import Motion
from hapkit_studio.gui.scenes.cat_body import color
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme
from tests.gui.scenes.scene_support import each_size

CAT = discover()["cat"]
FACE = (-46.0, -30.0, 0.3, 0.9)
MOODS = {
    "at rest": {},
    "content": {"contentment": 0.2},
    "purring": {"contentment": 0.6},
    "annoyed": {"contentment": -0.6},
    "swat": {"contentment": -0.55, "swat": 0.15, "push": 1.0},
    "sulking": {"contentment": -0.4, "sulk": 3.0},
}


def state(position=0.0, bend=0.0, **given):
    """Return a row's state: bend in m is how far the hand has bent the hair."""
    known = {"anchor": position - bend, "push": 1.0, "started": 1.0} | given
    values = np.zeros(16)
    for name, value in known.items():
        values[CAT.state_names.index(name)] = value
    return values


def cat_view():
    """Return a scene that shows the cat at its defaults."""
    view = SceneView()
    view.resize(880, 236)
    view.set_environment(CAT, CAT.values())
    view._hint = False
    view.show()
    return view


def show(view, position=0.0, force=0.0, hand=None, bend=0.0, **given):
    view._words.invalidate()
    view.update_state(position, force, force, hand, False, False, state(position, bend, **given))
    return view.grab().toImage()


def box(view, left, right, low, high):
    """Return the pixels from left to right mm and low to high share of the cat's height."""
    stage = Stage(view.width(), view.height())
    top, bottom = cat_body.y(stage, high), cat_body.y(stage, low)
    return QRect(int(stage.x(left)), int(top), int(stage.x(right) - stage.x(left)), int(bottom - top))


def count(image, area, wanted):
    """Return how many pixels of an area have a colour."""
    places = itertools.product(range(area.left(), area.right()), range(area.top(), area.bottom()))
    return sum(image.pixelColor(x, y) == wanted for x, y in places)


@pytest.fixture
def view(qtbot):
    view = cat_view()
    qtbot.addWidget(view)
    return view


@pytest.mark.parametrize(("mood", "open_"), [("at rest", True), ("purring", False), ("annoyed", True)])
def test_eyes_close_in_contentment(view, mood, open_):
    image = show(view, **MOODS[mood])
    seen = count(image, box(view, *FACE), color("iris"))
    assert seen > 15 if open_ else seen == 0


def test_eyes_fall_shut_by_and_by():
    opened = [cat_body.Mood(c).eyes for c in (-0.5, -0.2, 0.0, 0.1, 0.2, 0.3)]
    assert all(b < a for a, b in itertools.pairwise(opened))
    assert cat_body.Mood(0.301).eyes == 0.0


def test_pupils_follow_the_hand_but_not_in_a_sulk(view):
    middles = []
    for mood in ("at rest", "sulking"):
        for position in (-0.045, 0.04):
            image, area = show(view, position, **MOODS[mood]), box(view, -46.0, -38.6, 0.55, 0.75)
            dark = [
                x
                for x, y in itertools.product(
                    range(area.left(), area.right()), range(area.top(), area.bottom())
                )
                if image.pixelColor(x, y) == color("iris")
            ]
            middles.append(np.mean(dark))
    assert middles[0] > middles[1] + 1.0  # what is seen of the iris lies behind the pupil
    assert middles[2] == middles[3]


@pytest.mark.parametrize("mood", MOODS)
def test_purr_arcs_are_there_while_it_purrs(view, mood):
    arcs = count(show(view, **MOODS[mood]), box(view, -34.5, -28.0, 0.3, 0.62), theme.color("accent"))
    assert (arcs > 0) == (mood == "purring")


def test_ears_turn_back_below_the_mood_it_swats_in(view):
    tips = box(view, -44.0, -33.0, 0.93, 1.09)
    ears = {c: count(show(view, contentment=c), tips, color("fur")) for c in (0.0, -0.3, -0.51)}
    assert ears[0.0] > 30
    assert ears[-0.3] > 30
    assert ears[-0.51] == 0


@pytest.mark.parametrize("position", [-0.01, 0.02])
def test_the_paw_goes_out_to_the_hand_in_a_swat(view, position):
    reach = box(view, 1e3 * min(position, 0.005) - 9.0, 1e3 * min(position, 0.005), 0.6, 0.85)
    assert count(show(view, position, **MOODS["swat"]), reach, color("cream")) > 40
    assert count(show(view, position, **MOODS["annoyed"]), reach, color("cream")) == 0


@pytest.mark.parametrize("mood", MOODS)
def test_a_word_says_the_mood(mood):
    motion = Motion(state=state(**MOODS[mood]))
    assert cat_body.read(motion).word == mood


@pytest.mark.parametrize("rows", [np.zeros(0), np.zeros(3), np.full(16, np.nan)])
def test_without_a_state_it_is_at_rest(view, rows):
    view.update_state(0.0, 0.0, 0.0, None, False, False, rows)
    view.grab()
    assert cat_body.read(Motion(state=rows)).word == "at rest"


@each_size
@pytest.mark.parametrize("mood", MOODS)
def test_nothing_overlaps_or_leaves_the_picture(view, size, mood):
    view.resize(*size)
    for position, force in itertools.product(np.linspace(-0.05, 0.05, 9), (-0.42, 0.0, 0.85)):
        show(view, position, force, position + 0.012, **MOODS[mood])
        stage, boxes = Stage(*size), view.text_boxes()
        for one in boxes:
            assert one.left() >= 0
            assert one.right() <= size[0]
        for first, second in itertools.combinations(boxes, 2):
            assert not first.intersects(second)
        stem = stage.x(1e3 * position)
        below = [one for one in boxes if stage.top - 8.0 * stage.u < one.center().y() < stage.rail]
        assert len(below) == 1  # the mood's word
        assert not below[0].left() < stem < below[0].right()


def test_hair_moves_in_the_picture_only_where_the_pad_is(view):
    first, second = show(view, 0.005, bend=0.0017), show(view, 0.005, bend=-0.003)
    near, far = box(view, -2.0, 12.0, 0.7, 0.95), box(view, -25.0, -15.0, 0.7, 0.95)
    assert first.copy(near) != second.copy(near)
    assert first.copy(far) == second.copy(far)


@each_size
def test_tail_and_ears_stay_in_the_picture(view, size):
    view.resize(*size)
    ground = theme.color("scene")
    for breath in np.linspace(0.0, 6.2, 13):
        image = show(view, -0.01, contentment=-1.0, breath=breath)
        stage = Stage(*size)
        for x in (1, size[0] - 2):
            for y in range(8, int(stage.rail) - 4):
                assert image.pixelColor(x, y) == ground


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
