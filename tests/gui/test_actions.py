"""The action table: every key once, every action runs, keys are silent where a person types."""

from collections import Counter

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel, QLineEdit

from hapkit_studio.environments import discover
from hapkit_studio.gui.actions import native, table
from hapkit_studio.gui.dialogs import KeysDialog, TextDialog
from hapkit_studio.gui.live.time_plots import SPANS

TABLE = table(discover().values())


def press(window, *keys):
    """Press keys while the scene has the focus."""
    window.centre.scene.setFocus()
    for key in keys:
        QTest.keyClick(window.focusWidget() or window, key)


def sheets(window):
    return [sheet for sheet in window.findChildren(TextDialog) if sheet.isVisible()]


@pytest.fixture(autouse=True)
def as_it_began(shared_window):
    """Leave the file's window as each test found it."""
    yield
    for sheet in sheets(shared_window):
        sheet.close()
    single_keys = shared_window.actions_by_key.qt["view.single_keys"]
    if not single_keys.isChecked():
        single_keys.trigger()
    shared_window.studio.choose("wall")


def menu_actions(menu):
    for action in menu.actions():
        if action.menu() is not None:
            yield from menu_actions(action.menu())
        elif not action.isSeparator():
            yield action


def test_no_key_stands_on_two_actions():
    portable = [QKeySequence(key).toString() for action in TABLE for key in action.keys]
    assert all(portable)
    for once in (portable, [action.key for action in TABLE]):
        assert [key for key, times in Counter(once).items() if times > 1] == []


def test_every_action_stands_in_a_menu(shared_window):
    shown = {id(action) for action in menu_actions(shared_window.menuBar())}
    assert {id(action) for action in shared_window.actions_by_key.qt.values()} <= shown


def test_digits_choose_environments_and_space_pauses(shared_window):
    window = shared_window
    for key, environment in window.studio.environments.items():
        press(window, environment.shortcut)
        assert window.studio.environment.key == key
    window.studio.choose("wall")
    press(window, Qt.Key.Key_Space)
    assert window.live.paused
    assert window.centre.time.paused
    assert window.header.pause.word.text() == "Resume"
    press(window, Qt.Key.Key_Space)
    assert not window.live.paused


def test_keys_are_silent_in_a_field(shared_window):
    window = shared_window
    box, field = window.panel.parameters.rows["stiffness"].box, QLineEdit(window)
    field.show()
    for widget in (box, field):
        widget.setFocus()
        for key in ("0", "1", "3", "f", "?", " "):
            widget.selectAll()
            QTest.keyClick(widget, key)
            assert widget is box or field.text() == key
            assert window.studio.environment.key == "wall"
            assert not window.live.paused
            assert sheets(window) == []
    field.deleteLater()


def test_space_never_presses_a_focused_button(shared_window):
    window = shared_window
    buttons = [
        window.gallery.rows["spring"],
        window.header.devices,
        window.header.stop,
        window.loop.fold,
        window.panel.title.help,
        window.panel.parameters.rows["damping_mode"].picker.button(1),
    ]
    clicks = []
    for button in buttons:
        button.pressed.connect(lambda: clicks.append(1))
        button.setFocus()
        before = window.live.paused
        QTest.keyClick(button, Qt.Key.Key_Space)
        assert window.live.paused != before
    assert clicks == []
    assert window.studio.environment.key == "wall"
    assert not window.studio.stopped
    assert not window.live.paused


def test_single_letter_keys_can_be_switched_off(shared_window):
    shared_window.actions_by_key.run("view.single_keys")
    press(shared_window, "1", " ")
    assert shared_window.studio.environment.key == "wall"
    assert not shared_window.live.paused
    press(shared_window, Qt.Key.Key_F1)
    assert len(sheets(shared_window)) == 1
    shared_window.actions_by_key.run("view.single_keys")
    press(shared_window, "1")
    assert shared_window.studio.environment.key == "spring"
    shared_window.studio.choose("wall")


def test_there_is_one_sheet_of_keys_at_a_time_and_it_names_every_key(shared_window):
    sheet = KeysDialog(TABLE, shared_window)
    words = " ".join(label.text() for label in sheet.findChildren(QLabel))
    for action in TABLE:
        assert all(action.text in words and native(key) in words for key in action.keys)
    for _ in range(3):
        shared_window.actions_by_key.run("help.keys")
    shared_window.actions_by_key.run("help.about")
    assert sorted(sheet.windowTitle() for sheet in sheets(shared_window)) == ["Hapkit Studio", "Keys"]


def test_the_time_window_is_set_from_menu_and_list_alike(shared_window):
    for seconds in SPANS:
        shared_window.actions_by_key.run(f"view.span.{seconds:g}")
        assert shared_window.centre.time.span == seconds
        assert shared_window.centre.toolbar.span.currentText() == f"{seconds:g} s"
        assert shared_window.actions_by_key.qt[f"view.span.{seconds:g}"].isChecked()


def test_every_action_runs_without_a_device(shared_window):
    """All but the tabs, whose pages take seconds: their own tests open them."""
    for action in TABLE:
        if action.key != "session.quit" and not action.key.startswith("view.tab"):
            shared_window.actions_by_key.run(action.key)
            assert shared_window.isVisible(), action.key


@pytest.mark.slow
@pytest.mark.parametrize("fixture", ["idle_window", "window"])
def test_every_action_and_every_tab_runs(request, fixture):
    window = request.getfixturevalue(fixture)
    for action in TABLE:
        if action.key not in ("session.quit", "device.reconnect"):
            window.actions_by_key.run(action.key)
    assert (window.studio.engine is not None) == (fixture == "window")
    assert window.isVisible()
