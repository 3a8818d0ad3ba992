"""The failure over its knob: the formula, what was measured, the boundary, and where the knob stands."""

from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.tabs.break_it_lines import Key
from hapkit_studio.gui.tabs.break_it_paint import CurvePainter
from hapkit_studio.gui.tabs.break_it_record import Record
from hapkit_studio.gui.tabs.chart import Chart

if TYPE_CHECKING:
    from hapkit_studio.analysis.failures import Chart as Found

_ROOM = 0.06
_NAMES = 0.05  # of the height, for each limit's name at the top
_LEAST, _LEFT = (240, 170), 50
Pair = tuple[float, float]


def spans(found: "Found") -> tuple[Pair, Pair]:
    """Return the ranges across and up that hold every finite point, with room for the names of limits."""
    x = _extent([np.asarray(line.x, float) for line in found.lines], found.log_x)
    y = [np.asarray(line.y, float) for line in found.lines]
    if found.level is not None:
        y.append(np.array([found.level]))
    return x, _wider(_extent(y, found.log_y), found.log_y, _ROOM + _NAMES * len(found.marks))


def _extent(parts: list[np.ndarray], log: bool) -> Pair:
    values = np.concatenate(parts)
    good = values[np.isfinite(values) & ((values > 0.0) | (not log))]
    return (float(good.min()), float(good.max())) if len(good) else (1.0, 2.0)


def _wider(pair: Pair, log: bool, above: float) -> Pair:
    low, high = pair
    if log:
        ratio = max(high / low, 1.01)
        return low / ratio**_ROOM, high * ratio**above
    room = high - low or 1.0
    return low - _ROOM * room, high + above * room


class CurveCard(QWidget):
    """Emits ``picked`` with a share of the limit where a person clicks or drags."""

    picked = Signal(float)

    def __init__(self) -> None:
        super().__init__()
        self.setMinimumSize(*_LEAST)
        self.key = Key()
        self.key.setParent(self)
        self._record: Record | None = None
        self._painter: CurvePainter | None = None
        self.chart = self._new((False, False))

    def show_record(self, record: Record) -> None:
        """Show a failure's chart, or an empty one."""
        found = record.chart
        self._record = record
        self._painter = CurvePainter(record, found) if found else None
        if found:
            self.key.show_lines(found.y_label, found.lines, found.level_label)
        else:
            self.key.show_lines("", ())
        self._use((found.log_x, found.log_y) if found else (False, False))
        self._place()
        self.chart.under = [self._painter.under] if self._painter else []
        self.chart.over = [self._painter.over] if self._painter else []
        if found:
            self.chart.set_titles(found.x_label, "")  # what runs up stands in the key, where it is never cut
            self.chart.setAccessibleName(f"Chart of {found.y_label} over {found.x_label}")
            self.chart.set_range(*spans(found))
        else:
            self.chart.set_titles("", "")
            self.chart.set_range((0.0, 1.0), (0.0, 1.0))

    def _use(self, log: tuple[bool, bool]) -> None:
        """Have axes of this kind."""
        if log != self.chart.log:
            self.chart.hide()
            self.chart.deleteLater()
            self.chart = self._new(log)

    def _new(self, log: tuple[bool, bool]) -> Chart:
        chart = Chart("", "", log)
        chart.setMinimumSize(120, 60)
        chart.left.setWidth(_LEFT)
        chart.clicked.connect(self._pick)
        chart.dragged.connect(self._pick)
        chart.setParent(self)
        chart.show()
        return chart

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._place()

    def _place(self) -> None:
        """Put the key above the chart, in the rows that it needs at this width."""
        high = self.key.needed(self.width())
        self.key.setGeometry(0, 0, self.width(), high)
        self.chart.setGeometry(0, high + 2, self.width(), self.height() - high - 2)

    def _pick(self, x: float, _y: float) -> None:
        """Turn the knob to a place across, where the chart runs over the knob."""
        scale = self._painter.scale if self._painter else None
        if self._record is not None and scale is not None and self._record.limit is not None:
            low, high = self._record.failure.span
            self.picked.emit(min(max(x / scale / self._record.limit, low), high))
