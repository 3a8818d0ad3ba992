"""A chart of what was measured: linear or logarithmic axes with titles, pointer, and painted layers."""

import math
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QPainter

from hapkit_studio.gui.plots.axis import Axis
from hapkit_studio.gui.plots.canvas import Canvas
from hapkit_studio.gui.theme import theme

Layer = Callable[[QPainter, "Chart"], None]
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_TITLE = 18.0
_LEAST = 1e-300


def power(exponent: int) -> str:
    """Write a power of ten: 0.1, 1, 10 and 100 as such, others as 10ⁿ."""
    if -1 <= exponent <= 2:
        return f"{10.0**exponent:g}"
    return "10" + str(exponent).translate(_SUPERSCRIPTS)


def decades(low: float, high: float, most: int) -> list[float]:
    """Return the whole exponents to label in [low, high], at most so many, evenly spaced."""
    first, last = math.ceil(low - 1e-9), math.floor(high + 1e-9)
    size = max(1, math.ceil((last - first + 1) / max(most, 1)))
    return [float(k) for k in range(first, last + 1) if k % size == 0]


def steps(low: float, high: float) -> list[float]:
    """Return the exponents of 1, 2 and 5 times the powers of ten in [low, high]."""
    whole = range(math.floor(low), math.ceil(high) + 1)
    found = [k + math.log10(factor) for k in whole for factor in (1.0, 2.0, 5.0)]
    return [value for value in found if low - 1e-9 <= value <= high + 1e-9]


class LogAxis(Axis):
    """An axis whose values are exponents of ten; where less than two decades are seen, 2 and 5 as well."""

    def places(self, low: float, high: float, size: float) -> list[float]:
        found = decades(low, high, self.room(size)[0] + 3)
        return found if len(found) > 2 else steps(low, high)

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        texts = [
            power(round(v)) if math.isclose(v, round(v), abs_tol=1e-9) else f"{10.0**v:g}" for v in values
        ]
        if self.unit and texts:
            texts[-1] += f" {self.unit}"
        return texts


@dataclass(frozen=True)
class _Press:
    """Where and on which axes a drag began: what opens meanwhile and moves the chart moves nothing else."""

    place: QPointF
    on_screen: QPointF
    box: QRectF
    mapping: tuple[float, float, float, float]

    def now(self, on_screen: QPointF) -> QPointF:
        """Return where the pointer is, in the pixels of the press, kept inside the frame."""
        place, box = self.place + on_screen - self.on_screen, self.box
        return QPointF(
            min(max(place.x(), box.left()), box.right()), min(max(place.y(), box.top()), box.bottom())
        )


