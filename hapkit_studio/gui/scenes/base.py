"""How a scene is declared, and what every scene shares: the handle, the hand, and their motion."""

import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPen, QPolygonF

from hapkit_studio.discovery import declared
from hapkit_studio.environments.base import Environment
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import number, theme

RING = 7.5  # px at u = 1: the hand's ring's radius
Values = Mapping[str, float]


@dataclass
class Motion:
    """The newest row as a scene needs it, in mm, mm/s and N; words change slower than what is drawn."""

    position: float = 0.0
    velocity: float = 0.0
    force: float = 0.0
    asked: float = 0.0
    hand: float | None = None
    loose: bool = False
    clamped: bool = False
    stopped: bool = False
    state: np.ndarray = field(default_factory=lambda: np.zeros(0))
    trail: deque[float] = field(default_factory=lambda: deque(maxlen=12))
    force_text: str = "0.00 N"
    position_text: float = 0.0


def handle(stage: Stage, mm: float, tip: float | None = None, alpha: float = 1.0) -> None:
    """Draw knob, stem and foot at a position; with a tip the stem ends there and a mark shows the place."""
    u, x, p = stage.u, stage.x(mm), stage.p
    p.setOpacity(alpha)
    bottom = stage.rail if tip is None else tip
    stage.line(x, stage.knob_top + stage.knob_height, x, bottom, stage.pen("handle", 4.5))
    p.setPen(Qt.PenStyle.NoPen)
    p.setBrush(theme.color("handle"))
    if tip is None:
        p.drawRoundedRect(QRectF(x - 8 * u, stage.rail - 5 * u, 16 * u, 10 * u), 3 * u, 3 * u)
    else:
        low = stage.rail + 8 * u
        p.drawPolygon(
            QPolygonF([QPointF(x, stage.rail - u), QPointF(x - 5 * u, low), QPointF(x + 5 * u, low)])
        )
    p.setPen(QPen(theme.color("scene"), 1.5 * u))
    p.drawRoundedRect(knob(stage, mm), 9 * u, 9 * u)
    for i in (-1, 0, 1):
        column = x + i * 6 * u
        top, low = stage.knob_top + 7 * u, stage.knob_top + stage.knob_height - 7 * u
        stage.line(column, top, column, low, stage.pen("ridge", 2))
    p.setOpacity(1.0)


def knob(stage: Stage, mm: float) -> QRectF:
    """Return the knob's rectangle."""
    return QRectF(stage.x(mm) - stage.knob_width / 2, stage.knob_top, stage.knob_width, stage.knob_height)


def point_out(
    stage: Stage, left: float, right: float, row: float, tokens: tuple[str, str], text: str
) -> bool:
    """Point to what has left the picture and say where it is; left and right are its columns.

    tokens are those of the arrow's fill and of its line; return False while it is in sight.
    """
    if right >= 0.0 and left <= stage.width:
        return False
    u, d = stage.u, 1 if left > stage.width else -1
    edge = stage.width / 2 + d * (stage.width / 2 - 8 * u)
    back = edge - d * 11 * u
    stage.p.setPen(stage.pen(tokens[1], 1.6))
    stage.p.setBrush(theme.color(tokens[0]))
    corners = [QPointF(edge, row), QPointF(back, row - 10 * u), QPointF(back, row + 10 * u)]
    stage.p.drawPolygon(QPolygonF(corners))
    stage.say(text, [(back - d * 10 * u, row + 4.8 * u, -d)], "ink", 13, 600, must=True)
    return True


def beyond(stage: Stage, motion: Motion) -> bool:
    """Point to a handle that has left the picture."""
    x = stage.x(motion.position)
    text = f"handle at {number(motion.position_text, 1)} mm, {motion.force_text}"
    return point_out(stage, x, x, stage.knob_middle, ("handle", "handle"), text)


def ring_place(stage: Stage, hand: float) -> float:
    """Return the ring's column: at the hand, but whole inside the picture."""
    return min(max(stage.x(hand), 11 * stage.u), stage.width - 11 * stage.u)


def apart(stage: Stage, motion: Motion) -> bool:
    """Say whether the hand's ring stands beside the knob."""
    away = abs(ring_place(stage, motion.hand or 0.0) - stage.x(motion.position))
    return motion.hand is not None and away >= stage.knob_width / 2 + 9 * stage.u


