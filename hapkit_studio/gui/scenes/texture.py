"""Texture: damping bands, ridges or sandpaper, drawn to scale along the rail, with a mark for λ."""

import math

import numpy as np
from PySide6.QtCore import QRectF

from hapkit_studio.environments.texture import BANDS, ENVIRONMENT, GRATING, grain
from hapkit_studio.formatting import compact
from hapkit_studio.gui.scenes.base import Motion, Scene, Values
from hapkit_studio.gui.scenes.parts import BALL, Relief, ground, occupy_stem, riding, sampled
from hapkit_studio.gui.scenes.stage import HALF_TRAVEL, Stage
from hapkit_studio.gui.widgets.theme import theme

# fractions of the picture's height above the rail: level of the ground, largest height above the ground
_LEVEL, _ROOM = 0.40, 0.22
_RIDGE = 6.5  # px at u = 1: half the height of a ridge with a force of 0.25 N and λ = 5 mm
_CLOSE = 10.0  # px: ridges with a smaller spacing have a thin outline
_FINEST = 3.5  # px: ridges or bands with a smaller spacing are drawn as one strip
_WIDE = 14.0  # px at u = 1: the mark spans one λ if one λ is wider than this, otherwise ten λ
_LEAST_BALL = 3.2  # px at u = 1: minimum radius of the ball


def _wave(values: Values) -> float:
    """Return the wavelength λ in mm."""
    return 1e3 * values["wavelength"]


def _fine(stage: Stage, values: Values) -> bool:
    return _wave(values) * stage.per_mm < _FINEST


def _flat(stage: Stage, values: Values) -> bool:
    return height(stage, values) == 0.0 or (values["kind"] == GRATING and _fine(stage, values))


def height(stage: Stage, values: Values) -> float:
    """Return half a ridge's height in px; it grows with force and λ, and is limited by the space."""
    if values["kind"] == BANDS:
        return 0.0
    ratio = values["amplitude"] / 0.25 * _wave(values) / 5.0
    return min(_RIDGE * stage.u * ratio**0.5, _ROOM * stage.band)


def relief(stage: Stage, values: Values) -> Relief:
    """Return the ground: flat for bands, otherwise proportional to the potential energy of the force."""
    return stage.cached("relief", lambda: sampled(stage, _relief(stage, values)))


def _relief(stage: Stage, values: Values) -> Relief:
    level, wave, high = _LEVEL * stage.band, _wave(values), height(stage, values)
    if _flat(stage, values):
        return lambda mm: np.full_like(mm, level + high)
    if values["kind"] != GRATING:
        return lambda mm: level + high * _grains(mm / (0.5 * wave), math.floor(values["seed"]))
    return lambda mm: level + high * np.cos(math.tau * mm / wave)


def _grains(places: np.ndarray, seed: int) -> np.ndarray:
    """Return sandpaper heights (n,) from −1 to 1 at positions (n,) in grains; their slope gives the force."""
    first = math.floor(float(places.min()))
    heights = np.array([grain(n, seed) for n in range(first, math.ceil(float(places.max())) + 2)])
    n = np.floor(places).astype(int) - first
    u = places - np.floor(places)
    rise = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    return 2.0 * (heights[n] + (heights[n + 1] - heights[n]) * rise) - 1.0


def fixed(stage: Stage, values: Values) -> None:
    """Draw the ground, its bands and the mark for λ."""
    kind = values["kind"]
    close = _wave(values) * stage.per_mm < _CLOSE
    ground(stage, relief(stage, values), close and not _flat(stage, values))
    if kind == BANDS and values["damping"] > 0.0:
        _bands(stage, values)
    elif kind == GRATING and _fine(stage, values):
        _shade(stage, -HALF_TRAVEL, HALF_TRAVEL, height(stage, values), -height(stage, values))
    _mark(stage, values)


def _shade(stage: Stage, left: float, right: float, high: float, low: float) -> None:
    """Darken the ground between two positions in mm and two heights in px relative to its level."""
    top = stage.rail - _LEVEL * stage.band - high + 1.3 * stage.u
    area = QRectF(stage.x(left), top, (right - left) * stage.per_mm, high - low)
    stage.p.fillRect(area, theme.color("mat2"))


def _bands(stage: Stage, values: Values) -> None:
    """Shade the damping bands, each half a wavelength wide; very fine bands become one shallow strip."""
    wave, deep = _wave(values), -_LEVEL * stage.band + 2.5 * stage.u
    if _fine(stage, values):
        _shade(stage, -HALF_TRAVEL, HALF_TRAVEL, 0.0, 0.4 * deep)
        return
    for i in range(math.floor(-HALF_TRAVEL / wave), math.ceil(HALF_TRAVEL / wave)):
        left, right = max(i * wave, -HALF_TRAVEL), min((i + 0.5) * wave, HALF_TRAVEL)
        if right > left:
            _shade(stage, left, right, 0.0, deep)


def _measure(stage: Stage, values: Values) -> tuple[float, float, float, int]:
    """Return the mark for λ above the ground: its two end columns, its row, and how many λ it spans.

    The mark spans one λ, or ten if one λ is too short to be visible.
    """
    wave = _wave(values)
    count = 1 if wave * stage.per_mm > _WIDE * stage.u else 10
    left = stage.x(wave * math.ceil(15.0 / wave))
    row = stage.rail - _LEVEL * stage.band - height(stage, values) - 10 * stage.u
    return left, left + count * wave * stage.per_mm, row, count


def _mark(stage: Stage, values: Values) -> None:
    u, (left, right, y, _) = stage.u, _measure(stage, values)
    ends = [[(x, y - 4 * u), (x, y + 4 * u)] for x in (left, right)]
    stage.lines(stage.pen("ink3", 1.4), *ends, [(left, y), (right, y)])


def labels(stage: Stage, values: Values, motion: Motion) -> None:
    """Write the label of λ above or beside its mark, away from the stem."""
    u, (left, right, y, count) = stage.u, _measure(stage, values)
    occupy_stem(stage, motion, stage.rail)
    text = f"{'' if count == 1 else '10 '}λ = {compact(count * _wave(values), 3)} mm"
    places = [
        ((left + right) / 2, y - 8 * u, 0),
        (right + 8 * u, y + 4 * u, 1),
        (left - 8 * u, y + 4 * u, -1),
    ]
    stage.write(text, places, "ink2", 12.5)


def _radius(stage: Stage, values: Values) -> float:
    """Return the ball's radius in px: small enough to fit between ridges, but not below the minimum."""
    fits = BALL * stage.u if height(stage, values) == 0.0 else 0.2 * _wave(values) * stage.per_mm
    return max(min(BALL * stage.u, fits), _LEAST_BALL * stage.u)


moving, tip = riding(relief, _radius)
SCENE = Scene(ENVIRONMENT, fixed, moving, labels, tip)
