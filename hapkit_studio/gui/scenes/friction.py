"""Friction: a brush on rough ground. Its bristles lean by the friction model's deflection."""

import math

import numpy as np
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QPainterPath

from hapkit_studio.environments.friction import COULOMB, ENVIRONMENT, PROJECTION, SMOOTHED, TETHER
from hapkit_studio.gui.scenes.base import Motion, Scene, Values
from hapkit_studio.gui.scenes.parts import ground
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme

_LEVEL = 0.34  # level of the ground, as a fraction of the picture's height above the rail
_GRAINS = np.random.default_rng(4).uniform(-1.0, 1.0, 101)
_BRISTLES = 9
_HEIGHT = 15.0  # px at u = 1: distance from the pad to the ground
_REACH = 22.0  # px at u = 1: maximum deflection of the bristles, which then lie flat
_STILL = 2.0  # mm: a label is shown if the handle has moved by less than this in the last frames


def _row(stage: Stage) -> float:
    return stage.rail - stage.band * _LEVEL


def _pad(stage: Stage, motion: Motion) -> QRectF:
    u, width, height = stage.u, 46 * stage.u, 16 * stage.u
    return QRectF(stage.x(motion.position) - width / 2, _row(stage) - _HEIGHT * u - height, width, height)


def fixed(stage: Stage, values: Values) -> None:
    """Draw the ground; it is rougher if the friction is stronger."""
    places = np.linspace(-50.0, 50.0, 101)
    height = 3.0 * min(1.6, values["kinetic_force"] / 0.4) ** 0.5 * stage.u
    ground(stage, lambda mm: stage.band * _LEVEL + height * np.interp(mm, places, _GRAINS))


def _sticks(values: Values, motion: Motion) -> bool:
    holds = values["model"] not in (COULOMB, SMOOTHED)
    return holds and motion.state["started"] > 0.5 and motion.state["slides"] == 0.0


def stretch(values: Values, motion: Motion) -> float:
    """Return the offset in mm from the handle to the point where the bristles touch the ground."""
    slides = motion.state["slides"]
    # while the brush slides, the contact point is behind the handle
    if slides and values["model"] in (PROJECTION, TETHER):
        return 1e3 * math.copysign(values["kinetic_force"] / values["tether_stiffness"], slides)
    return 1e3 * motion.state["anchor"] - motion.position if motion.state["started"] > 0.5 else 0.0


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw bristles and pad; while the brush sticks, also draw the anchor."""
    u, pad = stage.u, _pad(stage, motion)
    lean = stretch(values, motion) * stage.per_mm
    bent = max(-_REACH * u, min(_REACH * u, lean))
    _bristles(stage, pad, bent)
    if bent != lean:  # the bristles do not reach the anchor, so a line is drawn to it
        y, anchor = _row(stage) - 2 * u, pad.center().x() + lean
        stage.line(pad.center().x() + bent, y, anchor, y, stage.pen("objline", 1.6))
        stage.p.setBrush(theme.color("obj"))
        stage.p.drawEllipse(QPointF(anchor, y), 3 * u, 3 * u)
    if _sticks(values, motion):
        _anchor(stage, pad.center().x() + lean)
    stage.use(stage.pen("objline", 1.8), "obj")
    stage.p.drawRoundedRect(pad, 4 * u, 4 * u)
    stage.occupied.append(pad)


def _bristles(stage: Stage, pad: QRectF, bent: float) -> None:
    u, low = stage.u, _row(stage) - 2 * stage.u
    path = QPainterPath()
    for i in range(_BRISTLES):
        x = pad.left() + 4 * u + i * (pad.width() - 8 * u) / (_BRISTLES - 1)
        path.moveTo(x, pad.bottom())
        path.quadTo(x + 0.15 * bent, (pad.bottom() + low) / 2, x + bent, low)
    stage.stroke(path, stage.pen("objline", 1.8))


def _anchor(stage: Stage, x: float) -> None:
    """Draw a fixed support under the ends of the bristles."""
    u, y = stage.u, _row(stage) + 5 * stage.u
    half = 23 * u
    starts = [x - half + (4 + 7 * i) * u for i in range(7)]
    hatches = [[(start, y), (start - 5 * u, y + 6 * u)] for start in starts]
    stage.lines(stage.pen("matline", 1.8), [(x - half, y), (x + half, y)], *hatches)


def labels(stage: Stage, values: Values, motion: Motion) -> None:
    """Write "sticks" while the motion is slow enough for the user to read it."""
    slow = not motion.trail or max(motion.trail) - min(motion.trail) < _STILL
    if slow and _sticks(values, motion):
        pad, u = _pad(stage, motion), stage.u
        y = pad.center().y() + 4.5 * u
        stage.write("sticks", [(pad.right() + 9 * u, y, 1), (pad.left() - 9 * u, y, -1)], "ink2", 12, 600)


def tip(stage: Stage, values: Values, motion: Motion) -> float:
    """Return the pixel row inside the pad where the stem ends."""
    return _pad(stage, motion).top() + stage.u


SCENE = Scene(ENVIRONMENT, fixed, moving, labels, tip)
