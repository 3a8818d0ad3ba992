"""Line numbers beside a text; a marked line carries a cross as well as its colour."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QRect, QRectF, Qt
from PySide6.QtGui import QFontMetrics, QPainter, QPaintEvent, QTextBlock
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.gui.editor.code_edit import CodeEdit

_SIGN, _SIDE = 16, 8
_LEAST_DIGITS = 3


class Gutter(QWidget):
    """Drawn by line, scrolled with the text."""

    def __init__(self, code: "CodeEdit"):
        super().__init__(code)
        self._code = code
        theme.changed.connect(self.update)

    @property
    def wanted(self) -> int:
        """Return the width that the last line's number needs."""
        digits = max(_LEAST_DIGITS, len(str(self._code.blockCount())))
        return _SIGN + _SIDE + digits * QFontMetrics(self._code.font()).horizontalAdvance("0")

    def follow(self, rect: QRect, dy: int) -> None:
        """Scroll, or paint anew beside what of the text is painted anew."""
        if dy:
            self.scroll(0, dy)
        else:
            self.update(0, rect.y(), self.width(), rect.height())

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.fillRect(event.rect(), theme.color("side"))
        painter.setFont(self._code.font())
        current, marks = self._code.textCursor().blockNumber(), self._code.marks
        block = self._code.firstVisibleBlock()
        while block.isValid():
            box = self._box(block)
            if box.top() > event.rect().bottom() or box.bottom() > self._code.whole + 1:
                return  # what is cut off has no number
            number = block.blockNumber()
            self._paint_line(painter, box, number + 1, number == current, number + 1 in marks)
            block = block.next()

    def _box(self, block: QTextBlock) -> QRectF:
        place = self._code.blockBoundingGeometry(block).translated(self._code.contentOffset())
        return QRectF(0, place.top(), self.width(), place.height())

    @staticmethod
    def _paint_line(painter: QPainter, box: QRectF, number: int, current: bool, marked: bool) -> None:
        if marked:
            painter.fillRect(box, theme.color("dangersoft"))
        painter.setPen(theme.color("danger" if marked else "ink" if current else "ink3"))
        if marked:
            sign = QRectF(box.left(), box.top(), _SIGN, box.height())
            painter.drawText(sign, Qt.AlignmentFlag.AlignCenter, "✕")
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(box.adjusted(0, 0, -_SIDE, 0), right, str(number))
