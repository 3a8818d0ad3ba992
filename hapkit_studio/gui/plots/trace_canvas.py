"""One quantity over time: its traces, contact shading, limit and surface lines, and the mark of now."""

from dataclasses import dataclass, field

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPen

from hapkit_studio.gui.history import Window
from hapkit_studio.gui.plots import strokes
from hapkit_studio.gui.plots.canvas import Canvas
from hapkit_studio.gui.plots.declared import TimePlot
from hapkit_studio.gui.plots.gaps import hatch, lengths
from hapkit_studio.gui.plots.held import Held, paint
from hapkit_studio.gui.plots.ticks import fitted, widened
from hapkit_studio.gui.theme import number, theme

_PALE = 0.45  # of a trace's colour while the device is gone
_SAME = 0.3  # px: closer than this, two lines are one
_WIDTH, _UNIT_WIDTH = 44.0, 60.0  # px of the value axis, without and with a unit
_EMPTY = Window(np.empty(0), {}, False)


@dataclass
class Shown:
    """What all time plots share in one frame; times in s relative to the right edge's zero.

    window and begin are in the history's own time: axes widen only for what came after begin.
    """

    window: Window = _EMPTY
    zero: float = 0.0
    begin: float = -np.inf
    contact: list[tuple[float, float]] = field(default_factory=list)
    gaps: list[tuple[float, float]] = field(default_factory=list)
    now: dict[str, float] | None = None
    surface: float | None = None
    max_force: float = np.inf
    paused: bool = False
    stale: bool = False
    held: Held | None = None
    pointer: float | None = None
    pointed: dict[str, float] | None = None


