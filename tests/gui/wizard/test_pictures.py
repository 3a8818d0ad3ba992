"""The pictures of the steps, and the box that says what was found."""

import math

import numpy as np
import pytest
from PySide6.QtCore import QRect, Qt

from hapkit_studio.gui.wizard.board_dialog import LONG_SECONDS, SIGNS, ResultBox
from hapkit_studio.gui.wizard.handle_view import HandleView
from hapkit_studio.gui.wizard.kit_drawing import KitDrawing
from hapkit_studio.gui.wizard.recent_plot import PositionPlot, SensorPlot


def test_the_hand_lets_go_where_it_is(qtbot):
    view, moved = HandleView(), []
    qtbot.addWidget(view)
    view.hand_moved.connect(moved.append)
    view.set_hand_enabled(True)
    view.show()
    assert view.let_go.isHidden()
    view.move_hand(0.01)
    assert view.let_go.isVisible()
    qtbot.mouseClick(view.let_go, Qt.MouseButton.LeftButton)
    assert moved == [0.01, None]
    assert view.let_go.isHidden()


def ink(widget, box, token="applied"):
    """Return whether pixels of a colour are in a part of a widget."""
    from hapkit_studio.gui.widgets.theme import theme

    image = widget.grab(box).toImage()
    wanted = theme.color(token).rgb()
    return any(image.pixel(x, y) == wanted for x in range(image.width()) for y in range(image.height()))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_force_of_a_handle_at_the_end_keeps_its_number(qtbot, side):
    view = HandleView()
    qtbot.addWidget(view)
    view.resize(400, 166)
    view.show_handle(side * 0.048, side * 1.0)
    inner = QRect(400 - 130, 10, 80, 60) if side > 0.0 else QRect(50, 10, 80, 60)
    assert ink(view, inner)
    outermost = QRect(397, 0, 3, 166) if side > 0.0 else QRect(0, 0, 3, 166)
    assert not ink(view, outermost)


@pytest.mark.parametrize("value", [3, 1020])
def test_a_reading_that_stands_still_at_an_end_hides_neither_title_nor_scale(qtbot, value):
    plot = SensorPlot()
    qtbot.addWidget(plot)
    plot.resize(500, 150)
    title = QRect(10, 2, 200, 20)
    plain = plot.grab(title).toImage()
    plot.show_readings(np.linspace(0.0, 10.0, 500), np.full(500, value), 0, 1023)
    assert plot.grab(title).toImage() == plain


@pytest.mark.parametrize("wide", [300, 400, 800])
def test_words_of_a_drawing_are_never_small(qtbot, wide, monkeypatch):
    from PySide6.QtGui import QPainter

    sizes = []
    drawing = KitDrawing(supply=True)
    qtbot.addWidget(drawing)
    drawing.resize(wide, wide // 2)
    draw = QPainter.drawText

    def noted(painter, *words):
        sizes.append(painter.font().pixelSize() * painter.transform().m11())
        return draw(painter, *words)

    monkeypatch.setattr(QPainter, "drawText", noted)
    drawing.grab()
    assert min(sizes) >= 11.0


def test_a_long_run_shows_its_bar_and_a_short_or_endless_one_does_not(qtbot):
    """In the margin below the words: what stands above the box stays where it is."""
    box = ResultBox()
    qtbot.addWidget(box)
    box.resize(400, 60)
    box.show()
    box.show_text("Sweeping. Hands off…")
    qtbot.wait(10)
    low, hint = box.height(), box.sizeHint()
    box.show_progress(3.0, 12.0)
    assert box.bar.isVisible()
    assert box.bar.value() == 0.25 * box.bar.maximum()
    assert box.height() == low
    assert box.sizeHint() == hint
    assert box.rect().contains(box.bar.geometry())
    assert box.bar.geometry().top() > box.words.geometry().bottom()
    box.show_text("Found.", "Next: hang 50 g on it.", SIGNS["pass"])
    qtbot.wait(10)
    assert box.height() == low
    assert box.bar.geometry().top() > box.remedy.geometry().bottom()
    for passed, seconds in ((1.0, 0.9 * LONG_SECONDS), (20.0, math.inf), (0.0, 0.0)):
        box.show_progress(passed, seconds)
        assert not box.bar.isVisible()
        assert box.height() == low


def test_the_sweeps_limits_lie_about_its_start(qtbot):
    plot = PositionPlot()
    qtbot.addWidget(plot)
    plot.show_positions(np.array([0.0, 1.0]), np.array([0.007, 0.008]))
    assert plot.start == 0.008
    plot.show_positions(np.array([0.0, 1.0]), np.array([0.008, 0.020]))
    assert plot.start == 0.008
    assert plot.values[-1] == 12.0
    plot.begin_here()
    plot.show_positions(np.array([0.0, 1.0]), np.array([0.008, 0.020]))
    assert plot.start == 0.020


def test_the_button_that_lets_a_hand_go_never_covers_the_hand(qtbot):
    view = HandleView()
    qtbot.addWidget(view)
    view.set_hand_enabled(True)
    for width in (view.minimumWidth(), 812):
        view.resize(width, view.minimumHeight())
        for place in np.linspace(-0.055, 0.055, 23):
            view.move_hand(float(place))
            ring, button = view.hand_rect().toAlignedRect(), view.let_go.geometry()
            assert view.rect().contains(button)
            assert not button.intersects(ring)
