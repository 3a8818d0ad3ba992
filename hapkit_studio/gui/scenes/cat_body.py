"""The cat's mood, shape, coat and body."""

import math
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPen, QPixmap, QPolygonF

from hapkit_studio.environments.cat import ENVIRONMENT, PURRS_ABOVE, SWAT_TIME, SWATS_BELOW
from hapkit_studio.gui.scenes.base import Motion
from hapkit_studio.gui.scenes.parts import read as number
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.palette import MODES

# part: light, dark, high contrast
COAT: dict[str, tuple[str, str, str]] = {
    "fur": ("#E7A75F", "#D98F48", "#E7A75F"),
    "stripe": ("#C57F3C", "#AD6A2E", "#B56E2C"),
    "hair": ("#8C5321", "#9A5C22", "#5A2F0B"),
    "edge": ("#8C5321", "#5E3614", "#5A2F0B"),
    "cream": ("#FBEBD6", "#F2DCC0", "#FFF6EA"),
    "pink": ("#E9938C", "#E58F88", "#E9938C"),
    "iris": ("#D3DB6C", "#DDE377", "#D3DB6C"),
    "dark": ("#2B1A0C", "#2B1A0C", "#1B0D02"),
    "whisker": ("#8C5321", "#F2E6D6", "#5A2F0B"),
}
BREATH = 0.012  # of the body's height, either way
_CONTENT = 0.1
_FULL_BEND = 3.0  # mm: hairs bent by this are drawn bent as far as they go
HEAD = -38.5, 0.62  # mm along the rail, share of the height: the middle of the face
_KNOTS = np.array([-40.0, -33.0, -29.0, -24.0, -18.0, -10.0, 0.0, 10.0, 18.0, 26.0, 32.0, 36.5])  # mm
_HEIGHTS = np.array([0.36, 0.55, 0.66, 0.735, 0.78, 0.78, 0.755, 0.76, 0.785, 0.755, 0.60, 0.33])
_DIP, _DIP_WIDTH = 0.055, 3.6  # share, mm: fur pressed down by the pad
BACK = np.linspace(-40.0, 36.5, 81)  # mm
_SCALE = np.linspace(-60.0, 60.0, 1201)  # mm
_HEAD_TOP, _HEAD_WIDTH = 0.90, 7.2  # share, mm: what a pad on the head goes over
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


@cache
def _color(part: str, name: str, alpha: float) -> QColor:
    color = QColor(COAT[part][MODES.index(name)])
    color.setAlphaF(alpha)
    return color


def color(part: str, alpha: float = 1.0) -> QColor:
    """Return a part's colour in the theme in force."""
    return _color(part, theme.name, alpha)


