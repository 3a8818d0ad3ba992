"""Bump and valley: a ball rolls on the drawn relief. The felt force may belong to another relief."""

import numpy as np

from hapkit_studio.environments.bump_valley import ENVIRONMENT, height
from hapkit_studio.gui.scenes.base import Scene, Values
from hapkit_studio.gui.scenes.parts import BALL, Relief, ground, riding, sampled, saturating
from hapkit_studio.gui.scenes.stage import HALF_TRAVEL, Stage

# fractions of the picture's height above the rail: level of the ground, largest height above the ground
_LEVEL, _ROOM = 0.42, 0.38
_REFERENCE = 2e-3  # m: a hill of this height is drawn with 63 % of the largest height


def relief(stage: Stage, values: Values) -> Relief:
    """Return the relief: the environment's heights, scaled to fit the scene."""
    return stage.cached("relief", lambda: _relief(stage, values))


def _relief(stage: Stage, values: Values) -> Relief:
    heights = sampled(stage, lambda mm: height(values, 1e-3 * mm))
    highest = float(np.max(np.abs(heights(np.linspace(-HALF_TRAVEL, HALF_TRAVEL, 1001)))))
    scale = saturating(highest, _REFERENCE, _ROOM * stage.band) / max(highest, 1e-12)
    return lambda mm: _LEVEL * stage.band + scale * heights(mm)


def fixed(stage: Stage, values: Values) -> None:
    """Draw the relief."""
    ground(stage, relief(stage, values))


moving, tip = riding(relief, lambda stage, _values: BALL * stage.u)
SCENE = Scene(ENVIRONMENT, fixed, moving, tip=tip)
