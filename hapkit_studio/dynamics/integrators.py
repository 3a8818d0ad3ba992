"""Integrators of a moving mass: single steps for laws, and ``integrate``; all in SI units.

The last eleven arguments of every step are those of ``moving_mass``. ``now`` is the acceleration at (x, v).
"""

from collections.abc import Mapping
from dataclasses import astuple, dataclass

import numpy as np

from hapkit_studio.dynamics.friction import projected
from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.dynamics.moving_mass import FAR, acceleration, exact, linear, place
from hapkit_studio.dynamics.paddle import apply, transition
from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import Choice, Parameter


@compiled
def verlet(x, v, now, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall):
    """Return (x, v) by velocity Verlet, with the damping force at the new velocity."""
    x += h * v + 0.5 * h * h * now
    half = 0.5 * h
    base = v + half * now
    touching, _, beyond = place(x, v, touch, side, speed, reach)
    closing = 0.0
    if pad > 0.0:
        # the force decreases with speed, so the sign of the excess at equal speeds shows whether the new
        # velocity is above the handle's
        level = acceleration(x, speed, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
        closing = 1.0 if side * (speed - base - half * level) > 0.0 else 0.0
    damping, stiffness, force = linear(
        touching, closing, beyond, b, k, f, touch, speed, contact, pad, reach, wall
    )
    return x, (base + half * (force - stiffness * x) / m) / (1.0 + half * damping / m)


@compiled
def rk4(x, v, now, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall):
    """Return (x, v) by the classical Runge-Kutta method with four force evaluations."""
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
    """Return u - base - h x''(x + h u, u), which increases with u and is 0 at the solution."""
    return (
        u - base - h * acceleration(x + h * u, u, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
    )


@compiled
def implicit(base, x, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall):
    """Return the velocity u = base + h x''(x + h u, u), solved exactly.

    The excess is piecewise linear between four velocities. Its signs at these velocities bracket the
    solution. If the damper's jump at contact skips the solution, the object ends at the surface.
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


INTEGRATORS = (
    "explicit_euler",
    "lecture",
    "semi_implicit",
    "verlet",
    "rk4",
    "implicit_euler",
    "trapezoid",
    "exact",
)
_EXPLICIT_EULER, _LECTURE, _SEMI_IMPLICIT, _VERLET, _RK4, _IMPLICIT_EULER, _TRAPEZOID, _EXACT = map(
    float, range(len(INTEGRATORS))
)
# smaller numbers are set to 0, because denormals slow processors down by a factor of ten
_FLUSH_BELOW = 1e-150


@compiled
def advanced(method, x, v, before, now, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall):
    """Return (x, v) after h seconds by any method except exact, and dx/dv in s.

    ``before`` and ``now`` are the accelerations one step earlier and at (x, v).
    """
    half = 0.5 * h
    if method == _EXPLICIT_EULER:
        return x + h * v, v + h * now, 0.0
    if method == _LECTURE:
        u = v + half * (before + now)
        return x + half * (v + u), u, half
    if method == _SEMI_IMPLICIT:
        u = v + h * now
        return x + h * u, u, h
    if method == _VERLET:
        q, u = verlet(x, v, now, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
        return q, u, half
    if method == _RK4:
        q, u = rk4(x, v, now, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
        return q, u, half
    if method == _IMPLICIT_EULER:
        u = implicit(v, x, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
        return x + h * u, u, h
    base, middle = v + half * now, x + half * v
    u = implicit(base, middle, half, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
    return x + half * (v + u), u, half


@compiled
def step(method, x, v, before, h, friction, m, b, k, f, touch, side, speed, contact, pad, reach, wall):
    """Return (x, v) after h seconds, and the acceleration at the start of the step.

    ``method`` is the number of a method in INTEGRATORS. ``before`` is the acceleration one step earlier, for
    the lecture's rule. Coulomb friction in N reduces the velocity at the end of the step, at most to 0; the
    exact method computes when the mass stops.
    """
    now = acceleration(x, v, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
    if method == _EXACT:
        q, u = exact(x, v, h, friction, m, b, k, f, touch, side, speed, contact, pad, reach, wall)
    else:
        q, free, follows = advanced(
            method, x, v, before, now, h, m, b, k, f, touch, side, speed, contact, pad, reach, wall
        )
        u = free
        if friction > 0.0:
            u = projected(free, friction * h / m)
            q += follows * (u - free)
    if abs(q) < _FLUSH_BELOW:
        q = 0.0
    if abs(u) < _FLUSH_BELOW:
        u = 0.0
    return q, u, now


@compiled
def glide(h, m, b, k, force, x, v):
    """Compute x, v (n,) from their first values by one exact map per step, without contact.

    ``force`` (n,) is constant during a step.
    """
    whole, q, u = transition(m, b, k, h), x[0], v[0]
    for n in range(x.size - 1):
        q, u = apply(whole, q, u, force[n], 0.0)
        q, u = q if abs(q) >= _FLUSH_BELOW else 0.0, u if abs(u) >= _FLUSH_BELOW else 0.0
        x[n + 1], v[n + 1] = q, u


@dataclass(frozen=True)
class Body:
    """The parameters of an object in the order of ``moving_mass``, without force and handle; SI units."""

    mass: float
    damping: float = 0.0
    stiffness: float = 0.0
    contact: float = 0.0
    reach: float = FAR
    wall: float = 0.0
    static: float = 0.0
    kinetic: float = 0.0

    def numbers(self) -> np.ndarray:
        """Return the parameters as a row."""
        return np.array(astuple(self))


@compiled
def drive(method, times, h, body, force, touch, x, v):
    """Compute x, v (n,) from their first values; ``force`` and ``touch`` (n,) are constant during a step.

    The computation is repeated ``times`` times, to measure its speed. ``body`` contains the numbers of Body.
    Static friction acts on a body at rest, kinetic friction on a moving one.
    """
    m, b, k, contact = body[0], body[1], body[2], body[3]
    reach, wall, static, kinetic = body[4], body[5], body[6], body[7]
    for _ in range(times):
        if method == _EXACT and contact == 0.0 and wall == 0.0 and max(static, kinetic) == 0.0:
            glide(h, m, b, k, force, x, v)
            continue
        before = acceleration(x[0], v[0], m, b, k, force[0], touch[0], 1.0, 0.0, contact, 0.0, reach, wall)
        for n in range(x.size - 1):
            f = force[n]
            stuck = v[n] == 0.0 and abs(f - k * x[n]) <= static
            friction = static if stuck else kinetic
            x[n + 1], v[n + 1], before = step(
                method, x[n], v[n], before, h, friction,
                m, b, k, f, touch[n], 1.0, 0.0, contact, 0.0, reach, wall,
            )  # fmt: skip


HUGE, TINY = 1e12, 1e-12
_METHOD = Choice("method", "The method", INTEGRATORS)
_QUANTITIES = {
    p.key: p
    for p in (
        Parameter("mass", "Mass", "kg", 1.0, TINY, HUGE),
        Parameter("damping", "Damping", "N·s/m", 0.0, 0.0, HUGE),
        Parameter("stiffness", "Stiffness", "N/m", 0.0, 0.0, HUGE),
        Parameter("force", "Force", "N", 0.0, -HUGE, HUGE),
        Parameter("x0", "x0", "m", 0.0, -HUGE, HUGE),
        Parameter("v0", "v0", "m/s", 0.0, -HUGE, HUGE),
        Parameter("dt", "dt", "s", 1e-3, 1e-9, 1e3),
        Parameter("seconds", "Seconds", "s", 1.0, 0.0, 1e9),
        # parameters of a mass with dry friction
        Parameter("spring", "Spring", "N/m", 0.0, 0.0, HUGE),
        Parameter("static", "Static friction", "N", 0.0, 0.0, HUGE),
        Parameter("kinetic", "Kinetic friction", "N", 0.0, 0.0, HUGE),
        Parameter("viscous", "Viscous friction", "N·s/m", 0.0, 0.0, HUGE),
        Parameter("speed", "Speed", "m/s", 0.0, -HUGE, HUGE),
    )
}
_MOST_STEPS = 100_000_000


def checked(given: Mapping[str, object]) -> dict[str, float]:
    """Return the quantities of a motion by name as numbers; raise ParameterError for an invalid one."""
    return {key: _QUANTITIES[key].check(value) for key, value in given.items()}


def instants(seconds: float, dt: float) -> np.ndarray:
    """Return the times (n,) in s of a motion, with both ends; raise ParameterError if there are too many."""
    count = round(seconds / dt) + 1
    if count > _MOST_STEPS:
        raise ParameterError(f"A motion has at most {_MOST_STEPS:g} steps, not {seconds:g} s by {dt:g} s.")
    return dt * np.arange(count)


def integrate(
    method: str,
    *,
    mass: float,
    damping: float,
    stiffness: float,
    x0: float,
    v0: float,
    dt: float,
    seconds: float,
    force: float = 0.0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (t, x, v), each (n,), of m x'' = force - damping x' - stiffness x by one of INTEGRATORS.

    ``mass`` is in kg, ``damping`` in N·s/m, ``stiffness`` in N/m, ``x0`` in m, ``v0`` in m/s, ``dt`` and
    ``seconds`` in s, ``force`` in N. Row k is at t = k dt, and row 0 is the start; n = round(seconds / dt) +
    1. A diverging motion ends as inf or NaN. Raise ParameterError for an invalid argument.
    """
    number = _METHOD.check(method)
    given = {"mass": mass, "damping": damping, "stiffness": stiffness, "force": force}
    value = checked({**given, "x0": x0, "v0": v0, "dt": dt, "seconds": seconds})
    t = instants(value["seconds"], value["dt"])
    x, v, pull, touch = (np.full_like(t, start) for start in (value["x0"], value["v0"], value["force"], -FAR))
    body = Body(value["mass"], value["damping"], value["stiffness"])
    drive(number, 1, value["dt"], body.numbers(), pull, touch, x, v)
    return t, x, v
