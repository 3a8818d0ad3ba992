"""Puck: a disc of true size between two walls. An arrow and pale copies show its velocity."""

from PySide6.QtCore import QRectF, Qt

from hapkit_studio.environments import puck as law
from hapkit_studio.environments.puck import ENVIRONMENT
from hapkit_studio.gui.scenes.base import Motion, Scene, Values, point_out
from hapkit_studio.gui.scenes.parts import block
from hapkit_studio.gui.scenes.stage import HALF_TRAVEL, Stage
from hapkit_studio.gui.widgets.theme import number, theme

# mm: radius of the puck, and distance of each wall from the rail's centre
RADIUS, WALL = 1e3 * law.RADIUS, 1e3 * (law.REACH + law.RADIUS)
_LEAST_WIDTH = 2.0  # mm: minimum width of a compressed puck
_ECHOES = ((3, 0.12), (2, 0.20), (1, 0.32))  # age in steps of _STEP, and opacity, of each pale copy
_STEP = 0.03  # s: age difference between two copies
_SLOW = 0.01  # m/s: below this speed no arrow and no copies are drawn
_PER_SPEED = 130.0  # px at u = 1: length of the arrow per m/s
_LONGEST = 46.0
# maximum ratio of the picture's width to its height; a wider picture is too low for a round puck
_WIDEST = 4.6


def place(motion: Motion) -> float:
    """Return the position of the puck's centre in mm."""
    return 1e3 * (motion.state["object"] if motion.state["started"] > 0.5 else law.START)


def outline(stage: Stage, motion: Motion) -> QRectF:
    """Return the puck's outline.

    It is narrower if the handle or a wall compresses the puck, and lower if the scene has little height.
    """
    middle, side = place(motion), motion.state["side"]
    left = max(middle - RADIUS, min(-WALL, middle + RADIUS - _LEAST_WIDTH))
    right = min(middle + RADIUS, max(WALL, middle - RADIUS + _LEAST_WIDTH))
    if side > 0.0:
        left = min(max(left, motion.position), right - _LEAST_WIDTH)
    elif side < 0.0:
        right = max(min(right, motion.position), left + _LEAST_WIDTH)
    half = RADIUS * stage.per_mm
    row = stage.rail - half - 2 * stage.u
    return QRectF(stage.x(left), row - half, (right - left) * stage.per_mm, 2 * half)


def fixed(stage: Stage, values: Values) -> None:
    """Draw the walls."""
    for side in (-1, 1):
        block(stage, stage.x(side * WALL), stage.x(side * HALF_TRAVEL))


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw the copies, the puck and the arrow."""
    shape, speed = outline(stage, motion), motion.state["object_velocity"]
    if abs(speed) > _SLOW:
        _echoes(stage, motion, shape, speed)
    stage.use(stage.pen("objline", 1.8), "obj")
    stage.p.drawEllipse(shape)
    stage.p.setBrush(Qt.BrushStyle.NoBrush)
    stage.p.drawEllipse(shape.center(), 0.21 * shape.width(), 0.21 * shape.height())
    if abs(speed) > _SLOW:
        _arrow(stage, shape, speed)


def _echoes(stage: Stage, motion: Motion, shape: QRectF, speed: float) -> None:
    """Draw pale copies at the puck's earlier positions, which are computed from its current speed."""
    stage.p.setPen(Qt.PenStyle.NoPen)
    side = motion.state["side"]
    low = max(-WALL, motion.position if side > 0.0 else -WALL) + RADIUS
    high = min(WALL, motion.position if side < 0.0 else WALL) - RADIUS
    for steps, opacity in _ECHOES:
        was = place(motion) - 1e3 * speed * _STEP * steps
        if low <= was <= high:
            stage.p.setBrush(theme.color("obj", opacity))
            half = RADIUS * stage.per_mm
            echo = QRectF(stage.x(was) - half, shape.top(), 2 * half, shape.height())
            stage.p.drawEllipse(echo)


def _arrow(stage: Stage, shape: QRectF, speed: float) -> None:
    u, d, y = stage.u, 1 if speed > 0 else -1, shape.center().y()
    start = (shape.right() if d > 0 else shape.left()) + d * 7 * u
    end = start + d * min(max(abs(speed) * _PER_SPEED, 10.0), _LONGEST) * u
    head = [(end - d * 7 * u, y - 5 * u), (end, y), (end - d * 7 * u, y + 5 * u)]
    stage.lines(stage.pen("velocity", 2.4), [(start, y), (end, y)], head)


def labels(stage: Stage, values: Values, motion: Motion) -> None:
    """Point with an arrow to a puck that is outside the picture."""
    shape = outline(stage, motion)
    text = f"puck at {number(place(motion), 1)} mm"
    point_out(stage, shape.left(), shape.right(), shape.center().y(), ("obj", "objline"), text)


SCENE = Scene(ENVIRONMENT, fixed, moving, labels, widest=_WIDEST)
