"""The signal of every time plot is stored, recorded, drawn and read by cursors, live and in a replay."""

import math
from contextlib import closing

import numpy as np
import pytest

from hapkit_studio.gui.live.history import LiveHistory
from hapkit_studio.gui.live.plots.declared import time_plots
from hapkit_studio.gui.live.recorded import Recorded
from hapkit_studio.gui.live.time_plots import TimePlots
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.signals import COLUMN
from hapkit_studio.sessions.chunk import pack
from hapkit_studio.sessions.file import SessionWriter
from hapkit_studio.sessions.session import Session
from tests.gui.live.plot_fixtures import shown
from tests.gui.live.plot_support import RATE, colored, telemetry

QUANTUM = 20.7e-6


@pytest.mark.parametrize("plot", [*time_plots(), *time_plots(beside=True)], ids=lambda plot: plot.key)
@pytest.mark.parametrize("replayed", [False, True], ids=["live", "replayed"])
def test_the_last_signal_of_every_plot_is_drawn_and_read(plot, replayed, qtbot, tmp_path):
    trace, table = plot.traces[-1], telemetry(3000)
    column, time = COLUMN[trace.channel], table[:, rows.HOST_TIME]
    table[:, column] = 0.8 * plot.reach / plot.scale * np.sin(5.0 * time)
    within = max(QUANTUM, 0.02 * plot.reach / plot.scale)
    with SessionWriter.whole(tmp_path / "a.hapkit") as writer:
        writer.add(pack(table, QUANTUM, 0, truth=True))
    with closing(Session(tmp_path / "a.hapkit")) as session:
        history = Recorded(session) if replayed else LiveHistory(seconds=60.0, rate=RATE)
        if isinstance(history, LiveHistory):
            history.append(table)
        else:
            history.move_to(history.stop)
        plots = shown(qtbot, TimePlots(plots=[plot]), (560, 250), history)
        assert len(colored(plots.canvases[0].grab().toImage(), trace.color)) > 100
        values = history.between(-math.inf, 9.0).y[trace.channel]
        np.testing.assert_allclose(values, table[:, column], atol=within)
        plots.cursors.show(True)
        for at, values in zip(plots.cursors.times, plots.cursors.at(), strict=True):
            expected = np.interp(at, time, table[:, column])
            assert values[trace.channel] == pytest.approx(expected, abs=within)
        assert history.latest()[trace.channel] == pytest.approx(table[-1, column], abs=within)
