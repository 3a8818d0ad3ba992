"""Build a simulated handle from loop settings."""

import math

from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import LoopSettings


def simulated_handle(
    settings: LoopSettings, real: bool = True, position: float = 0.0, velocity: float = 0.0
) -> SimulatedHapkit:
    """Return a handle that starts at a position in m and a velocity in m/s, without a force limit.

    If ``real`` is False, the handle has no Coulomb friction and no sensor steps, as the exact limits assume.
    """
    coulomb, quantum = (settings.coulomb, settings.quantum) if real else (0.0, 0.0)
    return SimulatedHapkit(settings.mass, settings.viscous, coulomb, quantum, math.inf, position, velocity)
