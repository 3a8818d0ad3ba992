"""Each gesture of the user that changes a setting adds one labelled divider to the history."""

import math
import time

import pytest

from hapkit_studio.gui.live.history import LiveHistory
from tests.gui.live.plot_support import RATE, telemetry


@pytest.fixture
def noted(reset_window):
    """Return the window's studio, undo and history; only the test feeds samples."""
    window = reset_window
    window.live.tick()
    window.live.history.clear()
    return window.studio, window.history, window.live


def later(live):
    """Wait until the history has new samples."""
    live.tick()
    before, deadline = live.history.now, time.monotonic() + 30.0
    while live.history.now == before or math.isnan(live.history.now):
        assert time.monotonic() < deadline
        live.tick()


def divider_texts(live):
    return [text for _, text in live.history.dividers]


def test_a_drag_adds_one_divider_at_its_end_and_a_new_press_another(noted):
    studio, undo, live = noted
    later(live)
    for stiffness in (300.0, 500.0, 800.0):
        begun = live.history.now
        studio.set_value("stiffness", stiffness)
        later(live)
    ((when, text),) = live.history.dividers
    assert text == "Stiffness 250 → 800 N/m"
    assert begun <= when < live.history.now
    undo.gesture += 1
    studio.set_loop(rate=2000.0)
    assert divider_texts(live) == ["Stiffness 250 → 800 N/m", "Servo rate 1,000 → 2,000 Hz"]


def test_a_drag_back_to_its_start_adds_no_divider_but_undo_does(noted):
    studio, undo, live = noted
    later(live)
    undo.gesture += 1
    for stiffness in (300.0, 250.0):
        studio.set_value("stiffness", stiffness)
        later(live)
    assert divider_texts(live) == []
    undo.gesture += 1
    studio.set_value("stiffness", 900.0)
    later(live)
    undo.gesture += 1
    undo.undo()
    assert divider_texts(live) == ["Stiffness 250 → 900 N/m", "Stiffness 900 → 250 N/m"]


def test_another_environment_adds_one_divider_with_its_name(noted, qtbot):
    """Settings of an environment that is not active add no divider."""
    studio, _, live = noted
    later(live)
    studio.set_values_of("spring", {"stiffness": 77.0})
    assert divider_texts(live) == []
    studio.choose("spring")
    qtbot.waitUntil(lambda: studio.environment.key == "spring")
    assert divider_texts(live) == ["Spring"]


def test_a_divider_can_replace_or_remove_an_earlier_one():
    history = LiveHistory(seconds=60.0, rate=RATE)
    history.append(telemetry(1000))
    history.divide("first", 0.2)
    history.divide("other", 0.4)
    history.divide("second", 0.6, instead=0.2)
    assert history.dividers == [(0.4, "other"), (0.6, "second")]
    history.divide("", 0.8, instead=0.6)
    assert history.dividers == [(0.4, "other")]


def test_another_device_adds_a_divider_and_starts_new_data(noted):
    """Samples of the previous device stay visible, but are not part of the new device's data."""
    _, _, live = noted
    later(live)
    live._device = "another"
    newest = live.history.now
    live._follow()
    assert divider_texts(live) == ["Simulated Hapkit"]
    assert len(live.history)
    assert live.history.begin > newest
