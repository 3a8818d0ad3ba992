"""Wall: a hatched block whose face gives way under the handle, its surface dashed, the depth in words."""

from PySide6.QtCore import QPointF
from PySide6.QtGui import QPainterPath

from hapkit_studio.environments.wall import ENVIRONMENT
from hapkit_studio.gui.scenes.base import Motion, Scene, Values, reader
from hapkit_studio.gui.scenes.parts import block, mark, surface_line
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import number

_value = reader(ENVIRONMENT)


def _side(values: Values) -> int:
    return -1 if _value(values, "side") else 1


def depth(values: Values, position: float) -> float:
    """Return how deep in mm a position in mm lies behind the surface; negative outside."""
    return _side(values) * (position - 1e3 * _value(values, "position"))


def fixed(stage: Stage, values: Values) -> None:
    """Mark the surface below the rail."""
    mark(stage, stage.x(1e3 * _value(values, "position")), "wall")


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw the block from the face that the handle pushes to the end of the rail."""
    side = _side(values)
    surface, inside = stage.x(1e3 * _value(values, "position")), depth(values, motion.position) > 0
    face = stage.x(motion.position) + side * 2.2 * stage.u if inside else surface
    block(stage, face, stage.x(50.0 * side))
    if inside:
        surface_line(stage, surface)


def words(stage: Stage, values: Values, motion: Motion) -> None:
    """Write the depth, with an arrow from the surface to the handle where it fits."""
    deep = depth(values, motion.position)
    if deep <= 0:
        return
    u, side = stage.u, _side(values)
    surface, stem = stage.x(1e3 * _value(values, "position")), stage.x(motion.position)
    y = stage.top + stage.band * 0.34
    read = depth(values, motion.position_text)
    text = f"d = {number(read if read > 0 else deep, 2)} mm"
    places = [
        (surface - side * 9 * u, y + 4 * u, -side),
        (stem + side * 12 * u, y + 4 * u, side),
        ((surface + stem) / 2, y - 8 * u, 0),
    ]
    stage.say(text, places, "ink2", 12.5, 600, must=True)
    a, b = sorted((surface + side * 2 * u, stem - side * 3.5 * u))
    if b - a > 7.5 * u:
        _between(stage, a, b, y)


def _between(stage: Stage, a: float, b: float, y: float) -> None:
    q = 3.2 * stage.u
    path = QPainterPath(QPointF(a, y))
    path.lineTo(b, y)
    for end, d in ((a, 1), (b, -1)):
        path.moveTo(end + d * q, y - q)
        path.lineTo(end, y)
        path.lineTo(end + d * q, y + q)
    stage.stroke(path, stage.pen("ink2", 1.3))


SCENE = Scene("wall", fixed, moving, words)
