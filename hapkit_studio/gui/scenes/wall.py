"""Wall: a hatched block whose face moves with the handle, a dashed line for the surface, and the depth."""

from hapkit_studio.environments.wall import ENVIRONMENT
from hapkit_studio.gui.scenes.base import Motion, Scene, Values
from hapkit_studio.gui.scenes.parts import block, mark, surface_line
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import number


def _side(values: Values) -> int:
    return -1 if values["side"] else 1


def depth(values: Values, position: float) -> float:
    """Return the depth in mm of a position (in mm) inside the wall; outside the wall it is negative."""
    return _side(values) * (position - 1e3 * values["position"])


def fixed(stage: Stage, values: Values) -> None:
    """Mark the surface below the rail."""
    mark(stage, stage.x(1e3 * values["position"]), "wall")


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw the block from its face to the end of the rail; the handle moves the face if it is in the wall."""
    side = _side(values)
    surface, inside = stage.x(1e3 * values["position"]), depth(values, motion.position) > 0
    face = stage.x(motion.position) + side * 2.2 * stage.u if inside else surface
    block(stage, face, stage.x(50.0 * side))
    if inside:
        surface_line(stage, surface)


def labels(stage: Stage, values: Values, motion: Motion) -> None:
    """Write the depth, with an arrow from the surface to the handle if it fits."""
    deep = depth(values, motion.position)
    if deep <= 0:
        return
    u, side = stage.u, _side(values)
    surface, stem = stage.x(1e3 * values["position"]), stage.x(motion.position)
    y = stage.top + stage.band * 0.34
    read = depth(values, motion.position_text)
    text = f"d = {number(read if read > 0 else deep, 2)} mm"
    places = [
        (surface - side * 9 * u, y + 4 * u, -side),
        (stem + side * 12 * u, y + 4 * u, side),
        ((surface + stem) / 2, y - 8 * u, 0),
    ]
    stage.write(text, places, "ink2", 12.5, 600, must=True)
    a, b = sorted((surface + side * 2 * u, stem - side * 3.5 * u))
    if b - a > 7.5 * u:
        q = 3.2 * u
        heads = [[(end + d * q, y - q), (end, y), (end + d * q, y + q)] for end, d in ((a, 1), (b, -1))]
        stage.lines(stage.pen("ink2", 1.3), [(a, y), (b, y)], *heads)


SCENE = Scene(ENVIRONMENT, fixed, moving, labels)
