"""Detents: the ground has wells; a ball at the stem's end settles in the nearest well."""

import numpy as np

from hapkit_studio.environments.detents import ENVIRONMENT
from hapkit_studio.gui.scenes.base import Scene, Values
from hapkit_studio.gui.scenes.parts import BALL, Relief, ground, riding, saturating
from hapkit_studio.gui.scenes.stage import Stage

# fractions of the picture's height above the rail: level of the ground, largest depth of a well
_LEVEL, _ROOM = 0.52, 0.42
_ENERGY = 1.1e-3  # J: a well of this energy is drawn with 63 % of the largest depth
_STEEPEST = 1.6  # maximum ratio of a well's depth to half its width, so that the ball fits into the well
_LEAST_BALL = 3.2  # px at u = 1: minimum radius of the ball


def relief(stage: Stage, values: Values) -> Relief:
    """Return the ground: around each multiple of the pitch, it is a parabola like a spring's energy."""
    pitch, half = 1e3 * values["pitch"], 1e3 * values["half_width"]
    energy = 0.5 * values["stiffness"] * (1e-3 * half) ** 2
    depth = min(saturating(energy, _ENERGY, _ROOM * stage.band), _STEEPEST * half * stage.per_mm)
    level = _LEVEL * stage.band

    def height(mm: np.ndarray) -> np.ndarray:
        off = (mm - pitch * np.floor(mm / pitch + 0.5)) / half
        return level - depth * np.maximum(1.0 - off**2, 0.0)

    return height


def _radius(stage: Stage, values: Values) -> float:
    """Return the ball's radius in px; the ball must fit into a well."""
    half = 1e3 * values["half_width"] * stage.per_mm
    return max(min(BALL * stage.u, 0.5 * half), _LEAST_BALL * stage.u)


def fixed(stage: Stage, values: Values) -> None:
    """Draw the ground."""
    ground(stage, relief(stage, values))


moving, tip = riding(relief, _radius)
SCENE = Scene(ENVIRONMENT, fixed, moving, tip=tip)
