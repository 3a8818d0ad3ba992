"""The cat's head: ears, eyes, face."""

import math
from functools import cache, lru_cache

from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QPainter, QPainterPath, QPen, QPixmap

from hapkit_studio.environments.cat import PURRS_ABOVE
from hapkit_studio.gui.scenes.cat_body import HEAD, Mood, between, color, pen, scale, y
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme

_APART, _HALF = 11.6, 6.0  # units
_LEVEL = -0.8
_ASIDE, _AWAY = 1.9, -2.4  # units: how far a pupil goes to follow the hand, and to shun it
_FOLLOWS = 60.0  # mm from the head to where the eyes look as far aside as they can
_TURN = 4.5  # units: how far the face looks away while it sulks
_EDGE = 1.8
_WIDE, _ABOVE, _BELOW = 47.0, 42.0, 30.0  # units round the middle of the face
_SHADE, _STEP = 0.02, 4.0  # of contentment, mm: finer changes of the face are not drawn


def eyes(p: QPainter, mood: Mood, pad: float) -> None:
    """Draw both eyes, in the head's units."""
    for side in (-1.0, 1.0):
        middle = side * _APART
        if mood.eyes < 0.05:
            _closed(p, middle)
        else:
            _open(p, middle, side, mood, pad)


def _closed(p: QPainter, middle: float) -> None:
    path = QPainterPath(QPointF(middle - 5.2, -1.4))
    path.quadTo(QPointF(middle, 5.4), QPointF(middle + 5.2, -1.4))
    p.strokePath(path, pen("dark", 2.5))


def _open(p: QPainter, middle: float, side: float, mood: Mood, pad: float) -> None:
    """Draw an eye whose upper lid comes down with calm and slants to the nose in anger."""
    slant = 1.6 * max(mood.anger, 0.7 if mood.sulk > 0.0 else 0.0) - 1.3 * between(
        mood.contentment, 0.0, 0.25
    )
    outer = QPointF(middle + side * _HALF, _LEVEL - slant)
    inner = QPointF(middle - side * _HALF, _LEVEL + slant)
    path = QPainterPath(outer)
    path.quadTo(QPointF(middle, _LEVEL - 12.0 * mood.eyes + 0.5 * slant), inner)
    lid = QPainterPath(path)
    path.quadTo(QPointF(middle, _LEVEL + 5.0 + 3.0 * mood.eyes), outer)
    p.fillPath(path, color("iris"))
    p.save()
    p.setClipPath(path, Qt.ClipOperation.IntersectClip)
    _pupil(p, middle, mood, pad)
    p.restore()
    p.strokePath(path, pen("dark", 1.3))
    p.strokePath(lid, pen("dark", 2.3 + 0.5 * mood.anger))


def _pupil(p: QPainter, middle: float, mood: Mood, pad: float) -> None:
    looks = 2.0 * between(pad, HEAD[0] - _FOLLOWS, HEAD[0] + _FOLLOWS) - 1.0
    aside = _AWAY if mood.sulk > 0.0 else _ASIDE * looks
    wide = 1.8 + 1.7 * mood.anger + 0.6 * float(mood.swat > 0.0)
    place = QPointF(middle + aside, _LEVEL + 0.2)
    p.setPen(Qt.PenStyle.NoPen)
    p.setBrush(color("dark"))
    p.drawEllipse(place, wide, 5.2)
    if mood.eyes > 0.45:
        p.setBrush(color("cream"))
        p.drawEllipse(place + QPointF(-1.1, -2.0), 1.0, 1.0)


def head(stage: Stage, mood: Mood, pad: float) -> None:
    """Draw the head; pad is the place in mm that the eyes follow."""
    s, follows = scale(stage), not (mood.purrs or mood.cross)
    gaze = _STEP * round(pad / _STEP) if follows else 0.0
    picture = _picture(s, stage.u, stage.ratio, theme.name, _look(mood), gaze)
    corner = QPointF(stage.x(HEAD[0]) - _WIDE * s, y(stage, HEAD[1]) - _ABOVE * s)
    stage.p.drawPixmap(corner, picture)


