"""The cat, which the handle strokes with a pad. The pad bends the cat's hairs, which bristle in anger.

The picture is assets/scenes/cat.svg; each of its groups is painted according to mood and breath.
"""

import math
import re
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPainterPath, QPen, QPixmap
from PySide6.QtSvg import QSvgRenderer

from hapkit_studio import resources
from hapkit_studio.environments.cat import ENVIRONMENT, PURRS_ABOVE, SWAT_TIME, SWATS_BELOW
from hapkit_studio.gui.scenes.base import Motion, Scene, Values
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.palette import MODES

# colours of each part in the light, the dark and the high-contrast theme
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
_PER_MM, _HIGH = 2.5, 78.0  # units of the SVG picture per mm along the rail; height of the cat in these units
# pivots of the parts: (position along the rail in mm, height as a fraction of the cat's height)
_GROUND, _ROOT, _FACE, _EYES = (0.0, 0.0), (34.0, 0.20), (-38.5, 0.62), (-38.5, 0.63)
_PAW, _SHOULDER, _WORD = (-35.5, 0.075), (-31.0, 0.24), (-28.5, 0.95)
# length of the tail in units from root to tip; amplitude of its swing in degrees
_TAIL_LONG, _SWING = 62.0, 14.0
_BREATH = 0.012  # amplitude of the breath, as a fraction of the body's height
# the cat is at rest if its contentment is within ±_CONTENT; bend in mm at which hairs are drawn fully bent
_CONTENT, _FULL_BEND = 0.1, 3.0
_ASIDE, _AWAY = 1.9, -2.4  # shift of the pupils towards the hand, and away from it, in units of the picture
_FARTHEST = 2.0  # mm: maximum reach of the paw
_MM = np.arange(-60.0, 60.1, 0.2)
_FIRST, _LAST = -27.0, 35.0  # mm: positions of the first and the last hair
_FLAT, _BACKWARDS, _LIES, _BRISTLES = np.radians((8.0, 158.0, 38.0, 30.0))
_REACH = 4.5  # mm: the pad bends the hairs within this radius
_TUFT = 3
_PAD_WIDE, _PAD_HIGH = 34.0, 11.0


@dataclass(frozen=True)
class Mood:
    """The cat's contentment −1..1, breath in rad, and bend of the hairs −1..1.

    ``swat`` and ``sulk`` are the times in s for which the cat still swats or sulks.
    """

    contentment: float = 0.0
    breath: float = 0.0
    swat: float = 0.0
    sulk: float = 0.0
    bend: float = 0.0

    @property
    def word(self) -> str:
        if self.swat > 0.0 or self.sulk > 0.0:
            return "swat" if self.swat > 0.0 else "sulking"
        if self.contentment > _CONTENT:
            return "purring" if self.contentment > PURRS_ABOVE else "content"
        return "annoyed" if self.contentment < -_CONTENT else "at rest"

    @property
    def anger(self) -> float:
        """Return the anger 0..1: 0 above a contentment of −0.1, and 1 when the cat swats."""
        return (
            1.0 if self.swat > 0.0 else float(np.interp(-self.contentment, (_CONTENT, -SWATS_BELOW), (0, 1)))
        )

    @property
    def eyes(self) -> float:
        """Return the opening of the eyes 0..1; they are closed while the cat purrs."""
        if self.sulk > 0.0 and self.swat <= 0.0:
            return 0.5
        return float(np.interp(self.contentment, (0.0, PURRS_ABOVE), (1.0, 0.0)))

    @property
    def reach(self) -> float:
        """Return the extension of the paw 0..1."""
        return math.sin(math.pi * min(1.0, self.swat / SWAT_TIME)) if self.swat > 0.0 else 0.0

    @property
    def chest(self) -> float:
        """Return the body's height relative to its mean; it is largest when the cat starts to breathe out."""
        return 1.0 + _BREATH * math.cos(self.breath)

    @property
    def tail(self) -> float:
        """Return the position of the tail −1..1; in anger it swings three times as fast and as far."""
        return 0.25 * math.sin(self.breath) * (1.0 - self.anger) + self.anger * math.sin(3.0 * self.breath)


