"""The trigger finds the crossings of the signal's formula, however the rows are split into frames."""

import math

import numpy as np
import pytest
from PySide6.QtCore import QCoreApplication, Qt
from PySide6.QtGui import QContextMenuEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from hapkit_studio.gui.live.history import LiveHistory
from hapkit_studio.gui.live.time_view import TimeView
from hapkit_studio.gui.live.trigger import AGAIN, BEFORE, EDGE, EVENT, Trigger, crossings
from tests.gui.live.plot_support import LIBRARY, RATE, telemetry
from tests.gui.window_support import sheets

PEAK = 0.015  # amplitude in m of the handle's motion, which is 15 mm sin(3 t)
# time in s of the first contact with the wall at 5 mm; the next contact is 2π/3 s later
TOUCHES = math.asin(1.0 / 3.0) / 3.0
PERIOD = 2.0 * math.pi / 3.0


@pytest.fixture
def view():
    view = TimeView()
    view.set_history(LiveHistory(seconds=60.0, rate=RATE))
    return view


def armed(view, **values):
    """Return an armed trigger with these values; choices are given by their names."""
    trigger = Trigger(view)
    trigger.set_environment(LIBRARY["wall"])
    for key, value in values.items():
        choice = {"event": EVENT, "edge": EDGE, "again": AGAIN}.get(key)
        trigger.set_value(key, value if choice is None else choice.check(value))
    trigger.arm()
    return trigger


def come(view, trigger, stop, start=0.0, frame=16):
    """Feed the rows from start to stop in s, ``frame`` rows per frame; return the times of the events."""
    stood = []
    rows = telemetry(round((stop - start) * RATE), round(start * RATE))
    for first in range(0, len(rows), frame):
        view.live.append(rows[first : first + frame])
        trigger.refresh()
        if not view.follows and view.zero not in stood:
            stood.append(view.zero)
    return stood


def choose_over(canvas, text):
    """Choose an entry of a plot's context menu."""
    place = canvas.viewport().rect().center()
    event = QContextMenuEvent(QContextMenuEvent.Reason.Mouse, place, canvas.mapToGlobal(place))
    QCoreApplication.sendEvent(canvas.viewport(), event)
    menu = QApplication.activePopupWidget()
    next(action for action in menu.actions() if action.text() == text).trigger()
    menu.close()


def first_sample(time):
    """Return the time of the first sample at or after a time in s."""
    return math.ceil(time * RATE) / RATE


def test_a_constant_level_or_a_gap_is_no_crossing():
    values = np.array([2.0, 2.0, 1.0, 2.0, 2.0, 3.0, 1.0, np.nan, 3.0, 2.0, 1.9])
    assert list(crossings(values, 2.0, rising=True)) == [3]
    assert list(crossings(values, 2.0, rising=False)) == [6, 9]
    assert list(crossings(values, 1.95, rising=False)) == [2, 6, 10]
    assert not len(crossings(np.full(5, 2.0), 2.0, rising=True))
    assert not len(crossings(np.empty(0), 2.0, rising=True))


@pytest.mark.slow
@pytest.mark.parametrize("frame", [1, 16, 333, 4000])
@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"event": "contact"}, TOUCHES),
        ({"event": "position", "position": 0.005}, TOUCHES),
        ({"event": "position", "position": 0.005, "edge": "falling"}, math.pi / 3.0 - TOUCHES),
        ({"event": "position", "position": 0.99 * PEAK}, math.asin(0.99) / 3.0),
        ({"event": "velocity", "velocity": -40.0, "edge": "falling"}, math.acos(-40.0 / 45.0) / 3.0),
        ({"event": "force", "force": -2.0, "edge": "falling"}, math.asin(10.0 / 15.0) / 3.0),
    ],
)
def test_the_picture_stops_at_the_first_sample_beyond_the_level(view, frame, values, expected):
    trigger = armed(view, **values)
    assert come(view, trigger, 4.0, frame=frame) == pytest.approx([first_sample(expected)], abs=1e-9)
    assert not trigger.armed
    assert (view.left, view.right) == (-2.0, 8.0)


def test_a_level_1_percent_beyond_the_peak_is_not_crossed(view):
    trigger = armed(view, event="position", position=1.01 * PEAK)
    assert come(view, trigger, 8.0) == []
    assert trigger.armed
    assert view.status == "Waiting for position 15.15 mm"
    assert view.level == ("position", pytest.approx(0.01515))


def test_a_repeated_trigger_waits_until_the_picture_is_complete(view):
    """The view shows 2 s, of which 1.5 s follow the event; the time between contacts is 2.09 s."""
    trigger = armed(view, event="contact", again="repeated", before=25.0)
    view.set_span(2.0)
    touched = [first_sample(TOUCHES + n * PERIOD) for n in range(4)]
    assert come(view, trigger, 7.0) == pytest.approx(touched, abs=1e-9)
    assert (view.left, view.right) == (-0.5, 1.5)
    assert view.status == "Contact 1 s ago, waiting"
    view.set_span(4.0)  # 3 s follow the event, so every other contact triggers
    trigger.arm()
    later = [first_sample(TOUCHES + n * PERIOD) for n in (4, 6)]
    assert come(view, trigger, 14.0, start=7.0) == pytest.approx(later, abs=1e-9)


