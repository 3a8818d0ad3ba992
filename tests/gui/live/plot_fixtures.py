"""Plots with the history of a handle that oscillates in and out of a wall, for this folder's conftest."""

import pytest

from hapkit_studio.gui.live.cursors import Cursors
from hapkit_studio.gui.live.history import LiveHistory
from hapkit_studio.gui.live.phase_plot import ForcePosition
from hapkit_studio.gui.live.time_plots import TimePlots
from hapkit_studio.gui.live.time_view import TimeView
from tests.gui.live.plot_support import LIBRARY, RATE, telemetry


@pytest.fixture
def history():
    history = LiveHistory(seconds=60.0, rate=RATE)
    history.append(telemetry(14_000))
    return history


def shown(qtbot, widget, size, history):
    """Show plots at a size in px with a history and a wall of 400 N/m; return the plots."""
    qtbot.addWidget(widget)
    widget.resize(*size)
    widget.show()
    widget.view.set_history(history)
    widget.set_environment(LIBRARY["wall"], LIBRARY["wall"].values({"stiffness": 400.0}), 3.0)
    widget.refresh()
    return widget


@pytest.fixture
def plots(qtbot, history):
    return shown(qtbot, TimePlots(), (560, 500), history)


@pytest.fixture
def phase(qtbot, history):
    return shown(qtbot, ForcePosition(Cursors(TimeView())), (348, 420), history)
