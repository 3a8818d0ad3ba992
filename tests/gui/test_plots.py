"""Plots: what is drawn is what the history holds; axes, pause, pointer, theory, colours."""

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QWheelEvent
from PySide6.QtWidgets import QLabel

from hapkit_studio.environments import discover
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.history import CHANNELS, History
from hapkit_studio.gui.plots import ForcePosition, TimePlots, strokes
from hapkit_studio.gui.plots.declared import phase_plots, time_plots
from hapkit_studio.gui.plots.ticks import labels, ticks, widened
from hapkit_studio.gui.reel import Reel
from hapkit_studio.gui.theme import theme
from hapkit_studio.haptics import rows

RATE = 1000.0
LIBRARY = discover()


def telemetry(count, start=0, rate=RATE):
    """Return rows of a handle that swings in and out of a wall at 5 mm, the force clamped at 3 N."""
    tick = start + np.arange(count)
    table = np.zeros((count, rows.ROW_WIDTH))
    table[:, rows.TICK], table[:, rows.HOST_TIME] = tick, tick / rate
    table[:, rows.POSITION] = 0.015 * np.sin(3.0 * tick / rate)
    table[:, rows.VELOCITY] = 0.045 * np.cos(3.0 * tick / rate)
    table[:, rows.ASKED] = -400.0 * np.maximum(table[:, rows.POSITION] - 0.005, 0.0)
    table[:, rows.APPLIED] = np.maximum(table[:, rows.ASKED], -3.0)
    return table


@pytest.fixture
def history():
    history = History(seconds=60.0, rate=RATE)
    history.append(telemetry(14_000))
    return history


@pytest.fixture
def plots(qtbot, qapp, history):
    plots = TimePlots()
    qtbot.addWidget(plots)
    plots.resize(560, 500)
    plots.set_history(history)
    plots.set_environment(LIBRARY["wall"], LIBRARY["wall"].values(), 3.0)
    plots.show()
    plots.refresh()
    return plots


@pytest.fixture
def phase(qtbot, qapp, history):
    phase = ForcePosition()
    qtbot.addWidget(phase)
    phase.resize(348, 420)
    phase.show()
    phase.set_history(history)
    phase.set_environment(LIBRARY["wall"], LIBRARY["wall"].values({"stiffness": 400.0}), 3.0)
    phase.refresh()
    return phase


def settle(phase):
    """Let the older seconds be painted, one a frame."""
    for _ in range(12):
        phase.canvas.refresh()


def canvas_of(plots, key):
    return next(c for c in plots.canvases if c.plot_of.key == key)


def colored(image: QImage, token: str) -> np.ndarray:
    """Return (n, 2) columns and rows of the pixels that have exactly a token's colour."""
    image = image.convertToFormat(QImage.Format.Format_RGB32)
    raw = np.frombuffer(image.constBits(), np.uint32).reshape(image.height(), -1)[:, : image.width()]
    wanted = np.uint32(QColor(getattr(theme.c, token)).rgb())
    down, across = np.nonzero(raw == wanted)
    return np.column_stack([across, down])


# data to pixels -------------------------------------------------------------------------------------


def test_the_window_shows_every_extreme_of_the_history(plots, history):
    window, zero = plots.shown.window, plots.shown.zero
    assert zero == pytest.approx(history.now, abs=0.05)
    kept = history.between(zero - 10.0, np.inf)
    for name in CHANNELS:
        assert np.nanmax(window.y[name]) == kept.y[name].max()
        assert np.nanmin(window.y[name]) == kept.y[name].min()
    assert plots.shown.now["position"] == history.last("position")


def test_the_drawn_line_lies_where_the_samples_say(plots, history):
    canvas = canvas_of(plots, "position")
    found = colored(canvas.viewport().grab().toImage(), "position")
    canvas.measure()
    inside = canvas.frame().adjusted(4, 4, -12, -4)
    found = found[[inside.contains(*map(float, p)) for p in found]]
    assert len(np.unique(found[:, 0])) > 0.5 * inside.width()
    time = canvas.to_x(found[:, 0] + 0.5) + plots.shown.zero
    expected = 15.0 * np.sin(3.0 * time)
    _, down = canvas.to_pixels(time * 0.0, expected)
    slope = 45.0 * np.abs(np.cos(3.0 * time)) * canvas._map[1] ** -1 * -canvas._map[3]
    assert (np.abs(down - found[:, 1] - 0.5) <= 2.0 + slope).all()


def _trimmed(values):
    """Return values without a break at the left edge, where there is nothing to part from."""
    return values[int(np.isnan(values[0])) :]


