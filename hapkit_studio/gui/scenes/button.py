"""Button: a cap on a snapping dome in front of a fixed base, and the number of clicks."""

from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainterPath

from hapkit_studio.environments.button import ENVIRONMENT
from hapkit_studio.gui.scenes.base import Motion, Scene, Values
from hapkit_studio.gui.scenes.parts import block, mark, occupy_stem, surface_line
from hapkit_studio.gui.scenes.stage import Stage

CAP, NUB = 3.6, 3.4  # mm: thickness of cap and nub
_SHOULDER, _DIMPLE = 1.8, 0.6  # mm: minimum height of the snapped dome above base and nub
_DOME = 0.42  # half the height of the dome, as a fraction of the picture's height above the rail
# half the heights of cap and nub, as fractions of the picture's height above the rail
_PLATE, _PIN = 0.33, 0.09


def _surface(values: Values) -> float:
    return 1e3 * values["position"]


def fixed(stage: Stage, values: Values) -> None:
    """Mark the start of the button's travel."""
    mark(stage, stage.x(_surface(values)), "button")


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw base, dome and cap."""
    cap = max(motion.position, _surface(values))
    stop = _surface(values) + 1e3 * values["travel"] + CAP + NUB  # position of the nub's end at full travel
    tip = stage.x(cap + CAP + NUB)
    # the base is pushed back if the cap moves beyond its full travel
    face = stage.x(max(stop, cap + CAP + NUB))
    block(stage, face, stage.x(50.0))
    if tip > stage.x(stop):
        surface_line(stage, stage.x(stop))
    _dome(stage, tip, face, motion.state["pressed"] > 0.5)
    _cap(stage, cap)
    if cap > _surface(values):
        surface_line(stage, stage.x(_surface(values)))


def _dome(stage: Stage, apex: float, base: float, snapped: bool) -> None:
    """Draw the dome between nub and base: convex, or with its middle snapped through."""
    middle, half = stage.rail - 0.5 * stage.band, _DOME * stage.band
    crown = min(base - _SHOULDER * stage.per_mm, apex - _DIMPLE * stage.per_mm)
    path = QPainterPath()
    for side in (-1, 1):
        edge, shoulder = middle + side * half, middle + side * 0.6 * half
        path.moveTo(base, edge)
        if snapped:
            path.cubicTo(crown, edge, crown, edge, crown, shoulder)
            path.cubicTo(crown, middle + side * 0.3 * half, apex, middle + side * 0.5 * half, apex, middle)
        else:
            path.cubicTo(apex, edge, apex, middle + side * 0.5 * half, apex, middle)
    stage.stroke(path, stage.pen("matline", 2.6))


def _cap(stage: Stage, cap: float) -> None:
    u, middle = stage.u, stage.rail - 0.5 * stage.band
    face, back, tip = stage.x(cap), stage.x(cap + CAP), stage.x(cap + CAP + NUB)
    stage.use(stage.pen("objline", 1.8), "obj")
    pin, plate = _PIN * stage.band, _PLATE * stage.band
    stage.p.drawRoundedRect(QRectF(back - 4 * u, middle - pin, tip - back + 4 * u, 2 * pin), 2 * u, 2 * u)
    stage.p.drawRoundedRect(QRectF(face, middle - plate, back - face, 2 * plate), 4 * u, 4 * u)


def draw_counts(stage: Stage, values: Values, motion: Motion) -> None:
    """Write the number of clicks (pressed and released) in front of the button."""
    downs, ups = motion.state["downs"], motion.state["ups"]
    if downs + ups > 0:
        occupy_stem(stage, motion, stage.rail)
        places = (_surface(values), min(motion.position, _surface(values)), motion.position)
        spots = [(stage.x(place) - 12 * stage.u, stage.rail - 15 * stage.u, -1) for place in places]
        stage.write(f"{downs:.0f} clicks in, {ups:.0f} clicks out", spots, "ink", 13.0, 600)


SCENE = Scene(ENVIRONMENT, fixed, moving, draw_counts)
