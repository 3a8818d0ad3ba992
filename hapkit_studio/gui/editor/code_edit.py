"""The text editor of a law: line numbers, colours, indentation, and messages at the lines with problems."""

import keyword
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from PySide6 import QtGui
from PySide6.QtCore import QPointF, QRect, QRectF, Qt
from PySide6.QtGui import QFont, QFontDatabase, QFontMetrics, QPainter, QTextCharFormat, QTextCursor
from PySide6.QtWidgets import QPlainTextEdit, QTextEdit, QWidget

from hapkit_studio.gui.widgets.theme import theme

STEP = 4
_LEAVES = re.compile(r"\s*(return|break|continue|pass|raise)\b")
_OPENS = re.compile(r".*:\s*(#.*)?$")
# colour token, weight and italics of each kind of word
KINDS = {
    "keyword": ("asked", 600, False),
    "comment": ("ink3", 400, True),
    "string": ("energy", 400, False),
    "decorator": ("asked", 400, False),
    "defined": ("ink", 600, False),
    "position": ("position", 600, False),
    "velocity": ("velocity", 600, False),
    "owned": ("accent", 400, False),
}
_QUANTITIES = {"x": "position", "v": "velocity"}
_WORDS = re.compile(
    r"""
    (?P<comment>\#.*)
    | (?P<triple>[rRbBuUfF]{0,2}(?:\"{3}|'{3}))
    | (?P<string>[rRbBuUfF]{0,2}(?:"(?:\\.|[^"\\])*"?|'(?:\\.|[^'\\])*'?))
    | (?P<decorator>@[\w.]+)
    | (?P<defined>(?<=\bdef\s)\w+)
    | (?P<owned>(?<![\w.])[ps]\.\w+)
    | (?P<name>(?<![\w.])[A-Za-z_]\w*)
    """,
    re.VERBOSE,
)
_PLAIN, _QUOTES = -1, ('"""', "'''")
_SIGN, _SIDE = 16, 8
_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
_LEAST_DIGITS = 3
_FIGURE = "99,999"
PIXELS = 13
_GAP = 28
_LEAST_WORDS = 90


def _depth(text: str) -> int:
    return len(text) - len(text.lstrip(" "))


def newline(cursor: QTextCursor) -> None:
    """Break the line and indent the next line: more after a colon, less after ``return``."""
    before = cursor.block().text()[: cursor.positionInBlock()]
    deeper = STEP if _OPENS.match(before) else -STEP if _LEAVES.match(before) else 0
    cursor.insertText("\n" + " " * (_depth(before) + deeper))


def indent(cursor: QTextCursor) -> None:
    """Indent the selected lines by one step, or fill the current line with spaces up to the next step."""
    if cursor.hasSelection():
        _shift_lines(cursor, STEP)
    else:
        cursor.insertText(" " * (STEP - cursor.positionInBlock() % STEP))


def backspace(cursor: QTextCursor) -> bool:
    """Delete one indentation step if only spaces precede the cursor; return True if this was done."""
    place = cursor.positionInBlock()
    if cursor.hasSelection() or place == 0 or cursor.block().text()[:place].strip(" "):
        return False
    back = (place - 1) % STEP + 1
    cursor.movePosition(QTextCursor.MoveOperation.Left, QTextCursor.MoveMode.KeepAnchor, back)
    cursor.removeSelectedText()
    return True


def _shift_lines(cursor: QTextCursor, steps: int) -> None:
    """Indent the selected lines by ``steps`` spaces (negative: unindent) as one undo step."""
    document = cursor.document()
    first, last = document.findBlock(cursor.selectionStart()), document.findBlock(cursor.selectionEnd())
    if last != first and cursor.selectionEnd() == last.position():
        last = last.previous()
    cursor.beginEditBlock()
    for number in range(first.blockNumber(), last.blockNumber() + 1):
        line = QTextCursor(document.findBlockByNumber(number))
        text = line.block().text()
        if steps > 0 and text.strip():
            line.insertText(" " * steps)
        for _ in range(min(-steps, _depth(text))):
            line.deleteChar()
    cursor.endEditBlock()


