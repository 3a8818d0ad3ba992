"""Free: the handle, with pale copies at its recent positions."""

from hapkit_studio.environments.free import ENVIRONMENT
from hapkit_studio.gui.scenes.base import Motion, Scene, Values, handle, knob
from hapkit_studio.gui.scenes.stage import Stage

ECHOES = ((8, 0.14), (5, 0.26), (2, 0.38))  # age in frames and opacity of each copy
_LEAST = 1.0  # mm: a closer copy would blur the handle


def moving(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw the copies while the handle moves."""
    for ago, opacity in ECHOES:
        if len(motion.trail) > ago and abs(motion.trail[-1 - ago] - motion.position) > _LEAST:
            handle(stage, motion.trail[-1 - ago], alpha=opacity)
            stage.occupied.append(knob(stage, motion.trail[-1 - ago]))


SCENE = Scene(ENVIRONMENT, moving=moving)
