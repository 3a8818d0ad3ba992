"""The action table: every key once, every action runs, keys are silent where a person types."""

from collections import Counter

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel, QLineEdit

from hapkit_studio.environments import discover
from hapkit_studio.gui.actions import table
from hapkit_studio.gui.dialogs import TextDialog, keys_dialog, native
from hapkit_studio.gui.live.time_plots import SPANS

TABLE = table(discover().values())


def menu_actions(menu):
    for action in menu.actions():
        if action.menu() is not None:
            yield from menu_actions(action.menu())
        elif not action.isSeparator():
            yield action


def test_no_key_stands_on_two_actions():
    portable = [QKeySequence(key).toString() for action in TABLE for key in action.keys]
    assert all(portable)
    assert [key for key, times in Counter(portable).items() if times > 1] == []
    keys = [action.key for action in TABLE]
    assert len(keys) == len(set(keys))


def test_every_action_stands_in_a_menu(idle_window):
    bar = idle_window.menuBar()
    shown = {id(action) for action in menu_actions(bar)}
    assert {id(action) for action in idle_window.actions_by_key.qt.values()} <= shown


def test_every_action_runs_without_a_device(idle_window):
    for action in TABLE:
        if action.key != "session.quit":
            idle_window.actions_by_key.run(action.key)
            assert idle_window.isVisible(), action.key


@pytest.mark.slow
def test_every_action_runs_with_a_device(window):
    for action in TABLE:
        if action.key not in ("session.quit", "device.reconnect"):
            window.actions_by_key.run(action.key)
    assert window.studio.engine is not None
    assert window.isVisible()


def test_digits_choose_environments(idle_window):
    idle_window.centre.scene.setFocus()
    for key, environment in idle_window.studio.environments.items():
        QTest.keyClick(idle_window.focusWidget() or idle_window, environment.shortcut)
        assert idle_window.studio.environment.key == key


def test_space_pauses_and_resumes(idle_window):
    idle_window.centre.scene.setFocus()
    QTest.keyClick(idle_window.focusWidget() or idle_window, Qt.Key.Key_Space)
    assert idle_window.live.paused
    assert idle_window.centre.time.paused
    assert idle_window.header.pause.word.text() == "Resume"
    QTest.keyClick(idle_window.focusWidget() or idle_window, Qt.Key.Key_Space)
    assert not idle_window.live.paused


def test_keys_are_silent_in_a_field(idle_window):
    box, field = idle_window.panel.parameters.rows["stiffness"].box, QLineEdit(idle_window)
    field.show()
    for widget in (box, field):
        widget.setFocus()
        for key in ("0", "1", "3", "f", "?", " "):
            widget.selectAll()
            QTest.keyClick(widget, key)
            assert widget is box or field.text() == key
            assert idle_window.studio.environment.key == "wall"
            assert not idle_window.live.paused
            assert idle_window.findChildren(TextDialog) == []


def test_space_never_presses_a_focused_button(idle_window):
    window = idle_window
    buttons = [
        window.gallery.rows["spring"],
        window.header.devices,
        window.header.stop,
        window.loop.fold,
        window.panel.title.help,
        window.panel.parameters.rows["damping_mode"].picker.button(1),
    ]
    for button in buttons:
        clicks = []
        button.pressed.connect(lambda clicks=clicks: clicks.append(1))
        button.setFocus()
        before = window.live.paused
        QTest.keyClick(button, Qt.Key.Key_Space)
        assert clicks == []
        assert window.live.paused != before
    assert window.studio.environment.key == "wall"
    assert not window.studio.stopped


def test_single_letter_keys_can_be_switched_off(idle_window):
    idle_window.actions_by_key.run("view.single_keys")
    idle_window.centre.scene.setFocus()
    for key in ("1", " "):
        QTest.keyClick(idle_window.focusWidget() or idle_window, key)
    assert idle_window.studio.environment.key == "wall"
    assert not idle_window.live.paused
    QTest.keyClick(idle_window.focusWidget() or idle_window, Qt.Key.Key_F1)
    assert len(idle_window.findChildren(TextDialog)) == 1


def test_the_sheet_of_keys_names_every_key(idle_window):
    sheet = keys_dialog(TABLE, idle_window)
    words = " ".join(label.text() for label in sheet.findChildren(QLabel))
    for action in TABLE:
        assert all(action.text in words and native(key) in words for key in action.keys)


def test_one_sheet_of_keys_at_a_time(idle_window):
    for _ in range(3):
        idle_window.actions_by_key.run("help.keys")
    idle_window.actions_by_key.run("help.about")
    shown = [sheet.windowTitle() for sheet in idle_window.findChildren(TextDialog) if sheet.isVisible()]
    assert sorted(shown) == ["Hapkit Studio", "Keys"]


def test_the_time_window_is_set_from_menu_and_list_alike(idle_window):
    for seconds in SPANS:
        idle_window.actions_by_key.run(f"view.span.{seconds:g}")
        assert idle_window.centre.time.span == seconds
        assert idle_window.centre.toolbar.span.currentText() == f"{seconds:g} s"
        assert idle_window.actions_by_key.qt[f"view.span.{seconds:g}"].isChecked()


@pytest.mark.slow
def test_themes_recolour_at_once(idle_window):
    from hapkit_studio.gui.widgets.theme import theme

    for mode in ("dark", "contrast", "light"):
        idle_window.actions_by_key.run(f"view.theme.{mode}")
        side = theme.color("side").name()
        assert idle_window.header.grab().toImage().pixelColor(3, 10).name() == side