class Highlighter(QtGui.QSyntaxHighlighter):
    """A syntax highlighter in the theme's colours."""

    def __init__(self, document: QtGui.QTextDocument):
        super().__init__(document)
        self._formats: dict[str, QTextCharFormat] = {}
        theme.changed.connect(self._recolour)
        self._recolour()

    def highlightBlock(self, text: str) -> None:
        """Colour one line; the block's state is the triple quote that is still open at its end."""
        self.setCurrentBlockState(_PLAIN)
        at = 0
        if self.previousBlockState() in (0, 1):
            at = self._inside(text, 0, 0, self.previousBlockState())
        while match := _WORDS.search(text, at):
            at = match.end()
            if match.lastgroup == "triple":
                at = self._inside(text, match.start(), at, _QUOTES.index(match[0][-3:]))
            else:
                self._colour(match, text)

    def _inside(self, text: str, start: int, at: int, quote: int) -> int:
        """Colour a multi-line string up to its closing quotes or the line's end.

        Return the end's position.
        """
        end = text.find(_QUOTES[quote], at)
        if end < 0:
            self.setCurrentBlockState(quote)
        stop = len(text) if end < 0 else end + 3
        self.setFormat(start, stop - start, self._formats["string"])
        return stop

    def _colour(self, match: re.Match[str], text: str) -> None:
        kind = match.lastgroup or ""
        if kind == "name":
            word = match[0]
            # a keyword argument named x does not refer to the position x
            named = re.match(r"\s*=(?!=)", text[match.end() :])
            kind = "keyword" if keyword.iskeyword(word) else "" if named else _QUANTITIES.get(word, "")
        if kind:
            self.setFormat(match.start(), match.end() - match.start(), self._formats[kind])

    def _recolour(self) -> None:
        for kind, (token, weight, italic) in KINDS.items():
            form = self._formats[kind] = QTextCharFormat()
            form.setForeground(theme.color(token))
            form.setFontWeight(QFont.Weight(weight))
            form.setFontItalic(italic)
        self.rehighlight()


class Gutter(QWidget):
    """Shows line numbers, and a column with a count for each line; both scroll with the text."""

    def __init__(self, code: "CodeEdit"):
        super().__init__(code)
        self._code = code
        theme.changed.connect(self.update)

    @property
    def wanted_width(self) -> int:
        """Return the width that the last line's number and the column of counts need."""
        column = 2 * _SIDE + QFontMetrics(self._code.font()).horizontalAdvance(_FIGURE)
        return self._numbers + (0 if self._code.counts is None else column)

    @property
    def _numbers(self) -> int:
        digits = max(_LEAST_DIGITS, len(str(self._code.blockCount())))
        return _SIGN + _SIDE + digits * QFontMetrics(self._code.font()).horizontalAdvance("0")

    def follow(self, rect: QRect, dy: int) -> None:
        """Scroll by ``dy`` px together with the text; if ``dy`` is 0, repaint the part beside ``rect``."""
        if dy:
            self.scroll(0, dy)
        else:
            self.update(0, rect.y(), self.width(), rect.height())

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        painter = QPainter(self)
        painter.fillRect(event.rect(), theme.color("side"))
        painter.setFont(self._code.font())
        current, marks = self._code.textCursor().blockNumber(), self._code.marks
        counts = self._code.counts or {}
        most = max(counts.values(), default=0.0)
        block = self._code.firstVisibleBlock()
        while block.isValid():
            place = self._code.box(block)
            if place.top() > event.rect().bottom():
                return
            box = QRectF(0, place.top(), self.width(), place.height())
            number = block.blockNumber()
            self._paint_line(painter, box, number + 1, number == current, number + 1 in marks)
            if most > 0.0 and number + 1 in counts:
                self._paint_figure(painter, box, counts[number + 1], most)
            block = block.next()

    def _paint_figure(self, painter: QPainter, box: QRectF, value: float, most: float) -> None:
        """Paint a line's count, and behind it a bar whose length is proportional to the count."""
        column = box.adjusted(self._numbers, 0, -_SIDE, 0)
        bar = column.adjusted(column.width() * (1.0 - value / most), 1, _SIDE / 2, -1)
        painter.fillRect(bar, theme.color("accentsoft"))
        painter.setPen(theme.color("ink"))
        painter.drawText(column, _RIGHT, f"{value:,.0f}")

    def _paint_line(self, painter: QPainter, box: QRectF, number: int, current: bool, marked: bool) -> None:
        box = QRectF(box.left(), box.top(), self._numbers, box.height())
        if marked:
            painter.fillRect(box, theme.color("dangersoft"))
        painter.setPen(theme.color("danger" if marked else "ink" if current else "ink3"))
        painter.drawText(box.adjusted(2, 0, -_SIDE, 0), _LEFT, "✕" if marked else "")
        painter.drawText(box.adjusted(0, 0, -_SIDE, 0), _RIGHT, str(number))


