"""The view of the history can be zoomed, panned, copied, locked and made live again while data arrive."""

import numpy as np
import pyqtgraph as pg
import pytest
from PySide6.QtCore import QPoint, Qt

from hapkit_studio.gui.live.history import LiveHistory
from hapkit_studio.gui.live.time_view import TimeView
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import RATE, canvas_of, colored, telemetry, turn_wheel

LEFT = Qt.MouseButton.LeftButton
CTRL = Qt.KeyboardModifier.ControlModifier


@pytest.fixture(autouse=True)
def every_mouse_move_counts(monkeypatch):
    """Disable the plots' rate limit for mouse moves, because the tests move the mouse faster than a hand."""
    monkeypatch.setitem(pg.CONFIG_OPTIONS, "mouseRateLimit", 0)


def ends(plots):
    """Return the ranges of all time axes."""
    shown = [canvas.view.viewRange()[0] for canvas in plots.canvases]
    assert all(each == pytest.approx(shown[0], abs=1e-9) for each in shown)
    return shown[0]


def drag(qtbot, canvas, far):
    """Drag a plot to the right by a distance in px."""
    view, start = canvas.viewport(), canvas.measure().center().toPoint()
    qtbot.mousePress(view, LEFT, pos=start)
    for part in np.linspace(0.0, 1.0, 12):
        qtbot.mouseMove(view, start + QPoint(round(part * far), 0))
    qtbot.mouseRelease(view, LEFT, pos=start + QPoint(far, 0))


def test_the_wheel_zooms_at_the_pointer_and_new_data_do_not_move_the_picture(plots, history):
    canvas = canvas_of(plots, "force")
    place, values = canvas.measure(), canvas.view.viewRange()[1]
    column = round(place.left() + 0.4 * place.width())
    before = plots.shown.zero + canvas.to_x(column)
    assert turn_wheel(canvas, 0.4).x() == column
    left, right = ends(plots)
    assert -10.0 < left < right < -1.0
    width = 10.0 / place.width()
    assert plots.shown.zero + canvas.to_x(column) == pytest.approx(before, abs=width)
    assert canvas.view.viewRange()[1] == values
    standing = plots.shown.window.y["position"].copy()
    history.append(telemetry(3000, 14_000))
    plots.refresh()
    np.testing.assert_array_equal(plots.shown.window.y["position"], standing)
    assert plots.view.status == f"{-right + 3.0:.0f} s ago"  # 3 s of new data have arrived


def test_a_view_zoomed_at_the_right_end_keeps_following(plots, history):
    for across, follows in ((0.97, True), (0.7, False)):
        plots.view.follow(10.0)
        turn_wheel(plots.canvases[0], across)
        assert plots.view.follows == follows
        assert plots.view.span < 8.0
    plots.view.follow()
    history.append(telemetry(500, 14_000))
    plots.refresh()
    assert plots.shown.zero == pytest.approx(14.499, abs=0.02)


def test_a_view_dragged_back_shows_its_distance_and_follows_again_at_the_end(plots, history, qtbot):
    canvas = plots.canvases[1]
    per_px = 10.0 / canvas.measure().width()
    drag(qtbot, canvas, 150)
    left, right = ends(plots)
    assert right - left == pytest.approx(10.0)
    assert right == pytest.approx(-150 * per_px, abs=12 * per_px)  # dragging starts after a few px
    header = plots.headers[0]
    assert header.back.isVisible()
    history.append(telemetry(2000, 14_000))
    assert plots.view.status == f"{2.0 - right:.0f} s ago"
    drag(qtbot, canvas, -100)  # the end has moved by 2 s, so this drag does not reach the end
    assert not plots.view.follows
    drag(qtbot, canvas, -250)
    assert plots.view.follows
    assert ends(plots) == [-10.0, 0.0]
    assert not header.back.isVisible()
    drag(qtbot, canvas, 150)
    with qtbot.waitSignal(plots.back_pressed):
        qtbot.mouseClick(header.back, LEFT)


def test_a_plot_without_data_does_not_change(plots, qtbot):
    plots.view.set_history(LiveHistory(seconds=60.0, rate=RATE))
    drag(qtbot, plots.canvases[1], 150)
    turn_wheel(plots.canvases[1])
    assert plots.view.follows


def followed_by(view, start, stop):
    """Feed rows from start to stop in s, and call keep_samples() every 0.5 s, as the window does."""
    for first in np.arange(start, stop - 1e-9, 0.5):
        view.live.append(telemetry(500, round(first * RATE)))
        view.keep_samples()


@pytest.mark.parametrize("left", [-8.0, -6.0])
def test_a_fixed_view_keeps_its_samples_for_any_time(left):
    """A history keeps 10 s of samples; a fixed view is copied just before its samples are dropped."""
    view = TimeView()
    view.set_history(LiveHistory(seconds=10.0, rate=RATE))
    followed_by(view, 0.0, 20.0)
    view.move(left, -2.0)
    whole = view.history.between(*view.stretch).y["position"].copy()
    assert len(whole) == pytest.approx((-2.0 - left) * RATE, abs=1)
    followed_by(view, 20.0, 28.0 + left + 0.9)
    assert view.history is view.live
    followed_by(view, 28.0 + left + 1.0, 50.0)
    np.testing.assert_array_equal(view.history.between(*view.stretch).y["position"], whole)
    view.follow()
    assert view.history is view.live