def _look(mood: Mood) -> Mood:
    """Return one of a few moods with the same face: each face is painted once for many frames.

    Rounded up, so that what purrs goes on purring and what does not quite purr does not.
    """
    contentment = _SHADE * math.ceil(mood.contentment / _SHADE)
    return Mood(contentment, swat=0.1 * (mood.swat > 0.0), sulk=float(mood.sulk > 0.0))


@lru_cache(maxsize=48)
def _picture(s: float, u: float, ratio: float, look: str, mood: Mood, pad: float) -> QPixmap:
    """Return the head painted at s px a unit; look is the theme's name."""
    wide, high = math.ceil(2 * _WIDE * s * ratio), math.ceil((_ABOVE + _BELOW) * s * ratio)
    picture = QPixmap(wide, high)
    picture.setDevicePixelRatio(ratio)
    picture.fill(Qt.GlobalColor.transparent)
    p = QPainter(picture)
    p.setRenderHint(QPainter.RenderHint.Antialiasing)
    p.scale(s, s)
    p.translate(_WIDE, _ABOVE)
    p.rotate(0.0 if mood.cross else -3.0 * between(mood.contentment, 0.1, 0.5))
    edge = pen("edge", _EDGE * u / s)
    for side in (-1.0, 1.0):
        outer, inner = _ear(side, mood.ears)
        shape(p, outer, "fur", edge)
        p.fillPath(inner, color("pink"))
    shape(p, _skull(), "fur", edge)
    brow, cheeks = _marks()
    p.strokePath(brow, pen("stripe", 3.0))
    p.strokePath(cheeks, pen("stripe", 2.5))
    p.translate(-_TURN if mood.sulk > 0.0 else 0.0, 0.0)
    p.fillPath(_muzzle(), color("cream"))
    eyes(p, mood, pad)
    _mouth(p, mood)
    p.strokePath(_whiskers(mood.ears), pen("whisker", 1.1, 0.85))
    p.end()
    return picture


def shape(p: QPainter, path: QPainterPath, part: str, edge: QPen) -> None:
    """Fill a path with a part's colour and draw its edge."""
    p.fillPath(path, color(part))
    p.strokePath(path, edge)


def _mixed(a: tuple[float, float], b: tuple[float, float], share: float, side: float) -> QPointF:
    return QPointF(side * (a[0] + share * (b[0] - a[0])), a[1] + share * (b[1] - a[1]))


# three curves' points from the outer root over the tip to the inner root: upright, and turned back
_UP = ((24.0, -6.0), (25.0, -30.0), (20.0, -37.0), (9.0, -30.0), (4.0, -19.0))
_BACK = ((25.5, -1.0), (36.0, -8.0), (39.5, -15.0), (24.0, -22.0), (8.0, -18.5))
_UP_INSIDE = ((20.5, -13.0), (21.5, -26.0), (18.8, -31.0), (12.0, -26.0), (9.0, -18.5))
_BACK_INSIDE = ((25.0, -6.5), (32.0, -10.0), (35.0, -13.5), (25.0, -18.5), (17.0, -17.5))


def _ear(side: float, turned: float) -> tuple[QPainterPath, QPainterPath]:
    """Return an ear's outline and its inside, turned back by 0..1."""
    paths = []
    for up, back in ((_UP, _BACK), (_UP_INSIDE, _BACK_INSIDE)):
        root, bow, tip, slope, inner = (_mixed(a, b, turned, side) for a, b in zip(up, back, strict=True))
        path = QPainterPath(root)
        path.quadTo(bow, tip)
        path.quadTo(slope, inner)
        path.closeSubpath()
        paths.append(path)
    return paths[0], paths[1]


def curved(*points: tuple[float, ...]) -> QPainterPath:
    """Return a path: a start (x, y), then lines (2 numbers), quadratic (4) and cubic (6) curves."""
    path = QPainterPath(QPointF(*points[0]))
    for step in points[1:]:
        ends = [QPointF(*step[i : i + 2]) for i in range(0, len(step), 2)]
        (path.lineTo, path.quadTo, path.cubicTo)[len(ends) - 1](*ends)
    return path