def code_font() -> QFont:
    """Return the system's fixed-width font."""
    font = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)
    font.setPixelSize(PIXELS)
    return font


_Note = tuple[QTextCursor, str, Any]
"""A note on a line: a cursor in the line, the line's text at that time, and the message or figure."""


def _note(block: QtGui.QTextBlock, content: Any) -> _Note:
    return QTextCursor(block), block.text(), content


def _unchanged(notes: Iterable[_Note]) -> Iterator[tuple[QtGui.QTextBlock, Any]]:
    """Yield the lines whose text has not changed, with their notes."""
    return ((cursor.block(), content) for cursor, text, content in notes if cursor.block().text() == text)


class CodeEdit(QPlainTextEdit):
    """A plain-text editor with marks and remarks by line (from 1); they disappear when the line changes."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self._marks: list[_Note] = []
        self._remarks: list[_Note] = []
        self._counts: list[_Note] | None = None
        self.setObjectName("code")
        self.setFrameShape(QPlainTextEdit.Shape.NoFrame)
        self.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        self.setFont(code_font())
        self.setTabStopDistance(STEP * QFontMetrics(code_font()).horizontalAdvance(" "))
        self.highlighter = Highlighter(self.document())
        self.gutter = Gutter(self)
        self.blockCountChanged.connect(self._place_gutter)
        self.updateRequest.connect(self.gutter.follow)
        self.textChanged.connect(self._show_lines)
        self.cursorPositionChanged.connect(self._show_lines)
        theme.changed.connect(self._show_lines)
        self._place_gutter()
        self._show_lines()

    # marks

    @property
    def marks(self) -> dict[int, str]:
        """Return the problems by current line number, from 1."""
        return {block.blockNumber() + 1: note for block, note in _unchanged(self._marks)}

    @property
    def remarks(self) -> dict[int, str]:
        """Return the remarks by line, as in ``marks``."""
        return {block.blockNumber() + 1: note for block, note in _unchanged(self._remarks)}

    def mark(self, problems: Iterable[tuple[int, str]], remarks: Iterable[tuple[int, str]] = ()) -> None:
        """Replace all marks. A line after the end of the text means its last line; line 0 marks no line."""
        self._marks, self._remarks = (
            [_note(self.block(line), note) for line, note in given if line > 0]
            for given in (problems, remarks)
        )
        self._show_lines()
        self.viewport().update()  # repaint, as a message may change although the coloured lines do not
        self.gutter.update()

    @property
    def counts(self) -> dict[int, float] | None:
        """Return the counts by current line number, except the counts of changed lines.

        Return None if the column of counts is hidden.
        """
        if self._counts is None:
            return None
        return {block.blockNumber() + 1: value for block, value in _unchanged(self._counts)}

    def count(self, by_line: Mapping[int, float] | None) -> None:
        """Show a count beside each of these lines until the line changes; None removes the column."""
        self._counts = None
        if by_line is not None:
            blocks = ((self.document().findBlockByNumber(line - 1), value) for line, value in by_line.items())
            self._counts = [_note(block, value) for block, value in blocks if block.isValid()]
        self._place_gutter()
        self.gutter.update()

    def block(self, line: int) -> QtGui.QTextBlock:
        """Return the block of a line, or the last block if there is no such line."""
        return self.document().findBlockByNumber(min(max(line, 1), self.blockCount()) - 1)

    def box(self, block: QtGui.QTextBlock) -> QRectF:
        """Return a block's rectangle in viewport pixels."""
        return self.blockBoundingGeometry(block).translated(self.contentOffset())

    def scroll_to(self, line: int) -> None:
        """Scroll to a line without moving the cursor."""
        box = self.box(self.block(line))
        if box.top() < 0 or box.bottom() > self.viewport().height():
            self.go_to(line)

    def go_to(self, line: int) -> None:
        """Move the cursor to the first word of a line and scroll to it."""
        block = self.block(line)
        cursor = QTextCursor(block)
        cursor.setPosition(block.position() + _depth(block.text()))
        self.setTextCursor(cursor)
        self.centerCursor()

    def _show_lines(self) -> None:
        """Highlight the current line and the marked ones."""
        grounds = [] if self.isReadOnly() else [self._ground(self.textCursor(), "contact")]
        for notes, token in ((self._remarks, "warnsoft"), (self._marks, "dangersoft")):
            grounds += [self._ground(QTextCursor(block), token) for block, _ in _unchanged(notes)]
        self.setExtraSelections(grounds)

    @staticmethod
    def _ground(cursor: QTextCursor, token: str) -> QTextEdit.ExtraSelection:
        ground = QTextEdit.ExtraSelection()
        ground.format.setBackground(theme.color(token))  # type: ignore[attr-defined]
        ground.format.setProperty(QtGui.QTextFormat.Property.FullWidthSelection, True)  # type: ignore[attr-defined]
        ground.cursor = QTextCursor(cursor)  # type: ignore[attr-defined]
        ground.cursor.clearSelection()  # type: ignore[attr-defined]
        return ground

    def paintEvent(self, event: QtGui.QPaintEvent) -> None:
        """Paint the text, then the message after each marked line."""
        super().paintEvent(event)
        painter = QPainter(self.viewport())
        painter.setFont(theme.font("label"))
        metrics = painter.fontMetrics()
        for notes, token, sign in ((self._remarks, "warn", "! "), (self._marks, "danger", "✕ ")):
            painter.setPen(theme.color(token))
            for block, note in _unchanged(notes):
                box = self.box(block)
                left = box.left() + block.layout().lineAt(0).naturalTextWidth() + _GAP
                room = self.viewport().width() - left - 8
                if room >= _LEAST_WORDS:
                    text = metrics.elidedText(sign + note, Qt.TextElideMode.ElideRight, int(room))
                    middle = box.top() + (box.height() + metrics.capHeight()) / 2
                    painter.drawText(QPointF(left, middle), text)

    # keyboard events

    def keyPressEvent(self, event: QtGui.QKeyEvent) -> None:
        """Indent as Python requires; other keys have their usual effect."""
        key, cursor = event.key(), self.textCursor()
        plain = Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.KeypadModifier
        if self.isReadOnly() or event.modifiers() & ~plain:
            super().keyPressEvent(event)
            return
        if key in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            newline(cursor)
        elif key == Qt.Key.Key_Tab:
            indent(cursor)
        elif key == Qt.Key.Key_Backtab:
            _shift_lines(cursor, -STEP)
        elif key != Qt.Key.Key_Backspace or not backspace(cursor):
            super().keyPressEvent(event)
            return
        self.setTextCursor(cursor)

    # space for the line numbers

    def _place_gutter(self) -> None:
        inside, width = self.contentsRect(), self.gutter.wanted_width
        self.setViewportMargins(width, 0, 0, 0)
        self.gutter.setGeometry(QRect(inside.left(), inside.top(), width, inside.height()))

    def resizeEvent(self, event: QtGui.QResizeEvent) -> None:
        super().resizeEvent(event)
        self._place_gutter()
        if self.hasFocus():
            self.ensureCursorVisible()  # the height becomes smaller when a banner appears above
