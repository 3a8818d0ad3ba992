"""The hair on the cat's back: it lies with the nap, gives way under the pad, stands where rubbed wrong."""

from functools import cache

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QPainterPath

from hapkit_studio.gui.scenes.actors import Motion
from hapkit_studio.gui.scenes.cat_coat import color
from hapkit_studio.gui.scenes.cat_mood import Mood
from hapkit_studio.gui.scenes.cat_shape import scale, top
from hapkit_studio.gui.scenes.stage import Stage

_FIRST, _LAST = -29.5, 34.5  # mm
_LIES, _FLAT, _BACKWARDS, _STANDS, _BRISTLES = np.radians((38.0, 8.0, 158.0, 62.0, 30.0))
_REACH = 4.5  # mm: how far from the pad a hair is still touched
_LONG, _SHORTER = 6.2, 0.25
_TRACE = 4.0  # mm: a stroke as long as this leaves its full trace
_CURL = 0.35
_THICK = 1.2  # half a root
_TUFT = 3


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
