"""Axes, ticks, the time window."""

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.live.canvas import labels, ticks, widened
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import canvas_of, telemetry


def test_axes_widen_at_once_and_narrow_only_on_request(plots, history):
    canvas = canvas_of(plots, "position")
    burst = telemetry(50, 14_000)
    burst[25, rows.POSITION] = 0.045
    history.append(burst)
    plots.refresh()
    wide = canvas.view.viewRange()[1]
    assert wide[1] > 45.0
    history.append(telemetry(12_000, 14_050))
    plots.refresh()
    assert canvas.view.viewRange()[1] == wide
    plots.fit()
    assert 15.0 < canvas.view.viewRange()[1][1] < 20.0


@pytest.mark.parametrize(
    ("low", "high"), [(-1.0, 1.0), (-0.3, 7.1), (0.0, 1e-3), (-4321.0, 17.0), (4.9, 5.1)]
)
@pytest.mark.parametrize("most", [2, 3, 5])
def test_ticks_are_few_round_and_inside(low, high, most):
    values = ticks(low, high, most)
    assert 1 <= len(values) <= most
    assert all(low - 1e-9 <= v <= high + 1e-9 for v in values)
    steps = np.diff(values)
    assert np.allclose(steps, steps[:1])
    if len(steps):
        mantissa = steps[0] / 10 ** np.floor(np.log10(steps[0]) + 1e-9)
        assert mantissa == pytest.approx(round(mantissa))
        assert round(mantissa) in (1, 2, 5)


def test_ticks_keep_their_distance_and_are_more_than_one_where_there_is_room():
    assert ticks(-72.0, 61.0, 5, 50 / 15) == [-50.0, 0.0, 50.0]
    assert ticks(-72.0, 61.0, 5, 30 / 15) == [0.0]
    for gaps in (1.0, 1.7, 3.3, 12.0):
        for high in (1.0, 3.7, 42.0):
            assert np.all(np.diff(ticks(-1.0, high, 5, gaps)) >= (high + 1.0) / gaps - 1e-9)


def test_tick_labels_have_a_true_minus_and_enough_decimals():
    assert labels([-0.5, 0.0, 0.5]) == ["−0.5", "0.0", "0.5"]
    assert labels([-100.0, 0.0, 100.0]) == ["−100", "0", "100"]
    assert labels([-20000.0, 0.0, 20000.0]) == ["−20,000", "0", "20,000"]
    assert labels([1234.5, 1235.0]) == ["1,234.5", "1,235.0"]


def test_widening_leaves_a_margin_and_ignores_what_is_no_number():
    assert widened((-1.0, 1.0), -0.5, 0.5) == (-1.0, 1.0)
    low, high = widened((-1.0, 1.0), -0.5, 3.0)
    assert low == -1.0
    assert high > 3.0
    assert widened((-1.0, 1.0), np.nan, np.nan) == (-1.0, 1.0)


def test_the_time_window_goes_from_1_to_60_seconds(plots, qtbot):
    with qtbot.waitSignal(plots.span_changed):
        plots.set_span(30.0)
    assert plots.canvases[0].view.viewRange()[0] == pytest.approx([-30.0, 0.0])
    for seconds in (0.5, 61.0):
        with pytest.raises(ParameterError, match="1 to 60 s"):
            plots.set_span(seconds)


def turn_wheel(canvas, qapp):
    place = QPointF(canvas.frame().center())
    there = QPointF(canvas.mapToGlobal(place.toPoint()))
    event = QWheelEvent(
        place, there, QPoint(), QPoint(0, 240), Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    qapp.sendEvent(canvas.viewport(), event)


def test_the_wheel_zooms_into_time_only_while_paused(plots, qapp):
    canvas = canvas_of(plots, "force")
    values = canvas.view.viewRange()[1]
    turn_wheel(canvas, qapp)
    assert canvas.view.viewRange()[0] == pytest.approx([-10.0, 0.0])
    plots.set_paused(True)
    turn_wheel(canvas, qapp)
    left, right = canvas.view.viewRange()[0]
    assert -10.0 < left < right < 0.0
    assert canvas.view.viewRange()[1] == values
    assert plots.shown.window.x[0] == pytest.approx(plots.shown.zero + left, abs=0.02)


def test_the_view_never_leaves_what_can_be_kept(plots):
    plots.set_paused(True)
    plots.canvases[0].view.setXRange(-200.0, 50.0, padding=0)
    left, right = plots.canvases[0].view.viewRange()[0]
    assert left >= -60.0
    assert right <= 0.0
