"""Base class of plots: ticks, axes, frame, grid and mapping to pixels. Subclasses paint the data."""

import math
from typing import TypeVar

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QFontMetricsF, QPainter, QPen
from PySide6.QtWidgets import QGraphicsGridLayout, QMenu, QSizePolicy

from hapkit_studio.formatting import tick_labels
from hapkit_studio.gui.widgets.text import paint_text
from hapkit_studio.gui.widgets.theme import theme

# Fractions of an axis's range. If the data come closer to the frame than _EDGE, the range grows by _MARGIN.
_EDGE, _MARGIN = 0.04, 0.12
_LOOSE = 1.15  # an axis is fitted to this multiple of the data's range
_OVERHANG = 40  # px: a label may extend beyond the frame by this much
# maximum number of labels on an axis; minimum distance between them in px
_TICKS = {"left": (5, 15.0), "bottom": (6, 56.0)}
Numbers = TypeVar("Numbers", float, np.ndarray)
LABEL = 12  # px at scale 1: half of the last label's size
RIGHT = 16  # px: space beside the frame for the last label and the mark of the current time


def ticks(low: float, high: float, most: int = 5, gaps: float = math.inf) -> list[float]:
    """Return the ticks in [low, high]: multiples of a step 1, 2 or 5 × 10ⁿ.

    The step is the smallest with at most ``most`` ticks. ``gaps`` is the maximum number of steps in the
    range; it ensures a minimum distance between labels.
    """
    span = max(high - low, 1e-12)
    least = span / gaps
    power = 10.0 ** math.floor(math.log10(max(span / max(most, 1), least)))
    for size in (factor * power for factor in (1.0, 2.0, 5.0, 10.0, 20.0)):
        slack = 1e-9 * size
        inside = range(math.ceil((low - slack) / size), math.floor((high + slack) / size) + 1)
        if size >= least and len(inside) <= most:
            break
    return [k * size for k in inside]


def widened(shown: tuple[float, float], low: float, high: float) -> tuple[float, float]:
    """Return the range extended to show [low, high], with a margin on each extended side.

    A side is extended as soon as the data come close to the frame.
    """
    if not (math.isfinite(low) and math.isfinite(high)):
        return shown
    edge = _EDGE * (shown[1] - shown[0])
    margin = _MARGIN * (max(high, shown[1]) - min(low, shown[0]))
    bottom = low - margin if low < shown[0] + edge else shown[0]
    top = high + margin if high > shown[1] - edge else shown[1]
    return bottom, top


def fitted(low: float, high: float, least: float) -> tuple[float, float]:
    """Return [low, high] with a margin.

    The range extends at least by ``least`` on each side of its middle.
    """
    middle, half = (low + high) / 2, max((high - low) / 2 * _LOOSE, least)
    return middle - half, middle + half


def with_nearest(low: float, high: float, places: np.ndarray) -> tuple[float, float]:
    """Return the interval [low, high], extended if necessary to contain at least one of the values (n,)."""
    if not len(places):
        return low, high
    nearest = float(places[np.argmin(np.maximum(low - places, places - high))])
    return min(low, nearest), max(high, nearest)


