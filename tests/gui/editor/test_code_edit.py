"""The text of a law: colours, indentation, line numbers, marks at their lines."""

import pytest
from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QRegion, QTextCursor
from PySide6.QtTest import QTest

from hapkit_studio.gui.editor.code_edit import KINDS, CodeEdit
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.palette import MODES, TOKENS, luminance


class Painted(QObject):
    """Keeps what is painted of a widget."""

    def __init__(self, widget):
        super().__init__(widget)
        self.regions = []
        widget.installEventFilter(self)

    def eventFilter(self, _widget, event):
        if event.type() == QEvent.Type.Paint:
            self.regions.append(QRegion(event.region()))
        return False


@pytest.fixture
def code(qtbot) -> CodeEdit:
    widget = CodeEdit()
    qtbot.addWidget(widget)
    widget.resize(640, 320)
    widget.show()
    qtbot.waitExposed(widget)
    return widget


def color_of(code: CodeEdit, word: str) -> str:
    """Return the colour a word's first letter is drawn in."""
    cursor = code.document().find(word)
    at = cursor.selectionStart() - cursor.block().position()
    for part in cursor.block().layout().formats():
        if part.start <= at < part.start + part.length:
            return part.format.foreground().color().name()
    return theme.color("ink").name()


@pytest.mark.parametrize("mode", range(len(MODES)))
def test_every_colour_can_be_read_on_every_ground(mode):
    for token in {token for token, _, _ in KINDS.values()} | {"ink", "danger"}:
        for ground in ("surface", "contact", "dangersoft"):
            lights = sorted(luminance(TOKENS[name][mode]) for name in (token, ground))
            assert (lights[1] + 0.05) / (lights[0] + 0.05) >= 4.5, (token, ground)


@pytest.mark.parametrize(
    ("text", "word", "token"),
    [
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
    ],
)
def test_words_have_the_colour_of_what_they_are(code, text, word, token):
    code.setPlainText(text)
    assert color_of(code, word) == theme.color(token).name()


def test_colours_follow_the_theme(code):
    code.setPlainText("return x")
    theme.set_mode("dark")
    assert color_of(code, "return") == TOKENS["asked"][1].lower()


def test_enter_keeps_the_depth_and_goes_deeper_after_a_colon(code):
    QTest.keyClicks(code, "if x > 0:  # in")
    QTest.keyClick(code, Qt.Key.Key_Return)
    QTest.keyClicks(code, "y = 1")
    QTest.keyClick(code, Qt.Key.Key_Return)
    QTest.keyClicks(code, "return y")
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


def test_home_goes_to_the_first_word_and_then_to_the_beginning(code):
    code.setPlainText("    word")
    code.moveCursor(QTextCursor.MoveOperation.End)
    QTest.keyClick(code, Qt.Key.Key_Home, Qt.KeyboardModifier.ShiftModifier)
    assert code.textCursor().selectedText() == "word"
    QTest.keyClick(code, Qt.Key.Key_Home)
    assert code.textCursor().position() == 0


def test_selected_lines_move_together_and_undo_at_once(code):
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


def test_other_words_at_the_same_line_are_drawn_at_once(code, qapp, qtbot):
    code.setPlainText("one\ntwo\nthree")
    code.mark([(2, "wrong")])
    qapp.processEvents()
    place = code.cursorRect(QTextCursor(code.document().findBlockByNumber(1))).center()
    painted = Painted(code.viewport())
    code.mark([(2, "still wrong, but otherwise")])
    qtbot.waitUntil(lambda: any(region.contains(place) for region in painted.regions))


@pytest.mark.parametrize("height", range(200, 216, 3))
@pytest.mark.parametrize("width", [300, 2000])
@pytest.mark.parametrize("top", [0, 20])
def test_no_line_is_cut_off_at_the_bottom(code, height, width, top):
    code.setPlainText("\n".join("█" * 60 for _ in range(60)))
    code.resize(width, height)
    assert code.horizontalScrollBar().isVisible() == (width == 300)
    code.verticalScrollBar().setValue(top)
    picture = code.viewport().grab().toImage()
    dark = [y for y in range(picture.height()) if picture.pixelColor(60, y).lightness() < 128]
    line = code.blockBoundingRect(code.firstVisibleBlock()).height()
    lines = int((code.viewport().height() - code.contentOffset().y()) // line)
    assert max(dark) < code.contentOffset().y() + lines * line
    assert max(dark) > code.contentOffset().y() + (lines - 1) * line


def test_a_line_gone_to_stays_in_sight_with_what_follows_it(code):
    code.setPlainText("\n".join(map(str, range(200))))
    code.go_to(30)
    for height in (900, 200):
        code.resize(640, height)
        above = 29 - code.firstVisibleBlock().blockNumber()
        line = code.blockBoundingRect(code.firstVisibleBlock()).height()
        assert above == int(0.25 * code.viewport().height() / line)
    code.moveCursor(QTextCursor.MoveOperation.End)
    code.resize(640, 400)
    assert code.viewport().rect().contains(code.cursorRect())


def test_line_numbers_have_room_for_the_last_one(code):
    code.setPlainText("\n" * 9)
    few = code.gutter.width()
    code.setPlainText("\n" * 12_000)
    assert code.gutter.wanted_width > few
    assert code.viewport().geometry().left() == code.gutter.wanted_width
