"""Ctrl+K finds and runs every action; F1 shows every key and explains the terms of the window."""

import re

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel

from hapkit_studio.gui.shell.action_set import matches, native
from hapkit_studio.gui.shell.command_palette import CommandPalette
from hapkit_studio.gui.shell.window_dialogs import KeysDialog
from hapkit_studio.gui.widgets.glossary import WORDS


@pytest.fixture
def shown(reset_idle_window):
    """Return this test file's window in its initial state."""
    return reset_idle_window


@pytest.fixture
def palette(shown):
    """Return the palette, opened over this test file's window with Ctrl+K."""
    shown.centre.scene.setFocus()
    QTest.keyClick(shown.centre.scene, Qt.Key.Key_K, Qt.KeyboardModifier.ControlModifier)
    (palette,) = opened(shown)
    return palette


def opened(window):
    return [palette for palette in window.findChildren(CommandPalette) if palette.isVisible()]


def rows(palette):
    """Return the texts of all visible rows."""
    shown = (row for row in range(palette.rows.rowCount()) if not palette.list.isRowHidden(row))
    return [[palette.rows.item(row, column).text() for column in range(3)] for row in shown]


@pytest.mark.parametrize(
    ("sought", "text", "found"),
    [
        ("", "Wall", True),
        ("pau pic", "Pause the picture", True),
        ("picture PAUSE", "Pause the picture", True),
        ("theme dark", "Dark View › Theme", True),
        ("wndw", "Time window", True),
        ("pause wall", "Pause the picture", False),
        ("ip", "Pause the picture", False),  # the letters of a word in the wrong order
        ("(", "Pause the picture", False),
    ],
)
def test_search_matches_whole_words_parts_and_letters_in_order(sought, text, found):
    assert bool(matches(sought, text)) == found


def test_every_action_is_listed_once_with_its_menu_and_keys(shown, palette):
    entries = shown.actions_by_key.entries
    assert [(menu, keys) for _, menu, keys in rows(palette)] == [
        (entry.menu.replace("/", " › "), ", ".join(native(key) for key in entry.keys)) for entry in entries
    ]


def test_enter_runs_the_first_enabled_action(shown, palette):
    QTest.keyClicks(palette.field, "spr")
    assert rows(palette)[0][0] == "Spring"
    QTest.keyClick(palette.field, Qt.Key.Key_Return)
    assert shown.studio.environment.key == "spring"
    assert not opened(shown)


def test_a_disabled_action_is_grey_and_is_not_run(shown, palette):
    """The window has no device, so the position cannot be set to zero."""
    QTest.keyClicks(palette.field, "zero here")
    ((text, _, _),) = rows(palette)
    assert text == "Set zero here"
    assert not palette.list.currentIndex().isValid()
    QTest.keyClick(palette.field, Qt.Key.Key_Return)
    assert palette.isVisible()


def test_arrow_keys_skip_disabled_actions(palette):
    QTest.keyClicks(palette.field, "session")
    first = palette.list.currentIndex().data()
    QTest.keyClick(palette.field, Qt.Key.Key_Down)
    assert (first, palette.list.currentIndex().data()) == ("E-stop", "Pause the picture")


def test_the_palette_does_not_cover_the_stop_button_in_the_smallest_window(shown):
    shown.resize(shown.minimumSize())
    shown.show_commands()
    (palette,) = opened(shown)
    stop = shown.header.stop
    top = stop.mapToGlobal(stop.rect().topLeft())
    assert not palette.geometry().intersects(stop.rect().translated(top))


@pytest.mark.slow
def test_the_palette_is_opened_from_the_right_end_of_the_menu_bar(shown):
    bar = shown.menuBar()
    button = bar.cornerWidget()
    assert button.isVisible()
    labels = [part.text() for part in button.findChildren(QLabel)]
    assert labels == ["Find a command", "Ctrl+K"]


@pytest.mark.slow
def test_every_term_is_explained_in_two_sentences():
    for word, explained in WORDS.items():
        sentences = re.split(r"(?<=[a-z])\.(?: |$)", explained)[:-1]
        assert len(sentences) == 2, word
        assert max(map(len, sentences)) < 130, word
    for needed in ("Passivity", "Added delay", "Kalman", "Z-width", "Impedance", "Quantization", "Stable"):
        assert needed in WORDS


@pytest.mark.slow
def test_the_key_sheet_can_be_searched_and_hides_empty_groups(shown):
    sheet = KeysDialog(shown.actions_by_key.entries, shown)
    sheet.show()

    def seen():
        return [part.text() for part in sheet._body.findChildren(QLabel) if part.isVisible()]

    everything = len(seen())
    sheet.field.setText("words passivity energy")
    assert [text for text in seen() if text in ("Session", "View", "Words")] == ["Words"]
    assert "Passivity" in seen()
    assert "Kalman" not in seen()
    sheet.field.setText("undo")
    assert seen() == ["Edit", "Undo", "Ctrl+Z"]
    sheet.field.clear()
    assert len(seen()) == everything
    sheet.close()