def pen(part: str, width: float, alpha: float = 1.0) -> QPen:
    """Return a round pen, its width in the painter's units."""
    pen = QPen(color(part, alpha), width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    return pen


def between(value: float, low: float, high: float) -> float:
    """Return 0..1: where value lies from low to high, which may lie below low."""
    return min(1.0, max(0.0, (value - low) / (high - low)))


@dataclass(frozen=True)
class Mood:
    """Contentment −1..1, breath rad, seconds left of swat and sulk, the swat's direction, bent hair −1..1."""

    contentment: float = 0.0
    breath: float = 0.0
    swat: float = 0.0
    sulk: float = 0.0
    push: float = 1.0
    bend: float = 0.0

    @property
    def word(self) -> str:
        if self.swat > 0.0:
            return "swat"
        if self.sulk > 0.0:
            return "sulking"
        if self.purrs:
            return "purring"
        if self.contentment < -_CONTENT:
            return "annoyed"
        return "content" if self.contentment > _CONTENT else "at rest"

    @property
    def purrs(self) -> bool:
        return self.contentment > PURRS_ABOVE

    @property
    def cross(self) -> bool:
        """Say whether it swats or sulks."""
        return self.swat > 0.0 or self.sulk > 0.0

    @property
    def anger(self) -> float:
        """Return 0..1: nothing yet down to −0.1, all of it where it would swat."""
        return 1.0 if self.swat > 0.0 else between(self.contentment, -_CONTENT, SWATS_BELOW)

    @property
    def ears(self) -> float:
        """Return 0..1: upright, turned back below the mood it swats in."""
        return 1.0 if self.cross else between(self.contentment, -0.35, SWATS_BELOW)

    @property
    def eyes(self) -> float:
        """Return 0..1.15: how far the eyes are open; they fall shut until it purrs."""
        if self.swat > 0.0:
            return 1.15
        if self.sulk > 0.0:
            return 0.5
        if self.purrs:
            return 0.0
        return 0.62 + 0.38 * self.anger - 1.6 * max(0.0, self.contentment)

    @property
    def reach(self) -> float:
        """Return 0..1: how far the paw is out."""
        return math.sin(math.pi * min(1.0, self.swat / SWAT_TIME)) if self.swat > 0.0 else 0.0

    @property
    def chest(self) -> float:
        """Return the body's height as a share of its mean: full as the breath begins to go out."""
        return 1.0 + BREATH * math.cos(self.breath)

    @property
    def tail(self) -> float:
        """Return −1..1: slow with the breath, three times as fast and far in anger."""
        calm, lash = math.sin(self.breath), math.sin(3.0 * self.breath)
        return (0.22 + 0.12 * self.contentment) * calm * (1.0 - self.anger) + self.anger * lash


def read(motion: Motion) -> Mood:
    """Return the mood in the newest row."""
    state = {name: number(motion, ENVIRONMENT.state_names, name) for name in ENVIRONMENT.state_names}
    bent = (motion.position - 1e3 * state["anchor"]) / _FULL_BEND if state["started"] else 0.0
    return Mood(
        min(1.0, max(-1.0, state["contentment"])),
        state["breath"],
        state["swat"],
        state["sulk"],
        math.copysign(1.0, state["push"] or 1.0),
        min(1.0, max(-1.0, bent)),
    )


@cache
def _curve() -> np.ndarray:
    """Return the back's height over _SCALE: cubics through the knots, sloped as their neighbours lie."""
    x = _SCALE
    slopes = np.gradient(_HEIGHTS, _KNOTS)
    i = np.clip(np.searchsorted(_KNOTS, x) - 1, 0, _KNOTS.size - 2)
    width = _KNOTS[i + 1] - _KNOTS[i]
    t = np.clip((x - _KNOTS[i]) / width, 0.0, 1.0)
    y = (1 + 2 * t) * (1 - t) ** 2 * _HEIGHTS[i] + t * (1 - t) ** 2 * width * slopes[i]
    return y + t * t * (3 - 2 * t) * _HEIGHTS[i + 1] + t * t * (t - 1) * width * slopes[i + 1]


def back(mm: np.ndarray | float) -> np.ndarray:
    """Return the resting back's height at places in mm."""
    return np.interp(mm, _SCALE, _curve())


def top(mm: np.ndarray | float, mood: Mood, pad: float) -> np.ndarray:
    """Return the back's height at places in mm: it breathes, and gives way under a pad at pad mm."""
    return back(mm) * mood.chest - _DIP * np.exp(-(((mm - pad) / _DIP_WIDTH) ** 2))


def pad_height(mm: float, mood: Mood) -> float:
    """Return the height that a pad rests at: on the back, over the head, down where the cat ends."""
    body = float(top(mm, mood, mm))
    if mm > _KNOTS[-1]:
        body *= float(np.exp(-(((mm - _KNOTS[-1]) / 4.0) ** 2)))
    head = _HEAD_TOP * float(np.exp(-(((mm - HEAD[0]) / _HEAD_WIDTH) ** 4)))
    if mm < _KNOTS[0]:
        body *= float(np.exp(-(((mm - _KNOTS[0]) / 4.0) ** 2)))
    return max(body, head)


def y(stage: Stage, share: float) -> float:
    """Return the row in px of a share of the cat's height."""
    return stage.rail - 2.0 * stage.u - share * stage.band


def scale(stage: Stage) -> float:
    """Return the px of one unit of head, paw or hair: as the stage is high, but never too wide for it."""
    return min(stage.band / 78.0, 0.4 * stage.per_mm)


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
