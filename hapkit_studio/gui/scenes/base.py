"""The declaration of a scene, and the parts that every scene has: handle, hand, and their motion."""

import math
from collections import defaultdict, deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QPen

from hapkit_studio.discovery import declared
from hapkit_studio.environments.base import Environment
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import number, theme

RING = 7.5  # px at u = 1: radius of the hand's ring
_LARGEST = 1e6  # limit for values of the state; larger values would not change the picture
Values = Mapping[str, float]


@dataclass
class Motion:
    """The newest telemetry row in mm, mm/s and N; the values shown as texts are updated less often."""

    position: float = 0.0
    velocity: float = 0.0
    force: float = 0.0
    asked: float = 0.0
    hand: float | None = None
    loose: bool = False
    clamped: bool = False
    stopped: bool = False
    state: Values = field(default_factory=lambda: defaultdict(float))
    trail: deque[float] = field(default_factory=lambda: deque(maxlen=12))
    force_text: str = "0.00 N"
    position_text: float = 0.0


class Zone(NamedTuple):
    """A target range for the handle in m; ``token`` is the token of its colour."""

    low: float
    high: float
    name: str
    token: str


def draw_zone(stage: Stage, zone: Zone) -> None:
    """Draw a zone as an area from the rail to the top of the picture, with its name."""
    u, left, right = stage.u, stage.x(1e3 * zone.low), stage.x(1e3 * zone.high)
    box = QRectF(left, stage.top, right - left, stage.rail - stage.top)
    stage.p.fillRect(box, theme.color(zone.token, 0.22))
    for x in (left, right):
        stage.line(x, stage.top, x, stage.rail, stage.pen(zone.token, 2.0))
    places = [(right + 7 * u, stage.rail - 8 * u, 1), (left - 7 * u, stage.rail - 8 * u, -1)]
    stage.write(zone.name, places, zone.token, 12, 600, must=True)


def handle(stage: Stage, mm: float, tip: float | None = None, alpha: float = 1.0) -> None:
    """Draw knob, stem and foot at a position.

    If ``tip`` is given, the stem ends in this pixel row, and a mark on the rail replaces the foot.
    """
    u, x, p = stage.u, stage.x(mm), stage.p
    p.setOpacity(alpha)
    bottom = stage.rail if tip is None else tip
    stage.line(x, stage.knob_top + stage.knob_height, x, bottom, stage.pen("handle", 4.5))
    stage.use(None, "handle")
    if tip is None:
        p.drawRoundedRect(QRectF(x - 8 * u, stage.rail - 5 * u, 16 * u, 10 * u), 3 * u, 3 * u)
    else:
        low = stage.rail + 8 * u
        stage.polygon([(x, stage.rail - u), (x - 5 * u, low), (x + 5 * u, low)])
    p.setPen(QPen(theme.color("scene"), 1.5 * u))
    p.drawRoundedRect(knob(stage, mm), 9 * u, 9 * u)
    for i in (-1, 0, 1):
        column = x + i * 6 * u
        top, low = stage.knob_top + 7 * u, stage.knob_top + stage.knob_height - 7 * u
        stage.line(column, top, column, low, stage.pen("ridge", 2))
    p.setOpacity(1.0)


def knob(stage: Stage, mm: float) -> QRectF:
    """Return the rectangle of the knob."""
    return QRectF(stage.x(mm) - stage.knob_width / 2, stage.knob_top, stage.knob_width, stage.knob_height)


def point_out(
    stage: Stage, left: float, right: float, row: float, tokens: tuple[str, str], text: str
) -> bool:
    """Draw an arrow with a text at the edge if an object is outside the picture.

    ``left`` and ``right`` are the pixel columns of the object's edges; ``tokens`` are the colours of the
    arrow's fill and outline. Return False while the object is visible.
    """
    if right >= 0.0 and left <= stage.width:
        return False
    u, d = stage.u, 1 if left > stage.width else -1
    edge = stage.width / 2 + d * (stage.width / 2 - 8 * u)
    back = edge - d * 11 * u
    stage.use(stage.pen(tokens[1], 1.6), tokens[0])
    stage.polygon([(edge, row), (back, row - 10 * u), (back, row + 10 * u)])
    stage.write(text, [(back - d * 10 * u, row + 4.8 * u, -d)], "ink", 13, 600, must=True)
    return True


def beyond(stage: Stage, motion: Motion) -> bool:
    """Draw an arrow if the handle is outside the picture; return False while the handle is visible."""
    x = stage.x(motion.position)
    text = f"handle at {number(motion.position_text, 1)} mm, {motion.force_text}"
    return point_out(stage, x, x, stage.knob_middle, ("handle", "handle"), text)


def ring_place(stage: Stage, hand: float) -> float:
    """Return the pixel column of the hand's ring: that of the hand, clamped to the picture."""
    return min(max(stage.x(hand), 11 * stage.u), stage.width - 11 * stage.u)