class Chart(Canvas):
    """Layers are painted in order: ``under`` beneath the grid, ``over`` above it, ``marks`` over the frame.

    Each is called with the painter and the chart, whose ``at(x, y)`` maps data to pixels.
    ``clicked(x, y)`` and ``dragged(x, y)`` come in data units, ``hovered`` with (x, y) or None.
    """

    clicked = Signal(float, float)
    dragged = Signal(float, float)
    hovered = Signal(object)

    def __init__(self, across: str, up: str, log: tuple[bool, bool] = (False, False), unit: str = ""):
        kinds = (LogAxis if log[0] else Axis, LogAxis if log[1] else Axis)
        super().__init__(bottom=True, unit=unit, left_width=66.0, axes=kinds)
        self.across, self.up, self.log = across, up, log
        self._press: _Press | None = None
        self.under: list[Layer] = []
        self.over: list[Layer] = []
        self.marks: list[Layer] = []
        self.ground.setContentsMargins(_TITLE - 14, 10, 16, _TITLE + 4)
        self.setMouseTracking(True)
        self.setMinimumSize(260, 180)
        self.setAccessibleName(f"Chart of {up} over {across}")
        self.recolor()

    def set_titles(self, across: str, up: str) -> None:
        """Name the axes."""
        self.across, self.up = across, up
        self.setAccessibleName(f"Chart of {up} over {across}")
        self.redraw()

    def set_range(self, across: tuple[float, float], up: tuple[float, float]) -> None:
        """Show these ranges, in data units."""
        x, y = (self._inner(pair, log) for pair, log in zip((across, up), self.log, strict=True))
        self.view.setRange(xRange=x, yRange=y, padding=0, update=True)
        self.redraw()

    def shown(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the ranges in sight, in data units."""
        pairs = self.view.viewRange()
        x, y = (
            (10.0 ** pair[0], 10.0 ** pair[1]) if log else (pair[0], pair[1])
            for pair, log in zip(pairs, self.log, strict=True)
        )
        return x, y

    def redraw(self) -> None:
        """Paint anew."""
        self.viewport().update()

    def at(self, x: float, y: float) -> QPointF:
        """Map one point to pixels."""
        self.measure()
        return self.pixel(*(self._one(value, log) for value, log in zip((x, y), self.log, strict=True)))

    def points(self, x: Sequence[float] | np.ndarray, y: Sequence[float] | np.ndarray) -> list[QPointF]:
        """Map points to pixels, those without a number left out."""
        pairs = zip(np.asarray(x, dtype=float), np.asarray(y, dtype=float), strict=True)
        return [self.at(float(a), float(b)) for a, b in pairs if math.isfinite(a) and math.isfinite(b)]

    def value(self, place: QPointF) -> tuple[float, float]:
        """Map pixels to data units."""
        return self._value(place, self._mapped())

    # painting

    def paint_under(self, painter: QPainter, box: QRectF) -> None:
        self._paint(painter, self.under)

    def paint_over(self, painter: QPainter, box: QRectF) -> None:
        self._paint(painter, self.over)

    def paint_marks(self, painter: QPainter, box: QRectF) -> None:
        painter.setFont(theme.font("hint"))
        painter.setPen(theme.color("axis"))
        size = self.viewport().size()
        bottom = QRectF(box.left(), size.height() - _TITLE - 3, box.width(), _TITLE)
        painter.drawText(bottom, Qt.AlignmentFlag.AlignCenter, self.across)
        painter.save()
        painter.translate(4.0, box.center().y())
        painter.rotate(-90.0)
        side = QRectF(-box.height() / 2, 0.0, box.height(), _TITLE)
        painter.drawText(side, Qt.AlignmentFlag.AlignCenter, self.up)
        painter.restore()
        self._paint(painter, self.marks)

    def _paint(self, painter: QPainter, layers: list[Layer]) -> None:
        for layer in layers:
            painter.save()
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            try:
                layer(painter, self)
            except Exception:  # a defect that left the painter open would take the program down
                traceback.print_exc()
            painter.restore()

    # pointer

    def mousePressEvent(self, event) -> None:
        place = event.position()
        if event.button() == Qt.MouseButton.LeftButton and self.frame().contains(place):
            self._press = _Press(place, event.globalPosition(), self.frame(), self._mapped())
            self.clicked.emit(*self.value(place))

    def mouseMoveEvent(self, event) -> None:
        place = event.position()
        self.hovered.emit(self.value(place) if self.frame().contains(place) else None)
        if self._press is not None and event.buttons() & Qt.MouseButton.LeftButton:
            self.dragged.emit(*self._value(self._press.now(event.globalPosition()), self._press.mapping))

    def mouseReleaseEvent(self, event) -> None:
        self._press = None

    def leaveEvent(self, event) -> None:
        super().leaveEvent(event)
        self.hovered.emit(None)

    # mapping

    def _value(self, place: QPointF, mapping: tuple[float, float, float, float]) -> tuple[float, float]:
        left, across, bottom, up = mapping
        x, y = (place.x() - left) / across, (place.y() - bottom) / up
        return (10.0**x if self.log[0] else x), (10.0**y if self.log[1] else y)

    def _mapped(self) -> tuple[float, float, float, float]:
        self.measure()
        return self._map

    @staticmethod
    def _one(value: float, log: bool) -> float:
        return math.log10(max(value, _LEAST)) if log else value

    @classmethod
    def _inner(cls, pair: tuple[float, float], log: bool) -> tuple[float, float]:
        return cls._one(pair[0], log), cls._one(pair[1], log)