@cache
def _skull() -> QPainterPath:
    return curved(
        (-26, 2), (-27, -14, -14, -21, 0, -21), (14, -21, 27, -14, 26, 2), (29, 6, 29, 9, 25, 10),
        (20, 20, 9, 23, 0, 23), (-9, 23, -20, 20, -25, 10), (-29, 9, -29, 6, -26, 2),
    )  # fmt: skip


@cache
def _marks() -> tuple[QPainterPath, QPainterPath]:
    """Return the stripes on the forehead and on the cheeks."""
    brow, cheeks = QPainterPath(), QPainterPath()
    for a in (-6.0, 0.0, 6.0):
        brow.addPath(curved((a * 1.15, -19.0), (a * 0.9, -14.0, a * 0.75, -9.5)))
    for side in (-1.0, 1.0):
        for b in (1.0, 6.2):
            cheeks.addPath(curved((side * 25.0, b), (side * 21.0, b + 0.2, side * 18.2, b - 1.0)))
    return brow, cheeks


@cache
def _muzzle() -> QPainterPath:
    return curved((0, 3.5), (13, 2, 17, 18, 7, 21), (4, 22, -4, 22, -7, 21), (-17, 18, -13, 2, 0, 3.5))


@cache
def _whiskers(drawn_back: float) -> QPainterPath:
    path = QPainterPath()
    for side in (-1.0, 1.0):
        for i, b in enumerate((8.0, 11.5, 15.0)):
            tip = (side * (33.0 - i), b + (i - 1.2) * 4.6 - 5.0 * drawn_back)
            path.addPath(curved((side * 10.5, b * 0.8 + 3.2), (side * 22.0, b * 0.9 + (i - 1) * 1.6, *tip)))
    return path


@cache
def _nose() -> QPainterPath:
    return curved((-3.4, 6), (0, 4.6, 3.4, 6), (2.4, 9.6, 0, 10.2), (-2.4, 9.6, -3.4, 6))


def _mouth(p: QPainter, mood: Mood) -> None:
    """Draw nose and mouth: a smile, a frown, or the teeth."""
    line = pen("dark", 1.9)
    if mood.swat > 0.0:
        p.fillPath(
            curved((-6, 13), (0, 10, 6, 13), (6.5, 21.5, 0, 21.5), (-6.5, 21.5, -6, 13)), color("dark")
        )
        for side in (-1.0, 1.0):
            p.fillPath(curved((side * 5.0, 12.8), (side * 3.6, 17.6), (side * 2.2, 11.9)), color("cream"))
    else:
        smile = (
            1.0 + 0.35 * between(mood.contentment, 0.0, 0.5) - 2.2 * max(mood.anger, float(mood.sulk > 0.0))
        )
        p.strokePath(curved((0, 10.2), (0, 12.2)), line)
        low, corner = 12.4 + 4.6 * smile, 12.6 - 0.8 * smile
        p.strokePath(curved((-7, corner), (-3.5, low, 0, 12.4), (3.5, low, 7, corner)), line)
    shape(p, _nose(), "pink", pen("dark", 0.9))


def purr(stage: Stage, mood: Mood) -> None:
    """Draw the arcs at the throat: as many as the cat is content, paler outwards."""
    if mood.cross:
        return
    s, x, row = scale(stage), stage.x(HEAD[0]), y(stage, HEAD[1])
    for i, alpha in enumerate((1.0, 0.65, 0.35)):
        if mood.contentment > PURRS_ABOVE + 0.1 * i:
            far = 31.0 + 7.0 * i
            path = QPainterPath(QPointF(x + (far * 0.86 + 4) * s, row + (13 - i * 3.2) * s))
            bow, end = QPointF((4 + i) * s, (6 + i * 2.4) * s), QPointF(0.0, (12 + i * 5) * s)
            start = path.currentPosition()
            path.quadTo(start + bow, start + end)
            stage.stroke(path, stage.pen("accent", 2.0, alpha=alpha))
