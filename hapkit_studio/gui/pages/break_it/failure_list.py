"""The list of failures: title, what is known, and whether it held inside the limit and outside it."""

from collections.abc import Iterable

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QFontMetrics, QPainter, QPen
from PySide6.QtWidgets import QAbstractItemView, QListWidget, QListWidgetItem, QStyle, QStyledItemDelegate

from hapkit_studio.gui.pages.break_it.record import LIMIT, Record, knob_text
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.theme import theme

WIDE, NARROW = 244, 204
_LEFT, _RIGHT, _EDGE = 14, 10, 9
_SIGN, _LINE = 16, 18
_SHORT = 6  # letters of a symbol that fits
_WORDS, _SIGNS = Qt.ItemDataRole.UserRole, Qt.ItemDataRole.UserRole + 1
_SHEET = "QListWidget { background: @surface; border: none; border-right: 1px solid @line; }"
_SAID = {None: "not tried", True: "holds", False: "fails"}
_WRAP = Qt.TextFlag.TextWordWrap | Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop
Index = QModelIndex | QPersistentModelIndex


class _Row(QStyledItemDelegate):
    """Paints a failure: title over at most a few lines, below it what is known and the signs."""

    def sizeHint(self, option, index: Index) -> QSize:
        return QSize(100, self._title(index).height() + _LINE + 2 * _EDGE)

    def paint(self, painter: QPainter, option, index: Index) -> None:
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        box, chosen = option.rect, bool(option.state & QStyle.StateFlag.State_Selected)
        if chosen or option.state & QStyle.StateFlag.State_MouseOver:
            painter.fillRect(box, theme.color("accentsoft" if chosen else "grid"))
        if chosen:
            painter.fillRect(box.left(), box.top(), 3, box.height(), theme.color("accent"))
        title = self._title(index)
        painter.setFont(theme.font("strong"))
        painter.setPen(theme.color("accent" if chosen else "ink"))
        place = title.translated(box.left() + _LEFT, box.top() + _EDGE)
        painter.drawText(place, _WRAP, index.data(Qt.ItemDataRole.DisplayRole))
        line = QRectF(box.left() + _LEFT, place.bottom() + 1, box.width() - _LEFT - _RIGHT, _LINE)
        painter.setFont(theme.font("hint"))
        painter.setPen(theme.color("ink2" if chosen else "ink3"))
        left = self._signs(painter, line, index.data(_SIGNS))
        painter.setPen(theme.color("ink2" if chosen else "ink3"))
        room = left - line.left() - 4
        words = painter.fontMetrics().elidedText(index.data(_WORDS), Qt.TextElideMode.ElideRight, round(room))
        painter.drawText(line, Qt.AlignmentFlag.AlignVCenter, words)
        if option.state & QStyle.StateFlag.State_HasFocus:
            painter.setPen(QPen(theme.color("accent"), 2))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRoundedRect(QRectF(box).adjusted(4, 2, -3, -2), 6, 6)
        painter.restore()

    def _title(self, index: Index):
        view = self.parent()
        assert isinstance(view, QAbstractItemView)
        width = view.width() - 1 - view.verticalScrollBar().sizeHint().width() - _LEFT - _RIGHT
        metrics = QFontMetrics(theme.font("strong"))
        return metrics.boundingRect(0, 0, width, 400, _WRAP, index.data(Qt.ItemDataRole.DisplayRole))

    @staticmethod
    def _signs(painter: QPainter, line: QRectF, signs: tuple[bool | None, bool | None]) -> float:
        """Paint "in" and "out", each with its sign if it was tried; return where that begins."""
        if signs == (None, None):
            return line.right()
        ratio, x = painter.device().devicePixelRatio(), line.right()
        painter.setPen(theme.color("ink2"))
        for word, holds in (("out", signs[1]), ("in", signs[0])):
            x -= _SIGN
            if holds is not None:
                name, token = ("check", "ok") if holds else ("close", "danger")
                box = QRectF(x, line.center().y() - _SIGN / 2, _SIGN, _SIGN)
                painter.drawPixmap(box.topLeft(), icons.pixmap(name, _SIGN, token, ratio))
            wide = painter.fontMetrics().horizontalAdvance(word) + 2.0
            x -= wide
            painter.drawText(QRectF(x, line.top(), wide, line.height()), Qt.AlignmentFlag.AlignVCenter, word)
            x -= 5.0
        return x


class FailureList(QListWidget):
    """The list; emits ``chosen(key)``, also by arrow keys."""

    chosen = Signal(str)

    def __init__(self, records: Iterable[Record]):
        super().__init__()
        self._items: dict[str, QListWidgetItem] = {}
        self.setItemDelegate(_Row(self))
        self.setAccessibleName("Where methods fail")
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.verticalScrollBar().setSingleStep(12)
        self.setMouseTracking(True)
        self.setResizeMode(QListWidget.ResizeMode.Adjust)
        self.setFixedWidth(WIDE)
        dress(self, _SHEET)
        for record in records:
            item = self._items[record.failure.key] = QListWidgetItem(record.failure.title, self)
            item.setData(Qt.ItemDataRole.UserRole + 2, record.failure.key)
            item.setToolTip(f"<p>{record.failure.summary}.</p>")
            self.show_record(record)
        self.currentItemChanged.connect(self._say)
        theme.changed.connect(self.doItemsLayout)

    def choose(self, key: str) -> None:
        """Select a failure, as a click does."""
        self.setCurrentItem(self._items[key])

    def show_record(self, record: Record, busy: bool = False) -> None:
        """Show what is known of a failure."""
        item, signs = self._items[record.failure.key], record.signs
        item.setData(_WORDS, _words(record, busy))
        item.setData(_SIGNS, signs)
        spoken = (
            f"{record.failure.title}. Inside the limit it {_SAID[signs[0]]}, outside it {_SAID[signs[1]]}"
        )
        if signs == (None, None):
            spoken = f"{record.failure.title}. {_words(record, busy)}"
        else:
            item.setToolTip(f"<p>{record.failure.summary}. {spoken.split('. ')[-1]}.</p>")
        item.setData(Qt.ItemDataRole.AccessibleTextRole, spoken)

    def _say(self, item: QListWidgetItem | None) -> None:
        if item is not None:
            self.chosen.emit(item.data(Qt.ItemDataRole.UserRole + 2))


def _words(record: Record, busy: bool) -> str:
    if busy:
        return "Measuring…"
    if record.wrong:
        return "Could not be tried"
    if LIMIT in record.old:
        return "Conditions changed"
    if record.limit is None:
        return "Not tried yet"
    knob = record.failure.knob
    name = "" if knob.unit else f"{knob.symbol if 0 < len(knob.symbol) <= _SHORT else knob.label.lower()} "
    return f"Limit {name}{knob_text(record.limit, knob)}"
