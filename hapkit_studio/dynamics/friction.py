"""Dry friction that laws and simulations share: written in the law language, compiled for both.

Forces in N act on the sliding body and are positive to the right. ``limit`` is the largest static friction.
"""

import math

from hapkit_studio.dynamics.jit import compiled


@compiled
def projected(velocity, limit):
    """Return the velocity after dry friction, which reduces the speed by at most `limit` m/s, down to 0.

    With limit = F_c dt / m this is the implicit step of dry friction (Kikuuwe et al. 2006).
    """
    if abs(velocity) <= limit:
        return 0.0
    return velocity - math.copysign(limit, velocity)


@compiled
def tether(x, anchor, stiffness, limit):
    """Return (force, anchor) of a spring to an anchor that is dragged when the force reaches ``limit``.

    ``stiffness`` is in N/m and positive; ``limit`` is in N and not negative. While the spring holds, the
    anchor stays exactly the same, without drift.
    """
    stretch, longest = anchor - x, limit / stiffness
    if abs(stretch) <= longest:
        return stiffness * stretch, anchor
    return math.copysign(limit, stretch), x + math.copysign(longest, stretch)


@compiled
def stribeck(velocity, static, kinetic, stribeck_velocity):
    """Return the friction in N at a speed: it falls from static at rest to kinetic (Stribeck)."""
    ratio = velocity / stribeck_velocity
    return kinetic + (static - kinetic) * math.exp(-ratio * ratio)


@compiled
def bristle(bend, moved, level, stiffness):
    """Return a bristle's deflection in m after its root has moved; the deflection tends to level / stiffness.

    This is the law of Dahl and LuGre, exact for a level in N that is constant during the step. ``stiffness``
    is in N/m and positive.
    """
    if level <= 0.0:
        return 0.0
    end = math.copysign(level / stiffness, moved)
    return end + (bend - end) * math.exp(-stiffness * abs(moved) / level)


@compiled
def sticking_tether(x, before, anchor, slides, stiffness, damping, static, kinetic, dt):
    """Return (force, anchor, slides) of a spring and damper to an anchor that sticks up to ``static`` N.

    Beyond this force the anchor slides with ``kinetic`` N (positive) until the motion reverses. Then the
    anchor sticks where the spring force is ``kinetic``. ``slides`` is the sign of the force while the anchor
    slides, else 0. ``x`` and ``before`` are in m, ``stiffness`` is in N/m (positive), and ``damping`` in
    N·s/m.
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

    The body enters the band with a slack tether, because a taut one would add energy.
    """
    if abs(v) < band:
        spring_force, anchor = tether(x, anchor, stiffness, static)
        return spring_force, anchor, 0.0 if abs(spring_force) < static else math.copysign(1.0, spring_force)
    return -math.copysign(kinetic, v), x, -math.copysign(1.0, v)
