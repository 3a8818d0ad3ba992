"""Hard surface: a solid block that rings after an impact. The ringing is drawn over time inside the block."""

import math

import numpy as np
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QPainter, QPainterPath, QPixmap

from hapkit_studio.environments.hard_surface import ENVIRONMENT, ringing
from hapkit_studio.environments.hard_surface import sound as sound_of
from hapkit_studio.gui.scenes.base import Motion, Scene, Values
from hapkit_studio.gui.scenes.parts import block, label, mark, ribbon, surface_line, text_width
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme

_SECONDS = 2e-3  # time scale of the drawn ringing, in s per mm of the block's length
_LARGEST = 3.0  # N: a ringing of this amplitude fills the block's height
_SPEED = 0.1  # m/s: impact speed for the drawing before the first impact
_SHOWN = 0.25  # s: time during which the arcs of an impact are visible
_BAR = 0.02  # s: length of the time scale bar
_ARCS = ((12.0, 0.9), (20.0, 0.6), (28.0, 0.35))  # radius at u = 1, and opacity of each arc


def _face(stage: Stage, values: Values, motion: Motion) -> tuple[float, bool]:
    """Return the pixel column of the block's face, and whether the handle presses the face in."""
    surface = 1e3 * values["position"]
    if motion.position > surface:
        return stage.x(motion.position) + 2.2 * stage.u, True
    return stage.x(surface), False


def sound(values: Values) -> tuple[float, float, float]:
    """Return the amplitude in N per m/s, decay in 1/s and frequency in Hz of the chosen material."""
    return sound_of(*(values[key] for key in ("material", "amplitude", "decay", "frequency")))


def wave(stage: Stage, values: Values, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times (n,) in s, one per pixel, and the ringing (n,) in N after an impact at a speed in m/s."""
    seconds, unit = stage.cached("ringing", lambda: _unit(stage, values))
    limit = values["limit"]
    return seconds, np.clip(speed * unit, -limit, limit)


def _unit(stage: Stage, values: Values) -> tuple[np.ndarray, np.ndarray]:
    longest = 50.0 - 1e3 * values["position"]
    seconds = np.arange(0.0, longest, 1.0 / stage.per_mm) * _SECONDS
    return seconds, np.array([ringing(t, *sound(values)) for t in seconds.tolist()])


def fixed(stage: Stage, values: Values) -> None:
    """Mark the surface below the rail."""
    mark(stage, stage.x(1e3 * values["position"]), "surface")


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw the block, its ringing, and arcs after an impact."""
    face, pressed = _face(stage, values, motion)
    block(stage, face, stage.x(50.0), "mat2", hatched=False)
    if pressed:
        surface_line(stage, stage.x(1e3 * values["position"]))
    since, speed = motion.state.get("since", -1.0), motion.state["speed"]
    sounding = since >= 0.0 and speed > 0.0
    _draw_wave(stage, values, face, speed or _SPEED, since if sounding else math.inf)
    if sounding and since < _SHOWN:
        _arcs(stage, face, 1.0 - since / _SHOWN)


def _draw_wave(stage: Stage, values: Values, face: float, speed: float, since: float) -> None:
    """Draw the ringing after an impact: the past part is pale, the future part is dark."""
    left, ratio = face + 9 * stage.u, stage.ratio
    room = stage.x(48.0) - left
    if room < 12 * stage.u:
        return
    over, left_over = stage.cached("wave", lambda: _pictures(stage, values, speed), of=speed)
    now = min(round(since / _SECONDS * stage.per_mm * ratio) / ratio, room) if since < math.inf else room
    high = over.height() / ratio
    for picture, start, stop in ((over, 0.0, now), (left_over, now, room)):
        source = QRectF(start * ratio, 0.0, (stop - start) * ratio, over.height())
        target = QRectF(round((left + start) * ratio) / ratio, stage.top, stop - start, high)
        stage.p.drawPixmap(target, picture, source)


def _pictures(stage: Stage, values: Values, speed: float) -> tuple[QPixmap, QPixmap]:
    """Return a pale and a dark picture of the whole ringing after an impact; each is as long as the block."""
    seconds, newtons = wave(stage, values, speed)
    rows = 0.47 * stage.band - 0.42 * stage.band / _LARGEST * newtons
    swing = stage.per_mm / (_SECONDS * max(sound(values)[2], 1.0))
    # px: make the line so thin that single oscillations remain visible
    width = min(2.4 * stage.u, max(1.2, 0.2 * swing))
    line = ribbon(seconds / _SECONDS * stage.per_mm, rows, width)
    return _picture(stage, line, "matline"), _picture(stage, line, "handle")


def _picture(stage: Stage, line: QPainterPath, token: str) -> QPixmap:
    picture = QPixmap(math.ceil(stage.width * stage.ratio), math.ceil(stage.band * stage.ratio))
    picture.setDevicePixelRatio(stage.ratio)
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.fillPath(line, theme.color(token))
    painter.end()
    return picture


def _arcs(stage: Stage, face: float, left: float) -> None:
    """Draw the impact's arcs in front of the face; ``left`` is the remaining fraction of their time."""
    u, y = stage.u, stage.top + 0.5 * stage.band
    for radius, opacity in _ARCS:
        r, x = radius * u, face - (7.0 + 0.34 * radius) * u
        path = QPainterPath()
        around = QRectF(x - 0.4 * r, y - r, 2 * r, 2 * r)
        path.arcMoveTo(around, 127)
        path.arcTo(around, 127, 106)
        stage.stroke(path, stage.pen("applied", 2.0, alpha=opacity * left))


def labels(stage: Stage, values: Values, motion: Motion) -> None:
    """Write the ringing's frequency and draw a time scale bar, if the block is wide enough."""
    u, left = stage.u, _face(stage, values, motion)[0] + 9 * stage.u
    bar, y = _BAR / _SECONDS * stage.per_mm, stage.rail - 9 * stage.u
    text = f"{1e3 * _BAR:.0f} ms"
    wide = text_width(stage, text)
    if left + bar + wide + 16 * u > stage.x(50.0):
        return
    stage.line(left, y - 4 * u, left + bar, y - 4 * u, stage.pen("handle", 1.6))
    label(stage, text, left + bar + 6 * u + wide / 2, y, ("ink", "mat2"))
    pitch = f"{sound(values)[2]:,.0f} Hz"
    half = text_width(stage, pitch) / 2
    if left + bar + wide + 24 * u + 2 * half < stage.x(50.0):
        label(stage, pitch, stage.x(50.0) - 8 * u - half, y, ("ink", "mat2"))


SCENE = Scene(ENVIRONMENT, fixed, moving, labels)
