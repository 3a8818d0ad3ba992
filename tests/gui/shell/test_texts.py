"""The list of all texts in the window, for proofreading."""

import pytest
from PySide6.QtWidgets import QDialog, QLabel, QPushButton

from hapkit_studio.gui.shell import texts


def test_a_widgets_text_tooltip_and_accessible_name_are_listed_with_its_children(qtbot):
    dialog = QDialog()
    qtbot.addWidget(dialog)
    label = QLabel("<b>Shown</b> text", dialog)
    label.setToolTip("A tip")
    QPushButton("Press", dialog).setAccessibleName("A name")
    found = set(texts._of_widgets("dialog", dialog))
    wanted = {("dialog", "Shown text"), ("dialog, tooltip", "A tip"), ("dialog", "Press")}
    assert wanted | {("dialog, accessible name", "A name")} <= found


@pytest.mark.slow
def test_a_message_in_the_source_is_listed_with_its_file_and_placeholders():
    found = {words: place for place, words in texts.messages()}
    assert found["Release the handle here"].startswith("gui/")
    assert found["{does.capitalize()} when let go"].startswith("analysis/stability/")
    assert texts.messages.__doc__.splitlines()[0] not in found


@pytest.mark.slow
def test_the_command_lists_every_environment_and_view_once(capsys):
    from hapkit_studio.cli import main

    assert main(["texts"]) == 0
    lines = capsys.readouterr().out.splitlines()
    words = [line.partition(" | ")[2] for line in lines]
    assert len(words) == len(set(words))
    assert {"Wall", "Cat", "Z-width", "Sessions", "Trigger settings…", "Flash firmware"} <= set(words)
