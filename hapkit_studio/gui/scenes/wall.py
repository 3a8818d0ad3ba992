"""Wall: a hatched block whose face gives way under the handle, its surface dashed, the depth in words."""

from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QPainterPath, QPolygonF

from hapkit_studio.gui.scenes.actors import Motion
from hapkit_studio.gui.scenes.declared import Scene, Values
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.theme import number, theme


def _side(values: Values) -> int:
    return -1 if values.get("side", 0.0) else 1


def depth(values: Values, position: float) -> float:
    """Return how deep in mm a position in mm lies behind the surface; negative outside."""
    return _side(values) * (position - 1e3 * values.get("position", 0.0))


def fixed(stage: Stage, values: Values) -> None:
    """Mark the surface below the rail."""
    u, x = stage.u, stage.x(1e3 * values.get("position", 0.0))
    top, low = stage.rail + u, stage.rail + 9 * u
    stage.p.setBrush(theme.color("matline"))
    stage.p.setPen(stage.pen("matline", 0.5))
    stage.p.drawPolygon(QPolygonF([QPointF(x, top), QPointF(x - 4.5 * u, low), QPointF(x + 4.5 * u, low)]))
    stage.say("wall", [(x, stage.rail + 22 * u, 0)], "matline", 12, 600, must=True)


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw the block from the face that the handle pushes to the end of the rail."""
    u, side = stage.u, _side(values)
    surface, inside = stage.x(1e3 * values.get("position", 0.0)), depth(values, motion.position) > 0
    face = stage.x(motion.position) + side * 2.2 * u if inside else surface
    end, top, corner = stage.x(50.0 * side), stage.top + 2 * u, 7 * u * side
    if side * (end - face) > abs(corner):
        _block(stage, face, end, top, corner)
    if inside:
        stage.line(surface, top, surface, stage.rail, stage.pen("matline", 1.6, (4, 4)))


def _block(stage: Stage, face: float, end: float, top: float, corner: float) -> None:
    """Draw the block between its face and the rail's end, the corner at the face rounded."""
    low, inner = stage.rail - 1.25 * stage.u, face + corner
    stage.hatch_rect(QRectF(QPointF(min(inner, end), top), QPointF(max(inner, end), low)))
    edge = QPainterPath(QPointF(inner, top))
    edge.quadTo(face, top, face, top + abs(corner))
    edge.lineTo(face, low)
    strip = QPainterPath(edge)
    strip.lineTo(inner, low)
    stage.fill(strip, stage.hatched())
    edge.moveTo(end, top)
    edge.lineTo(inner, top)
    stage.stroke(edge, stage.pen("matline", 2.6))


def words(stage: Stage, values: Values, motion: Motion) -> None:
    """Write the depth, with an arrow from the surface to the handle where it fits."""
    deep = depth(values, motion.position)
    if deep <= 0:
        return
    u, side = stage.u, _side(values)
    surface, stem = stage.x(1e3 * values.get("position", 0.0)), stage.x(motion.position)
    y = stage.top + stage.band * 0.34
    text = f"d = {number(depth(values, motion.position_text), 2)} mm"
    places = [(surface - side * 9 * u, y + 4 * u, -side), (stem + side * 12 * u, y + 4 * u, side)]
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
