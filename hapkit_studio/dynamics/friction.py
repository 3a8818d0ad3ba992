"""Dry friction as laws and simulations share it: written in the law language, compiled for both.

Forces act on what slides and are in N, positive to the right; a limit is the most that friction can hold.
"""

import math

from hapkit_studio.dynamics.jit import compiled

# A dragged tether is as taut as can be, rounding aside: the board's single precision knows a handle's place
# to 4 nm. This many m slack are more than that, whatever the stiffness, and less than a sensor ever shows.
SLACK = 2e-8


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
    stretch, longest = anchor - x, limit / stiffness
    if abs(stretch) <= longest:
        return stiffness * stretch, anchor
    return math.copysign(limit, stretch), x + math.copysign(longest, stretch)


@compiled
def stribeck(velocity, static, kinetic, stribeck_velocity):
    """Return the level of friction in N >= 0 at a speed: from static at rest down to kinetic."""
    ratio = velocity / stribeck_velocity
    return kinetic + (static - kinetic) * math.exp(-ratio * ratio)


@compiled
def bristle(bend, moved, level, stiffness):
    """Return the bend in m of a bristle after its root moved: towards level / stiffness, never beyond.

    Dahl's and LuGre's law, exact for a level in N that stays while it moves; stiffness N/m > 0.
    """
    if level <= 0.0:
        return 0.0
    end = math.copysign(level / stiffness, moved)
    return end + (bend - end) * math.exp(-stiffness * abs(moved) / level)


@compiled
def sticking_tether(x, before, anchor, slides, stiffness, damping, static, kinetic, dt):
    """Return (force, anchor, slides): a spring and damper to an anchor that holds up to `static`.

    Beyond that the anchor is dragged along with `kinetic` N > 0 until the tether goes slack or turns: then it
    sticks again. slides has the sign of the force of what slides, 0 where it sticks; x and before m, stiffness
    N/m > 0, damping N·s/m; the implicit step of Kikuuwe et al. 2006.
    """
    lag, taut = damping / (stiffness * dt), kinetic / stiffness
    stretch = anchor - x + lag * (before - x)
    if slides * stretch < taut - SLACK and abs(stretch) <= max(static, kinetic) / stiffness:
        return stiffness * stretch, anchor, 0.0
    anchor = x + (math.copysign(taut, stretch) + lag * (anchor - before)) / (1.0 + lag)
    return math.copysign(kinetic, stretch), anchor, math.copysign(1.0, stretch)


@compiled
def banded(x, v, anchor, stiffness, static, kinetic, band):
    """Return (force, anchor, slides) by Karnopp's rule: held within a band of speed, sliding beyond it.

    It enters the band with a slack tether: one already taut would be energy from nowhere.
    """
    if abs(v) < band:
        hold, anchor = tether(x, anchor, stiffness, static)
        return hold, anchor, 0.0 if abs(hold) < static else 1.0
    return -math.copysign(kinetic, v), x, 1.0
