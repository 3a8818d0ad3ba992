"""The cat: stroked by a pad, its hairs lie with the nap, flatten under the pad, stand when rubbed wrong."""

import math
from functools import cache

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainterPath, QPen

from hapkit_studio.gui.scenes import cat_body as body
from hapkit_studio.gui.scenes.base import Motion, Scene, Values
from hapkit_studio.gui.scenes.cat_body import Mood, color, pad_height, pen, read, scale, top, y
from hapkit_studio.gui.scenes.cat_head import head, purr
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme

_FIRST, _LAST = -29.5, 34.5  # mm
_LIES, _FLAT, _BACKWARDS, _STANDS, _BRISTLES = np.radians((38.0, 8.0, 158.0, 62.0, 30.0))
_REACH = 4.5  # mm: how far from the pad a hair is still touched
_LONG, _SHORTER = 6.2, 0.25
_TRACE = 4.0  # mm: a stroke as long as this leaves its full trace
_CURL = 0.35
_THICK = 1.2  # half a root
_TUFT = 3
_PAD_WIDE, _PAD_HIGH = 34.0, 11.0
_SHOULDER = -31.0, 0.24  # mm, share of the height
_FARTHEST = 2.0  # mm: as far as the paw can reach
_WORD = -28.5, 0.95  # mm, share: beside the ears, above the back


@cache
def _hairs(step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return each hair's place in mm, length in units and turn in rad."""
    rng = np.random.default_rng(11)
    place = np.arange(_FIRST, _LAST, step)
    place += rng.uniform(-0.2, 0.2, place.size)
    return place, _LONG + rng.uniform(-1.0, 1.6, place.size), np.radians(rng.uniform(-6.0, 6.0, place.size))


def angles(place: np.ndarray, mood: Mood, motion: Motion) -> np.ndarray:
    """Return each hair's angle in rad over the back, 0 flat towards the tail, pi flat towards the head."""
    pad, bend = motion.position, mood.bend
    near = np.exp(-(((place - pad) / _REACH) ** 2))
    pressed = _FLAT + max(0.0, -bend) * (_BACKWARDS - _FLAT)
    lying = _LIES + _BRISTLES * mood.anger + _trace(place, motion)
    return lying * (1.0 - near) + pressed * near


def _trace(place: np.ndarray, motion: Motion) -> np.ndarray:
    """Return the turn in rad of the hairs just stroked: up where it went against the nap, down with it."""
    start = motion.trail[0] if motion.trail else motion.position
    way = start - motion.position
    if abs(way) < 0.5:
        return np.zeros_like(place)
    fresh = np.clip((start - place) / way, 0.0, 1.0) * ((place - motion.position) * way > 0.0)
    most = _STANDS if way > 0.0 else -0.5 * _LIES
    return most * fresh * min(1.0, abs(way) / _TRACE)


def hair(stage: Stage, mood: Mood, motion: Motion) -> None:
    """Draw the hairs along the back."""
    s, pad = scale(stage), motion.position
    place, long, turn = _hairs(0.72 if stage.u > 1.2 else 1.0)
    row = top(place, mood, pad)
    slope = (top(place + 0.5, mood, pad) - top(place - 0.5, mood, pad)) * stage.band / stage.per_mm
    angle = np.arctan(slope) + angles(place, mood, motion) + turn
    near = np.exp(-(((place - pad) / _REACH) ** 2))
    long = long * s * (1.0 - _SHORTER * near) * (1.0 + 0.2 * mood.anger)
    x = stage.width / 2 + place * stage.per_mm
    y = stage.rail - 2.0 * stage.u - row * stage.band + 1.4 * stage.u
    bow_x, bow_y = x + 0.5 * long * np.cos(angle + _CURL), y - 0.5 * long * np.sin(angle + _CURL)
    half_x, half_y = _THICK * stage.u * np.sin(angle), _THICK * stage.u * np.cos(angle)
    points = (
        x - half_x, y - half_y, bow_x - half_x, bow_y - half_y,
        x + long * np.cos(angle), y - long * np.sin(angle),
        bow_x + half_x, bow_y + half_y, x + half_x, y + half_y,
    )  # fmt: skip
    _fill(stage, np.column_stack(points).tolist())


def _fill(stage: Stage, hairs: list[list[float]]) -> None:
    """Fill hairs, each from root over a bow to the tip and back, a few in one path: many would be slow."""
    ink = color("hair")
    for i in range(0, len(hairs), _TUFT):
        path = QPainterPath()
        path.setFillRule(Qt.FillRule.WindingFill)
        for a, b, c, d, e, f, g, h, k, m in hairs[i : i + _TUFT]:
            path.moveTo(a, b)
            path.quadTo(c, d, e, f)
            path.quadTo(g, h, k, m)
        stage.fill(path, ink)


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
