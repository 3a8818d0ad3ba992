"""Scenes: the pointer is the hand, the handle is true to scale, no words overlap, colours follow."""

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QPainter, QPixmap, QWheelEvent

from hapkit_studio.environments import discover
from hapkit_studio.gui.scenes import SceneView
from hapkit_studio.gui.scenes import base as scenes
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme

LIBRARY = discover()


@pytest.fixture
def view(qtbot):
    view = SceneView()
    qtbot.addWidget(view)
    view.resize(880, 236)
    view.set_environment(LIBRARY["wall"], LIBRARY["wall"].values())
    view.show()
    return view


def show(view, position, applied=0.0, hand=None, clamped=False, stopped=False):
    view._words.invalidate()
    view.update_state(position, applied, applied, hand, clamped, stopped, np.zeros(16))
    return view.grab().toImage()


def pixels_of(image, token, y):
    """Return the columns of a row, but for the focus ring, that have exactly a token's colour."""
    color = QColor(theme.tokens[token])
    return [x for x in range(4, image.width() - 4) if image.pixelColor(x, y) == color]


def test_every_drawing_is_of_an_environment_and_without_one_there_is_the_bare_handle(view):
    assert set(scenes.discover()) <= set(LIBRARY)
    bare = replace(LIBRARY["spring"], scene="drawn by nobody")
    view.set_environment(bare, bare.values())
    assert pixels_of(show(view, 0.0), "handle", int(Stage(880, 236).knob_middle))


@pytest.mark.parametrize("position", [-0.04, -0.0123, 0.0, 0.02, 0.05])
def test_the_handle_stands_at_its_true_place(view, position):
    view.set_environment(LIBRARY["free"], {})
    image = show(view, position)
    stage = Stage(880, 236)
    columns = pixels_of(image, "handle", int(stage.top + stage.band / 2))
    drawn = stage.mm(np.mean(columns) + 0.5) / 1e3
    assert drawn == pytest.approx(position, abs=0.5e-3 / stage.per_mm)


@pytest.mark.parametrize(("x", "expected"), [(440, 0.0), (880 - 21, 0.05), (21, -0.05)])
def test_pressing_moves_the_hand_to_the_pointer(view, qtbot, x, expected):
    with qtbot.waitSignal(view.hand_moved) as moved:
        qtbot.mousePress(view, Qt.MouseButton.LeftButton, pos=QPoint(x, 100))
    assert moved.args[0] == pytest.approx(expected, abs=0.15e-3)
    with qtbot.waitSignal(view.hand_moved) as moved:
        qtbot.mouseMove(view, QPoint(x + (84 if x < 800 else -84), 40))
    assert abs(moved.args[0] - expected) == pytest.approx(0.01, abs=0.3e-3)
    with qtbot.waitSignal(view.hand_released):
        qtbot.mouseRelease(view, Qt.MouseButton.LeftButton, pos=QPoint(0, 0))


