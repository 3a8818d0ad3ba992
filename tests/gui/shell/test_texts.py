"""The list of all texts in the window, for proofreading."""

import ast
from types import SimpleNamespace

import pytest
from PySide6.QtWidgets import QCheckBox, QDialog, QLabel, QPushButton, QTableWidget

from hapkit_studio.gui.panel.parameter_panel import ParameterPanel
from hapkit_studio.gui.shell import source_texts, texts
from hapkit_studio.gui.shell.texts import Text


def test_every_text_of_a_dialog_is_listed_with_its_kind(qtbot):
    dialog = QDialog()
    qtbot.addWidget(dialog)
    QLabel("<b>Shown</b> text", dialog).setToolTip("A tip")
    QPushButton("Press", dialog).setAccessibleName("A name")
    QCheckBox("Force as felt", dialog)
    QTableWidget(0, 1, dialog).setHorizontalHeaderLabels(["Applied force"])
    found = {(text.place, text.text) for text in texts.shown(texts.of_widgets(dialog, "dialog Lock"))}
    assert found == {
        ("dialog Lock: label", "Shown text"),
        ("dialog Lock: tooltip", "A tip"),
        ("dialog Lock: button", "Press"),
        ("dialog Lock: name for a screen reader", "A name"),
        ("dialog Lock: check box", "Force as felt"),
        ("dialog Lock: column heading", "Applied force"),
    }


@pytest.mark.parametrize(
    "text",
    [
        "Ctrl+Shift+O",
        "Page Up, Page Down",
        "0.00 mm",
        "30 min",
        "N·s/m",
        "/usr/bin/avrdude",
        "—",
        "F = −k d in the wall",
    ],
)
def test_a_key_a_value_a_unit_and_a_path_are_no_texts(text):
    assert not texts.shown([Text("panel: label", text, "")])


@pytest.mark.parametrize(
    "message", ["Hold", "Spring", "Trial 3 of 12", "Servo rate in Hz", "Home position", "Drag: virtual hand"]
)
def test_a_label_of_one_word_or_with_a_number_is_a_text(message):
    assert [text.text for text in texts.shown([Text("panel: label", message, "")])] == [message]


def test_a_tooltip_or_screen_reader_name_that_repeats_visible_texts_is_left_out():
    shown = texts.shown(
        [
            Text("panel: label", "Grip", ""),
            Text("panel: choice", "Medium", ""),
            Text("panel: name for a screen reader", "Grip, Medium", ""),
            Text("panel: name for a screen reader", "Grip: 3.5 N/m", ""),
            Text("panel: label", "Cutoff fc", ""),
            Text("panel: name for a screen reader", "Cutoff, 35.5 Hz", ""),
            Text("panel: name for a screen reader", "Plot of the grip's force", ""),
            Text("menu: command", "Save a copy…", ""),
            Text("menu: tooltip", "Save a copy", ""),
            Text("panel: tooltip", "Back to 35.5 Hz", ""),
            Text("panel: tooltip", "Back to 1,000 Hz", ""),
        ]
    )
    assert [text.text for text in shown] == [
        "Grip",
        "Medium",
        "Cutoff fc",
        "Plot of the grip's force",
        "Save a copy…",
        "Back to 35.5 Hz",
    ]


@pytest.mark.parametrize(
    "text",
    [
        "SELECT name FROM sqlite_master",
        "SELECT {columns}, crc FROM chunk WHERE id = ?",
        "'(?:Parameter|Choice)' object is not iterable",
        "sudo udevadm trigger",
        "constexpr struct {name} {",
        "runs half a step ahead, which",
        ", held by the motor",
        "Counts grow to the",
        "The velocity estimator",
        "{name}: {value} {unit}",
        "lower left",
        "Session (*.hks)",
        "Clamped",
    ],
)
def test_code_and_pieces_of_texts_are_no_messages(text):
    assert not source_texts.is_message(text)
    assert not source_texts.is_message(text, law=True)


@pytest.mark.parametrize(
    "text", ["Nothing was changed.", "{port} does not exist. Plug it in.", "vibration, Hz"]
)
def test_a_sentence_and_a_label_of_an_axis_are_messages(text):
    assert source_texts.is_message(text)


def test_values_are_shown_by_name_and_constants_as_they_appear():
    module = SimpleNamespace(LIMIT=0.4)
    code = """f"{name.title()} moved {number(1e3 * self.travel, 1)} m{'m' if m else ''}, max {LIMIT:.2f}" """
    node = ast.parse(code).body[0].value
    assert source_texts._text(node, module) == "{name} moved {travel} mm, max 0.40"


def test_docstrings_assertions_annotations_and_comparisons_are_not_shown():
    code = '''
def f(x: "A type of value") -> "A type of result":
    """A text for developers."""
    assert x, "An assertion failed."
    if x == "A stored value":
        raise TypeError("A programming error.")
    return f"A message of {x} words."
'''
    tree = ast.parse(code)
    silent = {id(part) for node in ast.walk(tree) for part in source_texts._silent(node)}
    constants = [node for node in ast.walk(tree) if isinstance(node, ast.Constant | ast.JoinedStr)]
    assert [source_texts._text(node, None) for node in constants if id(node) not in silent] == [
        "A message of {x} words."
    ]


def test_the_place_is_where_a_student_sees_the_text(qtbot):
    assert texts._place("gui/pages/accuracy") == "Speed and accuracy view"
    assert texts._place("analysis/failures/bounce") == "Break it view"
    assert texts._place("gui/widgets/parts") == ""
    assert (
        texts._place(ParameterPanel.__module__.removeprefix("hapkit_studio.").replace(".", "/"))
        == "panel of settings"
    )


@pytest.mark.slow
def test_the_command_lists_every_environment_view_and_message_once(capsys):
    from hapkit_studio.cli import main

    assert main(["texts"]) == 0
    lines = capsys.readouterr().out.splitlines()
    listed = [line.partition(" | ")[2] for line in lines]
    assert len(listed) == len(set(listed))
    assert {"Wall", "Cat", "Z-width", "Sessions", "Trigger settings…", "Flash firmware"} <= set(listed)
    assert "Nothing was changed. Check geometry, motor constant and force limit." in " ".join(listed)
    assert texts.texts.__doc__ not in listed
    assert not [line for line in lines if line.startswith(("gui/", ":"))]
