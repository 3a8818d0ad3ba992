"""Button: a cap on a dome that snaps through, in front of a base that stays; clicks are counted quietly."""

from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainterPath

from hapkit_studio.environments.button import ENVIRONMENT
from hapkit_studio.gui.scenes.actors import Motion
from hapkit_studio.gui.scenes.declared import Scene, Values
from hapkit_studio.gui.scenes.parts import block, mark, read, surface_line
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.theme import theme

STATES = ENVIRONMENT.state_names
_DEFAULTS = ENVIRONMENT.values()
CAP, NUB = 3.6, 3.4  # mm: how far cap and nub reach from the handle
_SHOULDER, _DIMPLE = 1.8, 0.6  # mm: how far the snapped dome stands out at least, from base and from nub
_DOME = 0.42  # of the band: half the dome's height
_PLATE, _PIN = 0.33, 0.09  # of the band: half the heights of cap and nub


def _surface(values: Values) -> float:
    return 1e3 * values.get("position", _DEFAULTS["position"])


def _base(values: Values) -> float:
    """Return where the base stands in mm: the nub reaches it when the cap has gone its whole travel."""
    return _surface(values) + 1e3 * values.get("travel", _DEFAULTS["travel"]) + CAP + NUB


def fixed(stage: Stage, values: Values) -> None:
    """Mark where the button begins."""
    mark(stage, stage.x(_surface(values)), "button")


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw base, dome and cap."""
    cap = max(motion.position, _surface(values))
    stop, tip = stage.x(_base(values)), stage.x(cap + CAP + NUB)
    block(stage, max(stop, tip), stage.x(50.0))
    if tip > stop:
        surface_line(stage, stop)
    _dome(stage, tip, max(stop, tip), read(motion, STATES, "pressed") > 0.5)
    _cap(stage, cap)
    if cap > _surface(values):
        surface_line(stage, stage.x(_surface(values)))


def _dome(stage: Stage, apex: float, base: float, snapped: bool) -> None:
    """Draw the spring between nub and base: bulging, or with its middle pushed through."""
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
    stage.p.setPen(stage.pen("objline", 1.8))
    stage.p.setBrush(theme.color("obj"))
    pin, plate = _PIN * stage.band, _PLATE * stage.band
    stage.p.drawRoundedRect(QRectF(back - 4 * u, middle - pin, tip - back + 4 * u, 2 * pin), 2 * u, 2 * u)
    stage.p.drawRoundedRect(QRectF(face, middle - plate, back - face, 2 * plate), 4 * u, 4 * u)


def words(stage: Stage, values: Values, motion: Motion) -> None:
    """Count the clicks in and out."""
    downs, ups = read(motion, STATES, "downs"), read(motion, STATES, "ups")
    if downs + ups > 0:
        x, y = stage.x(_surface(values)) - 12 * stage.u, stage.rail - 10 * stage.u
        stage.say(f"{downs:.0f} in, {ups:.0f} out", [(x, y, -1)], "ink2", 12, 500)


SCENE = Scene("button", fixed, moving, words)
