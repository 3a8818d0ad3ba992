"""A slider over a boundary: fine on one side, hatched on the other, the limit marked between them."""

from dataclasses import dataclass

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QBrush, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.tabs.break_it.record import Record, figures
from hapkit_studio.gui.widgets.numbers import NumberBox, Quantity, ValueSlider
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.theme import theme

_HEIGHT, _MIDDLE, _GROOVE, _THUMB = 38, 12.0, 6.0, 8.0
_STEPS_TO_LIMIT = 100
_PALE = 0.4


@dataclass(frozen=True)
class KnobQuantity(Quantity):
    """A knob on the screen, in hundredths of its limit; default is the limit."""

    @classmethod
    def of_record(cls, record: Record) -> "KnobQuantity":
        """Derive it from a failure whose limit is known; from the knob's own range where it has none."""
        knob = record.failure.knob
        plain = Quantity.of(knob)
        if record.limit is None:
            return cls(**vars(plain))
        limit = record.limit * plain.factor
        low, high = (min(max(share * limit, plain.low), plain.high) for share in record.failure.span)
        return cls(knob.label, plain.unit, plain.factor, low, high, limit, limit / _STEPS_TO_LIMIT, False)

    def text(self, value: float) -> str:
        """Write a value in four figures."""
        return figures(value) if abs(value) >= 1000.0 else f"{value:.4g}".replace("-", "−")


class BoundarySlider(ValueSlider):
    """Emits ``picked`` with a value in screen units; a double click goes to the limit.

    known: there is a limit; before, an empty groove is all there is to see.
    """

    known = True

    def __init__(self, quantity: KnobQuantity, parent: QWidget | None = None):
        super().__init__(quantity, parent)
        self.setFixedHeight(_HEIGHT)
        dress(self, f"QSlider {{ min-height: {_HEIGHT}px; }}")

    def take(self, quantity: KnobQuantity) -> None:
        """Run over another range."""
        blocked = self.blockSignals(True)
        self._quantity = quantity
        self.setRange(0, quantity.steps)
        self.blockSignals(blocked)
        self.update()

    def sizeHint(self) -> QSize:
        return QSize(260, _HEIGHT)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if not self.isEnabled():
            painter.setOpacity(_PALE)
        if not self.known:
            painter.setPen(QPen(theme.color("edge"), 1))
            painter.drawRoundedRect(QRectF(0.5, _MIDDLE - _GROOVE / 2, self.width() - 1, _GROOVE), 3, 3)
            return
        limit, thumb = self._place(self._quantity.default), self._place(self._exact)
        self._paint_groove(painter, limit)
        self._paint_words(painter, limit)
        painter.setPen(QPen(theme.color("ink"), 2))
        painter.drawLine(QPointF(limit, _MIDDLE - 8), QPointF(limit, _MIDDLE + 9))
        painter.setBrush(theme.color("surface"))
        painter.setPen(QPen(theme.color("accent"), 3))
        painter.drawEllipse(QPointF(thumb, _MIDDLE), _THUMB - 2, _THUMB - 2)
        if self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(theme.color("accent"), 1.5))
            painter.drawEllipse(QPointF(thumb, _MIDDLE), _THUMB + 1, _THUMB + 1)

    def _paint_groove(self, painter: QPainter, limit: float) -> None:
        top = _MIDDLE - _GROOVE / 2
        whole = QRectF(0.5, top, self.width() - 1, _GROOVE)
        painter.setPen(QPen(theme.color("edge"), 1))
        painter.setBrush(theme.color("stable"))
        painter.drawRoundedRect(whole, 3, 3)
        if limit < self.width() - 1:
            beyond = QRectF(limit, top, self.width() - 1 - limit, _GROOVE)
            for brush in (
                theme.color("unstable"),
                QBrush(theme.color("danger", 0.8), Qt.BrushStyle.BDiagPattern),
            ):
                painter.setBrush(brush)
                painter.drawRoundedRect(beyond, 3, 3)

    def _paint_words(self, painter: QPainter, limit: float) -> None:
        """Name the limit and the ends, in shares of the limit."""
        painter.setFont(theme.font("hint"))
        q = self._quantity
        places = [(limit, "limit", "ink2")]
        places += [(self._place(v), f"{100.0 * v / q.default:.0f} %", "ink3") for v in (q.low, q.high)]
        taken: list[QRectF] = []
        for x, words, token in places:
            width = painter.fontMetrics().horizontalAdvance(words) + 2.0
            left = min(max(x - width / 2, 0.0), self.width() - width)
            box = QRectF(left, _MIDDLE + 9, width, 16)
            if not any(box.intersects(other) for other in taken):
                taken.append(box)
                painter.setPen(theme.color(token))
                painter.drawText(box, Qt.AlignmentFlag.AlignCenter, words)


class KnobBox(NumberBox):
    """The knob's value as a number; nothing before it is known."""

    known = True

    def textFromValue(self, value: float) -> str:
        return super().textFromValue(value) if self.known else ""

    def take(self, quantity: Quantity) -> None:
        """Count in other steps."""
        self._quantity = quantity
        self.setDecimals(quantity.decimals + 4)
        self.setSingleStep(quantity.step)