def hand_ring(stage: Stage, motion: Motion) -> None:
    """Draw the hand's ring at its target with a dotted line to the knob; round the knob when they meet."""
    if motion.hand is None:
        return
    u, y = stage.u, stage.knob_middle
    x, ring = stage.x(motion.position), ring_place(stage, motion.hand)
    stage.p.setBrush(Qt.BrushStyle.NoBrush)
    if not apart(stage, motion):
        stage.p.setPen(stage.pen("accent", 2.2))
        around = 4.5 * u
        stage.p.drawRoundedRect(
            knob(stage, motion.position).adjusted(-around, -around, around, around), 13 * u, 13 * u
        )
        return
    d = 1 if ring > x else -1
    start, stop = x + d * (stage.knob_width / 2 + 2 * u), ring - d * 9 * u
    if d * (stop - start) > 0 and not motion.loose:
        stage.line(start, y, stop, y, stage.pen("accent", 2.0, (2.5, 3.0)))
    ring_alone(stage, ring)
    stage.taken.append(QRectF(ring - 9 * u, y - 9 * u, 18 * u, 18 * u))


def ring_alone(stage: Stage, x: float) -> None:
    """Draw the hand's ring at a column."""
    u, y = stage.u, stage.knob_middle
    stage.p.setPen(stage.pen("accent", 2.2))
    stage.p.setBrush(theme.color("scene"))
    stage.p.drawEllipse(QPointF(x, y), RING * u, RING * u)
    stage.p.setPen(Qt.PenStyle.NoPen)
    stage.p.setBrush(theme.color("accent"))
    stage.p.drawEllipse(QPointF(x, y), 2.2 * u, 2.2 * u)


def hand_label(stage: Stage, motion: Motion) -> None:
    """Name the hand beside its ring, where there is room."""
    if motion.hand is None or not apart(stage, motion):
        return
    u, x, ring = stage.u, stage.x(motion.position), ring_place(stage, motion.hand)
    d = 1 if ring > x else -1
    text = "your hand, grip released" if motion.loose else "your hand"
    stage.say(text, [(ring + d * 15 * u, stage.knob_middle + 4.5 * u, d)], "accent", 12, 600)


def preparing(stage: Stage, fraction: float | None) -> None:
    """Say that the loop is being prepared, with a bar of how far it is."""
    width, height = 210.0, 6.0
    left, top = stage.width / 2 - width / 2, stage.top + stage.band * 0.45
    stage.say("Preparing the loop, once only", [(stage.width / 2, top - 12, 0)], "ink", 13, 500, must=True)
    stage.p.setPen(Qt.PenStyle.NoPen)
    for token, part in (("grid", 1.0), ("accent", fraction or 0.0)):
        stage.p.setBrush(theme.color(token))
        stage.p.drawRoundedRect(QRectF(left, top, width * min(max(part, 0.0), 1.0), height), 3, 3)


def reader(environment: Environment) -> Callable[[Values, str], float]:
    """Return how a drawing reads a parameter: within its limits, its default if no number is given."""
    known = {p.key: p for p in environment.parameters}

    def read(values: Values, key: str) -> float:
        parameter = known[key]
        value = values.get(key, parameter.default)
        return min(max(value, parameter.low), parameter.high) if math.isfinite(value) else parameter.default

    return read


def _nothing(stage: Stage, values: Values) -> None:
    """Draw nothing."""


def _still(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw nothing."""


@dataclass(frozen=True)
class Scene:
    """One environment's drawing.

    fixed is painted once per size, theme and parameters, marks below the rail included; moving is painted
    behind the handle in every frame; words is called last, when the places taken are known.
    per_newton is the arrow's length in px at u = 1; tip gives the stem's end in px for a shown surface;
    height is the card's in px where there is room.
    """

    key: str
    fixed: Callable[[Stage, Values], None] = _nothing
    moving: Callable[[Stage, Values, Motion], None] = _still
    words: Callable[[Stage, Values, Motion], None] = _still
    tip: Callable[[Stage, Values, Motion], float] | None = None
    per_newton: float = 46.0
    height: int = 236


@cache
def discover() -> dict[str, Scene]:
    """Return every scene of this folder by its key."""
    return {scene.key: scene for scene in declared(__package__, "SCENE", Scene)}


def named(key: str) -> Scene:
    """Return a scene; an environment without a drawing of its own gets the bare handle."""
    return discover().get(key) or Scene(key)
