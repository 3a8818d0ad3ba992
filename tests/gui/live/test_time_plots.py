"""Time plots: axes and ticks, drawn samples, pause, pointer, headers."""

import numpy as np
import pytest
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QLabel

from hapkit_studio.gui.live.history import LiveHistory
from hapkit_studio.gui.widgets.canvas import ticks
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.signals import COLUMN
from tests.gui.live.plot_support import LIBRARY, RATE, canvas_of, colored, telemetry, turn_wheel


@pytest.mark.parametrize("most", [2, 3, 5])
def test_ticks_are_few_round_and_inside(most):
    for low, high in ((-1.0, 1.0), (-0.3, 7.1), (0.0, 1e-3), (-4321.0, 17.0), (4.9, 5.1)):
        values = ticks(low, high, most)
        assert 1 <= len(values) <= most
        assert all(low - 1e-9 <= v <= high + 1e-9 for v in values)
        steps = np.diff(values)
        assert np.allclose(steps, steps[:1])
        mantissa = steps[:1] / 10 ** np.floor(np.log10(steps[:1]) + 1e-9)
        assert np.isclose(mantissa[:, None], [1, 2, 5]).any(axis=1).all()


def test_ticks_keep_their_distance_with_at_least_two():
    assert ticks(-72.0, 61.0, 5, 50 / 15) == [-50.0, 0.0, 50.0]
    assert ticks(-72.0, 61.0, 5, 30 / 15) == [0.0]
    for gaps in (1.0, 1.7, 3.3, 12.0):
        assert np.all(np.diff(ticks(-1.0, 3.7, 5, gaps)) >= 4.7 / gaps - 1e-9)


def test_while_paused_the_view_zooms_and_pans_in_the_history(plots, history):
    word = plots.headers[0].back
    assert not word.isVisible()
    plots.view.set_paused(True)
    # the word is above the plots, so it covers no data
    assert (word.text(), word.isVisible()) == ("Plots paused", True)
    turn_wheel(canvas_of(plots, "force"))
    left, right = plots.canvases[0].view.viewRange()[0]
    assert -10.0 < left < right < 0.0
    assert plots.shown.window.x[0] == pytest.approx(plots.shown.zero + left, abs=0.02)
    for asked, shown in (((-50.0, 10.0), (-60.0, 0.0)), ((-8.0, -7.0), (-8.0, -7.0))):
        plots.canvases[1].view.setXRange(*asked, padding=0)
        for canvas in plots.canvases:
            assert canvas.view.viewRange()[0] == pytest.approx(shown)
    assert plots.shown.window.x[0] == pytest.approx(history.now - 8.0, abs=0.01)
    plots.view.set_paused(False)
    assert not word.isVisible()
    assert plots.canvases[0].view.viewRange()[0] == pytest.approx([-1.0, 0.0])
    plots.view.set_span(30.0)
    assert plots.canvases[0].view.viewRange()[0] == pytest.approx([-30.0, 0.0])


def ranges_of(plots):
    return [canvas_of(plots, key).view.viewRange()[1] for key in ("position", "velocity", "force")]