class Axis(pg.AxisItem):
    """An axis with at most five tick labels, which have a true minus sign; the last may include the unit."""

    def __init__(self, orientation: str, unit: str = ""):
        super().__init__(orientation, maxTickLength=0)
        self.enableAutoSIPrefix(False)
        self.unit = unit
        offset = 7 if orientation == "left" else 4
        self.setCacheMode(pg.QtWidgets.QGraphicsItem.CacheMode.DeviceCoordinateCache)
        self.setStyle(tickTextOffset=offset, autoExpandTextSpace=False, hideOverlappingLabels=_OVERHANG)
        self.setPen(pg.mkPen(None))

    def tickValues(self, minVal: float, maxVal: float, size: float) -> list:
        return [(0.0, self.places(minVal, maxVal, size))]

    def places(self, low: float, high: float, size: float) -> list[float]:
        """Return the positions of ticks and grid lines between two values ``size`` pixels apart."""
        most, room = _TICKS[self.orientation]
        return ticks(low, high, most, max(size / theme.px(room), 1.0))

    def resizeEvent(self, ev=None):
        """Rebuild the labels, because update() alone would use Qt's cached picture of the old height."""
        super().resizeEvent(ev)
        mode = self.cacheMode()
        self.setCacheMode(pg.QtWidgets.QGraphicsItem.CacheMode.NoCache)
        self.setCacheMode(mode)

    def generateDrawSpecs(self, p):
        """Omit the tick lines, because the plot has a grid.

        Shift labels at the edge so that they are complete.
        """
        specs = super().generateDrawSpecs(p)
        return specs and (specs[0], [], [(self._inside(box), *rest) for box, *rest in specs[2]])

    def _inside(self, box: QRectF) -> QRectF:
        """Return a label's box shifted vertically into the widget."""
        view = self.getViewWidget()
        if self.orientation == "left" and view is not None:
            room = self.mapRectFromScene(QRectF(view.viewport().rect()))
            box.moveTop(max(min(box.top(), room.bottom() - box.height()), room.top()))
        return box

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        texts = tick_labels(values)
        if self.unit and texts:
            texts[-1] += f" {self.unit}"
        return texts


