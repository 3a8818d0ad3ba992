"""The longer steps of a moving mass: Verlet, Runge-Kutta and the implicit ones; law language, SI.

The last eleven arguments of every function are those of ``moving_mass``; now is the acceleration at (x, v).
"""

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.dynamics.moving_mass import acceleration, linear, place


@compiled
def verlet(x, v, now, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall):
    """Return (x, v): velocity Verlet, the new velocity from the damping at the new velocity."""
    x += h * v + 0.5 * h * h * now
    half = 0.5 * h
    base = v + half * now
    touching, _, beyond = place(x, v, touch, side, speed, reach)
    closing = 0.0
    if pad > 0.0:
        # Force falls with speed, so the sign at equal speeds says on which side of it the new velocity lies.
        level = acceleration(x, speed, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
        closing = 1.0 if side * (speed - base - half * level) > 0.0 else 0.0
    damping, stiffness, force = linear(
        touching, closing, beyond, b, k, f, touch, speed, contact, pad, reach, wall
    )
    return x, (base + half * (force - stiffness * x) / m) / (1.0 + half * damping / m)


@compiled
def rk4(x, v, now, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall):
    """Return (x, v) by the classical Runge-Kutta method, the force taken at each of its four places."""
    half = 0.5 * h
    v2 = v + half * now
    a2 = acceleration(x + half * v, v2, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
    v3 = v + half * a2
    a3 = acceleration(x + half * v2, v3, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
    v4 = v + h * a3
    a4 = acceleration(x + h * v3, v4, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
    return x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v + h / 6.0 * (now + 2.0 * a2 + 2.0 * a3 + a4)


@compiled
def excess(u, base, x, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall):
    """Return u - base - h x''(x + h u, u), which rises with u and is 0 at the velocity sought."""
    return (
        u - base - h * acceleration(x + h * u, u, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
    )


@compiled
def implicit(base, x, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall):
    """Return the velocity u = base + h x''(x + h u, u), solved exactly.

    The excess is linear between four velocities: its sign at each says on which side of it the solution lies.
    Where the damper sets in with a jump that steps over it, the object ends at the surface.
    """
    touching, closing, beyond = 0.0, 0.0, 0.0
    meeting = (touch - x) / h
    if contact > 0.0:
        over = excess(meeting, base, x, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
        touching = 1.0 if side * over > 0.0 else 0.0
        over = excess(speed, base, x, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
        closing = 1.0 if side * over > 0.0 else 0.0
    if wall > 0.0:
        right, left = (reach - x) / h, (-reach - x) / h
        over = excess(right, base, x, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
        beyond = 1.0 if over < 0.0 else 0.0
        over = excess(left, base, x, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
        beyond = -1.0 if over > 0.0 else beyond
    damping, stiffness, force = linear(
        touching, closing, beyond, b, k, f, touch, speed, contact, pad, reach, wall
    )
    u = (base + h * (force - stiffness * x) / m) / (1.0 + h * (damping + h * stiffness) / m)
    if contact > 0.0 and side * (meeting - u) * (touching - 0.5) < 0.0:
        return meeting
    return u
