"""The simulated handle of loop settings."""

import math

from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import LoopSettings


def simulated_handle(
    settings: LoopSettings, real: bool = True, position: float = 0.0, velocity: float = 0.0
) -> SimulatedHapkit:
    """Return the handle that starts at position m and velocity m/s, without a force limit.

    real=False: without Coulomb friction and sensor steps, as the exact limits have it.
    """
    coulomb, quantum = (settings.coulomb, settings.quantum) if real else (0.0, 0.0)
    return SimulatedHapkit(settings.mass, settings.viscous, coulomb, quantum, math.inf, position, velocity)
