"""The cat's eyes: closed in contentment, following the hand, slanted in anger."""

from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QPainter, QPainterPath

from hapkit_studio.gui.scenes.cat_coat import color, pen
from hapkit_studio.gui.scenes.cat_mood import Mood, between
from hapkit_studio.gui.scenes.cat_shape import HEAD

_APART, _HALF = 11.6, 6.0  # units
_LEVEL = -0.8
_ASIDE, _AWAY = 1.9, -2.4  # units: how far a pupil goes to follow the hand, and to shun it
_FOLLOWS = 60.0  # mm from the head to where the eyes look as far aside as they can


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
