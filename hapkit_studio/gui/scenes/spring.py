"""Spring: a coil between a post and the handle, with a dashed line at the rest position."""

from PySide6.QtCore import QPointF

from hapkit_studio.environments.spring import ENVIRONMENT
from hapkit_studio.gui.scenes.base import Motion, Scene, Values
from hapkit_studio.gui.scenes.parts import mark
from hapkit_studio.gui.scenes.stage import Stage

_POST = -46.0  # mm: position of the post
_TURNS = 11


def fixed(stage: Stage, values: Values) -> None:
    """Draw the post and the centre line."""
    x = stage.x(1e3 * values["center"])
    stage.line(x, stage.top, x, stage.rail, stage.pen("ghost", 1.5, (5, 5)))
    mark(stage, x, "x₀")
    stage.post(stage.x(_POST), -1)


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw the coil and its joint on the stem."""
    x, y = stage.x(motion.position), stage.rail - 0.46 * stage.band
    stage.coil(stage.x(_POST), x, y, 15 * stage.u, _TURNS)
    stage.use(None, "matline")
    stage.p.drawEllipse(QPointF(x, y), 5 * stage.u, 5 * stage.u)


SCENE = Scene(ENVIRONMENT, fixed, moving)
