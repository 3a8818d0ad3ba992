"""The other way's trace under the one of now: which stretch it is, and where it is named."""

import numpy as np
import pytest
from PySide6.QtCore import QRectF, QSizeF

from hapkit_studio.gui.live.history import CHANNELS, History
from hapkit_studio.gui.live.past_trace import PastTrace, past_trace
from hapkit_studio.gui.live.phase_canvas import emptiest_corner
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import colored, settle


def filled(seconds=4.0):
    history, n = History(60.0, 1000.0), int(1000 * seconds)
    table = np.zeros((n, rows.ROW_WIDTH))
    table[:, rows.TICK] = np.arange(n)
    table[:, rows.HOST_TIME] = 10.0 + np.arange(n) * 1e-3
    table[:, rows.POSITION] = 0.01 * np.sin(np.arange(n) * 1e-2)
    history.append(table)
    return history


def test_a_held_stretch_is_the_past_moved_on():
    past = past_trace(filled(), "on the computer", 11.0, 12.0, shift=2.0)
    assert past.time[[0, -1]] == pytest.approx([11.0, 12.0], abs=2e-3)
    x, y = past.part("position", 13.2, 13.3, 1000)
    assert x[[0, -1]] == pytest.approx([13.2, 13.3], abs=2e-3)
    assert y == pytest.approx(0.01 * np.sin((x - 2.0 - 10.0) * 10.0), abs=1e-9)


def test_a_dense_held_stretch_keeps_its_peaks():
    past = past_trace(filled(), "", 10.0, 14.0)
    x, y = past.part("position", 10.0, 14.0, 100)
    assert len(x) <= 2 * 101
    assert (y.min(), y.max()) == pytest.approx((-0.01, 0.01), abs=1e-6)
    assert past_trace(filled(), "", 100.0, 101.0) is None


def test_the_plots_show_what_is_held_and_name_it(plots):
    time = np.linspace(0.0, 1.0, 50)
    plots.set_past(PastTrace("on the board", time, {name: np.zeros(50) for name in CHANNELS}))
    label = plots.headers[0].past[-1]
    assert label.isVisibleTo(plots)
    assert label.text() == "on the board"
    plots.set_past(None)
    assert not label.isVisibleTo(plots)


def pushed_into_a_wall():
    x = np.linspace(-0.02, 0.02, 500)
    values = {name: x for name in CHANNELS} | {"applied": np.clip(-400.0 * (x - 0.005), -3.0, 0.0)}
    return PastTrace("on the board", x, values)


def test_force_over_position_names_what_is_held_where_nothing_is_drawn(phase):
    """A wall on the right leaves the upper right free; a handle at rest is no line that wants a name."""
    box = phase.canvas.frame()
    still = PastTrace("on the board", np.zeros(50), {name: np.full(50, 1e-5) for name in CHANNELS})
    for past, named in ((pushed_into_a_wall(), True), (still, False), (None, False)):
        phase.set_past(past)
        settle(phase)
        found = colored(phase.canvas.viewport().grab().toImage(), "axis")
        inside = np.array([at for at in found if box.contains(*at)])
        assert (len(inside) > 50) == named
        if named:
            assert inside[:, 0].min() > box.center().x()
            assert inside[:, 1].max() < box.top() + 40


@pytest.mark.parametrize("corner", [(1, 0), (0, 0), (1, 1), (0, 1)])
def test_words_stand_in_the_corner_with_nothing_in_it(corner):
    """Points in the middle of each quarter but one, so near the frame that words would cover them."""
    box, size = QRectF(40.0, 10.0, 300.0, 200.0), QSizeF(110.0, 16.0)
    taken = [(a, b) for a in (0, 1) for b in (0, 1) if (a, b) != corner]
    across = np.array([box.left() + (60.0, 240.0)[a] for a, _ in taken])
    down = np.array([box.top() + (12.0, 188.0)[b] for _, b in taken])
    place = emptiest_corner(box, size, across, down)
    assert box.contains(place)
    assert (place.center().x() > box.center().x(), place.center().y() > box.center().y()) == corner
