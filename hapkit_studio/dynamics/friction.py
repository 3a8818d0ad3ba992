"""Dry friction shared by laws and simulations: written in the law language, compiled for both.

Forces act on the sliding body and are in N, positive to the right; a limit is the largest static friction.
"""

import math

from hapkit_studio.dynamics.jit import compiled


@compiled
def projected(velocity, limit):
    """Return the velocity after dry friction that can change it by up to `limit` m/s: reduced, or exactly 0.

    With limit = F_c dt / m this is the implicit step of dry friction (Kikuuwe et al. 2006).
    """
    if abs(velocity) <= limit:
        return 0.0
    return velocity - math.copysign(limit, velocity)


@compiled
def tether(x, anchor, stiffness, limit):
    """Return (force, anchor): a spring to an anchor that is dragged along once the force reaches ``limit``.

    stiffness N/m > 0, limit N >= 0. While it holds, the anchor stays exactly the same: no drift.
    """
    stretch, longest = anchor - x, limit / stiffness
    if abs(stretch) <= longest:
        return stiffness * stretch, anchor
    return math.copysign(limit, stretch), x + math.copysign(longest, stretch)


@compiled
def stribeck(velocity, static, kinetic, stribeck_velocity):
    """Return the friction in N >= 0 at a speed: from static at rest down to kinetic (Stribeck)."""
    ratio = velocity / stribeck_velocity
    return kinetic + (static - kinetic) * math.exp(-ratio * ratio)


@compiled
def bristle(bend, moved, level, stiffness):
    """Return the bristle deflection in m after its root moved, which approaches level / stiffness.

    Dahl's and LuGre's law, exact for a level in N that is constant during the step; stiffness N/m > 0.
    """
    if level <= 0.0:
        return 0.0
    end = math.copysign(level / stiffness, moved)
    return end + (bend - end) * math.exp(-stiffness * abs(moved) / level)


@compiled
def sticking_tether(x, before, anchor, slides, stiffness, damping, static, kinetic, dt):
    """Return (force, anchor, slides): a spring and damper to an anchor that sticks up to ``static`` N.

    Beyond that it slides with ``kinetic`` N > 0 until it reverses; then it sticks to a new anchor, at a
    spring force of ``kinetic``. slides has the sign of the force while sliding, else 0; x and before in m,
    stiffness N/m > 0, damping N·s/m.
    """
    if slides != 0.0:
        if (before - x) * slides >= 0.0:
            return math.copysign(kinetic, slides), anchor, slides
        anchor = before + math.copysign(kinetic / stiffness, slides)
    pull = stiffness * (anchor - x) + damping / dt * (before - x)
    if abs(pull) <= max(static, kinetic):
        return pull, anchor, 0.0
    return math.copysign(kinetic, pull), anchor, math.copysign(1.0, pull)


@compiled
def banded(x, v, anchor, stiffness, static, kinetic, band):
    """Return (force, anchor, slides) by Karnopp's rule: sticking within a band of speed, sliding beyond it.

    It enters the band with a slack tether, as a taut one would add energy.
    """
    if abs(v) < band:
        hold, anchor = tether(x, anchor, stiffness, static)
        return hold, anchor, 0.0 if abs(hold) < static else math.copysign(1.0, hold)
    return -math.copysign(kinetic, v), x, -math.copysign(1.0, v)