@pytest.mark.parametrize("rate", [1000.0, 4000.0])
def test_rolling_columns_equal_columns_computed_anew(rate):
    history, reel, columns, span = History(seconds=20.0, rate=rate), Reel(), 300, 6.0
    history.append(telemetry(int(3 * rate), rate=rate))
    width, start = span / columns, int(3 * rate)
    random = np.random.default_rng(3)
    for _ in range(60):
        count = int(random.integers(1, int(rate / 4)))
        table = telemetry(count, start, rate)
        table[:, rows.VELOCITY] = random.normal(size=count)
        if random.random() < 0.2:
            table[0, rows.FLAGS] = rows.GAP
        history.append(table)
        start += count
        first = int(np.ceil(history.now / width)) - columns
        rolled = reel.window(history, first, columns, width)
        anew = Reel().window(history, first, columns, width)
        assert rolled.dense == anew.dense
        rolled_x, anew_x = _trimmed(rolled.x), _trimmed(anew.x)
        np.testing.assert_array_equal(rolled_x, anew_x)
        for name in CHANNELS:
            np.testing.assert_array_equal(_trimmed(rolled.y[name]), _trimmed(anew.y[name]))


def test_another_run_leaves_nothing_of_the_one_before(plots, phase, history):
    plots.set_history(history)
    phase.set_history(history)
    plots.refresh()
    settle(phase)
    history.clear()
    fresh = telemetry(20_000)
    fresh[:, rows.POSITION : rows.APPLIED + 1] = 0.0
    history.append(fresh)
    plots.refresh()
    settle(phase)
    assert not plots.shown.window.y["position"].any()
    found = colored(phase.canvas.viewport().grab().toImage(), "applied")
    zero = float(phase.canvas.pixel(0.0, 0.0).y())
    assert len(found)
    assert (np.abs(found[:, 1] - zero) < 8).all()


def test_lost_frames_leave_a_gap_in_the_picture(plots, history):
    late = telemetry(2000, 15_500)
    history.append(late)
    plots.refresh()
    canvas = canvas_of(plots, "velocity")
    found = colored(canvas.viewport().grab().toImage(), "velocity")
    canvas.measure()
    time = canvas.to_x(found[:, 0].astype(float)) + plots.shown.zero
    inside = (time > 14.05) & (time < 15.45)
    assert not inside.any()
    assert (time < 14.0).any()
    assert (time > 15.5).any()


def test_traces_are_paler_all_along_while_the_device_is_gone(plots, history):
    frozen = telemetry(12_000, start=20_000)
    frozen[:, rows.POSITION] = 0.001
    history.append(frozen)
    for stale, share in ((False, 1.0), (True, 0.45)):
        plots.set_stale(stale)
        plots.refresh()
        canvas = plots.canvases[0]
        line = canvas.grab().toImage()
        row = round(canvas.pixel(0.0, 1.0).y())
        seen = {line.pixelColor(x, row).name() for x in range(120, 400)}
        assert seen == {theme.paler("position", "plot", share).name()}


def test_asked_is_drawn_only_where_it_is_not_what_was_applied(plots):
    canvas = canvas_of(plots, "force")
    found = colored(canvas.viewport().grab().toImage(), "asked")
    canvas.measure()
    limit = float(canvas.to_pixels(0.0, -3.0)[1])
    assert len(found) > 20
    assert (found[:, 1] >= limit - 2).all()


def test_contact_is_shaded_where_a_force_was_asked_for(plots, history):
    window, zero = plots.shown.window, plots.shown.zero
    touching = [(a, b) for a, b in plots.shown.contact]
    for time, force in zip(window.x - zero, window.y["asked"], strict=True):
        shaded = any(a <= time <= b for a, b in touching)
        assert shaded or force == 0.0
    shaded_time = sum(b - a for a, b in touching)
    true = np.mean(history.between(zero - 10.0, np.inf).y["asked"] < 0.0) * 10.0
    assert shaded_time == pytest.approx(true, abs=0.2)


def test_only_an_environment_with_a_surface_is_shaded(plots):
    plots.set_environment(LIBRARY["spring"], LIBRARY["spring"].values(), 3.0)
    plots.refresh()
    assert plots.shown.contact == []
    assert plots.shown.surface is None
    assert not any(part.isVisible() for header in plots.headers for part in header.surface)


# axes -----------------------------------------------------------------------------------------------


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


# pause, pointer, header -----------------------------------------------------------------------------


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


# force over position --------------------------------------------------------------------------------


def test_theory_is_the_laws_own_force(phase):
    grid = phase.canvas.theory_grid(phase.plots[0])
    x, force = phase.canvas._theory
    np.testing.assert_allclose(x, 1e3 * grid)
    np.testing.assert_allclose(force, -400.0 * np.maximum(grid - 0.005, 0.0), atol=1e-12)


