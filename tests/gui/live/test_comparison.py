"""Both ways on top of each other: where in time a past movement lies, and what a comparison says."""

import numpy as np
import pytest

from hapkit_studio.gui.live import comparison
from hapkit_studio.gui.live.comparison import Part, difference_words
from hapkit_studio.gui.live.history import History
from hapkit_studio.haptics import link, rows

SWITCH, NOW = 12.0, 15.0


def history_of(position, force=np.zeros_like, start=0.0, stop=NOW):
    """Return a history at 1 kHz with a position in m and a force in N, functions of time in s."""
    time = np.arange(start, stop, 1e-3)
    table = np.zeros((len(time), rows.ROW_WIDTH))
    table[:, rows.TICK] = np.arange(len(time))
    table[:, rows.HOST_TIME] = time
    table[:, rows.POSITION] = position(time)
    table[:, rows.APPLIED] = force(time)
    history = History(60.0, 1000.0)
    history.append(table)
    return history


def press(at):
    """Return one smooth press of 10 mm that begins at a time in s and lasts one second."""
    return lambda t: 0.005 * (1.0 - np.cos(2.0 * np.pi * np.clip(t - at, 0.0, 1.0)))


def test_one_press_lies_on_the_press_before():
    history = history_of(lambda t: press(4.37)(t) + press(12.9)(t))
    found = comparison.find_shift(history, 0.0, SWITCH, SWITCH, NOW)
    assert found == pytest.approx(12.9 - 4.37, abs=comparison.STEP)


def test_a_push_to_and_fro_keeps_its_phase_over_the_switch():
    period = 0.8
    history = history_of(lambda t: 0.01 * np.sin(2.0 * np.pi * t / period))
    found = comparison.find_shift(history, 0.0, SWITCH, SWITCH + 0.2, NOW)
    assert found / period == pytest.approx(round(found / period), abs=comparison.STEP / period)


@pytest.mark.parametrize(
    "position",
    [lambda t: 0.001 * np.sin(9.0 * t), lambda t: np.where(t < SWITCH, 0.0, press(12.5)(t)), np.zeros_like],
    ids=["hardly moves", "never moved before", "stands still"],
)
def test_what_does_not_move_alike_is_not_laid_over(position):
    assert comparison.find_shift(history_of(position), 0.0, SWITCH, SWITCH, NOW) is None


def test_too_little_of_either_side_says_nothing():
    history = history_of(lambda t: 0.01 * np.sin(8.0 * t))
    assert comparison.find_shift(history, 0.0, SWITCH, NOW - 0.9 * comparison.LEAST, NOW) is None
    assert comparison.find_shift(history, SWITCH - 0.5, SWITCH, SWITCH, NOW) is None


def test_the_difference_is_that_of_the_same_moments():
    force = lambda t: np.where(t < 5.0, -np.sin(t - 1.0), -np.sin(t - 7.0) - 0.3)  # noqa: E731
    words = difference_words(
        history_of(np.zeros_like, force), Part("computer", 1.0, 4.0), Part("board", 7.0, 10.0)
    )
    assert "0.30 N rms, 0.30 N at most" in words
    assert "dotted: computer, in colour: board" in words


def test_what_ends_a_comparison_is_said_and_who_rendered_renders_on(held_board_window, qtbot, monkeypatch):
    window = held_board_window
    switch, note, running = window.loop.where, window.loop.where.note, window.comparison.comparison
    switch.compare.emit()
    assert "1 of 2" in note.text()
    window.studio.set_value("stiffness", 100.0)
    assert not running.running
    assert "nothing was compared" in note.text()
    monkeypatch.setattr(comparison, "PATIENCE", 0.0)
    monkeypatch.setattr(comparison, "RENDERERS", ("board", "computer"))
    switch.compare.emit()
    assert window.studio.loop.where == "board"
    qtbot.waitUntil(lambda: not running.running)
    assert window.studio.loop.where == "computer"
    assert "did not begin to render" in note.text()
    assert switch.button.text() == "Compare both"
    window.studio.stop()
    switch.compare.emit()
    assert "Release the E-stop" in note.text()
    assert not running.running


def test_the_energy_is_said_to_be_unwatched_while_the_board_renders(held_board_window):
    window = held_board_window
    phase, conn = window.centre.phase, window.studio.engine.driver.conn
    phase.choose(len(phase.plots))
    assert phase.note.isHidden()
    conn.words[link.HANDOVER] = link.ON_BOARD
    window.comparison._look()
    assert "part of the computer's loop" in phase.note.text()
    assert phase.note.isVisibleTo(window)
    phase.choose(0)
    assert phase.note.isHidden()
