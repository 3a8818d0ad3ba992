"""Line numbers beside a text, and figures where there are some; a marked line carries a cross as well."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QRect, QRectF, Qt
from PySide6.QtGui import QFontMetrics, QPainter, QPaintEvent, QTextBlock
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.gui.editor.code_edit import CodeEdit

_SIGN, _SIDE = 16, 8
_LEAST_DIGITS = 3
_FIGURE = "99,999"


class Gutter(QWidget):
    """Drawn by line, scrolled with the text."""

    def __init__(self, code: "CodeEdit"):
        super().__init__(code)
        self._code = code
        theme.changed.connect(self.update)

    @property
    def wanted(self) -> int:
        """Return the width that the last line's number needs, and the figures' column if there is one."""
        return self._numbers + (0 if self._code.counts is None else self._column)

    @property
    def _numbers(self) -> int:
        digits = max(_LEAST_DIGITS, len(str(self._code.blockCount())))
        return _SIGN + _SIDE + digits * QFontMetrics(self._code.font()).horizontalAdvance("0")

    @property
    def _column(self) -> int:
        return 2 * _SIDE + QFontMetrics(self._code.font()).horizontalAdvance(_FIGURE)

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
        counts = self._code.counts or {}
        most = max(counts.values(), default=0.0)
        block = self._code.firstVisibleBlock()
        while block.isValid():
            box = self._box(block)
            if box.top() > event.rect().bottom() or box.bottom() > self._code.whole + 1:
                return  # what is cut off has no number
            number = block.blockNumber()
            self._paint_line(painter, box, number + 1, number == current, number + 1 in marks)
            if most > 0.0 and number + 1 in counts:
                self._paint_figure(painter, box, counts[number + 1], most)
            block = block.next()

    def _box(self, block: QTextBlock) -> QRectF:
        place = self._code.blockBoundingGeometry(block).translated(self._code.contentOffset())
        return QRectF(0, place.top(), self.width(), place.height())

    def _paint_figure(self, painter: QPainter, box: QRectF, value: float, most: float) -> None:
        """Paint a figure with a bar behind it, as long as its share of the largest one."""
        column = box.adjusted(self._numbers, 0, 0, 0)
        bar = column.adjusted(_SIDE / 2, 1, -_SIDE / 2, -1)
        bar.setLeft(bar.right() - bar.width() * value / most)
        painter.fillRect(bar, theme.color("accentsoft"))
        painter.setPen(theme.color("ink"))
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(column.adjusted(0, 0, -_SIDE, 0), right, f"{value:,.0f}")

    def _paint_line(self, painter: QPainter, box: QRectF, number: int, current: bool, marked: bool) -> None:
        box = QRectF(box.left(), box.top(), self._numbers, box.height())
        if marked:
            painter.fillRect(box, theme.color("dangersoft"))
        painter.setPen(theme.color("danger" if marked else "ink" if current else "ink3"))
        if marked:
            sign = QRectF(box.left(), box.top(), _SIGN, box.height())
            painter.drawText(sign, Qt.AlignmentFlag.AlignCenter, "✕")
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(box.adjusted(0, 0, -_SIDE, 0), right, str(number))
