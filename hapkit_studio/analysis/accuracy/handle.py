"""The friction scene's models on a handle that should hold under a trembling pull, by the loop's own tick."""

import math

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy import sliders, timing
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import Hand
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings_writer import LoopSettings

# So soft a spring pulls with the same force wherever the handle is: it goes to 1 m for a newton.
_SOFT = 1.0
LEVELS = {"static_force": sliders.STATIC, "kinetic_force": sliders.KINETIC}


def _target(t: np.ndarray) -> np.ndarray:
    return sliders.trembling(t) / _SOFT


def stage(model: str, dt: float, times: int = 1) -> headless.Stage:
    """Return a handle without friction of its own, slid to rest and held by one of the scene's models."""
    law = environments.named("friction")
    handle = SimulatedHapkit(coulomb_force=0.0, max_force=math.inf, initial_velocity=sliders.SLIDES_IN)
    scene = headless.Scene(law, law.values({"model": model, **LEVELS}), handle, LoopSettings(1.0 / dt))
    pull = Hand(stiffness=_SOFT, target=_target, vectorised=True)  # type: ignore[arg-type]
    return headless.stage(scene, pull, times * round(sliders.HELD_SECONDS / dt) + 1)


def prepared(model: str, dt: float, times: int) -> timing.Work:
    """Return what renders the handle."""
    made = stage(model, dt, times)
    made.out.fill(0.0)  # so that the time is the loop's, not the memory's
    return made.run


def error(model: str, dt: float) -> float:
    """Return the drift in m/s."""
    x = stage(model, dt).run()[:, rows.TRUE_POSITION]
    return sliders.drift(dt * np.arange(x.size), x)
