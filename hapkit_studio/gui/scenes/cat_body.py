"""The cat's body: flank, stripes, belly, haunch, paws and tail."""

import math
from functools import lru_cache

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPainterPath, QPixmap, QPolygonF

from hapkit_studio.gui.scenes.cat_coat import color, pen
from hapkit_studio.gui.scenes.cat_mood import Mood
from hapkit_studio.gui.scenes.cat_shape import BACK, back, scale, top, y
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.theme import theme

# mm, share of the height, mm: where a stripe hangs from the back, how long and how wide it is
_STRIPES = (
    (-19.0, 0.34, 2.0), (-13.5, 0.42, 2.3), (-7.5, 0.36, 2.2), (-1.0, 0.42, 2.4), (5.5, 0.36, 2.3),
    (12.0, 0.42, 2.4), (18.5, 0.36, 2.2), (25.0, 0.33, 2.0), (30.0, 0.26, 1.7),
)  # fmt: skip
_RINGS = (0.12, 0.30, 0.48, 0.66, 0.82, 0.95)
HIND, FAR, NEAR = (10.5, 25.0, 0.15), (-45.5, -33.0, 0.16), (-42.5, -28.5, 0.15)
_EDGE = 1.8
_STRIPE_BELOW = 0.012
_TAIL_ROOM = 84.0  # units from its root to as far as it swings


def _at(stage: Stage, mm: float, share: float) -> QPointF:
    return QPointF(stage.x(mm), y(stage, share))


def tail(stage: Stage, mood: Mood) -> None:
    """Draw the tail: it swings with the mood and bristles in anger."""
    root, sway = _at(stage, 34.0, 0.20), mood.tail
    s = min(scale(stage), (stage.width - root.x()) / _TAIL_ROOM)
    x, low = root.x(), y(stage, 0.0)
    lean = 14.0 * sway * s
    first = [
        root,
        QPointF(x + 34 * s, low),
        QPointF(x + 52 * s, y(stage, 0.12)),
        QPointF(x + 45 * s + 0.35 * lean, y(stage, 0.5)),
    ]
    second = [
        first[3],
        QPointF(x + 38 * s + 0.7 * lean, y(stage, 0.88)),
        QPointF(x + 24 * s + 1.2 * lean, y(stage, 0.98)),
        QPointF(x + 42 * s + 2.0 * lean, y(stage, 1.06 - 0.05 * abs(sway))),
    ]
    path = QPainterPath(root)
    path.cubicTo(*first[1:])
    path.cubicTo(*second[1:])
    thick = 1.0 + 0.35 * mood.anger
    stage.stroke(path, pen("edge", 12.0 * thick * s + 2 * _EDGE * stage.u))
    stage.stroke(path, pen("fur", 12.0 * thick * s))
    rings = QPainterPath()
    for t in _RINGS:
        _ring(rings, path, t, 5.0 * thick * s)
    ring = pen("stripe", 3.4 * s)
    ring.setCapStyle(Qt.PenCapStyle.FlatCap)
    stage.stroke(rings, ring)


def _ring(rings: QPainterPath, path: QPainterPath, t: float, half: float) -> None:
    """Add a bar across a path at a share of its length."""
    middle, angle = path.pointAtPercent(t), np.radians(path.angleAtPercent(t))
    across = QPointF(half * np.sin(angle), half * np.cos(angle))
    rings.moveTo(middle - across)
    rings.lineTo(middle + across)


def body(stage: Stage, mood: Mood, pad: float) -> None:
    """Draw flank, stripes, belly, haunch and the paws that never move."""
    columns = stage.width / 2 + BACK * stage.per_mm
    rows = stage.rail - 2.0 * stage.u - top(BACK, mood, pad) * stage.band
    line = [QPointF(a, b) for a, b in zip(columns.tolist(), rows.tolist(), strict=True)]
    path = QPainterPath()
    path.addPolygon(QPolygonF(line))
    path.connectPath(_under(stage))
    # the outline as a second body behind, a little higher: a stroke along the back takes five times as long
    stage.fill(path.translated(0.0, -_EDGE * stage.u), color("edge"))
    stage.fill(path, color("fur"))
    _stripes(stage, mood, pad)
    left, row, picture = _still(stage.width, stage.height, stage.ratio, theme.name)
    stage.p.drawPixmap(QPointF(left, row), picture)