def test_moving_without_a_pressed_button_and_the_wheel_do_nothing(view, qtbot):
    turn = QWheelEvent(
        QPointF(400, 100), QPointF(400, 100), QPoint(), QPoint(0, 120), Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    with qtbot.assertNotEmitted(view.hand_moved), qtbot.assertNotEmitted(view.hand_released):
        qtbot.mouseMove(view, QPoint(300, 100))
        view.wheelEvent(turn)
        qtbot.mouseRelease(view, Qt.MouseButton.LeftButton)


def test_the_pointer_never_pulls_beyond_the_handles_reach(view):
    assert view.target_at(5000) == pytest.approx(0.06)
    assert view.target_at(-5000) == pytest.approx(-0.06)


def test_arrow_keys_take_the_handle_where_it_is_and_hold_it(view, qtbot):
    show(view, 0.0031)
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


def test_a_real_board_has_no_pointer_hand(view, qtbot):
    qtbot.keyClick(view, Qt.Key.Key_Right)
    with qtbot.waitSignal(view.hand_released):
        view.set_hand_enabled(False)
    with qtbot.assertNotEmitted(view.hand_moved):
        qtbot.mousePress(view, Qt.MouseButton.LeftButton, pos=QPoint(100, 100))
        qtbot.keyClick(view, Qt.Key.Key_Right)


def test_the_wall_gives_way_exactly_under_the_handle(view):
    view.set_environment(LIBRARY["wall"], LIBRARY["wall"].values({"position": 0.005}))
    stage = Stage(880, 236)
    row = int(stage.rail - 12)
    for position, face in ((-0.02, 5.0), (0.0, 5.0), (0.012, 12.0)):
        image = show(view, position)
        mat = QColor(theme.tokens["mat"])
        first = next(x for x in range(880) if image.pixelColor(x, row) == mat)
        assert first == pytest.approx(stage.x(face), abs=5 * stage.u)


@pytest.mark.parametrize("position", [-0.0619, 0.0901])
def test_a_handle_out_of_sight_is_pointed_to(view, position):
    stage = Stage(880, 236)
    columns = pixels_of(show(view, position, -1.0, hand=0.0), "handle", int(stage.knob_middle))
    edge = 0 if position < 0 else 880
    assert columns
    assert all(abs(x - edge) < 25 * stage.u for x in columns)
    assert any(abs(box.center().x() - edge) < 220 for box in view.text_boxes())
    show(view, 0.05)
    assert len(view.text_boxes()) > 1


def test_a_released_grip_draws_no_line_to_the_hand(view):
    stage = Stage(880, 236)
    between = range(int(stage.x(-35) + 12 * stage.u), int(stage.x(0) - 30 * stage.u))
    for grip, pulls in (("released", False), ("medium", True)):
        view.set_grip(grip)
        columns = pixels_of(show(view, 0.0, hand=-0.035), "accent", int(stage.knob_middle))
        assert bool(set(columns) & set(between)) == pulls


def test_stopped_shows_no_arrow(view):
    stage = Stage(880, 236)
    row = int(stage.knob_middle)
    pushing = len(pixels_of(show(view, 0.01, -2.0), "applied", row))
    stopped = len(pixels_of(show(view, 0.01, -2.0, stopped=True), "applied", row))
    assert pushing > 2.0 * 46 * 0.8
    assert stopped < 60


def test_preparing_stands_in_the_scenes_place(view, qtbot):
    view.set_preparing(True, 0.5)
    image = view.grab().toImage()
    stage = Stage(880, 236)
    row = int(stage.top + stage.band * 0.45 + 3)
    assert len(pixels_of(image, "accent", row)) == pytest.approx(105, abs=3)
    with qtbot.assertNotEmitted(view.hand_moved):
        qtbot.mousePress(view, Qt.MouseButton.LeftButton, pos=QPoint(100, 100))
    view.set_preparing(False)
    assert len(pixels_of(view.grab().toImage(), "accent", row)) == 0


def test_the_hint_goes_with_the_first_drag(view, qtbot):
    before = len(pixels_of(show(view, 0.0), "accent", int(Stage(880, 236).knob_middle)))
    qtbot.mousePress(view, Qt.MouseButton.LeftButton, pos=QPoint(440, 100))
    qtbot.mouseRelease(view, Qt.MouseButton.LeftButton, pos=QPoint(440, 100))
    after = len(pixels_of(show(view, 0.0), "accent", int(Stage(880, 236).knob_middle)))
    assert before > 10
    assert after == 0


def test_what_a_screen_reader_says_carries_numbers_and_units(view):
    show(view, 0.00725, -0.9)
    assert "Wall" in view.accessibleName()
    assert "+7.25 mm" in view.accessibleDescription()
    assert "−0.90 N" in view.accessibleDescription()


@pytest.mark.parametrize("key", ["wall", "hard_surface", "cat"])
def test_a_scene_draws_at_twice_the_resolution(qapp, key):
    picture = QPixmap(1760, 472)
    picture.setDevicePixelRatio(2.0)
    picture.fill(QColor("black"))
    painter = QPainter(picture)
    stage = Stage(880, 236, 2.0)
    stage.begin(painter)
    stage.ground()
    scene = scenes.named(key)
    scene.fixed(stage, {})
    stage.axis()
    painter.end()
    assert picture.toImage().pixelColor(1700, 16) == QColor(theme.tokens["scene"])
