"""Dry friction as laws and simulations share it: written in the law language, compiled for both.

Forces act on what slides and are in N, positive to the right; a limit is the most that friction can hold.
"""

import math

from hapkit_studio.dynamics.jit import compiled


@compiled
def projected(velocity, limit):
    """Return the velocity after friction that can take away up to `limit` m/s: shrunk by it, or exactly 0.

    With limit = F_c dt / m this is the implicit step of dry friction (Kikuuwe et al. 2006).
    """
    if abs(velocity) <= limit:
        return 0.0
    return velocity - math.copysign(limit, velocity)


@compiled
def tether(x, anchor, stiffness, limit):
    """Return (force, anchor): a spring to an anchor that is dragged along once it would pull beyond `limit`.

    stiffness N/m > 0, limit N >= 0. Where it holds, the anchor stays bit for bit: no drift.
    """
    pull = stiffness * (anchor - x)
    if abs(pull) <= limit:
        return pull, anchor
    force = math.copysign(limit, pull)
    return force, x + force / stiffness


@compiled
def stribeck(velocity, static, kinetic, stribeck_velocity):
    """Return the level of friction in N >= 0 at a speed: from static at rest down to kinetic."""
    ratio = velocity / stribeck_velocity
    return kinetic + (static - kinetic) * math.exp(-ratio * ratio)
