"""An axis of a plot: where its ticks stand and what they say."""

import pyqtgraph as pg
from PySide6.QtCore import QRectF

from hapkit_studio.gui.plots.ticks import labels, step, ticks

_OVERHANG = 40  # px a label may stand out beside the frame
_TICK_ROOM = {"left": 15.0, "bottom": 56.0}  # px from one label to the next
_MOST = {"left": 5, "bottom": 6}


class Axis(pg.AxisItem):
    """Tick labels only: at most five, true minus, the last one with the unit if given."""

    def __init__(self, orientation: str, unit: str = ""):
        super().__init__(orientation, maxTickLength=0)
        self.enableAutoSIPrefix(False)
        self.unit = unit
        offset = 7 if orientation == "left" else 4
        self.setCacheMode(pg.QtWidgets.QGraphicsItem.CacheMode.DeviceCoordinateCache)
        self.setStyle(tickTextOffset=offset, autoExpandTextSpace=False, hideOverlappingLabels=_OVERHANG)
        self.setPen(pg.mkPen(None))

    def room(self, size: float) -> tuple[int, float]:
        """Return how many ticks fit into so many pixels, and how many steps."""
        return _MOST[self.orientation], max(size / _TICK_ROOM[self.orientation], 1.0)

    def tickValues(self, minVal: float, maxVal: float, size: float) -> list:
        return [(step(minVal, maxVal, *self.room(size)), self.places(minVal, maxVal, size))]

    def places(self, low: float, high: float, size: float) -> list[float]:
        """Return where ticks and grid lines stand between two values so many pixels apart."""
        return ticks(low, high, *self.room(size))

    def resizeEvent(self, ev=None):
        """Write the labels anew: an update alone leaves those of the old height in Qt's cached picture."""
        super().resizeEvent(ev)
        mode = self.cacheMode()
        self.setCacheMode(pg.QtWidgets.QGraphicsItem.CacheMode.NoCache)
        self.setCacheMode(mode)

    def generateDrawSpecs(self, p):
        """Leave out the tick lines, the grid says the same; keep labels at the edge whole."""
        specs = super().generateDrawSpecs(p)
        return specs and (specs[0], [], [(self._whole(box), *rest) for box, *rest in specs[2]])

    def _whole(self, box: QRectF) -> QRectF:
        """Return a label's box moved into the widget from above and below."""
        view = self.getViewWidget()
        if self.orientation == "left" and view is not None:
            room = self.mapRectFromScene(QRectF(view.viewport().rect()))
            box.moveTop(max(min(box.top(), room.bottom() - box.height()), room.top()))
        return box

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        texts = labels(list(values))
        if self.unit and texts:
            texts[-1] += f" {self.unit}"
        return texts