def apart(stage: Stage, motion: Motion) -> bool:
    """Return whether the hand's ring is drawn separately from the knob."""
    away = abs(ring_place(stage, motion.hand or 0.0) - stage.x(motion.position))
    return motion.hand is not None and away >= stage.knob_width / 2 + 9 * stage.u


def hand_ring(stage: Stage, motion: Motion) -> None:
    """Draw the hand's ring at its target with a dotted line to the knob.

    If the target is close to the knob, draw the ring around the knob.
    """
    if motion.hand is None:
        return
    u, y = stage.u, stage.knob_middle
    x, ring = stage.x(motion.position), ring_place(stage, motion.hand)
    if not apart(stage, motion):
        stage.use(stage.pen("accent", 2.2))
        around = 4.5 * u
        box = knob(stage, motion.position).adjusted(-around, -around, around, around)
        stage.p.drawRoundedRect(box, 13 * u, 13 * u)
        return
    d = 1 if ring > x else -1
    start, stop = x + d * (stage.knob_width / 2 + 2 * u), ring - d * 9 * u
    if d * (stop - start) > 0 and not motion.loose:
        stage.line(start, y, stop, y, stage.pen("accent", 2.0, (2.5, 3.0)))
    ring_alone(stage, ring)
    stage.occupied.append(QRectF(ring - 9 * u, y - 9 * u, 18 * u, 18 * u))


def ring_alone(stage: Stage, x: float) -> None:
    """Draw the hand's ring at a pixel column."""
    u, y = stage.u, stage.knob_middle
    stage.use(stage.pen("accent", 2.2), "scene")
    stage.p.drawEllipse(QPointF(x, y), RING * u, RING * u)
    stage.use(None, "accent")
    stage.p.drawEllipse(QPointF(x, y), 2.2 * u, 2.2 * u)


def hand_label(stage: Stage, motion: Motion) -> None:
    """Write a label beside the hand's ring if there is space."""
    if motion.hand is None or not apart(stage, motion):
        return
    u, x, ring = stage.u, stage.x(motion.position), ring_place(stage, motion.hand)
    d = 1 if ring > x else -1
    text = "your hand, grip released" if motion.loose else "your hand"
    stage.write(text, [(ring + d * 15 * u, stage.knob_middle + 4.5 * u, d)], "accent", 12, 600)


def preparing(stage: Stage, fraction: float | None) -> None:
    """Show with a progress bar that the loop is being prepared."""
    width, height = 210.0, 6.0
    left, top = stage.width / 2 - width / 2, stage.top + stage.band * 0.45
    stage.write(
        "Preparing the loop. This happens only once.",
        [(stage.width / 2, top - 12, 0)],
        "ink",
        13,
        500,
        must=True,
    )
    for token, part in (("grid", 1.0), ("accent", fraction or 0.0)):
        stage.use(None, token)
        stage.p.drawRoundedRect(QRectF(left, top, width * min(max(part, 0.0), 1.0), height), 3, 3)


def _nothing(*_given: object) -> None:
    pass


@dataclass(frozen=True)
class Scene:
    """The drawing of one environment; without an environment only the handle is drawn.

    A user's environment may use this scene with different parameters and a different state. ``fixed`` is
    painted once for each size, theme and set of parameters, and includes marks below the rail. ``moving`` is
    painted behind the handle in every frame. ``labels`` is painted last, when the occupied areas are known.
    ``per_newton`` is the force arrow's length in px per newton at u = 1. ``tip`` returns the row in px where
    the stem ends on a surface. ``height`` is the preferred height of the card in px. ``widest`` is the
    maximum width of the picture as a multiple of its height.
    """

    environment: Environment | None = None
    fixed: Callable[[Stage, Values], None] = _nothing
    moving: Callable[[Stage, Values, Motion], None] = _nothing
    labels: Callable[[Stage, Values, Motion], None] = _nothing
    tip: Callable[[Stage, Values, Motion], float] | None = None
    per_newton: float = 46.0
    height: int = 236
    widest: float = math.inf

    def values(self, given: Values) -> Values:
        """Return each parameter clamped to its limits, or its default if it is missing or not finite."""
        parameters = self.environment.parameters if self.environment else ()
        values = {p.key: given.get(p.key, math.nan) for p in parameters}
        return {
            p.key: min(max(values[p.key], p.low), p.high) if math.isfinite(values[p.key]) else p.default
            for p in parameters
        }

    def state(self, row: np.ndarray) -> Values:
        """Return the law's state (n,) by name; a missing or non-finite value becomes 0."""
        names = self.environment.state_names if self.environment else ()
        known = zip(names, row.tolist(), strict=False)
        numbers = {name: min(max(v, -_LARGEST), _LARGEST) for name, v in known if math.isfinite(v)}
        return defaultdict(float, numbers)


@cache
def discover() -> dict[str, Scene]:
    """Return all scenes of this folder by the key of their environment."""
    return {s.environment.key: s for s in declared(__package__, "SCENE", Scene) if s.environment}


def named(key: str) -> Scene:
    """Return the scene with a key; for an unknown key, a scene that shows only the handle."""
    return discover().get(key) or Scene()