def read(motion: Motion) -> Mood:
    """Return the mood that follows from the law's state."""
    state = motion.state
    bent = (motion.position - 1e3 * state["anchor"]) / _FULL_BEND if state["started"] else 0.0
    contentment, bend = min(1.0, max(-1.0, state["contentment"])), min(1.0, max(-1.0, bent))
    return Mood(contentment, state["breath"], state["swat"], state["sulk"], bend)


# the picture ------------------------------------------------------------------------------------


def color(part: str) -> QColor:
    """Return a part's colour in the current theme."""
    return QColor(COAT[part][MODES.index(theme.name)])


@lru_cache(maxsize=3)
def _drawing(_theme: str) -> QSvgRenderer:
    """Return the picture in the current theme's colours; ``_theme`` is only the cache key."""
    text = resources.path("scenes", "cat.svg").read_text(encoding="utf-8")
    colors = {name: color(name).name() for name in COAT}
    return QSvgRenderer(re.sub(r"@(\w+)", lambda m: colors.get(m[1]) or theme.tokens[m[1]], text).encode())


@lru_cache(maxsize=64)
def _picture(
    names: tuple[str, ...], across: float, up: float, ratio: float, theme_name: str
) -> tuple[QPointF, QPixmap]:
    """Return an image of some groups of the drawing, and its upper left corner in units.

    ``across`` and ``up`` are the scale in px per unit.
    """
    drawing, box = _drawing(theme_name), QRectF()
    for name in names:
        box |= drawing.boundsOnElement(name)
    box.adjust(-1, -1, 1, 1)
    picture = QPixmap(math.ceil(box.width() * across * ratio), math.ceil(box.height() * up * ratio))
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.scale(across * ratio, up * ratio)
    painter.translate(-box.topLeft())
    for name in names:
        drawing.render(painter, name, drawing.boundsOnElement(name))
    painter.end()
    picture.setDevicePixelRatio(ratio)
    return box.topLeft(), picture


def part(
    stage: Stage, names: tuple[str, ...], pivot: tuple[float, float], scale: tuple[float, float],
    at: QPointF | None = None, turn: float = 0.0, stretch: float = 1.0,
) -> None:  # fmt: skip
    """Paint groups of the drawing, rotated by ``turn`` degrees around a pivot and stretched vertically."""
    corner, picture = _picture(names, *scale, stage.ratio, theme.name)
    stage.p.save()
    stage.p.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
    stage.p.translate(at or _at(stage, *pivot))
    stage.p.rotate(turn)
    stage.p.scale(1.0, stretch)
    away = corner - QPointF(pivot[0] * _PER_MM, -pivot[1] * _HIGH)
    stage.p.drawPixmap(QPointF(away.x() * scale[0], away.y() * scale[1]), picture)
    stage.p.restore()


@cache
def _outline(*names: str) -> np.ndarray:
    """Return the upper outline (n,) of some groups at the positions _MM, as a fraction of the height."""
    image = QImage(2 * int(_PER_MM * 120) + 1, 220, QImage.Format.Format_Alpha8)
    image.fill(0)
    painter = QPainter(image)
    painter.scale(2.0, 2.0)
    painter.translate(_PER_MM * 60.0, 110.0)
    drawing = _drawing(theme.name)
    for name in names:
        drawing.render(painter, name, drawing.boundsOnElement(name))
    painter.end()
    seen = np.frombuffer(image.constBits(), np.uint8).reshape(220, -1)[:, : len(_MM)] > 127
    return np.where(seen.any(axis=0), (110.0 - 0.5 * seen.argmax(axis=0)) / _HIGH, 0.0)


