"""Comparison of rendering by computer and board: its result, and the events that end it."""

import numpy as np
import pytest

from hapkit_studio.gui.live import comparison
from hapkit_studio.gui.live.comparison import Part, difference_text
from hapkit_studio.gui.live.history import LiveHistory
from hapkit_studio.haptics import link, rows
from tests.gui.live.plot_support import RATE, telemetry


def test_forces_at_equal_times_after_the_start_are_compared():
    table, history = telemetry(11_000), LiveHistory(60.0, RATE)
    t = table[:, rows.HOST_TIME]
    table[:, rows.APPLIED_FORCE] = np.where(t < 5.0, -np.sin(t - 1.0), -np.sin(t - 7.0) - 0.3)
    history.append(table)
    text = difference_text(history, Part("computer", 1.0, 4.0), Part("board", 7.0, 10.0))
    assert "0.30 N (RMS) and by at most 0.30 N" in text
    assert "Kept curve: rendered by the computer. Coloured curve: rendered by the board." in text


@pytest.mark.slow
def test_an_ended_comparison_gives_the_reason_and_restores_the_renderer(
    held_board_window, qtbot, monkeypatch
):
    window = held_board_window
    switch, note, running = window.loop.where, window.loop.where.note, window.comparison
    assert window.centre.toolbar.release.isHidden()  # the button Release exists only for the simulated device
    switch.compare.emit()
    assert "1 of 2" in note.text()
    window.studio.set_value("stiffness", 100.0)
    assert not running.running
    assert "comparison ended without a result" in note.text()
    monkeypatch.setattr(comparison, "PATIENCE", 0.0)
    monkeypatch.setattr(comparison, "RENDERERS", ("board", "computer"))
    switch.compare.emit()
    assert window.studio.loop.where == "board"
    qtbot.waitUntil(lambda: not running.running)
    assert window.studio.loop.where == "computer"
    assert "did not start to render" in note.text()
    assert switch.button.text() == "Compare computer and board"
    window.studio.stop()
    switch.compare.emit()
    assert "Release the E-stop" in note.text()
    assert not running.running
    energy_is_unwatched_on_the_board(window)


def energy_is_unwatched_on_the_board(window):
    """Check that only the energy plot has a note that the energy alarm is not available."""
    phase, conn = window.centre.phase, window.studio.engine.driver.conn
    phase.choose(len(phase.plots))
    assert phase.note.isHidden()
    conn.state.handover = link.ON_BOARD
    window.comparison._refresh()
    assert "only the computer's loop" in phase.note.text()
    assert phase.note.isVisibleTo(window)
    phase.choose(0)
    assert phase.note.isHidden()
