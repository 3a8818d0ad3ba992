"""Mass–spring–damper: the handle pushes a block, which a spring and a dashpot connect to a fixed post."""

from PySide6.QtCore import QPointF, QRectF

from hapkit_studio.environments.mass_spring_damper import ENVIRONMENT
from hapkit_studio.formatting import compact
from hapkit_studio.gui.scenes.base import Motion, Scene, Values, point_out
from hapkit_studio.gui.scenes.parts import label, mark, on_object, surface_line, text_width
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import number

_POST = 47.0  # mm: position of the post
_TURNS = 7
_COIL, _DASHPOT = 0.28, 0.74  # vertical positions on the block: distance from the top / height


def _rest(values: Values) -> float:
    return 1e3 * values["rest_position"]


def place(values: Values, motion: Motion) -> float:
    """Return the position of the block's left face in mm."""
    return 1e3 * motion.state["object"] if motion.state["started"] > 0.5 else _rest(values)


def width(values: Values) -> float:
    """Return the block's width: 15 mm, or less if its rest position is close to the post."""
    return min(15.0, max(5.0, 0.5 * (_POST - 8.0 - _rest(values))))


def _body(stage: Stage, values: Values, motion: Motion) -> QRectF:
    """Return the block's rectangle; it is higher for a larger mass, and the handle compresses it."""
    high = stage.band * min(0.9, max(0.6, 0.8 * (values["mass"] / 2.0) ** (1.0 / 3.0)))
    face = place(values, motion)
    right = stage.x(face + width(values))
    left = min(max(stage.x(face), stage.x(motion.position)), right - 2 * stage.u)
    return QRectF(left, stage.rail - 6 * stage.u - high, right - left, high)


def fixed(stage: Stage, values: Values) -> None:
    """Draw the post and mark the spring's rest position."""
    x = stage.x(_rest(values))
    stage.line(x, stage.top, x, stage.rail, stage.pen("ghost", 1.5, (5, 5)))
    mark(stage, x, "rest")
    stage.post(stage.x(_POST), 1)


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw coil, dashpot and block."""
    body = _body(stage, values, motion)
    post = stage.x(_POST)
    if body.right() < post:
        if values["stiffness"] > 0.0:
            y = body.top() + _COIL * body.height()
            stage.coil(body.right(), post, y, min(9 * stage.u, 0.2 * body.height()), _TURNS)
        if values["damping"] > 0.0:
            _dashpot(stage, body.right(), post, body.top() + _DASHPOT * body.height())
    u, p = stage.u, stage.p
    stage.use(None, "objline")
    for part in (0.22, 0.78):
        p.drawEllipse(QPointF(body.left() + part * body.width(), stage.rail - 5 * u), 4 * u, 4 * u)
    stage.use(stage.pen("objline", 1.8), "obj")
    p.drawRoundedRect(body, 5 * u, 5 * u)
    if motion.position > place(values, motion):
        surface_line(stage, stage.x(place(values, motion)), "objline")


def _dashpot(stage: Stage, left: float, right: float, y: float) -> None:
    """Draw a dashpot: its piston is on the block's side, its cylinder on the post's side."""
    length, half = right - left, 8 * stage.u
    mouth, bottom, piston = left + 0.30 * length, left + 0.72 * length, left + 0.42 * length
    cylinder = [(mouth, y - half), (bottom, y - half), (bottom, y + half), (mouth, y + half)]
    rods = [(left, y), (piston, y)], [(bottom, y), (right, y)]
    stage.lines(stage.pen("matline", 2.2), cylinder, *rods)
    stage.line(piston, y - 0.75 * half, piston, y + 0.75 * half, stage.pen("matline", 3))


def labels(stage: Stage, values: Values, motion: Motion) -> None:
    """Write the mass on the block, or above a narrow block."""
    body = _body(stage, values, motion)
    text = f"{compact(values['mass'], 3)} kg"
    where = f"block at {number(place(values, motion), 1)} mm"
    if point_out(stage, body.left(), body.right(), body.center().y(), ("obj", "objline"), where):
        return
    y = body.center().y() + 4.5 * stage.u
    if text_width(stage, text, 13, 700) + 8 * stage.u < body.width():
        label(stage, text, body.center().x(), y, (on_object(), "obj"), 13, 700)
    else:
        stage.write(text, [(body.center().x(), body.top() - 7 * stage.u, 0)], "ink", 13, 700)


SCENE = Scene(ENVIRONMENT, fixed, moving, labels)
