"""The cat's looks are its mood: eyes, ears, paw and words."""

import itertools

import numpy as np
import pytest

from hapkit_studio.gui.scenes import cat_body
from hapkit_studio.gui.scenes.base import Motion
from hapkit_studio.gui.scenes.cat_body import color
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme
from tests.gui.cat_support import MOODS, SIZES, box, cat_view, count, show, state


@pytest.fixture
def view(qtbot):
    view = cat_view()
    qtbot.addWidget(view)
    return view


FACE = (-46.0, -30.0, 0.3, 0.9)


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


@pytest.mark.parametrize(
    "size", [SIZES[0], *(pytest.param(size, marks=pytest.mark.slow) for size in SIZES[1:])]
)
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
