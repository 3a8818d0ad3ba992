"""The text of a law has colours, indentation, line numbers, and marks beside its lines."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QTextCursor
from PySide6.QtTest import QTest

from hapkit_studio.gui.editor.code_edit import KINDS, CodeEdit
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.palette import MODES, TOKENS, luminance


@pytest.fixture
def code(qtbot) -> CodeEdit:
    widget = CodeEdit()
    qtbot.addWidget(widget)
    widget.resize(640, 320)
    widget.show()
    qtbot.waitExposed(widget)
    return widget


def color_of(code: CodeEdit, word: str) -> str:
    """Return the colour of a word's first letter."""
    cursor = code.document().find(word)
    at = cursor.selectionStart() - cursor.block().position()
    for part in cursor.block().layout().formats():
        if part.start <= at < part.start + part.length:
            return part.format.foreground().color().name()
    return theme.color("ink").name()


def test_every_colour_is_readable_on_every_background():
    for mode in range(len(MODES)):
        for token in {token for token, _, _ in KINDS.values()} | {"ink", "danger"}:
            for ground in ("surface", "contact", "dangersoft"):
                lights = sorted(luminance(TOKENS[name][mode]) for name in (token, ground))
                assert (lights[1] + 0.05) / (lights[0] + 0.05) >= 4.5, (token, ground)


COLOURS = [
    ("return x", "return", "asked"),
    ("a = x * 2", "x", "position"),
    ("a = v * 2", "v", "velocity"),
    ("call(x=2)", "x=", "ink"),
    ("a = p.stiffness", "p.", "accent"),
    ("maximum = 1", "max", "ink"),
    ("a = 'x # v'  # why", "'x", "energy"),
    ("a = 'x # v'  # why", "# why", "ink3"),
    ('"""long\nreturn v\nend""" + x', "return", "energy"),
    ('"""long\nreturn v\nend""" + x', "x", "position"),
    ('a = """one""" + x', "x", "position"),
]


def test_words_have_the_colour_of_their_kind(code):
    for text, word, token in COLOURS:
        code.setPlainText(text)
        for mode in ("dark", "light"):
            theme.set_mode(mode)
            assert color_of(code, word) == theme.color(token).name(), text


def test_enter_keeps_the_depth_and_goes_deeper_after_a_colon(code):
    for line in ("if x > 0:  # in", "y = 1", "return y"):
        QTest.keyClicks(code, line)
        QTest.keyClick(code, Qt.Key.Key_Return)
    QTest.keyClicks(code, "z")
    assert code.toPlainText() == "if x > 0:  # in\n    y = 1\n    return y\nz"


def test_tab_is_four_spaces_and_backspace_takes_them_back(code):
    QTest.keyClicks(code, "ab")
    QTest.keyClick(code, Qt.Key.Key_Tab)
    assert code.toPlainText() == "ab  "
    code.setPlainText("")
    QTest.keyClick(code, Qt.Key.Key_Tab)
    QTest.keyClick(code, Qt.Key.Key_Tab)
    assert code.toPlainText() == " " * 8
    QTest.keyClick(code, Qt.Key.Key_Backspace)
    assert code.toPlainText() == " " * 4


def test_selected_lines_move_together_in_one_undo_step(code):
    code.setPlainText("a\n\nb\nc")
    cursor = code.textCursor()
    cursor.setPosition(0)
    cursor.setPosition(4, QTextCursor.MoveMode.KeepAnchor)
    code.setTextCursor(cursor)
    QTest.keyClick(code, Qt.Key.Key_Tab)
    assert code.toPlainText() == "    a\n\n    b\nc"
    QTest.keyClick(code, Qt.Key.Key_Backtab)
    assert code.toPlainText() == "a\n\nb\nc"
    code.undo()
    assert code.toPlainText() == "    a\n\n    b\nc"


def test_a_mark_follows_its_line(code):
    code.setPlainText("one\ntwo\nthree")
    code.mark([(2, "wrong"), (99, "beyond"), (0, "nowhere")])
    assert code.marks == {2: "wrong", 3: "beyond"}
    code.moveCursor(QTextCursor.MoveOperation.Start)
    QTest.keyClick(code, Qt.Key.Key_Return)
    assert code.marks == {3: "wrong", 4: "beyond"}
    code.mark(())
    assert code.marks == {}


def test_a_mark_is_removed_only_when_its_line_changes(code):
    code.setPlainText("one\ntwo\nthree")
    code.mark([(1, "wrong"), (3, "wrong too")])
    code.go_to(2)
    QTest.keyClicks(code, "x")
    assert code.marks == {1: "wrong", 3: "wrong too"}
    code.go_to(3)
    QTest.keyClicks(code, "x")
    assert code.marks == {1: "wrong"}
    assert len([s for s in code.extraSelections() if s.format.background() == theme.color("dangersoft")]) == 1


def test_a_mark_is_drawn_with_its_words_and_a_sign(code):
    code.setPlainText("one\ntwo\nthree")
    plain, numbers = code.viewport().grab().toImage(), code.gutter.grab().toImage()
    code.mark([(2, "wrong")])
    marked, signed = code.viewport().grab().toImage(), code.gutter.grab().toImage()
    row = int(code.cursorRect(QTextCursor(code.document().findBlockByNumber(1))).center().y())
    danger, ground = theme.color("danger"), theme.color("dangersoft").name()
    beside = [marked.pixelColor(x, y) for x in range(60, 140) for y in range(row - 8, row + 8)]
    assert marked.pixelColor(marked.width() - 3, row).name() == ground
    assert any(abs(c.red() - danger.red()) + abs(c.green() - danger.green()) < 60 for c in beside)
    assert signed != numbers
    assert plain.copy(0, 0, 300, 10) == marked.copy(0, 0, 300, 10)


def test_go_to_scrolls_to_the_line_and_its_number(code):
    code.setPlainText("\n".join(map(str, range(12_000))))
    assert code.viewport().geometry().left() == code.gutter.wanted_width == code.gutter.width()
    code.go_to(9000)
    assert code.textCursor().blockNumber() == 8999
    code.resize(640, 200)
    assert code.viewport().rect().contains(code.cursorRect())
    code.moveCursor(QTextCursor.MoveOperation.End)
    code.scroll_to(5)
    assert code.textCursor().blockNumber() == 4