class Canvas(pg.GraphicsView):
    """A plot without legend, menu or autoscale.

    Subclasses draw the data in ``paint_under`` and ``paint_over``.
    """

    fit_wanted = Signal()
    pointed = Signal(object)
    paper = "surface"  # colour token of the background around the frame
    below = 22  # px: space for the labels below the frame

    def __init__(self, bottom: bool, unit: str = "", left_width: float = 44.0):
        super().__init__()
        self.bottom, self.left = Axis("bottom", unit), Axis("left")
        self._left_width = left_width
        self.bottom.setVisible(bottom)
        # pyqtgraph's PlotItem is not used, because each one would create a hundred menu widgets
        ground = self._ground = pg.GraphicsWidget()
        self.view = pg.ViewBox(parent=ground, enableMenu=False)
        grid = QGraphicsGridLayout(ground)
        grid.setContentsMargins(1, 1, 1, 1)
        grid.setSpacing(0)
        grid.addItem(self.view, 0, 1)
        for axis, place in ((self.left, (0, 0)), (self.bottom, (1, 1))):
            axis.linkToView(self.view)
            axis.setZValue(0.5)
            grid.addItem(axis, *place)
        self.setCentralItem(ground)
        self.view.setMouseEnabled(False, False)
        self.view.setDefaultPadding(0)
        self.view.disableAutoRange()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setCacheMode(pg.QtWidgets.QGraphicsView.CacheModeFlag.CacheNone)
        self.setFrameShape(pg.QtWidgets.QFrame.Shape.NoFrame)
        self.setMinimumSize(60, 24)
        self._box: QRectF | None = None
        self._map = (0.0, 1.0, 0.0, 1.0)
        self._grid: list[QLineF] = []
        self.view.geometryChanged.connect(self._invalidate)
        self.view.sigRangeChanged.connect(self._invalidate)
        self.viewport().setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setRenderHint(QPainter.RenderHint.Antialiasing, False)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        theme.changed.connect(self.recolor)
        self.recolor()

    def recolor(self) -> None:
        """Apply the theme's colours, fonts and sizes."""
        beside = max(RIGHT, theme.px(LABEL))
        self._ground.setContentsMargins(0, 0, beside, 0 if self.bottom.isVisible() else 1)
        self.left.setWidth(theme.px(self._left_width))
        self.bottom.setHeight(theme.px(self.below))
        for axis in (self.left, self.bottom):
            axis.setTextPen(theme.color("axis"))
            axis.setStyle(tickFont=theme.font("tick"))
        self.bottom.label.setFont(theme.font("tick"))
        self.bottom.label.setDefaultTextColor(theme.color("ink3"))
        self.setBackground(None)
        self.viewport().update()

    # mapping ------------------------------------------------------------------------------------

    def _invalidate(self, *_: object) -> None:
        self._box = None

    def measure(self) -> QRectF:
        """Update mapping and grid if axes or size have changed; return the plot's rectangle."""
        if self._box is not None:
            return self._box
        box = self._box = self.view.sceneBoundingRect()
        (x0, x1), (y0, y1) = self.view.viewRange()
        across, up = box.width() / (x1 - x0), box.height() / (y1 - y0)
        self._map = box.left() - x0 * across, across, box.bottom() + y0 * up, -up
        columns = np.array(self.bottom.places(x0, x1, box.width()))
        levels = np.array(self.left.places(y0, y1, box.height()))
        columns, levels = self.to_pixels(columns, levels)
        self._grid = [QLineF(x, box.top(), x, box.bottom()) for x in np.round(columns)]
        self._grid += [QLineF(box.left(), y, box.right(), y) for y in np.round(levels)]
        return box

    def to_pixels(self, x: Numbers, y: Numbers) -> tuple[Numbers, Numbers]:
        """Map data to pixels with the mapping of the last ``measure``; painting calls ``measure`` first."""
        left, across, bottom, up = self._map
        return left + x * across, bottom + y * up

    def pixel(self, x: float, y: float) -> QPointF:
        """Map one point to pixels with the mapping of the last ``measure``."""
        return QPointF(*self.to_pixels(x, y))

    def to_x(self, pixel: float) -> float:
        """Map a pixel's column to a value on the x axis."""
        self.measure()
        return (pixel - self._map[0]) / self._map[1]

    # painting -----------------------------------------------------------------------------------

    def paint_under(self, painter: QPainter, box: QRectF) -> None:
        """Paint the layer below the grid."""

    def paint_over(self, painter: QPainter, box: QRectF) -> None:
        """Paint the data, clipped to the frame."""

    def paint_marks(self, painter: QPainter, box: QRectF) -> None:
        """Paint marks that may extend beyond the frame."""

    def drawBackground(self, painter: QPainter, rect: QRectF) -> None:
        """Paint background, lower layer, grid and frame."""
        box = self.measure()
        painter.fillRect(rect, theme.color(self.paper))
        painter.fillRect(box, theme.color("plot"))
        painter.save()
        painter.setClipRect(box)
        self.paint_under(painter, box)
        painter.restore()
        if theme.grid:
            painter.setPen(QPen(theme.color("grid"), 1))
            painter.drawLines(self._grid)
        painter.setPen(QPen(theme.color("line"), theme.frame))
        painter.drawRect(box)

    def drawForeground(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the data, then the marks."""
        box = self.measure()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, True)
        painter.save()
        painter.setClipRect(box)
        self.paint_over(painter, box)
        painter.restore()
        self.paint_marks(painter, box)

    def note(self, painter: QPainter, x: float, y: float, text: str, token: str, right: bool = False) -> None:
        """Write a label with a halo; a label at the edge is shifted into the frame."""
        font, box = theme.font("label"), self.measure()
        width = QFontMetricsF(font).horizontalAdvance(text)
        most = max(box.right() - width - 4, box.left() + 4)
        x = min(max(x - width if right else x, box.left() + 4), most)
        paint_text(painter, x, y, text, font, (token, "plot"), 4.0, self.devicePixelRatioF())

    # pointer ------------------------------------------------------------------------------------

    def mouseMoveEvent(self, event) -> None:
        """Emit the x value at the pointer."""
        super().mouseMoveEvent(event)
        place = event.position()
        self.pointed.emit(self.to_x(place.x()) if self.measure().contains(place) else None)

    def leaveEvent(self, event) -> None:
        """Emit that the pointer has left the plot."""
        super().leaveEvent(event)
        self.pointed.emit(None)

    def mouseDoubleClickEvent(self, event) -> None:
        """Emit the request to fit the axes."""
        self.fit_wanted.emit()

    def contextMenuEvent(self, event) -> None:
        """Show a menu with the added actions."""
        menu = QMenu(self)
        menu.addActions(self.actions())
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(event.globalPos())
