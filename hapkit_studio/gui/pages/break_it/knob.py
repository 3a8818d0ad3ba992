"""The knob of a failure: a slider over the limit, plain where it holds, hatched where it fails."""

import re
from dataclasses import dataclass

from PySide6.QtCore import QPointF, QRectF, QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QBrush, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QWidget

from hapkit_studio.gui.pages.break_it.record import Record, short_number
from hapkit_studio.gui.widgets.numbers import NumberBox, Quantity, ValueSlider
from hapkit_studio.gui.widgets.style import dress, mark
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
        return short_number(value) if abs(value) >= 1000.0 else f"{value:.4g}".replace("-", "−")


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
        """Use another quantity, with its range."""
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
        """Use another quantity, with its step."""
        self._quantity = quantity
        self.setDecimals(quantity.decimals + 4)
        self.setSingleStep(quantity.step)


_BOX = 88


class KnobBar(QWidget):
    """Emits ``turned`` with a share of the limit; nothing can be turned while the limit is not known."""

    turned = Signal(float)

    def __init__(self, record: Record):
        super().__init__()
        self._record = record
        self.quantity = KnobQuantity.of_record(record)
        self.label, self.unit = QLabel(), QLabel()
        self.unit.setProperty("role", "hint")
        self.slider, self.box = BoundarySlider(self.quantity), KnobBox(self.quantity)
        self.box.setFixedWidth(_BOX)
        self.inside, self.outside = QPushButton(autoDefault=True), QPushButton(autoDefault=True)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(8)
        for part in (self.label, self.slider, self.box, self.unit, self.inside, self.outside):
            row.addWidget(part, 1 if part is self.slider else 0)
        self.slider.picked.connect(self._take)
        self.box.entered.connect(self._take)
        self.inside.clicked.connect(lambda: self.turned.emit(1.0 - self._record.failure.margin))
        self.outside.clicked.connect(lambda: self.turned.emit(1.0 + self._record.failure.margin))
        self.show_record(record)

    def show_record(self, record: Record) -> None:
        """Show a failure's knob as it stands."""
        self._record = record
        self.setEnabled(record.ready)
        self.quantity = KnobQuantity.of_record(record)
        self.slider.take(self.quantity)
        self.box.take(self.quantity)
        self._name()
        self.show_value()

    def show_value(self) -> None:
        """Show where the knob stands."""
        value = self._record.value
        knob = self._record.failure.knob
        mark(self.box, "invalid", False)
        self.slider.known = self.box.known = value is not None
        if value is None:
            self.slider.setAccessibleName(f"{knob.label}, its limit is not known yet")
            self.slider.update()
            with QSignalBlocker(self.box):
                self.box.lineEdit().clear()
            return
        shown = value * self.quantity.factor
        self.slider.show_value(shown)
        self.box.show_value(shown)
        spoken = f"{knob.label}, {self.quantity.text(shown)} {self.quantity.unit}".rstrip()
        self.slider.setAccessibleName(f"{spoken}, {100.0 * self._record.share:.0f} % of the limit")
        self.box.setAccessibleName(spoken)

    def _name(self) -> None:
        failure = self._record.failure
        symbol = re.sub(r"_(\w+)", r"<sub>\1</sub>", failure.knob.symbol)
        self.label.setText(f'{failure.knob.label} <i style="font-family: serif">{symbol}</i>'.strip())
        self.unit.setText(self.quantity.unit)
        percent = f"{100.0 * failure.margin:g} %"
        self.inside.setText(f"{percent} inside")
        self.outside.setText(f"{percent} outside")
        limits = Quantity.of(failure.knob).limits()
        for part in (self.label, self.slider, self.box):
            part.setToolTip(f"<p>{failure.knob.help}. {limits} Double click: the limit.</p>")

    def _take(self, value: float) -> None:
        """Turn to a value in screen units; one that cannot be tried stays in the box, marked."""
        plain = Quantity.of(self._record.failure.knob)
        if not plain.inside(value):
            mark(self.box, "invalid", True)
            self.box.setToolTip(plain.limits())
            return
        assert self._record.limit is not None
        self.turned.emit(value / plain.factor / self._record.limit)
