"""Cat: lying along the rail, petted by a pad at the handle's tip; its looks are its mood."""

import math

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainterPath, QPen

from hapkit_studio.gui.scenes import cat_body as body
from hapkit_studio.gui.scenes.actors import Motion
from hapkit_studio.gui.scenes.cat_coat import color, pen
from hapkit_studio.gui.scenes.cat_fur import hair
from hapkit_studio.gui.scenes.cat_head import head, purr
from hapkit_studio.gui.scenes.cat_mood import Mood, read
from hapkit_studio.gui.scenes.cat_shape import pad_height, scale, y
from hapkit_studio.gui.scenes.declared import Scene, Values
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.theme import theme

_PAD_WIDE, _PAD_HIGH = 34.0, 11.0
_SHOULDER = -31.0, 0.24  # mm, share of the height
_FARTHEST = 2.0  # mm: as far as the paw can reach
_WORD = -28.5, 0.95  # mm, share: beside the ears, above the back


def tip(stage: Stage, values: Values, motion: Motion) -> float:
    """Return the row where the stem ends, on the pad."""
    return y(stage, pad_height(motion.position, read(motion))) - 4.0 * stage.u


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw the cat, then the pad on it."""
    mood, pad = read(motion), motion.position
    body.tail(stage, mood)
    body.body(stage, mood, pad)
    if mood.reach == 0.0:
        body.paw(stage, *body.NEAR)
    hair(stage, mood, motion)
    head(stage, mood, pad)
    purr(stage, mood)
    _pad(stage, values, motion)
    if mood.reach > 0.0:
        _arm(stage, mood, motion)


def _pad(stage: Stage, values: Values, motion: Motion) -> None:
    u, low = stage.u, tip(stage, values, motion)
    x, wide, high = stage.x(motion.position), _PAD_WIDE * u, _PAD_HIGH * u
    stage.p.setPen(QPen(theme.color("scene"), 1.2 * u))
    stage.p.setBrush(theme.color("handle"))
    stage.p.drawRoundedRect(QRectF(x - wide / 2, low - high / 2, wide, high), high / 2, high / 2)
    stage.taken.append(QRectF(x - wide / 2, stage.top, wide, low - stage.top + high))


def _arm(stage: Stage, mood: Mood, motion: Motion) -> None:
    """Draw the foreleg that goes out to the hand, and its claws' trace at the pad."""
    s, u = scale(stage), stage.u
    shoulder = QPointF(stage.x(_SHOULDER[0]), y(stage, _SHOULDER[1]))
    rest = QPointF(stage.x(body.NEAR[0] + 6.0), y(stage, 0.08))
    reached = min(motion.position - 3.0, _FARTHEST)
    goal = QPointF(stage.x(reached), y(stage, pad_height(reached, mood) - 0.02))
    hand = rest + (goal - rest) * mood.reach
    path = QPainterPath(shoulder)
    bow = QPointF((shoulder.x() + hand.x()) / 2, max(shoulder.y(), hand.y()) + 4.0 * s)
    path.quadTo(bow, hand)
    stage.stroke(path, pen("edge", 15.0 * s + 3.6 * u))
    stage.stroke(path, pen("fur", 15.0 * s))
    stage.p.setPen(Qt.PenStyle.NoPen)
    stage.p.setBrush(color("fur"))
    stage.p.drawEllipse(shoulder, 7.5 * s + 2.6 * u, 7.5 * s + 2.6 * u)
    stage.p.setPen(pen("edge", 1.8 * u))
    stage.p.setBrush(color("cream"))
    stage.p.drawEllipse(hand, 10.0 * s, 9.0 * s)
    _claws(stage, mood, motion)


def _claws(stage: Stage, mood: Mood, motion: Motion) -> None:
    """Draw three strokes that come from where the swat comes from."""
    s, x, row = scale(stage), stage.x(motion.position), tip(stage, {}, motion)
    for i in (-1, 0, 1):
        start = QPointF(x - mood.push * (24.0 + 3.0 * abs(i)) * s, row + (9.0 * i - 6.0) * s)
        path = QPainterPath(start)
        long = 16.0 * s * mood.reach
        path.quadTo(start + QPointF(mood.push * long * 0.5, -3.0 * s), start + QPointF(mood.push * long, 0.0))
        stage.stroke(path, stage.pen("applied", 2.4, alpha=math.sqrt(mood.reach)))


def words(stage: Stage, values: Values, motion: Motion) -> None:
    """Say the mood, beside the ears or where the handle leaves room."""
    row, u = y(stage, _WORD[1]), stage.u
    places = [
        (stage.x(_WORD[0]), row, 1),
        (stage.x(-5.0), row, 1),
        (stage.x(motion.position) + 26 * u, row, 1),
    ]
    stage.say(read(motion).word, places, "ink3", 12.5, 500)


SCENE = Scene("cat", moving=moving, words=words, tip=tip, per_newton=90.0, height=272)