def test_a_view_without_samples_follows_again():
    view = TimeView()
    view.set_history(LiveHistory(seconds=10.0, rate=RATE))
    followed_by(view, 0.0, 8.0)
    view.move(-11.0, -1.0)
    view.live.clear()
    view.keep_samples()
    assert view.follows


def test_zooming_out_at_an_event_keeps_its_place_in_the_frame():
    view = TimeView()
    view.set_history(LiveHistory(seconds=60.0, rate=RATE))
    followed_by(view, 0.0, 12.0)
    view.stand(9.0, 0.2, "Contact")
    assert (view.left, view.right) == (-2.0, 8.0)
    view.set_span(5.0)
    assert (view.left, view.right) == (-1.0, 4.0)
    assert view.stretch == pytest.approx((8.0, 12.0), abs=2e-3)
    view.follow()
    view.set_span(2.0)
    assert (view.left, view.right) == (-2.0, 0.0)


def far(start, force=2.5):
    """Return rows of a handle at 45 mm, where it has a large force."""
    table = telemetry(2000, start)
    table[:, rows.POSITION], table[:, rows.APPLIED_FORCE] = 0.045, force
    return table


def test_locked_axes_do_not_change_and_arrows_mark_values_outside(plots, history, qtbot):
    canvas = canvas_of(plots, "position")
    plots.view.set_locked(True)
    kept = canvas.view.viewRange()[1]
    assert plots.headers[0].unlock.isVisible()
    history.append(far(14_000))
    plots.refresh()
    assert canvas.view.viewRange()[1] == kept
    top = canvas.measure().top() + 1
    heads = [place for place in colored(canvas.grab().toImage(), "position") if abs(place[1] - top) <= 2]
    assert np.mean([place[0] for place in heads]) == pytest.approx(canvas.pixel(-2.0, 0.0).x(), abs=4)
    plots.fit()  # fitting by hand changes locked axes, too
    assert canvas.view.viewRange()[1][1] > 45.0
    qtbot.mouseClick(plots.headers[0].unlock, LEFT)
    assert not plots.view.locked


def test_the_lock_of_the_force_plot_ends_with_another_quantity(phase, history):
    phase.view.set_locked(True)
    before = phase.canvas.view.viewRange()
    history.append(far(14_000, 2.9))
    phase.canvas.refresh()
    assert phase.canvas.view.viewRange() == before
    phase.choose(1)
    assert phase.canvas.view.viewRange() != before  # the axis is in mm/s instead of mm, so the lock has ended
    phase.choose(0)
    phase.view.set_locked(False)
    phase.canvas.refresh()
    assert phase.canvas.view.viewRange()[0][1] > 45.0


def test_force_over_position_shows_the_same_stretch_as_the_time_plots(phase, history):
    """The handle moves until 14 s and then rests at 10 mm; a view moved back by 11 s shows the motion."""
    table = telemetry(12_000, 14_000)
    table[:, rows.POSITION], table[:, rows.APPLIED_FORCE] = 0.01, -2.0
    history.append(table)
    count = {}
    for back in (0.0, 12.0):
        phase.view.move(-10.0 - back, -back)
        phase.canvas.refresh()
        count[back] = len(np.unique(colored(phase.canvas.viewport().grab().toImage(), "applied")[:, 0]))
    assert count[0.0] < 16 < 100 < count[12.0]


@pytest.mark.parametrize(("across", "key"), [(0.5, CTRL), (-0.05, Qt.KeyboardModifier.NoModifier)])
def test_the_wheel_over_the_value_axis_or_with_ctrl_zooms_values_and_locks_them(plots, across, key):
    canvas = canvas_of(plots, "position")
    low, high = canvas.view.viewRange()[1]
    place = turn_wheel(canvas, across, 240, key)
    box = canvas.measure()
    zoomed = canvas.view.viewRange()[1]
    # each of the 30 small turns of the wheel zooms by a factor of 1.02
    assert np.ptp(zoomed) == pytest.approx((high - low) / 1.02**30, rel=0.02)
    part = (box.bottom() - place.y()) / box.height()
    assert zoomed[0] + part * np.ptp(zoomed) == pytest.approx(low + part * (high - low), abs=1e-6)
    assert ends(plots) == [-10.0, 0.0]
    plots.refresh()
    assert canvas.view.viewRange()[1] == zoomed
    assert plots.view.locked


def test_a_history_of_hours_can_be_panned():
    """Only a replay has hours of history; a live history is never longer than the longest time window."""
    view, history = TimeView(), LiveHistory(seconds=500.0, rate=10.0)
    table = np.zeros((3000, rows.ROW_WIDTH))
    table[:, rows.TICK], table[:, rows.HOST_TIME] = np.arange(3000), 0.1 * np.arange(3000)
    history.append(table)
    view.set_history(history)
    view.move(-210.0, -200.0)
    assert (view.left, view.right) == (-210.0, -200.0)
