"""Settings locked by an instructor cannot be changed without the code; stopping is always possible."""

import json

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractSpinBox

from hapkit_studio.errors import FileError, ParameterError
from hapkit_studio.gui.state.lock import DEVICE, ENTRY, LOOP, Lock
from hapkit_studio.gui.state.permissions import LOCKED
from hapkit_studio.gui.state.undo import settings_of
from hapkit_studio.gui.teach.lock_dialog import LockDialog
from tests.environments.calling import LIBRARY
from tests.gui.shell.test_actions import TABLE, press
from tests.gui.state.test_presets import preset
from tests.gui.window_support import sheet_of

STIFFNESS = ("value", "wall", "stiffness")
PLACES = [STIFFNESS, LOOP, DEVICE, *(("environment", key) for key in LIBRARY if key != "wall")]


@pytest.fixture(scope="module")
def closed():
    """Return a lock under which only the wall's parameters other than stiffness can be changed.

    All tests share it, because hashing its code is slow by design.
    """
    return Lock.closed(PLACES, "1234")


@pytest.fixture
def window(reset_idle_window, closed):
    """Return this test file's window, locked at 900 N/m, with one older step in the undo history."""
    reset_idle_window.history.forget()
    reset_idle_window.studio.set_value("stiffness", 900.0)
    reset_idle_window.studio.permissions.set_lock(closed)
    yield reset_idle_window
    reset_idle_window.studio.permissions.set_lock(Lock())
    reset_idle_window.two.forget()


def locked_settings(studio):
    """Return the locked settings with their current values."""
    return {place: v for place, v in settings_of(studio).items() if studio.permissions.lock.covers(place)} | {
        "environment": studio.environment.key
    }


def test_only_its_own_code_opens_a_lock_and_the_code_is_not_stored(closed):
    text = closed.text()
    assert "1234" not in text
    assert Lock.read(text) == closed
    assert closed.opens("1234")
    for code in ("", "1235", "12345", closed.digest.hex()):
        assert not closed.opens(code)
    assert Lock.closed(PLACES, "1234").digest != closed.digest  # each lock has its own salt
    assert Lock.read("") == Lock()


def test_a_damaged_lock_is_refused(closed):
    text = closed.text()
    whole = json.loads(text)
    damaged = [
        {**whole, name: value}
        for name in whole
        for value in (None, 3, "", [], {}, "x" * 32, [1], [[]], [["moon"]], [["loop", "x"]], [[1, 2]])
    ]
    for damage in ("{", "[]", "3", "[" * 5000, text.replace("salt", "salz"), *map(json.dumps, damaged)):
        with pytest.raises(FileError, match=r"^lock[^\n]+\.$"):
            Lock.read(damage)


@pytest.mark.parametrize(
    "change",
    [
        lambda s: s.set_value("stiffness", 891.0),
        lambda s: s.set_values({"damping": 1.0, "stiffness": 909.0}),
        lambda s: s.set_values_of("wall", {"stiffness": 0.0}),
        lambda s: s.set_loop(delay=0.001),
        lambda s: s.set_loop(hand="firm"),
        lambda s: s.hide_values(LIBRARY["wall"].values({"stiffness": 100.0})),
    ],
)
def test_the_studio_refuses_every_change_of_a_locked_setting(window, change):
    before = settings_of(window.studio)
    with pytest.raises(ParameterError, match=r"^(Stiffness|Loop and grip): locked by the instructor\.$"):
        change(window.studio)
    assert settings_of(window.studio) == before
    # damping is not locked; the locked stiffness keeps its value
    window.studio.set_values({"damping": 1.0, "stiffness": 900.0})
    assert window.studio.values["damping"] == 1.0


def test_no_action_changes_a_locked_setting(window):
    before = locked_settings(window.studio)
    for action in TABLE:
        if action.menu.partition("/")[0] in ("Edit", "Environment", "Teach"):
            window.actions_by_key.run(action.key)
            assert locked_settings(window.studio) == before, action.key
    assert "locked by the instructor" in window.banners.get("undo").text