@cache
def _path_of_the_pad() -> np.ndarray:
    """Return the height (n,) of the pad above the rail at the positions _MM, relative to the cat's height."""
    beside = np.lib.stride_tricks.sliding_window_view(np.pad(_outline("body", "head"), 10), 21).max(axis=1)
    return np.convolve(np.pad(beside, 10, "edge"), np.full(21, 1.0 / 21.0), "valid")


def pad_height(mm: float, mood: Mood) -> float:
    """Return the pad's height as a fraction of the cat's height."""
    return float(np.interp(mm, _MM, _path_of_the_pad())) * mood.chest


def y(stage: Stage, share: float) -> float:
    """Return the pixel row at a fraction of the cat's height."""
    return stage.rail - 2.0 * stage.u - share * stage.band


def _at(stage: Stage, mm: float, share: float) -> QPointF:
    return QPointF(stage.x(mm), y(stage, share))


def _unit(stage: Stage) -> float:
    """Return the scale of head, paw and hair in px per unit, so that they fit in the scene."""
    return min(stage.band / _HIGH, stage.per_mm / _PER_MM)


# painting ---------------------------------------------------------------------------------------


def tip(stage: Stage, values: Values, motion: Motion) -> float:
    """Return the pixel row where the stem ends on the pad."""
    return y(stage, pad_height(motion.position, read(motion))) - 4.0 * stage.u


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw the cat, then the pad."""
    mood, s = read(motion), _unit(stage)
    tail = min(s, (stage.width - stage.x(_ROOT[0])) / _TAIL_LONG)
    part(stage, ("tail",), _ROOT, (tail, tail), turn=_SWING * mood.tail)
    part(stage, ("body",), _GROUND, (stage.per_mm / _PER_MM, stage.band / _HIGH), stretch=mood.chest)
    if mood.reach == 0.0:
        part(stage, ("paw",), _PAW, (s, s))
    _hair(stage, mood, motion.position)
    _head(stage, mood, motion.position)
    _pad(stage, tip(stage, values, motion), stage.x(motion.position))
    if mood.reach > 0.0:
        _arm(stage, mood, motion.position)


def _head(stage: Stage, mood: Mood, pad: float) -> None:
    """Draw the head; the eyes follow ``pad``, a position in mm."""
    scale = (_unit(stage),) * 2
    cross = mood.swat > 0.0 or mood.sulk > 0.0
    ears = "ears_back" if cross or mood.contentment < SWATS_BELOW else "ears_up"
    mouth = "calm" if not cross and mood.contentment >= -_CONTENT else "cross"
    part(stage, (ears, "head", f"mouth_{'hiss' if mood.swat > 0.0 else mouth}"), _FACE, scale)
    if mood.eyes == 0.0:
        part(stage, ("eyes_closed",), _EYES, scale)
    else:
        part(stage, ("eyes_cross" if mood.anger > 0.5 else "eyes_open",), _EYES, scale, stretch=mood.eyes)
        looks = float(np.interp(pad - _FACE[0], (-60.0, 60.0), (-_ASIDE, _ASIDE)))
        aside = _AWAY if mood.sulk > 0.0 else looks
        part(
            stage, ("pupils",), _EYES, scale, _at(stage, *_EYES) + QPointF(aside * scale[0], 0.0),
            stretch=mood.eyes,
        )  # fmt: skip
    if not cross:
        arcs = [f"purr_{i}" for i in range(3) if mood.contentment > PURRS_ABOVE + 0.1 * i]
        if arcs:
            part(stage, tuple(arcs), _FACE, scale)


def angles(place: np.ndarray, mood: Mood, pad: float) -> np.ndarray:
    """Return each hair's angle to the back in rad: at 0 it points to the tail, at π to the head."""
    near = np.exp(-(((place - pad) / _REACH) ** 2))
    pressed = _FLAT + max(0.0, -mood.bend) * (_BACKWARDS - _FLAT)
    return (_LIES + _BRISTLES * mood.anger) * (1.0 - near) + pressed * near


