"""The force's arrow and its number: both in the picture and of one mind; words stand clear of the stem."""

import numpy as np
import pytest

from hapkit_studio.gui.scenes import force_arrow, stage
from hapkit_studio.gui.scenes.force_arrow import HEAD
from tests.gui.scenes.scene_support import LIBRARY, each_size, has, paint, scene_of, shot, state_of


def arrow(view, stage, picture):
    """Return the columns (n,) in which the arrow's middle is painted; its number has the same colour."""
    row = has(picture, "applied", 2)[int(stage.knob_middle)]
    columns = np.flatnonzero(row) + 0.5
    number = next(box for box in view.text_boxes() if box.bottom() < stage.top)
    return columns[(columns < number.left()) | (columns > number.right())]


@pytest.mark.parametrize("key", sorted(LIBRARY))
@each_size
@pytest.mark.parametrize("side", [-1, 1])
def test_an_outward_force_stays_in_the_picture_with_its_number(qtbot, key, size, side):
    view, stage = scene_of(qtbot, key, size)
    for place in (0.03, 0.041, 0.046, 0.05):
        for force in (0.02, 0.8, 3.0):
            columns = arrow(view, stage, shot(view, side * place, (), side * force))
            tip = (side * (columns - stage.width / 2)).max()
            assert place * 1e3 * stage.per_mm < tip < stage.width / 2 - 2 * stage.u
            assert np.ptp(columns) > 0.6 * HEAD * stage.u
            number = next(box for box in view.text_boxes() if box.bottom() < stage.top)
            assert number.left() >= 2
            assert number.right() <= stage.width - 2


@pytest.mark.parametrize(("force", "says"), [(0.0049, "0.00 N"), (0.0051, "+0.01 N"), (-0.0051, "−0.01 N")])
def test_there_is_an_arrow_where_the_number_is_not_zero(qtbot, force, says):
    view, stage = scene_of(qtbot, "free")
    columns = arrow(view, stage, shot(view, 0.0, (), force))
    assert view._motion.force_text == says
    assert bool(len(columns)) == (says != "0.00 N")


def said(view, force, position=0.0):
    """Return the number beside the arrow after one more row."""
    view.update_state(position, force, force, None, False, False, np.zeros(0))
    return view._motion.force_text


def test_a_number_never_contradicts_its_arrow_and_does_not_dance(qtbot, monkeypatch):
    monkeypatch.setattr(force_arrow, "EACH_MS", 10**9)
    view, _ = scene_of(qtbot, "free")
    assert [said(view, force) for force in (0.49, 0.52, -0.30, 0.0, -0.31, 0.61, -0.004)] == [
        "+0.49 N", "+0.49 N", "−0.30 N", "0.00 N", "−0.30 N", "+0.49 N", "0.00 N",
    ]  # fmt: skip
    view._words.invalidate()
    assert said(view, -0.31) == "−0.31 N"


def test_a_number_is_taken_anew_ten_times_a_second(qtbot):
    view, _ = scene_of(qtbot, "free")
    said(view, 0.49)
    qtbot.wait(120)
    assert said(view, 0.52) == "+0.52 N"


def test_the_walls_depth_is_never_negative(qtbot, monkeypatch):
    monkeypatch.setattr(force_arrow, "EACH_MS", 10**9)
    written, words = [], stage.paint_words
    monkeypatch.setattr(stage, "paint_words", lambda *given: (written.append(given[3]), words(*given)))
    view, _ = scene_of(qtbot, "wall")
    for position in (0.004, 0.0075, 0.0081):
        said(view, -1.0, position)
        view.grab()
    assert [text for text in written if text.startswith("d =")] == ["d = 2.50 mm", "d = 3.10 mm"]


@pytest.mark.parametrize("force", [0.0, 2.1])
def test_the_line_to_the_hand_is_not_seen_through_the_number(qtbot, force):
    view, stage = scene_of(qtbot, "spring")
    picture = shot(view, 0.045, (), force, 0.01)
    number = next(box for box in view.text_boxes() if box.bottom() < stage.top)
    row = has(picture, "accent", 60)[int(stage.knob_middle)]
    assert not row[int(number.left()) : int(number.right())].any()
    assert row[: int(number.left())].any()
    assert row[int(number.right()) :].any()


def test_the_hands_ring_is_whole_over_the_arrows_shaft_and_never_hides_its_head(qtbot):
    view, stage = scene_of(qtbot, "damping")
    row = int(stage.knob_middle)
    on_shaft = has(shot(view, -0.01, (), -2.2, -0.02), "applied", 2)[row]
    ring = slice(int(stage.x(-20.0) - 6 * stage.u), int(stage.x(-20.0) + 6 * stage.u))
    assert on_shaft[: ring.start].any()
    assert not on_shaft[ring].any()
    tip = int(stage.x(-45.0) - stage.knob_width / 2 - 7 * stage.u)
    at_the_edge = has(shot(view, -0.045, (), -2.2, -0.06), "applied", 2)[row]
    assert at_the_edge[13 : tip - 3].all()


CLEAR = [
    ("texture", {"kind": kind, "wavelength": wave}, {})
    for kind in ("bands", "grating", "sandpaper")
    for wave in (0.001, 0.005, 0.02)
] + [("button", {"position": place}, {"downs": 11.0, "ups": 10.0}) for place in (-0.04, 0.005, 0.034)]


@each_size
@pytest.mark.parametrize(("key", "given", "numbers"), CLEAR)
def test_what_is_said_of_it_stands_clear_of_the_stem(qtbot, key, given, numbers, size):
    view, stage = scene_of(qtbot, key, size, given)
    for position in np.arange(-0.03, 0.045, 0.0011):
        paint(view, position, state_of(key, **numbers))
        said = [box for box in view.text_boxes() if stage.top < box.center().y() < stage.rail]
        assert len(said) == 1, position
        stem, half = stage.x(1e3 * position), 2.25 * stage.u
        assert said[0].right() < stem - half or stem + half < said[0].left(), position


def test_a_spring_has_no_coil_behind_its_post(qtbot):
    view, stage = scene_of(qtbot, "spring")
    row = has(shot(view, -0.05), "matline", 40)[int(stage.rail - 0.46 * stage.band)]
    assert not row[int(stage.x(-45.5)) :].any()