def rest(count, start, **peaks):
    """Return rows of a handle at rest; only the middle sample of each channel in ``peaks`` is not zero."""
    quiet = telemetry(count, start)
    quiet[:, rows.POSITION : rows.APPLIED_FORCE + 1] = 0.0
    for name, peak in peaks.items():
        quiet[count // 2, COLUMN[name]] = peak
    return quiet


def show(plots, history, table):
    history.append(table)
    plots.refresh()
    return ranges_of(plots)


OPENED = [[-12.0, 12.0], [-120.0, 120.0], [-1.2, 1.2]]


def test_axes_widen_at_once_and_narrow_after_a_peak_has_left_the_window(plots, history):
    assert show(plots, history, rest(12_000, 14_000)) == OPENED
    wide = show(plots, history, rest(50, 26_000, position=0.045, velocity=-0.9, applied_force=2.9))
    assert (wide[0][1], -wide[1][0], wide[2][1]) > (45.0, 900.0, 2.9)
    assert show(plots, history, rest(9900, 26_050)) == wide
    assert show(plots, history, rest(200, 35_950)) == OPENED
    wide = show(plots, history, rest(50, 36_150, position=0.018))
    assert 24.0 < np.ptp(wide[0]) < 1.5 * 24.0
    assert show(plots, history, rest(12_000, 36_200)) == wide


def test_fitted_axes_return_after_a_peak_and_another_scene_has_its_own(plots, history):
    show(plots, history, rest(12_000, 14_000))
    plots.fit()
    fitted = ranges_of(plots)
    assert np.ptp(fitted[0]) < 24.0 / 2
    assert show(plots, history, rest(50, 26_000, position=0.045))[0][1] > 45.0
    assert show(plots, history, rest(12_000, 26_050)) == fitted
    plots.set_environment(LIBRARY["spring"], LIBRARY["spring"].values(), 3.0)
    show(plots, history, rest(50, 38_050, position=0.045))
    assert show(plots, history, rest(12_000, 38_100))[0] == OPENED[0]


@pytest.mark.parametrize(("asked", "arrow"), [(-6.1, False), (-25.0, True), (25.0, True)])
def test_an_asked_force_far_beyond_the_limit_is_cut_off_with_an_arrow(plots, history, asked, arrow):
    """The force axis extends to twice the limit of 3 N, plus a margin."""
    quiet = rest(12_000, 14_000)
    quiet[6000:6200, rows.FORCE], quiet[6000:6200, rows.APPLIED_FORCE] = asked, np.sign(asked) * 3.0
    low, high = show(plots, history, quiet)[2]
    assert min(abs(asked), 6.0) < max(-low, high) < 7.5
    canvas = canvas_of(plots, "force")
    box, image = canvas.measure(), canvas.grab().toImage()
    edge = box.top() + 1 if asked > 0.0 else box.bottom() - 2
    heads = [p for p in colored(image, "asked") if abs(p[1] - edge) <= 2]
    assert bool(heads) == arrow
    if arrow:
        place = canvas.pixel(20.0 - plots.shown.zero, 0.0).x()
        assert np.mean([p[0] for p in heads]) == pytest.approx(place, abs=4)


def test_paused_axes_do_not_change_until_the_view_is_live(plots, history):
    wide = ranges_of(plots)
    assert wide[0][1] > 15.0
    plots.view.set_paused(True)
    history.end_environment()
    plots.set_environment(LIBRARY["spring"], LIBRARY["spring"].values(), 3.0)
    assert show(plots, history, rest(11_000, 14_000)) == wide
    plots.view.set_paused(False)
    plots.refresh()
    assert ranges_of(plots) == OPENED


def drawn(plots, key):
    """Return a plot's canvas, and time (n,) in s and row (n,) of its coloured pixels within the frame."""
    canvas = canvas_of(plots, key)
    found = colored(canvas.viewport().grab().toImage(), key)
    inside = canvas.measure().adjusted(4, 4, -12, -4)
    found = found[[inside.contains(*map(float, place)) for place in found]]
    return canvas, canvas.to_x(found[:, 0] + 0.5) + plots.shown.zero, found[:, 1] + 0.5


def test_the_line_is_drawn_at_its_samples(plots, history):
    canvas, time, row = drawn(plots, "position")
    assert plots.shown.zero == pytest.approx(history.now, abs=0.05)
    assert len(np.unique(time)) > 0.5 * canvas.measure().width()
    _, down = canvas.to_pixels(time * 0.0, 15.0 * np.sin(3.0 * time))
    slope = 45.0 * np.abs(np.cos(3.0 * time)) * canvas._map[1] ** -1 * -canvas._map[3]
    assert (np.abs(down - row) <= 2.0 + slope).all()


def test_lost_frames_leave_a_gap_in_the_picture(plots, history):
    show(plots, history, telemetry(2000, 15_500))
    _, time, _ = drawn(plots, "velocity")
    assert not ((time > 14.05) & (time < 15.45)).any()
    assert (time < 14.0).any()
    assert (time > 15.5).any()


def test_traces_follow_the_theme_and_are_paler_without_a_device(plots, history):
    frozen = telemetry(12_000, start=20_000)
    frozen[:, rows.POSITION] = 0.001
    history.append(frozen)
    for mode, stale, share in (("light", False, 1.0), ("light", True, 0.45), ("dark", False, 1.0)):
        theme.set_mode(mode)
        plots.set_stale(stale)
        plots.refresh()
        canvas = plots.canvases[0]
        line = canvas.grab().toImage()
        row = int(canvas.pixel(0.0, 1.0).y())
        seen = np.array([line.pixelColor(x, row).getRgb() for x in range(120, 400)])
        assert np.abs(seen - theme.paler("position", "plot", share).getRgb()).max() <= 1


def test_asked_is_drawn_only_where_it_differs_from_applied(plots):
    canvas = canvas_of(plots, "force")
    found = colored(canvas.viewport().grab().toImage(), "asked")
    canvas.measure()
    limit = float(canvas.to_pixels(0.0, -3.0)[1])
    assert len(found) > 20
    assert (found[:, 1] >= limit - 2).all()


def test_contact_is_shaded_where_a_force_was_asked_for(plots, history):
    window, touching = plots.shown.window, np.array(plots.shown.contact) + plots.shown.zero
    inside = ((touching[:, :1] <= window.x) & (window.x <= touching[:, 1:])).any(axis=0)
    assert inside[window.y["force"] != 0.0].all()
    true = np.mean(history.between(plots.shown.zero - 10.0, np.inf).y["force"] < 0.0) * 10.0
    assert np.ptp(touching, axis=1).sum() == pytest.approx(true, abs=0.2)
    history.end_environment()  # the forces of a previous environment are not shown as contact
    plots.refresh()
    assert plots.shown.contact == []


def test_a_surface_is_named_and_shaded_only_if_there_is_one(plots):
    for key in ("button", "wall"):
        plots.set_environment(LIBRARY[key], LIBRARY[key].values(), 3.0)
        parts = [part for header in plots.headers for part in header.surface]
        texts = [part.text() for part in parts if isinstance(part, QLabel)]
        assert texts == [key]
    plots.set_environment(LIBRARY["spring"], LIBRARY["spring"].values(), 3.0)
    plots.refresh()
    assert plots.shown.contact == []
    assert not any(part.isVisible() for header in plots.headers for part in header.surface)


def test_the_paused_picture_and_numbers_show_the_newest_sample(plots, history, qtbot):
    last = telemetry(1, 14_000)
    last[:, rows.APPLIED_FORCE] = 0.75
    history.append(last)
    plots.view.set_paused(True)
    force = next(h for h in plots.headers if h.plot.key == "force")
    assert force.value.text() == "+0.75 N"
    plots.refresh()
    before = plots.shown.window.y["position"].copy()
    more = telemetry(500, 14_001)
    more[:, rows.APPLIED_FORCE] = -1.25
    history.append(more)
    qtbot.wait(120)
    plots.refresh()
    np.testing.assert_array_equal(plots.shown.window.y["position"], before)
    assert force.value.text() == "+0.75 N"
    plots.view.set_paused(False)
    assert force.value.text() == "−1.25 N"
    plots.refresh()
    assert plots.shown.zero == pytest.approx(14.5, abs=0.05)


def test_pointing_reads_all_plots_at_one_time(plots, history, qtbot):
    with qtbot.waitSignal(plots.pointed) as pointed:
        plots.canvases[1].pointed.emit(-2.0)
    plots.refresh()
    assert pointed.args[0] == pytest.approx(plots.shown.zero - 2.0, abs=1e-6)
    np.testing.assert_equal(plots.shown.pointed, history.at(plots.shown.zero - 2.0))
    assert plots.shown.pointed["position"] == pytest.approx(
        0.015 * np.sin(3 * (plots.shown.zero - 2)), abs=1e-4
    )


@pytest.mark.parametrize(
    ("height", "seen"),
    [(285, ["position", "velocity", "force"]), (240, ["position", "force"]), (114, ["force"])],
)
def test_with_little_height_velocity_folds_then_position_and_force_keeps_50_px(plots, qapp, height, seen):
    """In the smallest window with two banners, 114 px are left for the plots."""
    for _ in plots.plots:  # each folded plot reduces the minimum height
        plots.resize(560, height)
        qapp.processEvents()
    assert [c.plot_of.key for c in plots.canvases if c.isVisible()] == seen
    assert [c.plot_of.key for c in plots.canvases if c.first] == seen[:1]
    assert canvas_of(plots, "force").measure().height() >= 50


def words_in(canvas):
    """Return columns and rows (n, 2) of the pixels of a divider's label."""
    found = colored(canvas.viewport().grab().toImage(), "ink2")
    return found[found[:, 0] > canvas.measure().left()]


def label_boxes(canvas, monkeypatch):
    """Return a dict from label texts to rectangles, which is filled when the canvas is drawn."""
    boxes = {}

    def note(_painter, x, y, text, _token):
        metrics = QFontMetricsF(theme.font("label"))
        boxes[text] = metrics.tightBoundingRect(text).translated(x, y)

    monkeypatch.setattr(canvas, "note", note)
    return boxes


def show_divided(plots, side):
    """Show 14 s of a handle at rest, 11 mm to one side of the middle, with a divider after 10 s."""
    history = LiveHistory(seconds=60.0, rate=RATE)
    table = telemetry(14_000)
    table[:, rows.POSITION] = side * 0.011
    history.append(table[:10_000])
    history.divide("Spring")
    history.append(table[10_000:])
    plots.view.set_history(history)
    plots.refresh()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_divider_label_avoids_the_trace(plots, side):
    """The label is at the top, or at the bottom if the trace is at the top."""
    show_divided(plots, side)
    canvas = plots.canvases[0]
    seen = words_in(canvas)[:, 1]
    assert np.sign(seen.mean() - canvas.measure().center().y()) == side
    away = seen - canvas.pixel(0.0, side * 11.0).y()
    assert np.abs(away).min() > 4.0


@pytest.mark.parametrize(("cursor", "side"), [(10.2, -1.0), (12.0, 1.0)])
def test_a_divider_label_avoids_a_cursors_tag(plots, monkeypatch, cursor, side):
    """The label, which begins at 10 s, is at the bottom if the tag at the top would cover it."""
    show_divided(plots, 0.0)
    canvas, rows_of = plots.canvases[0], {}
    monkeypatch.setattr(canvas, "note", lambda _p, _x, y, text, _token: rows_of.update({text: y}))
    plots.cursors.show(True)
    for index in (0, 1):
        plots.cursors.move(index, cursor)
    plots.refresh()
    canvas.grab()
    assert np.sign(canvas.measure().center().y() - rows_of["Spring"]) == side


@pytest.mark.parametrize("wide", [150, 180, 240, 400, 700])
def test_the_value_in_a_header_is_never_cut_off(plots, qapp, wide):
    header = next(header for header in plots.headers if header.plot.key == "force")
    header.show_value(-2.04)
    header.setParent(None)
    header.resize(wide, header.height())
    header.show()
    qapp.processEvents()
    assert header.value.width() >= header.value.sizeHint().width()
    assert all(part.isVisible() == (wide >= 400) for part in header.lines)


def test_a_resized_header_shows_no_hidden_part_on_trial(plots, qapp, monkeypatch):
    """Each change of visibility may resize the header again, without end."""
    header = next(header for header in plots.headers if header.plot.key == "force")
    header.setParent(None)
    header.resize(180, header.height())
    header.show()
    qapp.processEvents()
    shown = []
    for part in header.lines:
        monkeypatch.setattr(part, "showEvent", lambda _event, part=part: shown.append(part), raising=False)
    header.resize(181, header.height())
    qapp.processEvents()
    assert shown == []


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_divider_label_is_inside_the_frame_on_the_projector(plots, monkeypatch, side):
    theme.set_scale(2.0)
    try:
        show_divided(plots, side)
        canvas = plots.canvases[0]
        boxes = label_boxes(canvas, monkeypatch)
        canvas.grab()
        assert canvas.measure().adjusted(2, 2, -2, -2).contains(boxes["Spring"])
    finally:
        theme.set_scale(1.0)


def test_a_divider_crosses_all_plots_and_is_labelled_once(plots, history):
    """The label of an older divider is hidden if a newer one would overlap it."""

    def named():
        return np.unique(words_in(plots.canvases[0])[:, 0])

    assert not len(named())
    history.divide("Spring")
    history.append(telemetry(4000, 14_000))
    plots.refresh()
    line = int(plots.canvases[0].pixel(13.999 - plots.shown.zero, 0.0).x())
    for canvas in plots.canvases:
        rows_of = colored(canvas.viewport().grab().toImage(), "ink3")
        assert np.ptp(rows_of[rows_of[:, 0] == line][:, 1]) > 0.8 * canvas.measure().height()
    assert line < named()[0] < line + 12
    wide = np.ptp(named())
    for newer in ("Damping", "Friction"):
        history.divide(newer)
        history.append(telemetry(100, 18_000 + 100 * (newer == "Friction")))
    plots.refresh()
    last = named()[named() > line + wide + 14]
    assert last[-1] <= plots.canvases[0].measure().right()
    assert np.ptp(last) < 60  # only one label is at the right end


def test_an_older_divider_has_its_label_in_the_other_row(plots):
    """Of two labels that would overlap, one is at the top and one at the bottom; a third is hidden."""
    history = LiveHistory(seconds=60.0, rate=RATE)
    table = telemetry(14_000)
    table[:, rows.POSITION] = 0.0
    history.append(table)
    canvas, named = plots.canvases[0], "Stiffness 250 → 300 N/m"
    plots.view.set_history(history)
    for when, seen in ((9.0, [1.0]), (8.9, [-1.0, 1.0]), (8.8, [-1.0, 1.0])):
        before = len(words_in(canvas))
        history.divide(named, when)
        plots.refresh()
        found = words_in(canvas)
        assert sorted(set(np.sign(canvas.measure().center().y() - found[:, 1]))) == seen
    assert len(found) == before


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_pointer_readout_covers_no_divider_label(plots, monkeypatch, side):
    show_divided(plots, side)
    canvas = plots.canvases[0]
    boxes = label_boxes(canvas, monkeypatch)
    for away in (-0.3, 0.1, 0.4):
        boxes.clear()
        canvas.pointed.emit(9.999 + away - plots.shown.zero)
        canvas.grab()
        label, read_out = boxes.pop("Spring"), *boxes.values()
        assert not label.intersects(read_out)
        assert canvas.measure().contains(read_out)


def test_g_shows_or_hides_the_grid(reset_idle_window):
    window = reset_idle_window
    canvas = window.centre.time.canvases[0]

    def lines():
        return len(colored(canvas.viewport().grab().toImage(), "grid"))

    drawn = lines()
    assert drawn > 0
    window.actions_by_key.run("view.grid")
    assert (lines(), window.actions_by_key.qt["view.grid"].isChecked()) == (0, False)
    window.actions_by_key.run("view.grid")
    assert lines() == drawn


def test_an_older_divider_label_is_hidden_rather_than_cover_the_trace(plots):
    """A newer label is in the same row; in the other row, the older label would cover the trace."""
    history = LiveHistory(seconds=60.0, rate=RATE)
    table = telemetry(14_000)
    table[:, rows.POSITION] = 0.011
    history.append(table)
    canvas, named = plots.canvases[0], "Stiffness 250 → 300 N/m"
    plots.view.set_history(history)
    found = []
    for when in (9.0, 8.9):
        history.divide(named, when)
        plots.refresh()
        found.append(len(words_in(canvas)))
    assert found[0] == found[1] > 0