def test_no_widget_page_preset_or_key_changes_a_locked_setting(window, tmp_path):
    studio, row = window.studio, window.panel.parameters.rows["stiffness"]
    before = settings_of(studio)
    QTest.mouseClick(row.slider, Qt.MouseButton.LeftButton, pos=row.slider.rect().center())
    QTest.keyClicks(row.box, "5")
    QTest.keyClick(row.box, Qt.Key.Key_Up)
    press(window, "1", "C", Qt.Key.Key_X)
    window.gallery.rows["spring"].click()
    text = 'environment = "wall"\n[values]\ndamping = 2.0\nstiffness = 100.0\n'
    window.presets.import_file(preset(tmp_path, text))
    window.views.page("stability").go(2.0, 100.0)
    with pytest.raises(ParameterError):
        window.history.apply({("value", "wall", "damping"): 2.0, ("environment",): "cat"})
    assert settings_of(studio) == before
    assert row.value == 900.0


def test_a_padlock_replaces_the_reset_button_and_the_value_stays_readable(window):
    rows, loop = window.panel.parameters.rows, window.loop
    loop.set_folded(False)
    stiffness, damping = rows["stiffness"], rows["damping"]
    assert stiffness.padlock.isVisible()
    assert not stiffness.reset.isVisible()
    assert not stiffness.box.isEnabled()
    assert (stiffness.box.text(), stiffness.box.buttonSymbols()) == (
        "900",
        QAbstractSpinBox.ButtonSymbols.UpDownArrows,
    )
    assert LOCKED in stiffness.toolTip()
    assert damping.isEnabled()
    assert damping.padlock.isHidden()
    assert loop.padlock.isVisible()
    assert not loop.controller.isEnabled()
    assert window.gallery.rows["cat"].waiting == LOCKED
    assert LOCKED in window.gallery.rows["cat"].accessibleName()
    assert window.gallery.rows["wall"].waiting == ""
    stiffness.show_value(800.0)
    assert not stiffness.reset.isVisible()
    window.studio.permissions.set_lock(Lock())
    assert stiffness.reset.isVisible()
    assert stiffness.padlock.isHidden()
    assert loop.controller.isEnabled()


def test_stop_and_device_are_never_locked(window):
    run, studio = window.actions_by_key.run, window.studio
    run("session.stop")
    assert studio.stopped
    run("session.release")
    assert not studio.stopped
    assert window.header.devices.isEnabled()


@pytest.mark.slow
def test_locking_and_unlocking_in_a_dialog_survive_a_restart(window, make_window):
    window.studio.permissions.set_lock(Lock())
    window.show_lock()
    dialog = sheet_of(window, LockDialog)
    dialog.others.click()
    dialog.places.item(0).setCheckState(Qt.CheckState.Checked)
    assert set(dialog.ticked) == {place for place in PLACES if place not in (LOOP, DEVICE)}
    for code, again, can in (("", "", False), ("a", "b", False), ("a", "a", True)):
        dialog.code.setText(code)
        dialog.again.setText(again)
        assert dialog.confirm.isEnabled() == can
    dialog.confirm.click()
    window.state.save()
    again = make_window()
    again.state.restore()
    assert again.studio.permissions.lock == window.studio.permissions.lock
    assert again.studio.values["stiffness"] == 900.0  # the locked value is restored
    with pytest.raises(ParameterError):
        again.studio.set_value("stiffness", 250.0)
    again.show_lock()
    dialog = sheet_of(again, LockDialog)
    for code, left in (("b", 1), ("a", 0)):
        dialog.code.setText(code)
        dialog.confirm.click()
        assert bool(again.studio.permissions.lock.places) == left
    assert again.settings.value(ENTRY) == ""
    again.studio.set_value("stiffness", 250.0)


def test_the_dialog_fits_on_a_low_screen(window):
    """Qt limits a dialog to two thirds of the screen's height, here of 720 px. Nothing may overlap in it."""
    window.studio.permissions.set_lock(Lock())
    window.show_lock()
    dialog = sheet_of(window, LockDialog)
    dialog.resize(dialog.width(), 480)
    QTest.qWait(1)
    first = dialog.places.mapTo(dialog, dialog.places.rect().bottomLeft()).y()
    assert first < dialog.code.mapTo(dialog, dialog.code.rect().topLeft()).y()
    rows = [dialog.places.visualItemRect(dialog.places.item(row)) for row in range(2)]
    assert rows[1].top() - rows[0].top() >= 24
    dialog.close()


@pytest.mark.slow
def test_an_option_on_the_command_line_cannot_change_a_locked_setting(start_window, window, closed):
    window.settings.setValue(ENTRY, closed.text())
    window.state.save()
    assert start_window("--environment", "cat").studio.environment.key == "wall"
    window.settings.setValue(ENTRY, "")
    assert start_window("--environment", "cat").studio.environment.key == "cat"
