"""Scenes: mouse and keys move the hand, and positions are drawn to scale."""

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent

from hapkit_studio.gui.scenes import base as scenes
from tests.gui.scenes.scene_support import LIBRARY, has, scene_of, shot

SIZE = (880, 236)
LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def view(qtbot):
    return scene_of(qtbot, "wall", SIZE)[0]


@pytest.fixture
def stage(view):
    return view._layout()


def columns_of(picture, token, row):
    """Return the columns of a row with exactly a token's colour, without the focus ring."""
    return np.flatnonzero(has(picture[int(row)][np.newaxis, 4:-4], token, 0)[0]) + 4


def test_every_drawing_belongs_to_an_environment_and_the_handle_alone_is_the_default(view, stage):
    assert set(scenes.discover()) <= set(LIBRARY)
    bare = replace(LIBRARY["spring"], scene="drawn by nobody")
    view.set_environment(bare, bare.values())
    assert len(columns_of(shot(view, 0.0), "handle", stage.knob_middle))


@pytest.mark.parametrize("position", [-0.0123, 0.05])
def test_the_handle_is_drawn_to_scale(view, stage, position):
    view.set_environment(LIBRARY["free"], {})
    columns = columns_of(shot(view, position), "handle", stage.top + stage.band / 2)
    assert stage.mm(np.mean(columns) + 0.5) / 1e3 == pytest.approx(position, abs=0.5e-3 / stage.per_mm)


@pytest.mark.parametrize(("x", "expected"), [(440, 0.0), (880 - 21, 0.05), (21, -0.05)])
def test_pressing_moves_the_hand_to_the_pointer(view, qtbot, x, expected):
    with qtbot.waitSignal(view.hand_moved) as moved:
        qtbot.mousePress(view, LEFT, pos=QPoint(x, 100))
    assert moved.args[0] == pytest.approx(expected, abs=0.15e-3)
    with qtbot.waitSignal(view.hand_moved) as moved:
        qtbot.mouseMove(view, QPoint(x + (84 if x < 800 else -84), 40))
    assert abs(moved.args[0] - expected) == pytest.approx(0.01, abs=0.3e-3)
    with qtbot.waitSignal(view.hand_released):
        qtbot.mouseRelease(view, LEFT, pos=QPoint(0, 0))
    assert [view.target_at(far) for far in (5000, -5000)] == pytest.approx([0.06, -0.06])


def test_hover_and_wheel_do_nothing(view, qtbot):
    turn = QWheelEvent(
        QPointF(400, 100), QPointF(400, 100), QPoint(), QPoint(0, 120), Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    with qtbot.assertNotEmitted(view.hand_moved), qtbot.assertNotEmitted(view.hand_released):
        qtbot.mouseMove(view, QPoint(300, 100))
        view.wheelEvent(turn)
        qtbot.mouseRelease(view, LEFT)


def test_arrow_keys_start_at_the_handles_position_and_hold_it(view, qtbot):
    shot(view, 0.0031)
    targets = []
    view.hand_moved.connect(targets.append)
    qtbot.keyClick(view, Qt.Key.Key_Right)
    qtbot.keyClick(view, Qt.Key.Key_Right, Qt.KeyboardModifier.ShiftModifier)
    qtbot.keyClick(view, Qt.Key.Key_Left)
    assert targets == pytest.approx([0.0041, 0.0042, 0.0032])
    with qtbot.waitSignal(view.hand_released):
        qtbot.keyClick(view, Qt.Key.Key_Down)
    with qtbot.assertNotEmitted(view.hand_released):
        qtbot.keyClick(view, Qt.Key.Key_Down)


def test_the_hand_is_drawn_on_its_way_to_the_pointer(view, stage, qtbot):
    qtbot.mousePress(view, LEFT, pos=QPoint(round(stage.x(-35)), 100))
    for known, place in ((-0.02, -20.0), (None, -35.0)):
        columns = columns_of(shot(view, 0.0, (), 0.0, known), "accent", stage.knob_middle)
        assert [round(stage.x(dot)) in columns for dot in (-20.0, -35.0)] == [place == -20.0, place == -35.0]


def test_a_real_board_has_no_simulated_hand(view, qtbot):
    qtbot.keyClick(view, Qt.Key.Key_Right)
    with qtbot.waitSignal(view.hand_released):
        view.set_hand_enabled(False)
    with qtbot.assertNotEmitted(view.hand_moved):
        qtbot.mousePress(view, LEFT, pos=QPoint(100, 100))
        qtbot.keyClick(view, Qt.Key.Key_Right)


def test_the_wall_is_dented_exactly_under_the_handle(view, stage):
    for position, face in ((-0.02, 5.0), (0.0, 5.0), (0.012, 12.0)):
        first = columns_of(shot(view, position), "mat", stage.rail - 12)[0]
        assert first == pytest.approx(stage.x(face), abs=5 * stage.u)


@pytest.mark.parametrize("position", [-0.0619, 0.0901])
def test_an_arrow_points_to_a_handle_outside_the_picture(view, stage, position):
    columns = columns_of(shot(view, position, (), -1.0, 0.0), "handle", stage.knob_middle)
    edge = 0 if position < 0 else 880
    assert len(columns)
    assert (np.abs(columns - edge) < 25 * stage.u).all()
    assert any(abs(box.center().x() - edge) < 220 for box in view.text_boxes())
    shot(view, 0.05)
    assert len(view.text_boxes()) > 1


def test_no_line_to_the_hand_is_drawn_after_release(view, stage):
    between = range(int(stage.x(-35) + 12 * stage.u), int(stage.x(0) - 30 * stage.u))
    for grip, pulls in (("released", False), ("medium", True)):
        view.set_grip(grip)
        columns = columns_of(shot(view, 0.0, (), 0.0, -0.035), "accent", stage.knob_middle)
        assert bool(set(columns) & set(between)) == pulls


def test_no_arrow_is_drawn_while_stopped(view, stage):
    pushing = columns_of(shot(view, 0.01, (), -2.0), "applied", stage.knob_middle)
    stopped = columns_of(shot(view, 0.01, (), -2.0, stopped=True), "applied", stage.knob_middle)
    assert len(pushing) > 2.0 * 46 * 0.8
    assert len(stopped) < 60


def test_preparing_is_shown_in_the_scene_and_the_hint_at_the_knob(view, stage, qtbot):
    row = stage.top + stage.band * 0.45 + 3
    view.set_preparing(True, 0.5)
    assert len(columns_of(shot(view, 0.0), "accent", row)) == pytest.approx(105, abs=3)
    with qtbot.assertNotEmitted(view.hand_moved):
        qtbot.mousePress(view, LEFT, pos=QPoint(100, 100))
    view.set_preparing(False)
    assert len(columns_of(shot(view, 0.0), "accent", row)) == 0
    view._hint = True  # the hint is shown until the first drag
    assert len(columns_of(shot(view, 0.0), "accent", stage.knob_middle)) > 10
    qtbot.mouseClick(view, LEFT, pos=QPoint(440, 100))
    assert len(columns_of(shot(view, 0.0), "accent", stage.knob_middle)) == 0


def test_the_accessible_description_contains_numbers_and_units(view):
    shot(view, 0.00725, (), -0.9)
    assert "Wall" in view.accessibleName()
    assert "+7.25 mm" in view.accessibleDescription()
    assert "−0.90 N" in view.accessibleDescription()
