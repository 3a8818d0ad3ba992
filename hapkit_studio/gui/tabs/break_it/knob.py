"""The knob of a failure: what is turned, over its boundary, and two buttons just beside it."""

import re

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QWidget

from hapkit_studio.gui.tabs.break_it.record import Record
from hapkit_studio.gui.tabs.break_it.slider import BoundarySlider, KnobBox, KnobQuantity
from hapkit_studio.gui.widgets.numbers import Quantity
from hapkit_studio.gui.widgets.style import mark

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
