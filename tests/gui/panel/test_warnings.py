"""Warnings about rendering are shown below the parameters while they apply."""

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QRect

from hapkit_studio.formatting import unbroken
from hapkit_studio.gui.live.history import LATELY_SECONDS, LiveHistory, highest_speed
from hapkit_studio.gui.panel.limits import LoopFacts
from hapkit_studio.gui.panel.warnings import WarningLine, WarningLines
from hapkit_studio.gui.shell.banners import Notice
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import LIBRARY
from tests.gui.window_support import PATIENCE_MS


def complain(values, conditions):
    if values["stiffness"] > 300.0:
        yield f"Too stiff at {1.0 / conditions.period:g} Hz"
    if conditions.speed > 0.5:
        yield f"Too fast: {conditions.speed:.2f} m/s"


@pytest.fixture
def lines(reset_window):
    studio = reset_window.studio
    studio.adopt(replace(LIBRARY["wall"], warnings=complain))
    yield reset_window.panel.warnings
    studio.adopt(LIBRARY["wall"])


@pytest.fixture
def studio(lines, reset_window):
    return reset_window.studio


def moving(seconds_ago, speed):
    """Return a history of 20 s in which the handle once moved at a speed, some seconds before its end."""
    table = np.zeros((2001, rows.ROW_WIDTH))
    table[:, rows.TICK] = np.arange(2001)
    table[:, rows.HOST_TIME] = 0.01 * np.arange(2001)
    table[-1 - int(100 * seconds_ago), rows.VELOCITY] = -speed
    history = LiveHistory(60.0)
    history.append(table)
    return history


@pytest.mark.slow
def test_warnings_follow_values_and_loop(lines, studio):
    assert (lines.texts, lines.isHidden()) == ([], True)
    studio.set_value("stiffness", 301.0)
    assert lines.texts == ["Too stiff at 1000 Hz"]
    assert not lines.isHidden()
    studio.set_loop(rate=2000.0)
    assert lines.texts == ["Too stiff at 2000 Hz"]
    studio.set_value("stiffness", 299.0)
    assert lines.texts == []
    assert lines.isHidden()


@pytest.mark.slow
def test_the_recent_speed_is_remembered_for_a_while(lines):
    lines.watch(highest_speed(moving(0.9 * LATELY_SECONDS, 0.51)))
    assert lines.texts == ["Too fast: 0.51 m/s"]
    for calm in (moving(1.1 * LATELY_SECONDS, 0.51), LiveHistory(60.0)):
        lines.watch(highest_speed(calm))
        assert lines.texts == []


def test_without_a_device_nothing_is_judged(qtbot):
    studio = Studio(list)
    studio.environment = replace(LIBRARY["wall"], warnings=complain)
    made = WarningLines(studio, LoopFacts(studio))
    qtbot.addWidget(made)
    studio.set_value("stiffness", 301.0)
    assert made.texts == []


def test_the_conditions_are_those_of_the_current_device_and_loop(reset_window, qtbot):
    studio, lines = reset_window.studio, reset_window.panel.warnings
    studio.set_loop(delay=1e-3, estimator="iir")

    def late() -> bool:
        reset_window.live.refresh()  # the loop uses the new delay from its next tick on
        return lines.conditions.delay == 1e-3

    qtbot.waitUntil(late, timeout=PATIENCE_MS)
    device = studio.engine.device
    known = (device.mass, device.coulomb_force, device.max_force, "iir")
    assert (lines.conditions.mass, lines.conditions.coulomb, lines.conditions.max_force) == known[:3]
    assert lines.conditions.estimator == known[3]


def test_a_line_shows_the_first_sentence_and_its_tooltip_everything(qtbot):
    line = WarningLine("Above 0.05 m/s a ridge is missed; the handle moved at 0.1 m/s.")
    qtbot.addWidget(line)
    assert line.label.text() == "Above 0.05 m/s a ridge is missed …"
    assert unbroken("the handle moved at 0.1 m/s.") in line.toolTip()
    assert WarningLine("Too stiff at 1000 Hz").label.text() == "Too stiff at 1000 Hz"


@pytest.mark.slow
@pytest.mark.parametrize(("size", "mapped"), [((1024, 640), False), ((1280, 900), True)])
def test_warnings_and_verdict_stay_visible_and_the_map_if_it_fits(
    lines, studio, reset_window, qapp, qtbot, size, mapped
):
    panel, card = reset_window.panel, reset_window.panel.stability
    reset_window.resize(*size)
    reset_window.body.open_drawer(True)
    for rank, key in enumerate(("one", "other")):
        reset_window.banners.set(key, Notice(key, rank, "warn", "triangle", "Title.", "Text."))
    studio.set_value("stiffness", 301.0)
    lines.watch(highest_speed(moving(0.9 * LATELY_SECONDS, 0.51)))
    qtbot.waitUntil(lambda: card.question() is not None)
    card.ask()
    card.wait()
    qtbot.waitUntil(lambda: "limit" in card.verdict.text)
    qapp.processEvents()
    assert len(lines.texts) == 2
    assert card.map.isVisible() == mapped
    for part in (lines, card.verdict, card.label):
        assert panel.rect().contains(QRect(part.mapTo(panel, QPoint()), part.size()))
        assert part.height() >= part.heightForWidth(part.width())
    assert panel.upper.height() >= 200 or not mapped