def test_samples_before_arming_while_paused_or_of_another_scene_are_no_event(view):
    view.live.append(telemetry(1000))
    trigger = armed(view, event="contact")
    view.set_paused(True)
    come(view, trigger, 2.5, start=1.0)  # contact at 2.21 s
    view.set_paused(False)
    assert view.follows
    view.live.append(telemetry(2000, 2500))  # contact at 4.30 s
    view.live.end_environment()
    trigger.refresh()
    assert view.follows
    assert come(view, trigger, 8.0, start=4.5) == [first_sample(TOUCHES + 3.0 * PERIOD)]


@pytest.mark.parametrize(
    ("key", "text"),
    [("wall", "contact"), ("puck", "contact"), ("mass_spring_damper", "contact"), ("button", "contact"),
     ("spring", "position 5.0 mm"), ("damping", "position 5.0 mm"), ("cat", "position 5.0 mm")],
)  # fmt: skip
def test_the_event_suits_the_scene_until_one_is_chosen(view, key, text):
    trigger = armed(view)
    trigger.set_environment(LIBRARY[key])
    assert view.status == f"Waiting for {text}"
    trigger.set_value(EVENT.key, EVENT.check("velocity"))
    trigger.set_environment(LIBRARY["free"])
    assert view.status == "Waiting for velocity 100 mm/s"


def test_a_waiting_trigger_says_that_a_scene_has_no_contact(view):
    trigger = armed(view, event="contact")
    assert view.status == "Waiting for contact"
    trigger.set_environment(LIBRARY["spring"])
    assert view.status == "There is no contact in Spring"
    trigger.disarm()
    assert view.status == ""


@pytest.mark.slow
def test_a_held_trace_keeps_its_position_at_the_next_event(window, qtbot):
    """Two contacts 2.09 s apart are drawn on top of each other."""
    view, trigger = window.centre.view, window.centre.trigger
    window.live._reader = None  # from now on only the test's rows
    view.live.clear()
    view.set_span(1.0)
    trigger.set_value(AGAIN.key, AGAIN.check("repeated"))
    trigger.arm()
    come(view, trigger, 1.5)
    window.display.keep_curves()
    come(view, trigger, 3.5, start=1.5)
    window.centre.time.refresh()
    (curve,) = window.centre.kept_curves.curves.values()
    now = view.history.between(*view.stretch)
    assert view.zero == pytest.approx(first_sample(TOUCHES + PERIOD))
    seen = np.abs(curve.time - 0.3) < 0.4
    assert np.count_nonzero(seen) > 700
    there = np.interp(curve.time[seen], now.x - view.zero, now.y["position"])
    # within the sampling period of 1 ms, the handle moves by at most 45 µm
    assert curve.values["position"][seen] == pytest.approx(there, abs=50e-6)


def test_keys_arm_the_trigger_and_return_to_live_and_its_dialog_changes_it(window, qtbot):
    view, trigger, scene = window.centre.view, window.centre.trigger, window.centre.scene
    window.live._reader = None
    view.live.clear()
    view.live.append(telemetry(100))
    scene.setFocus()
    QTest.keyClick(scene, Qt.Key.Key_T)
    assert trigger.armed
    assert window.actions_by_key.qt["view.trigger"].isChecked()
    window.live.frame.disconnect()
    come(view, trigger, 1.0, start=0.1)
    window.centre.time.refresh()
    assert [text for _, text in window.centre.time.shown.dividers] == ["Contact"]
    assert not window.actions_by_key.qt["view.trigger"].isChecked()
    QTest.keyClick(scene, Qt.Key.Key_Space)
    assert view.status == "Plots paused"
    assert view.happened == "Contact"
    QTest.keyClick(scene, Qt.Key.Key_Backspace)
    assert view.follows
    assert not window.live.paused
    QTest.keyClick(scene, Qt.Key.Key_Y)
    assert view.locked
    choose_over(window.centre.time.canvases[0], "Trigger settings…")
    (dialog,) = sheets(window)
    rows = dialog.rows
    assert not rows["position"].isVisible()
    rows[EVENT.key].picker.setCurrentIndex(2)
    rows[EVENT.key].picker.activated.emit(2)
    assert (rows["velocity"].isVisible(), rows["position"].isVisible()) == (True, False)
    rows[BEFORE.key].box.setFocus()
    rows[BEFORE.key].box.selectAll()
    QTest.keyClicks(rows[BEFORE.key].box, "96\r")
    assert rows[BEFORE.key].error.text() == "Time shown before the event must be between 0 and 95 %."
    qtbot.mouseClick(dialog.arm, Qt.MouseButton.LeftButton)
    assert view.status == "Waiting for velocity 100 mm/s"
    assert (trigger.values["event"], trigger.values["before"]) == (2.0, 20.0)
    box = window.panel.parameters.rows["stiffness"].box
    box.setFocus()
    QTest.keyClick(box, Qt.Key.Key_Backspace)  # in a number box this key deletes a digit
    assert trigger.armed
    scene.setFocus()
    QTest.keyClick(scene, Qt.Key.Key_Backspace)
    assert not trigger.armed
