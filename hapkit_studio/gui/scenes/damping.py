"""Damping: the stem moves in a liquid; a bow wave and a wake grow with its speed."""

import math

from PySide6.QtCore import QPointF
from PySide6.QtGui import QPainterPath, QPolygonF

from hapkit_studio.environments.damping import ENVIRONMENT
from hapkit_studio.gui.scenes.base import Motion, Scene, Values
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme

_WALL = 47.0  # mm: distance of the tank's walls from the centre
_FAST = 150.0  # mm/s: at this speed and above, the wave has its largest height
_STEP = 4.0  # px: distance between points of the surface near the stem


def _level(stage: Stage) -> float:
    return stage.rail - stage.band * 0.62


def _swing(motion: Motion) -> float:
    """Return strength and direction of the wave, from −1 to 1."""
    return max(-1.0, min(1.0, motion.velocity / _FAST))


def _surface(stage: Stage, motion: Motion) -> QPolygonF:
    left, right, level, u = stage.x(-_WALL), stage.x(_WALL), _level(stage), stage.u
    middle, swing = stage.x(motion.position), _swing(motion)
    points = [QPointF(left, level)]
    count = int(100 * u / _STEP)
    for i in range(-count, count + 1):
        x = middle + i * _STEP
        if left < x < right:
            z = math.copysign(1.0, swing) * i * _STEP / u
            wave = 7 * math.exp(-(((z - 12) / 11) ** 2)) - 6 * math.exp(-(((z + 13) / 14) ** 2))
            points.append(QPointF(x, level - u * abs(swing) * wave))
    return QPolygonF([*points, QPointF(right, level)])


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw tank, liquid and wake."""
    u, level = stage.u, _level(stage)
    left, right, low = stage.x(-_WALL), stage.x(_WALL), stage.rail - 1.25 * stage.u
    surface = _surface(stage, motion)
    liquid = QPainterPath()
    liquid.addPolygon(surface)
    liquid.lineTo(right, low)
    liquid.lineTo(left, low)
    liquid.closeSubpath()
    stage.p.fillPath(liquid, theme.color("mat"))
    stage.p.setPen(stage.pen("matline", 2.2))
    stage.p.drawPolyline(surface)
    for x in (left, right):
        stage.line(x, level - 12 * u, x, low, stage.pen("matline", 2.6))
    _wake(stage, motion, left + 4 * u, right - 4 * u)


def _wake(stage: Stage, motion: Motion, left: float, right: float) -> None:
    u, level, swing = stage.u, _level(stage), _swing(motion)
    behind = -math.copysign(1.0, swing)
    for row in (1, 2, 3):
        y = level + (stage.rail - level) * row * 0.25
        for j in range(3):
            start = stage.x(motion.position) + behind * (16 + 26 * j + 6 * row) * u
            stop = start + behind * 24 * u
            if abs(swing) * 3 > j + 0.25 and left < min(start, stop) and max(start, stop) < right:
                path = QPainterPath(QPointF(start, y))
                path.quadTo(start + behind * 6 * u, y - 4 * u, start + behind * 12 * u, y)
                path.quadTo(start + behind * 18 * u, y + 4 * u, stop, y)
                stage.stroke(path, stage.pen("matline", 1.5, alpha=0.75 - 0.2 * j))


SCENE = Scene(ENVIRONMENT, moving=moving)
