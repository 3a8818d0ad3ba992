"""What cannot be rendered well is said below the parameters, and only while it is so."""

from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.gui.live.history import History
from hapkit_studio.gui.panel.warnings import LATELY_SECONDS, WarningLines
from hapkit_studio.gui.studio import Studio
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import LIBRARY


def complain(values, conditions):
    if values["stiffness"] > 300.0:
        yield f"Too stiff at {1.0 / conditions.period:g} Hz"
    if conditions.speed > 0.5:
        yield f"Too fast: {conditions.speed:.2f} m/s"


@pytest.fixture
def lines(qtbot):
    studio = Studio(list)
    studio.environment = replace(LIBRARY["wall"], warnings=complain)
    made = WarningLines(studio)
    qtbot.addWidget(made)
    made.studio = studio
    yield made
    studio.close()


def moving(seconds_ago, speed):
    """Return a history of 20 s whose handle went at a speed once, some seconds before its end."""
    table = np.zeros((2001, rows.ROW_WIDTH))
    table[:, rows.TICK] = np.arange(2001)
    table[:, rows.HOST_TIME] = 0.01 * np.arange(2001)
    table[-1 - int(100 * seconds_ago), rows.VELOCITY] = -speed
    history = History(60.0)
    history.append(table)
    return history


def test_nothing_is_said_without_a_reason(lines):
    assert lines.texts == []
    assert lines.isHidden()


def test_it_follows_values_and_loop(lines):
    lines.studio.set_value("stiffness", 301.0)
    assert lines.texts == ["Too stiff at 1000 Hz"]
    assert not lines.isHidden()
    lines.studio.set_loop(rate=2000.0)
    assert lines.texts == ["Too stiff at 2000 Hz"]
    lines.studio.set_value("stiffness", 299.0)
    assert lines.texts == []
    assert lines.isHidden()


def test_it_remembers_the_speed_for_a_while(lines):
    lines.watch(moving(0.9 * LATELY_SECONDS, 0.51))
    assert lines.texts == ["Too fast: 0.51 m/s"]
    lines.watch(moving(1.1 * LATELY_SECONDS, 0.51))
    assert lines.texts == []


def test_an_empty_history_has_no_speed(lines):
    lines.watch(History(60.0))
    assert lines.texts == []
