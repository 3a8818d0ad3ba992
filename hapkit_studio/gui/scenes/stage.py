"""The geometry of a scene (±50 mm on a rail), and drawing functions for all scenes.

Lengths are in pixels, positions on the rail in mm. ``u`` is the scale of all fixed sizes: it is 1.0 at a
scene height of 150 px, and 1.32 at 236 px. ``widest`` is the maximum width of the picture as a multiple of
its height; the space beside the picture is empty.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QFont, QFontMetricsF, QPainter, QPainterPath, QPen, QPolygonF

from hapkit_studio.gui.widgets.text import paint_text
from hapkit_studio.gui.widgets.theme import number, theme

T = TypeVar("T")
Place = tuple[float, float]

HALF_TRAVEL = 50.0  # mm: length of the rail on each side of the centre
_BESIDE = 4.0  # px: minimum distance between labels
_FAR = 1000.0  # mm: positions are clipped to this value, which is outside the picture
_CORNER = 8.0  # px: corner radius of a card


class Stage:
    """Geometry, painter and drawing functions for one size and one theme."""

    def __init__(self, width: float, height: float, ratio: float = 1.0, widest: float = math.inf):
        self.width, self.height, self.ratio = width, height, ratio
        grown = min(max(1.0 + (height / theme.scale - 150.0) / 86.0 * 0.32, 1.0), 1.45)
        self.u = u = theme.scale * grown
        self.text_scale = theme.scale * (1.0 + (grown - 1.0) * 0.55)
        pad = 16.0 * u
        self.per_mm = max((min(width, widest * height) - 2.0 * pad) / (2.0 * HALF_TRAVEL), 0.1)
        self.rail = height - 32.0 * u
        self.knob_top, self.knob_height, self.knob_width = 14.0 * u, 26.0 * u, 34.0 * u
        self.knob_middle = self.knob_top + self.knob_height / 2
        self.top = self.knob_top + self.knob_height + 10.0 * u
        self.band = self.rail - self.top
        self.p: QPainter = None  # type: ignore[assignment]
        self.occupied: list[QRectF] = []
        self.texts: list[QRectF] = []
        self._kept: list[QRectF] = []
        self._kept_texts: list[QRectF] = []
        self._fonts: dict[tuple[float, int], tuple[QFont, QFontMetricsF]] = {}
        self._made: dict[str, tuple[object, Any]] = {}

    def begin(self, painter: QPainter) -> None:
        """Start a frame with this painter; mark only the areas of the fixed parts as occupied."""
        self.p = painter
        self.occupied, self.texts = list(self._kept), list(self._kept_texts)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)

    def keep_occupied(self) -> None:
        """Store the occupied areas of the fixed parts for all later frames."""
        self._kept, self._kept_texts = list(self.occupied), list(self.texts)

    def cached(self, name: str, make: Callable[[], T], of: object = None) -> T:
        """Return the cached result of ``make``; call ``make`` again if ``of`` has changed.

        Parameters, size and theme do not change during a stage's life.
        """
        if name not in self._made or self._made[name][0] != of:
            self._made[name] = of, make()
        return self._made[name][1]

    def x(self, mm: float) -> float:
        """Return the pixel column of a position in mm."""
        return self.width / 2 + max(-_FAR, min(_FAR, mm)) * self.per_mm

    def mm(self, x: float) -> float:
        """Return the position in mm of a pixel column."""
        return (x - self.width / 2) / self.per_mm

    # strokes and fills --------------------------------------------------------------------------

    def pen(self, token: str, width: float = 1.5, dash: tuple[float, ...] = (), alpha: float = 1.0) -> QPen:
        """Return a pen with round joins; ``width`` and ``dash`` are in units of u."""
        cap = Qt.PenCapStyle.FlatCap if dash else Qt.PenCapStyle.RoundCap
        pen = QPen(theme.color(token, alpha), width * self.u, Qt.PenStyle.SolidLine, cap)
        pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        if dash:
            pen.setDashPattern([d / width for d in dash])
        return pen

    def line(self, x1: float, y1: float, x2: float, y2: float, pen: QPen) -> None:
        """Draw a straight line."""
        self.p.setPen(pen)
        self.p.drawLine(QPointF(x1, y1), QPointF(x2, y2))

    def use(self, pen: QPen | None, fill: str = "") -> None:
        """Set the pen (None: no outline) and the fill colour ("": no fill) of the following shapes."""
        self.p.setPen(pen or Qt.PenStyle.NoPen)
        self.p.setBrush(theme.color(fill) if fill else Qt.BrushStyle.NoBrush)

    def polygon(self, corners: Iterable[Place]) -> None:
        """Draw a closed shape."""
        self.p.drawPolygon(QPolygonF([QPointF(*corner) for corner in corners]))

    def lines(self, pen: QPen, *lines: Sequence[Place]) -> None:
        """Draw polylines."""
        path = QPainterPath()
        for line in lines:
            path.addPolygon(QPolygonF([QPointF(*place) for place in line]))
        self.stroke(path, pen)

    def stroke(self, path: QPainterPath, pen: QPen) -> None:
        """Draw a path's outline only."""
        self.use(pen)
        self.p.drawPath(path)

    def hatch(self, path: QPainterPath, token: str = "mat") -> None:
        """Fill a path with a hatched colour, which marks parts that do not move."""
        self.p.fillPath(path, theme.color(token))
        self.p.fillPath(path, QBrush(theme.color("mat2"), Qt.BrushStyle.BDiagPattern))

    # text -----------------------------------------------------------------------------------------

    def font(self, size: float, weight: int) -> tuple[QFont, QFontMetricsF]:
        """Return the scene's font and its metrics; ``size`` is the size in px at u = 1."""
        if (size, weight) not in self._fonts:
            font = theme.font("body")
            font.setPixelSize(round(max(11.5, size * self.text_scale)))
            font.setWeight(QFont.Weight(weight))
            self._fonts[size, weight] = font, QFontMetricsF(font)
        return self._fonts[size, weight]

    def write(
        self, text: str, places: list[tuple[float, float, int]], token: str, size: float = 12.0,
        weight: int = 500, must: bool = False, wipe: bool = False,
    ) -> bool:  # fmt: skip
        """Write a text at the first free place (x, base line, side); return whether it was written.

        If ``must`` is True and no place is free, use the first place inside the scene. If ``wipe`` is True,
        clear the background, so that no other drawing is visible between the letters.
        """
        font, metrics = self.font(size, weight)
        wide, high = metrics.horizontalAdvance(text), metrics.capHeight() + 6
        boxes = [(p, QRectF(p[0] - wide * (1 - p[2]) / 2, p[1] - high + 3, wide, high)) for p in places]
        inside = [(place, box) for place, box in boxes if box.left() >= 2 and box.right() <= self.width - 2]
        free = [(place, box) for place, box in inside if not self._is_occupied(box)]
        chosen = free or (inside or boxes if must else [])
        if not chosen:
            return False
        (_, y, _), box = chosen[0]
        self.occupied.append(box)
        self.texts.append(box)
        if wipe:
            self.p.fillRect(box.adjusted(-_BESIDE, 0, _BESIDE, 0), theme.color("scene"))
        paint_text(self.p, box.left(), y, text, font, (token, "scene"), 4.0 * self.u, self.ratio)
        return True

    def _is_occupied(self, box: QRectF) -> bool:
        wide = box.adjusted(-_BESIDE, 0, _BESIDE, 0)
        return any(wide.intersects(other) for other in self.occupied)

    # shared parts -------------------------------------------------------------------------------

    def ground(self) -> None:
        """Draw the background with faint lines every 10 mm."""
        outline = QPainterPath()
        inside = theme.px(_CORNER) - theme.frame
        outline.addRoundedRect(QRectF(0, 0, self.width, self.height), inside, inside)
        self.p.fillPath(outline, theme.color("scene"))
        pen = QPen(theme.color("scenegrid"), 1)
        for mm in range(-50, 51, 10):
            x = round(self.x(mm)) + 0.5
            self.line(x, 8 * self.u, x, self.rail, pen)

    def axis(self) -> None:
        """Draw the rail with ticks every 5 mm, and numbers every 20 mm where there is space."""
        self.line(self.x(-50), self.rail, self.x(50), self.rail, self.pen("rail", 2.5))
        for mm in range(-50, 51, 5):
            length = (7 if mm % 10 == 0 else 4) * self.u
            self.line(self.x(mm), self.rail, self.x(mm), self.rail + length, self.pen("rail", 1.2))
        for mm in range(-40, 41, 20):
            unit = " mm" if mm == 40 else ""
            # shift the text by half the unit's width, so that the number alone is centred at the tick
            x = self.x(mm) + 0.5 * self.font(11.5, 400)[1].horizontalAdvance(unit)
            self.write(number(mm, 0) + unit, [(x, self.rail + 22 * self.u, 0)], "ink3", 11.5, 400)

    def coil(self, x0: float, x1: float, y: float, height: float, turns: int) -> None:
        """Draw a spring between two columns."""
        if x1 <= x0:
            return
        lead = min(8.0 * self.u, 0.2 * (x1 - x0))
        length = x1 - x0 - 2 * lead
        width = min(2.4, max(0.7, 0.45 * length / (2 * turns * self.u)))
        step = 0.5 * length / turns
        coil = [(x0 + lead + (i + 0.5) * step, y + (height if i % 2 else -height)) for i in range(2 * turns)]
        self.lines(self.pen("matline", width), [(x0, y), (x0 + lead, y), *coil, (x1 - lead, y), (x1, y)])

    def post(self, x: float, side: int) -> None:
        """Draw a fixed support with its face at x."""
        width, top = 10.0 * self.u, self.top + 4 * self.u
        body = QPainterPath()
        body.addRect(QRectF(x if side > 0 else x - width, top, width, self.rail - top))
        self.hatch(body, "scene")
        self.line(x, top, x, self.rail, self.pen("matline", 2.6))