def _under(stage: Stage) -> QPainterPath:
    """Return the outline from the end of the back round to its beginning."""
    path = QPainterPath(_at(stage, float(BACK[-1]), float(back(BACK[-1]))))
    path.cubicTo(_at(stage, 39, 0.16), _at(stage, 39, 0), _at(stage, 33, 0))
    path.lineTo(_at(stage, -36, 0))
    path.cubicTo(_at(stage, -40.5, 0), _at(stage, -41.5, 0.2), _at(stage, -40, 0.36))
    return path


def _stripes(stage: Stage, mood: Mood, pad: float) -> None:
    """Draw the wedges that hang from the back: over the left edge to the right one, to the tip and back."""
    mm, long, wide = np.array(_STRIPES).T
    left, middle, right = top(np.array([mm - wide / 2, mm, mm + wide / 2]), mood, pad) - _STRIPE_BELOW
    columns = (mm - wide / 2, mm + 0.6, mm + wide / 2, mm + 1.6, mm + 1.2, mm - 0.4)
    shares = (left, middle - 0.008, right, middle - 0.55 * long, middle - long, middle - 0.5 * long)
    x = stage.width / 2 + np.array(columns).T * stage.per_mm
    rows = stage.rail - 2.0 * stage.u - np.array(shares).T * stage.band
    for (a, b, c, d, e, f), (g, h, i, j, k, m) in zip(x.tolist(), rows.tolist(), strict=True):
        path = QPainterPath(QPointF(a, g))
        path.quadTo(b, h, c, i)
        path.quadTo(d, j, e, k)
        path.quadTo(f, m, a, g)
        stage.fill(path, color("stripe"))


@lru_cache(maxsize=2)
def _still(width: float, height: float, ratio: float, look: str) -> tuple[float, float, QPixmap]:
    """Return what neither breathes nor gives way, painted once per size and theme, and its corner."""
    stage = Stage(width, height, ratio)
    row = math.floor(stage.top)
    picture = QPixmap(math.ceil(width * ratio), math.ceil((stage.rail + 4 * stage.u - row) * ratio))
    picture.setDevicePixelRatio(ratio)
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    stage.begin(painter)
    painter.translate(0.0, -row)
    belly = QPainterPath(_at(stage, -33, 0.015))
    belly.cubicTo(_at(stage, -28, 0.26), _at(stage, -6, 0.20), _at(stage, 10, 0.17))
    belly.cubicTo(_at(stage, 16, 0.15), _at(stage, 18, 0.05), _at(stage, 18, 0.015))
    stage.fill(belly, color("cream", 0.9))
    stage.stroke(_flank(stage), pen("stripe", 1.2 * stage.u, 0.75))
    haunch = QPainterPath(_at(stage, 17, 0.05))
    haunch.cubicTo(_at(stage, 15, 0.42), _at(stage, 24, 0.60), _at(stage, 31, 0.44))
    stage.stroke(haunch, pen("edge", _EDGE * stage.u))
    stage.stroke(_under(stage), pen("edge", _EDGE * stage.u))
    paw(stage, *HIND)
    paw(stage, *FAR)
    painter.end()
    return 0.0, row, picture


def _flank(stage: Stage) -> QPainterPath:
    """Return the short strokes of hair on the side."""
    rng, s, path = np.random.default_rng(11), scale(stage), QPainterPath()
    for mm, share in zip(
        rng.uniform(-30, 30, 70).tolist(), rng.uniform(0.24, 0.62, 70).tolist(), strict=True
    ):
        if share < back(mm) - 0.1 and not (16 < mm < 33 and share < 0.5):
            start = _at(stage, mm, share)
            path.moveTo(start)
            path.quadTo(start + QPointF(2.5 * s, 1.4 * s), start + QPointF(5.5 * s, 1.2 * s))
    return path


def paw(stage: Stage, left: float, right: float, high: float) -> None:
    """Draw a paw on the ground from left to right mm."""
    u, row, low = stage.u, y(stage, high), y(stage, -0.012)
    x, wide = stage.x(left), (right - left) * stage.per_mm
    round_ = min((low - row) * 0.5, wide / 2)
    stage.p.setPen(pen("edge", _EDGE * u))
    stage.p.setBrush(color("cream"))
    stage.p.drawRoundedRect(QRectF(x, row, wide, low - row), round_, round_)
    tall = low - row
    for toe in (0.10, 0.19):
        column = x + wide * toe + 2 * u
        stage.line(column, row + tall * 0.42, column, row + tall * 0.78, pen("edge", 1.4 * u))
