"""The action table: every key is unique, every action runs, and text fields receive their letters."""

from collections import Counter

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel, QLineEdit

from hapkit_studio.environments import discover
from hapkit_studio.gui.live.time_view import SPANS
from hapkit_studio.gui.shell.action_set import native
from hapkit_studio.gui.shell.actions import table
from hapkit_studio.gui.shell.window_dialogs import KeysDialog
from tests.gui.window_support import sheets

TABLE = table(discover().values())


def press(window, *keys):
    """Press keys while the scene has the focus."""
    window.centre.scene.setFocus()
    for key in keys:
        QTest.keyClick(window.focusWidget() or window, key)


@pytest.fixture
def shown(reset_idle_window):
    """Return this test file's window in its initial state."""
    return reset_idle_window


def menu_actions(menu):
    for action in menu.actions():
        if action.menu() is not None:
            yield from menu_actions(action.menu())
        elif not action.isSeparator():
            yield action


def test_no_two_actions_have_the_same_key():
    portable = [QKeySequence(key).toString() for action in TABLE for key in action.keys]
    assert all(portable)
    for once in (portable, [action.key for action in TABLE]):
        assert [key for key, times in Counter(once).items() if times > 1] == []


def test_every_action_is_in_a_menu(shown):
    listed = {id(action) for action in menu_actions(shown.menuBar())}
    assert {id(action) for action in shown.actions_by_key.qt.values()} <= listed


@pytest.mark.slow
def test_digits_choose_environments_and_space_pauses(shown):
    for key, environment in shown.studio.environments.items():
        press(shown, environment.shortcut)
        assert shown.studio.environment.key == key
    shown.studio.choose("wall")
    press(shown, Qt.Key.Key_Space)
    assert shown.live.paused
    assert shown.centre.view.paused
    assert shown.header.pause.word.text() == "Resume"
    press(shown, Qt.Key.Key_Space)
    assert not shown.live.paused


def test_action_keys_are_ignored_in_a_text_field(shown):
    box, field = shown.panel.parameters.rows["stiffness"].box, QLineEdit(shown)
    field.show()
    for widget in (box, field):
        widget.setFocus()
        for key in ("0", "1", "3", "f", "?", " "):
            widget.selectAll()
            QTest.keyClick(widget, key)
            assert widget is box or field.text() == key
            assert shown.studio.environment.key == "wall"
            assert not shown.live.paused
            assert sheets(shown) == []
    field.deleteLater()


def test_space_never_presses_a_focused_button(shown):
    buttons = [
        shown.gallery.rows["spring"],
        shown.header.devices,
        shown.header.stop,
        shown.loop.fold,
        shown.panel.title.help,
        shown.panel.parameters.rows["side"].picker.button(1),
    ]
    clicks = []
    for button in buttons:
        button.pressed.connect(lambda: clicks.append(1))
        button.setFocus()
        before = shown.live.paused
        QTest.keyClick(button, Qt.Key.Key_Space)
        assert shown.live.paused != before
    assert clicks == []
    assert shown.studio.environment.key == "wall"
    assert not shown.studio.stopped
    assert not shown.live.paused


def test_single_letter_keys_can_be_switched_off(shown):
    shown.actions_by_key.run("view.single_keys")
    press(shown, "1", " ")
    assert shown.studio.environment.key == "wall"
    assert not shown.live.paused
    press(shown, Qt.Key.Key_F1)
    assert len(sheets(shown)) == 1
    shown.actions_by_key.run("view.single_keys")
    press(shown, "1")
    assert shown.studio.environment.key == "spring"


@pytest.mark.slow
def test_the_key_sheet_opens_once_and_lists_every_key(shown):
    sheet = KeysDialog(TABLE, shown)
    text = " ".join(label.text() for label in sheet.findChildren(QLabel))
    for action in TABLE:
        assert all(action.text in text and native(key) in text for key in action.keys)
    for _ in range(3):
        shown.actions_by_key.run("help.keys")
    shown.actions_by_key.run("help.about")
    assert sorted(sheet.windowTitle() for sheet in sheets(shown)) == ["Hapkit Studio", "Keys and glossary"]


def test_the_time_window_is_set_from_menu_and_list(shown):
    for seconds in SPANS:
        shown.actions_by_key.run(f"view.span.{seconds:g}")
        assert shown.centre.view.span == seconds
        assert shown.centre.toolbar.span.currentText() == f"{seconds:g} s"
        assert shown.actions_by_key.qt[f"view.span.{seconds:g}"].isChecked()


@pytest.mark.slow
def test_every_action_runs_without_a_device(shown):
    """The tab actions are excluded: their pages take seconds and have their own tests."""
    for action in TABLE:
        if action.key != "session.quit" and not action.key.startswith("view.tab"):
            shown.actions_by_key.run(action.key)
            assert shown.isVisible(), action.key


@pytest.mark.slow
@pytest.mark.parametrize("fixture", ["idle_window", "window"])
def test_every_action_and_every_tab_runs(request, fixture):
    window = request.getfixturevalue(fixture)
    for action in TABLE:
        if action.key not in ("session.quit", "device.reconnect"):
            window.actions_by_key.run(action.key)
    assert (window.studio.engine is not None) == (fixture == "window")
    assert window.isVisible()
