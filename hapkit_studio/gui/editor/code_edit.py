"""The text of a law: line numbers, the current line, and what is wrong said at its very line."""

from collections.abc import Iterable, Mapping

from PySide6.QtCore import QPointF, QRect, QRectF, Qt, Signal
from PySide6.QtGui import (
    QFont,
    QFontDatabase,
    QFontMetrics,
    QKeyEvent,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QTextCursor,
    QTextFormat,
    QWheelEvent,
)
from PySide6.QtWidgets import QPlainTextEdit, QTextEdit, QWidget

from hapkit_studio.gui.editor import indentation
from hapkit_studio.gui.editor.gutter import Gutter
from hapkit_studio.gui.editor.highlighter import Highlighter
from hapkit_studio.gui.theme import theme

PIXELS = 13
_GAP = 28
_LEAST_WORDS = 90
_ABOVE = 0.25


def code_font() -> QFont:
    """Return the face of code: the system's fixed one."""
    font = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)
    font.setPixelSize(PIXELS)
    return font


class CodeEdit(QPlainTextEdit):
    """A plain text with marks; ``mark`` takes (line from 1, words) and keeps them at their lines."""

    marked = Signal()

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self._marks: list[tuple[QTextCursor, str]] = []
        self._counts: list[tuple[QTextCursor, str, float]] | None = None
        self._aim: int | None = None
        self.setObjectName("code")
        self.setFrameShape(QPlainTextEdit.Shape.NoFrame)
        self.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        self.setFont(code_font())
        self.setTabStopDistance(indentation.STEP * QFontMetrics(code_font()).horizontalAdvance(" "))
        self.highlighter = Highlighter(self.document())
        self.gutter = Gutter(self)
        self.blockCountChanged.connect(self._make_room)
        self.updateRequest.connect(self.gutter.follow)
        self.cursorPositionChanged.connect(self._note_cursor)
        theme.changed.connect(self._show_lines)
        self._make_room()
        self._show_lines()

    # marks

    @property
    def marks(self) -> dict[int, str]:
        """Return what is wrong by line, lines counted from 1 as they now stand."""
        return {cursor.blockNumber() + 1: words for cursor, words in self._marks}

    def mark(self, problems: Iterable[tuple[int, str]]) -> None:
        """Mark lines anew; a line beyond the text is its last one, line 0 marks nothing."""
        self._marks = []
        for line, words in problems:
            if line > 0:
                block = self.document().findBlockByNumber(min(line, self.blockCount()) - 1)
                self._marks.append((QTextCursor(block), words))
        self._show_lines()
        self.viewport().update()  # the words may change where the coloured lines do not
        self.gutter.update()
        self.marked.emit()

    @property
    def counts(self) -> dict[int, float] | None:
        """Return figures by line as lines now stand, without lines that have changed; None: no column."""
        if self._counts is None:
            return None
        same = ((c.block(), value) for c, text, value in self._counts if c.block().text() == text)
        return {block.blockNumber() + 1: value for block, value in same}

    def count(self, by_line: Mapping[int, float] | None) -> None:
        """Show a figure beside each of these lines for as long as it is that line; None: no column."""
        self._counts = None
        if by_line is not None:
            blocks = ((self.document().findBlockByNumber(line - 1), value) for line, value in by_line.items())
            self._counts = [(QTextCursor(b), b.text(), value) for b, value in blocks if b.isValid()]
        self._make_room()
        self.gutter.update()

    def bring_into_sight(self, line: int) -> None:
        """Leave the cursor where a person types, unless the line is out of sight."""
        block = self.document().findBlockByNumber(min(max(line, 1), self.blockCount()) - 1)
        box = self.blockBoundingGeometry(block).translated(self.contentOffset())
        if box.top() < 0 or box.bottom() > self.viewport().height():
            self.go_to(line)

    def go_to(self, line: int) -> None:
        """Put the cursor at the first word of a line and bring it into sight."""
        block = self.document().findBlockByNumber(min(max(line, 1), self.blockCount()) - 1)
        cursor = QTextCursor(block)
        cursor.movePosition(
            QTextCursor.MoveOperation.Right,
            QTextCursor.MoveMode.MoveAnchor,
            len(block.text()) - len(block.text().lstrip()),
        )
        self.setTextCursor(cursor)
        self._aim = block.blockNumber()
        self._scroll_to(self._aim)

    def _scroll_to(self, number: int) -> None:
        """Leave more room below a line than above it: what belongs to it follows."""
        self.verticalScrollBar().setValue(number - int(_ABOVE * self.viewport().height() / self._line))

    @property
    def whole(self) -> float:
        """Return how far down whole lines go, in px from the viewport's top."""
        top = self.contentOffset().y()
        return top + (self.viewport().height() - top) // self._line * self._line

    @property
    def _line(self) -> float:
        """Return a line's height; the last one has a margin below."""
        return self.blockBoundingRect(self.document().firstBlock()).height()

    def _note_cursor(self) -> None:
        self._aim = None
        self._show_lines()

    def _show_lines(self) -> None:
        """Colour the ground of the current line and of the marked ones."""
        grounds = [] if self.isReadOnly() else [self._ground(self.textCursor(), "contact")]
        self.setExtraSelections(grounds + [self._ground(cursor, "dangersoft") for cursor, _ in self._marks])

    @staticmethod
    def _ground(cursor: QTextCursor, token: str) -> QTextEdit.ExtraSelection:
        ground = QTextEdit.ExtraSelection()
        ground.format.setBackground(theme.color(token))  # type: ignore[attr-defined]
        ground.format.setProperty(QTextFormat.Property.FullWidthSelection, True)  # type: ignore[attr-defined]
        ground.cursor = QTextCursor(cursor)  # type: ignore[attr-defined]
        ground.cursor.clearSelection()  # type: ignore[attr-defined]
        return ground

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the text's whole lines, then behind each marked line what is wrong with it."""
        super().paintEvent(event)
        painter = QPainter(self.viewport())
        painter.setPen(theme.color("danger"))
        painter.setFont(theme.font("label"))
        for cursor, words in self._marks:
            self._say(painter, cursor, words)
        painter.fillRect(QRectF(self.viewport().rect()).adjusted(0, self.whole, 0, 0), theme.color("surface"))

    def _say(self, painter: QPainter, cursor: QTextCursor, words: str) -> None:
        block = cursor.block()
        box: QRectF = self.blockBoundingGeometry(block).translated(self.contentOffset())
        left = box.left() + block.layout().lineAt(0).naturalTextWidth() + _GAP
        room = self.viewport().width() - left - 8
        if block.isVisible() and room >= _LEAST_WORDS:
            text = painter.fontMetrics().elidedText("✕ " + words, Qt.TextElideMode.ElideRight, int(room))
            middle = box.top() + (box.height() + painter.fontMetrics().capHeight()) / 2
            painter.drawText(QPointF(left, middle), text)

    # typing

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Indent as Python is written; everything else is as in every text."""
        if self.isReadOnly() or not self._indents(event):
            super().keyPressEvent(event)

    def _indents(self, event: QKeyEvent) -> bool:
        key, cursor = event.key(), self.textCursor()
        if event.modifiers() & ~(Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.KeypadModifier):
            return False
        if key in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            indentation.newline(cursor)
        elif key == Qt.Key.Key_Tab:
            indentation.indent(cursor)
        elif key == Qt.Key.Key_Backtab:
            indentation.dedent(cursor)
        elif key == Qt.Key.Key_Home:
            indentation.home(cursor, bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier))
        elif key != Qt.Key.Key_Backspace or not indentation.unstep(cursor):
            return False
        self.setTextCursor(cursor)
        return True

    # room for the line numbers

    def _make_room(self) -> None:
        self.setViewportMargins(self.gutter.wanted, 0, 0, 0)
        self._place_gutter()

    def _place_gutter(self) -> None:
        inside = self.contentsRect()
        self.gutter.setGeometry(QRect(inside.left(), inside.top(), self.gutter.wanted, inside.height()))

    def wheelEvent(self, event: QWheelEvent) -> None:
        self._aim = None  # the person looks elsewhere now
        super().wheelEvent(event)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._place_gutter()
        if self._aim is not None:
            self._scroll_to(self._aim)
        elif self.hasFocus():
            self.ensureCursorVisible()  # a banner above takes from the height