class TraceCanvas(Canvas):
    """Paints one TimePlot's traces from the Shown that all share."""

    def __init__(self, plot: TimePlot, shown: Shown, bottom: bool, first: bool):
        self.plot_of, self.shown, self.first = plot, shown, first
        super().__init__(bottom, "s" if bottom else "", left_width=_UNIT_WIDTH if plot.beside else _WIDTH)
        if plot.beside:  # no header names it there
            self.left.unit = plot.unit
        self.setAccessibleName(f"{plot.title} over time, in {plot.unit}")
        self.open()

    def values(self, channel: str) -> np.ndarray:
        """Return a channel of the window in the plot's unit."""
        return self.shown.window.y[channel] * self.plot_of.scale

    def show_range(self, low: float, high: float) -> None:
        """Show exactly this range."""
        self.view.setYRange(low, high, padding=0)

    def open(self) -> None:
        """Narrow the value axis to what the plot opens with."""
        self.show_range(-self.plot_of.reach, self.plot_of.reach)

    def extent(self, begin: float = -np.inf) -> tuple[float, float]:
        """Return least and greatest value in the window from a time in s on; NaN when there is none."""
        window = self.shown.window
        first = int(np.argmax(window.x >= begin)) if len(window.x) else 0
        if not len(window.x) or not window.x[first] >= begin:
            return np.nan, np.nan
        values = [window.y[trace.channel][first:] for trace in self.plot_of.traces]
        low, high = min(map(np.fmin.reduce, values)), max(map(np.fmax.reduce, values))
        return float(low) * self.plot_of.scale, float(high) * self.plot_of.scale

    def widen(self) -> None:
        """Widen the value axis at once where the data needs it."""
        low, high = self.view.viewRange()[1]
        wanted = widened((low, high), *self.extent(self.shown.begin))
        if wanted != (low, high):
            self.show_range(*wanted)

    def fit(self) -> None:
        """Narrow the value axis to the data, but not below the plot's reach around its middle."""
        low, high = self.extent()
        if np.isfinite(low):
            self.show_range(*fitted(low, high, self.plot_of.reach / 8))

    def paint_under(self, painter: QPainter, box: QRectF) -> None:
        """Shade where there was contact; hatch where no data came."""
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(theme.color("contact"))
        edges, _ = self.to_pixels(np.array(self.shown.contact).reshape(-1, 2), np.zeros(1))
        painter.drawRects([QRectF(a, box.top(), b - a, box.height()) for a, b in edges.tolist()])
        painter.setBrush(Qt.BrushStyle.NoBrush)
        hatch(painter, box, self._gaps(box))

    def paint_over(self, painter: QPainter, box: QRectF) -> None:
        """Paint level lines, then traces."""
        self._lines(painter, box)
        self._held(painter, box)
        if len(self.shown.window.x):
            self._traces(painter)

    def paint_marks(self, painter: QPainter, box: QRectF) -> None:
        """Paint the dot for now, the pointer's read-out and the word for paused."""
        self._now(painter)
        self._pointer(painter, box)
        if self.first:
            for left, words in lengths(self._gaps(box), self.fontMetrics()):
                self.note(painter, left, box.top() + 16, words, "warn")
        if self.shown.paused and self.first:
            self.note(painter, box.right() - 6, box.top() + 16, "Paused", "accent", right=True)

    def _gaps(self, box: QRectF) -> list[tuple[float, float, float]]:
        """Return left and right in pixels and the length in s of the gaps that are seen."""
        places, _ = self.to_pixels(np.array(self.shown.gaps).reshape(-1, 2), np.zeros(1))
        cut = np.clip(places, box.left(), box.right()).tolist()
        found = [(a, b, stop - start) for (a, b), (start, stop) in zip(cut, self.shown.gaps, strict=True)]
        return [gap for gap in found if gap[0] < gap[1]]

    def _lines(self, painter: QPainter, box: QRectF) -> None:
        levels: list[tuple[float, str, list[float]]] = []
        if self.plot_of.limits and np.isfinite(self.shown.max_force):
            levels += [(s * self.shown.max_force, "danger", [1.2, 2.6]) for s in (1, -1)]
        if self.plot_of.surface and self.shown.surface is not None:
            levels.append((self.shown.surface * self.plot_of.scale, "matline", [3.5, 2.5]))
        for level, token, dash in levels:
            strokes.level(painter, box, self.pixel(0.0, level).y(), token, dash)

    def _held(self, painter: QPainter, box: QRectF) -> None:
        held, channel = self.shown.held, self.plot_of.traces[-1].channel
        if held is None or channel not in held.values:
            return
        left, right = (self.shown.zero + edge for edge in self.view.viewRange()[0])
        x, y = held.part(channel, left, right, round(box.width()))
        if len(x) > 1:
            paint(painter, *self.to_pixels(x - self.shown.zero, y * self.plot_of.scale))

    def _traces(self, painter: QPainter) -> None:
        x = self.shown.window.x - self.shown.zero
        lines = [self.to_pixels(x, self.values(trace.channel)) for trace in self.plot_of.traces]
        for index, (trace, (across, down)) in enumerate(zip(self.plot_of.traces, lines, strict=True)):
            color = theme.paler(trace.color, "plot", _PALE if self.shown.stale else 1.0)
            if trace.dash:
                painter.setPen(strokes.pen(color, 2.0))
                strokes.segments(painter, strokes.patterned(across, down, trace.dash))
            elif trace.dashed:
                painter.setPen(strokes.pen(color, 2.0))
                above = lines[-1][1] if index + 1 < len(lines) else None
                down = down if above is None else _apart(down, above)
                strokes.segments(painter, strokes.dashed(across, down))
            else:
                strokes.trace(painter, across, down, color)

    def _now(self, painter: QPainter) -> None:
        if self.shown.now is None:
            return
        trace = self.plot_of.traces[-1]
        value = self.shown.now[trace.channel] * self.plot_of.scale
        if np.isfinite(value):
            strokes.mark(painter, self.pixel(0.0, value), trace.color, shape=self.plot_of.marker)

    def _pointer(self, painter: QPainter, box: QRectF) -> None:
        if self.shown.pointer is None or self.shown.pointed is None:
            return
        trace = self.plot_of.traces[-1]
        value = self.shown.pointed[trace.channel] * self.plot_of.scale
        if not np.isfinite(value):
            return
        place = self.pixel(self.shown.pointer, value)
        x = place.x()
        painter.setPen(QPen(theme.color("ink3"), 1))
        painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))
        strokes.mark(painter, place, trace.color, 3.0)
        text = f"{number(value, self.plot_of.decimals, sign=True)} {self.plot_of.unit}"
        if self.first:
            text = f"{number(self.shown.pointer, 3)} s   {text}"
        left = x > box.center().x()
        beside = x + (-8 if left else 8)
        self.note(painter, beside, box.bottom() - 6, text, trace.color, right=left)


def _apart(line: np.ndarray, above: np.ndarray) -> np.ndarray:
    """Return a line with NaN wherever another hides it, one point beyond its visible parts."""
    apart = np.abs(line - above) > _SAME
    near = apart.copy()
    near[1:] |= apart[:-1]
    near[:-1] |= apart[1:]
    return np.where(near, line, np.nan)