def test_the_wall_is_shown_over_position_and_damping_over_velocity(phase):
    assert phase.switch.index == 0
    phase.set_environment(LIBRARY["damping"], LIBRARY["damping"].values({"damping": 6.0}), 3.0)
    assert phase.plots[phase.switch.index].key == "force_velocity"
    velocity, force = phase.canvas._theory
    np.testing.assert_allclose(force, -6.0 * velocity / 1e3, atol=1e-12)
    phase.choose(0)
    assert phase.canvas._theory is None


def test_a_changed_parameter_moves_the_theory_soon(phase, qtbot):
    phase.set_environment(LIBRARY["wall"], LIBRARY["wall"].values({"stiffness": 100.0}), 3.0)
    qtbot.waitUntil(lambda: phase.canvas._theory[1].min() == pytest.approx(-100.0 * 0.055))


def test_a_changed_theory_is_in_sight_unless_the_axes_were_fitted_by_hand(phase, qtbot):
    view = phase.canvas.view
    left = LIBRARY["wall"].values({"side": 1.0})
    assert view.viewRange()[1][1] < 3.0
    phase.set_environment(LIBRARY["wall"], left, 3.0)
    qtbot.waitUntil(lambda: view.viewRange()[1][1] > 3.0)
    phase.fit()
    fitted = view.viewRange()
    phase.set_environment(LIBRARY["wall"], left | {"stiffness": 2000.0}, 3.0)
    qtbot.waitUntil(lambda: phase.canvas._theory[1].max() > 80.0)
    assert view.viewRange() == fitted


def test_the_measured_force_lies_where_the_samples_say(phase, qapp):
    settle(phase)
    image = phase.canvas.viewport().grab().toImage()
    found = colored(image, "applied")
    phase.canvas.measure()
    left, across, bottom, up = phase.canvas._map
    x = (found[:, 0] + 0.5 - left) / across
    force = (found[:, 1] + 0.5 - bottom) / up
    expected = np.maximum(-0.4 * np.maximum(x - 5.0, 0.0), -3.0)
    near_dot = np.hypot(
        x * across - phase.canvas._history.last("position") * 1e3 * across,
        (force - phase.canvas._history.last("applied")) * up,
    )
    off = np.abs(force - expected)[near_dot > 7] * abs(up)
    assert len(off) > 50
    assert off.max() <= 3.5 + 0.4 * abs(up) / across


def test_older_parts_are_paler_and_the_oldest_are_gone(phase, history):
    still = telemetry(12_000, 14_000)
    still[:, rows.POSITION], still[:, rows.APPLIED] = -0.01, 0.0
    history.append(still[:3000])
    phase.fit()
    limit_row = float(phase.canvas.to_pixels(0.0, -1.5)[1])

    def darkest():
        settle(phase)
        image = phase.canvas.viewport().grab().toImage()
        band = [image.pixelColor(x, int(limit_row)).green() for x in range(60, image.width() - 20)]
        return min(band)

    recent = darkest()
    history.append(still[3000:7000])
    phase.fit()
    older = darkest()
    history.append(still[7000:])
    phase.canvas.refresh()
    gone = darkest()
    assert recent < older < gone


def test_paused_keeps_the_picture(phase, history):
    phase.set_paused(True)
    more = telemetry(500, 14_000)
    more[:, rows.APPLIED] = 2.9
    history.append(more)
    phase.canvas.refresh()
    assert phase.canvas.view.viewRange()[1][1] < 2.0
    phase.set_paused(False)
    phase.canvas.refresh()
    assert phase.canvas.view.viewRange()[1][1] > 2.9


# strokes and discovery ------------------------------------------------------------------------------


def test_dashes_cover_their_share_of_a_line_and_leave_gaps_alone():
    x = np.concatenate([np.linspace(0, 85, 30), [np.nan], np.linspace(100, 134, 12)])
    ends = strokes.dashed(x, np.where(np.isnan(x), np.nan, 10.0))
    lengths = ends[:, 2] - ends[:, 0]
    assert lengths == pytest.approx(np.full(14, 5.0))
    assert not ((ends[:, 0] < 86) & (ends[:, 2] > 99)).any()


def test_segments_are_painted(qapp):
    image = QImage(40, 20, QImage.Format.Format_RGB32)
    image.fill(QColor("white"))
    painter = QPainter(image)
    x = np.array([5.0, 20.0, np.nan, 25.0, 35.0])
    strokes.trace(painter, x, x * 0.0 + 10.0, QColor("black"))
    painter.end()
    dark = [x for x in range(40) if image.pixelColor(x, 10).lightness() < 128]
    assert dark == [*range(4, 21), *range(24, 36)]


def test_plots_are_found_by_their_files():
    assert [plot.key for plot in time_plots()] == ["position", "velocity", "force"]
    assert [plot.key for plot in phase_plots()] == ["force_position", "force_velocity"]
    for plot in time_plots():
        assert all(trace.channel in CHANNELS for trace in plot.traces)


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
