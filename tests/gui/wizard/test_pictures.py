"""The drawings of the steps, and the result box."""

import math

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt

from hapkit_studio.gui.scenes import base
from hapkit_studio.gui.wizard.board_dialog import LONG_SECONDS, SIGNS, ResultBox
from hapkit_studio.gui.wizard.pictures import HandleView, KitDrawing, PositionPlot, SensorPlot


def test_a_button_beside_the_hand_releases_it(qtbot):
    view, moved = HandleView(with_force=True), []
    qtbot.addWidget(view)
    view.hand_moved.connect(moved.append)
    view.hand_released.connect(lambda: moved.append(None))
    view.set_hand_enabled(True)
    view.show()
    assert view.let_go.isHidden()
    for width in (view.minimumWidth(), 812):
        view.resize(width, view.minimumHeight())
        for x in np.linspace(0, width, 23):
            qtbot.mousePress(view, Qt.MouseButton.LeftButton, pos=QPoint(int(x), 60))
            qtbot.mouseRelease(view, Qt.MouseButton.LeftButton)
            button, stage = view.let_go.geometry(), view._layout()
            assert view.rect().contains(button)
            assert (
                abs(button.center().x() - stage.x(1e3 * moved[-1])) > button.width() / 2 + base.RING * stage.u
            )
    places = set()
    for x in (380, 400, 420, 440):  # near the middle, the button fits on either side of the hand
        qtbot.mousePress(view, Qt.MouseButton.LeftButton, pos=QPoint(x, 60))
        qtbot.mouseRelease(view, Qt.MouseButton.LeftButton)
        places.add(view.let_go.x())
    assert len(places) == 1, "it does not move under the pointer"
    qtbot.mouseClick(view.let_go, Qt.MouseButton.LeftButton)
    assert moved[-1] is None
    assert view.let_go.isHidden()


@pytest.mark.parametrize("value", [3, 1020])
def test_a_constant_reading_is_drawn_with_its_limits(qtbot, value):
    plot = SensorPlot()
    qtbot.addWidget(plot)
    plot.show_readings(np.linspace(0.0, 10.0, 500), np.full(500, value), 0, 1023)
    assert [line.value() for line in plot.lines] == [value, value]
    low, high = plot.getViewBox().viewRange()[1]
    assert low < value < high


def test_each_step_has_its_own_drawing_of_the_kit(qtbot):
    drawing, seen = KitDrawing(supply=True), []
    qtbot.addWidget(drawing)
    for change in (lambda: None, drawing.show_scale, drawing.show_spring, lambda: drawing.show_weight("0"),
                   lambda: drawing.show_weight("50"), lambda: drawing.show_weight("100")):  # fmt: skip
        change()
        assert drawing.renderer().isValid()
        seen.append(bytes(drawing.grab().toImage().constBits()))
    assert len(set(seen)) == len(seen)


def test_only_a_long_run_shows_a_progress_bar_and_the_box_keeps_its_height(qtbot):
    box = ResultBox()
    qtbot.addWidget(box)
    box.show()
    box.show_text("Found.", "Next: hang 50 g on it.", SIGNS["pass"])
    box.resize(400, 60)
    low = box.height()
    for passed, seconds in ((1.0, 0.9 * LONG_SECONDS), (20.0, math.inf), (3.0, 12.0), (0.0, 0.0)):
        box.show_progress(passed, seconds)
        assert box.bar.isVisible() == (seconds == 12.0)
        assert box.height() == low
    assert box.bar.value() == 0.25 * box.bar.maximum()


def test_the_sweeps_limits_are_relative_to_its_start(qtbot):
    plot = PositionPlot()
    qtbot.addWidget(plot)
    plot.show_positions(np.array([0.0, 1.0]), np.array([0.007, 0.008]))
    plot.show_positions(np.array([0.0, 1.0]), np.array([0.008, 0.020]))
    assert (plot.start, plot.values[-1]) == (0.008, 12.0)
    plot.start = None
    plot.show_positions(np.array([0.0, 1.0]), np.array([0.008, 0.020]))
    assert plot.start == 0.020
