"""Pause, pointer, headers, colours."""

import numpy as np
import pytest
from PySide6.QtGui import QImage, QPainter
from PySide6.QtWidgets import QLabel

from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import canvas_of, colored, telemetry


def test_paused_freezes_the_picture_while_live_values_go_on(plots, history, qtbot):
    plots.set_paused(True)
    plots.refresh()
    before = plots.shown.window.y["position"].copy()
    more = telemetry(500, 14_000)
    more[:, rows.APPLIED] = -1.25
    history.append(more)
    qtbot.wait(120)
    plots.refresh()
    np.testing.assert_array_equal(plots.shown.window.y["position"], before)
    force = next(h for h in plots.headers if h.plot.key == "force")
    assert force.value.text() == "−1.25 N"
    plots.set_paused(False)
    plots.refresh()
    assert plots.shown.zero == pytest.approx(14.5, abs=0.05)


def test_while_paused_the_view_moves_through_history_in_all_plots(plots, history):
    plots.set_paused(True)
    plots.canvases[1].view.setXRange(-8.0, -7.0, padding=0)
    for canvas in plots.canvases:
        assert canvas.view.viewRange()[0] == pytest.approx([-8.0, -7.0])
    x = plots.shown.window.x
    assert x[0] == pytest.approx(history.now - 8.0, abs=0.01)
    plots.set_paused(False)
    assert plots.canvases[0].view.viewRange()[0] == pytest.approx([-10.0, 0.0])


def test_pointing_reads_all_plots_at_one_time(plots, history, qtbot):
    with qtbot.waitSignal(plots.pointed) as pointed:
        plots.canvases[1].pointed.emit(-2.0)
    plots.refresh()
    assert pointed.args[0] == pytest.approx(plots.shown.zero - 2.0, abs=1e-6)
    assert plots.shown.pointed == history.at(plots.shown.zero - 2.0)
    assert plots.shown.pointed["position"] == pytest.approx(
        0.015 * np.sin(3 * (plots.shown.zero - 2)), abs=1e-4
    )


def test_headers_name_their_lines_and_say_where_the_force_comes_from(plots):
    force = next(h for h in plots.headers if h.plot.key == "force")
    texts = [label.text() for label in force.findChildren(QLabel)]
    assert texts[:4] == ["Force", "applied", "asked", "limit"]
    tips = {label.text(): label.toolTip() for label in force.findChildren(QLabel)}
    assert tips["applied"] == "commanded after the clamp; the Hapkit has no force sensor"


@pytest.mark.parametrize("width", [380, 560])
def test_headers_have_room_for_all_they_say(plots, width, qapp):
    plots.resize(width, 420)
    qapp.processEvents()
    for header in plots.headers:
        for label in header.findChildren(QLabel):
            if label.isVisible():
                assert label.width() >= label.sizeHint().width()


def test_with_little_height_velocity_folds_to_its_header(plots, qapp):
    plots.resize(560, 240)
    qapp.processEvents()
    assert not canvas_of(plots, "velocity").isVisible()
    assert canvas_of(plots, "force").isVisible()
    assert canvas_of(plots, "force").height() > 80


def test_heights_are_shared_as_designed(plots, qapp):
    heights = [canvas.frame().height() for canvas in plots.canvases]
    shares = np.array(heights) / sum(heights)
    assert shares == pytest.approx([0.30, 0.27, 0.43], abs=0.02)


def test_tick_labels_stand_at_their_values_after_any_change_of_height(plots, qapp):
    for height in (400, 500, 430):
        plots.resize(560, height)
        qapp.processEvents()
        shown = plots.grab().toImage()
        for canvas in plots.canvases:
            canvas.left.setCacheMode(canvas.left.CacheMode.NoCache)
            canvas.left.picture = None
        assert shown == plots.grab().toImage()
        for canvas in plots.canvases:
            canvas.left.setCacheMode(canvas.left.CacheMode.DeviceCoordinateCache)


@pytest.mark.parametrize("edge", [-10.0, 10.0])
def test_a_tick_label_at_the_edge_is_whole(plots, edge, qapp):
    canvas = plots.canvases[0]
    canvas.show_range(min(edge, 0.0), max(edge, 0.0))
    qapp.processEvents()
    picture = QImage(canvas.size(), QImage.Format.Format_ARGB32)
    painter = QPainter(picture)
    boxes = [canvas.left.mapRectToScene(box) for box, *_ in canvas.left.generateDrawSpecs(painter)[2]]
    painter.end()
    assert len(boxes) > 1
    assert all(box.top() >= 0 and box.bottom() <= canvas.viewport().height() for box in boxes)


def test_colours_follow_the_theme(plots):
    canvas = canvas_of(plots, "velocity")
    assert len(colored(canvas.viewport().grab().toImage(), "velocity")) > 50
    theme.set_mode("dark")
    image = canvas.viewport().grab().toImage()
    assert len(colored(image, "velocity")) > 50
    assert len(colored(image, "plot")) > 1000
