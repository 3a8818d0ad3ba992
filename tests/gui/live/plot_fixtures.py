"""Plots on a history of a handle that swings in and out of a wall; loaded by the folder's conftest."""

import pytest

from hapkit_studio.gui.live.history import History
from hapkit_studio.gui.live.phase_plot import ForcePosition
from hapkit_studio.gui.live.time_plots import TimePlots
from tests.gui.live.plot_support import LIBRARY, RATE, telemetry


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
