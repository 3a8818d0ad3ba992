"""What is drawn is what the history holds."""

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication, QLabel

from hapkit_studio.gui.live.canvas import Canvas
from hapkit_studio.gui.live.history import CHANNELS, History, RollingWindow
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import LIBRARY, canvas_of, colored, settle, telemetry


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


def test_a_plot_makes_no_widgets_but_its_view(qtbot):
    """Menus that nobody opens cost more than the plot, and again with every change of the theme."""
    before = set(QApplication.allWidgets())
    canvas = Canvas(bottom=True)
    qtbot.addWidget(canvas)
    assert len(set(QApplication.allWidgets()) - before) < 10


def _trimmed(values):
    """Return values without a break at the left edge, where there is nothing to part from."""
    return values[int(np.isnan(values[0])) :]


@pytest.mark.parametrize("rate", [1000.0, 4000.0])
def test_rolling_columns_equal_columns_computed_anew(rate):
    history, rolling, columns, span = History(seconds=20.0, rate=rate), RollingWindow(), 300, 6.0
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
        rolled = rolling.window(history, first, columns, width)
        anew = RollingWindow().window(history, first, columns, width)
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


def test_a_surface_is_called_what_it_is(plots):
    for key in ("button", "wall"):
        plots.set_environment(LIBRARY[key], LIBRARY[key].values(), 3.0)
        parts = [part for header in plots.headers for part in header.surface]
        said = [part.text() for part in parts if isinstance(part, QLabel)]
        assert said == [key]
