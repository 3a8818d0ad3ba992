"""One step of a sliding mass under each friction model; the pull on it is known, as only a simulation knows.

A step goes from the velocity v m/s to the next one; memory holds the anchor, the bend of the bristles and
the last position (m), and whether it sticks. Options stand in numbers in the order that ``stick_slip`` says.
"""

import math

from hapkit_studio.dynamics.friction import bristle, projected, sticking_tether, stribeck
from hapkit_studio.dynamics.jit import compiled, internal

(
    COULOMB,
    SMOOTHED,
    KARNOPP,
    KARNOPP_BAND,
    STRIBECK,
    PROJECTION,
    TETHER,
    LUGRE,
    DAHL,
    HAYWARD_ARMSTRONG,
) = range(10)
MEMORY = 4
_ANCHOR, _BEND, _BEFORE, _STUCK = range(MEMORY)


@internal
def _slid(v, pull, kinetic, step):
    return v + step * (pull - math.copysign(kinetic, v))


@internal
def _held(v, pull, static, kinetic, step):
    """Return the velocity of what rests: 0 up to the static force, then off against the kinetic one."""
    return 0.0 if abs(pull) <= static else v + step * (pull - math.copysign(kinetic, pull))


@internal
def _coulomb(v, pull, static, kinetic, step):
    """By the sign of the velocity alone."""
    if v != 0.0:
        return _slid(v, pull, kinetic, step)
    return step * (pull - math.copysign(min(abs(pull), static), pull))


@internal
def _karnopp(v, pull, static, kinetic, step):
    """A state machine: it sticks where the velocity would change its sign."""
    if v == 0.0:
        return _held(v, pull, static, kinetic, step)
    after = _slid(v, pull, kinetic, step)
    return after if after * v > 0.0 else 0.0


@internal
def _projection(v, pull, static, kinetic, step):
    if v == 0.0 and abs(pull) <= static:
        return 0.0
    return projected(v + step * pull, kinetic * step)


@internal
def _bristles(v, memory, level, stiffness, damping, dt):
    """Return the friction in N of bristles that bend with stiffness and damping."""
    before = memory[_BEND]
    memory[_BEND] = bristle(before, v * dt, level, stiffness)
    return stiffness * memory[_BEND] + damping * (memory[_BEND] - before) / dt


@internal
def _hayward_armstrong(x, memory, static, kinetic, stiffness):
    """Return the friction in N of an anchor that creeps the more the farther it is strained."""
    reach, strain = kinetic / stiffness, x - memory[_ANCHOR]
    share = (strain * stiffness) ** 8
    creep = share / (static**8 + share) / reach if share > 0.0 else 0.0
    if creep * abs(strain) > 1.0:
        memory[_ANCHOR] = x - math.copysign(reach, strain)
    else:
        memory[_ANCHOR] += abs(x - memory[_BEFORE]) * creep * strain
    return stiffness * (x - memory[_ANCHOR])


@internal
def _strained(model, x, v, memory, static, kinetic, options, dt):
    """Return the friction in N, against positive motion, of the models that strain something."""
    if model == TETHER:
        drag, memory[_ANCHOR], memory[_STUCK] = sticking_tether(
            x, memory[_BEFORE], memory[_ANCHOR], memory[_STUCK], options[0], options[1], static, kinetic, dt
        )
        return -drag
    if model == LUGRE:
        return _bristles(v, memory, stribeck(v, static, kinetic, options[2]), options[0], options[1], dt)
    if model == DAHL:
        return _bristles(v, memory, kinetic, options[0], 0.0, dt)
    if model == HAYWARD_ARMSTRONG:
        return _hayward_armstrong(x, memory, static, kinetic, options[0])
    return stribeck(v, static, kinetic, options[1]) * math.tanh(v / options[0])


@internal
def _next(model, x, v, pull, memory, mass, static, kinetic, options, dt):
    step = dt / mass
    if model == COULOMB:
        return _coulomb(v, pull, static, kinetic, step)
    if model == KARNOPP:
        return _karnopp(v, pull, static, kinetic, step)
    if model == KARNOPP_BAND:
        if abs(v) >= options[0]:
            return _slid(v, pull, kinetic, step)
        return _held(v, pull, static, kinetic, step)
    if model == STRIBECK:
        return projected(v + step * pull, stribeck(v, static, kinetic, options[0]) * step)
    if model == PROJECTION:
        return _projection(v, pull, static, kinetic, step)
    friction = _strained(model, x, v, memory, static, kinetic, options, dt)
    memory[_BEFORE] = x
    return v + step * (pull - friction)


@compiled
def run(model, applied, mass, spring, viscous, static, kinetic, options, dt, memory, x, v):
    """Fill x, v (n,) from their first values: m x'' = applied - spring x - viscous v - friction.

    The semi-implicit rule: the new velocity moves the mass.
    """
    memory[_ANCHOR], memory[_BEND], memory[_BEFORE], memory[_STUCK] = x[0], 0.0, x[0], 1.0
    for n in range(x.size - 1):
        pull = applied[n] - spring * x[n] - viscous * v[n]
        v[n + 1] = _next(model, x[n], v[n], pull, memory, mass, static, kinetic, options, dt)
        x[n + 1] = x[n] + dt * v[n + 1]
