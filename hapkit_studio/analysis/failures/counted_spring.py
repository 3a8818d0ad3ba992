"""The spring of Diolaiti's plane: viscous and Coulomb friction, a sensor with steps, a handle let go."""

import math

import numpy as np

from hapkit_studio import environments
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings_writer import LoopSettings

RESTS, CYCLES, GROWS = "rests", "cycles", "grows"
SECONDS = 6.0
# A motion that has become this many times as large as it began is lost.
LOST = 20.0


def released(
    mass: float, viscous: float, coulomb: float, quantum: float, rate: float, stiffness: float, start: float
) -> np.ndarray:
    """Return the place (n,) in m of a handle let go ``start`` m from the edge it comes to rest at.

    The spring's centre lies half a count beyond the edge, so on both sides of it the force is half a count's.
    The motion ends where it is lost.
    """
    edge = quantum
    device = SimulatedHapkit(mass, viscous, coulomb, quantum, math.inf, edge + start)
    values = {"stiffness": stiffness, "damping": 0.0, "center": 0.5 * quantum}
    scene = headless.Scene(environments.named("spring"), values, device, LoopSettings(rate))
    out, _ = headless.render(scene, None, round(SECONDS * rate))
    x = out[:, rows.TRUE_POSITION] - edge
    lost = np.abs(x) > LOST * abs(start)
    return x[: int(np.argmax(lost))] if lost.any() else x


def judged(x: np.ndarray, start: float, rate: float) -> tuple[str, float]:
    """Return what a motion (n,) comes to, and the p-p of its last half second in m."""
    whole = len(x) == round(SECONDS * rate)
    last = float(np.ptp(x[-round(0.5 * rate) :])) if len(x) else math.inf
    # what still moves beyond its beginning after all that time is on its way out
    if not whole or np.abs(x[-round(0.5 * rate) :]).max() > abs(start):
        return GROWS, last
    return (RESTS if last == 0.0 else CYCLES), last