@cache
def _hairs(step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return each hair's position in mm, length in units and rotation in rad."""
    rng = np.random.default_rng(11)
    place = np.arange(_FIRST, _LAST, step)
    place += rng.uniform(-0.2, 0.2, place.size)
    return place, rng.uniform(5.2, 7.8, place.size), np.radians(rng.uniform(-6.0, 6.0, place.size))


def _hair(stage: Stage, mood: Mood, pad: float) -> None:
    """Draw the hairs along the back as thin crescents."""
    place, long, turn = _hairs(0.72 if stage.u > 1.2 else 1.0)
    back = _outline("body") * mood.chest * stage.band
    row, slope = np.interp(place, _MM, back), np.interp(place, _MM, np.gradient(back, _MM * stage.per_mm))
    angle = np.arctan(slope) + angles(place, mood, pad) + turn
    long = long * _unit(stage) * (1.0 + 0.2 * mood.anger)
    x, low = stage.width / 2 + place * stage.per_mm, stage.rail - 0.6 * stage.u - row
    bow_x, bow_y = x + 0.5 * long * np.cos(angle + 0.35), low - 0.5 * long * np.sin(angle + 0.35)
    half_x, half_y = 1.2 * stage.u * np.sin(angle), 1.2 * stage.u * np.cos(angle)
    points = np.column_stack((
        x - half_x, low - half_y, bow_x - half_x, bow_y - half_y,
        x + long * np.cos(angle), low - long * np.sin(angle),
        bow_x + half_x, bow_y + half_y, x + half_x, low + half_y,
    )).tolist()  # fmt: skip
    for i in range(0, len(points), _TUFT):  # draw a few hairs per path, because a long path is slow
        path = QPainterPath()
        path.setFillRule(Qt.FillRule.WindingFill)
        for a, b, c, d, e, f, g, h, k, m in points[i : i + _TUFT]:
            path.moveTo(a, b)
            path.quadTo(c, d, e, f)
            path.quadTo(g, h, k, m)
        stage.p.fillPath(path, color("hair"))


def _pad(stage: Stage, row: float, x: float) -> None:
    wide, high = _PAD_WIDE * stage.u, _PAD_HIGH * stage.u
    stage.use(QPen(theme.color("scene"), 1.2 * stage.u), "handle")
    stage.p.drawRoundedRect(QRectF(x - wide / 2, row - high / 2, wide, high), high / 2, high / 2)
    stage.occupied.append(QRectF(x - wide / 2, stage.top, wide, row - stage.top + high))


def _arm(stage: Stage, mood: Mood, pad: float) -> None:
    """Draw the foreleg, which reaches for the hand, and its paw."""
    s, reached = _unit(stage), min(pad - 3.0, _FARTHEST)
    shoulder, rest = _at(stage, *_SHOULDER), _at(stage, *_PAW)
    hand = rest + (_at(stage, reached, pad_height(reached, mood) - 0.02) - rest) * mood.reach
    for part_name, wide in (("edge", 18.0), ("fur", 15.0)):
        stroke = QPen(color(part_name), wide * s, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap)
        stage.line(shoulder.x(), shoulder.y(), hand.x(), hand.y(), stroke)
    part(stage, ("paw",), _PAW, (s, s), hand)


def labels(stage: Stage, values: Values, motion: Motion) -> None:
    """Write the mood beside the ears, or beside the handle."""
    row = y(stage, _WORD[1])
    places = [
        (x, row, 1) for x in (stage.x(_WORD[0]), stage.x(-5.0), stage.x(motion.position) + 26 * stage.u)
    ]
    stage.write(read(motion).word, places, "ink3", 12.5, 500)


SCENE = Scene(ENVIRONMENT, moving=moving, labels=labels, tip=tip, per_newton=90.0, height=272, widest=3.75)
