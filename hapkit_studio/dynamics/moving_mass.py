"""A moving mass with a spring, a damper, a handle that touches it, and two walls.

m x'' = f - b x' - k x. In contact, the handle adds the force ``contact`` * (touch - x), and while handle and
object approach each other also the force ``pad`` * (speed - x'). Beyond ± ``reach`` the spring ``wall`` acts.
``touch`` is the position of the object at first contact. ``side`` is +1 if the handle is on the left of the
object, -1 if it is on the right. ``speed`` is the handle's velocity. After its first arguments, every
function takes these eleven numbers, or some of them, in this order. All are in SI units; the functions are
written in the law language.

``exact`` simulates the object without error: the motion consists of linear pieces, and each piece has an
exact map up to the exact time of its end. A piece ends when the object meets or leaves the handle or a wall,
when the speeds are equal (the contact's damper acts on approach only), and when the object reverses.
"""

import math

from hapkit_studio.dynamics.friction import projected
from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.dynamics.paddle import transition

# position of a handle or wall that does not exist
FAR = 1e100
_FARTHEST, _FASTEST = 1.0, 1e4
# zeros of velocity or acceleration are at least pi / omega apart, so a shorter piece has at most one zero
_PIECE_ANGLE = 3.0
_POSITION, _VELOCITY, _ACCELERATION = 0.0, 1.0, 2.0
_NONE, _TURN, _STOP, _MEET, _WALL = 0.0, 1.0, 2.0, 3.0, 4.0


@compiled
def place(x, v, touch, side, speed, reach):
    """Return (touching, closing, beyond): two flags, 1 or 0, and +1 or -1 beyond a wall, else 0."""
    touching = 1.0 if side * (touch - x) > 0.0 else 0.0
    closing = 1.0 if side * (speed - v) > 0.0 else 0.0
    if x > reach:
        return touching, closing, 1.0
    if x < -reach:
        return touching, closing, -1.0
    return touching, closing, 0.0


@compiled
def linear(touching, closing, beyond, b, k, f, touch, speed, contact, pad, reach, wall):
    """Return (damping, stiffness, force) of the linear piece that a state belongs to."""
    if touching > 0.0:
        k += contact
        f += contact * touch
        if closing > 0.0:
            b += pad
            f += pad * speed
    if beyond != 0.0:
        k += wall
        f += wall * beyond * reach
    return b, k, f


@compiled
def acceleration(x, v, m, b, k, f, touch, side, speed, contact, pad, reach, wall):
    """Return x'' in m/s^2 at (x, v)."""
    force = f - b * v - k * x + pushed(x, v, touch, side, speed, contact, pad)
    if x > reach:
        force -= wall * (x - reach)
    elif x < -reach:
        force -= wall * (x + reach)
    return force / m


@compiled
def pushed(x, v, touch, side, speed, contact, pad):
    """Return the force in N of the handle on an object at x with velocity v, positive to the right.

    The damper acts on approach only. If its damping is 0, a board does not compute the direction.
    """
    depth = touch - x
    if side * depth <= 0.0:
        return 0.0
    force = contact * depth
    rate = speed - v
    if pad > 0.0 and side * rate > 0.0:
        force += pad * rate
    return force


@compiled
def flown_apart(x, v):
    """Return 1 if an object is more than 1 m away, faster than 10 km/s or not finite, else 0.

    A method that adds energy causes such a motion. The scene then restarts, and renders no force in between.
    """
    return 0.0 if abs(x) <= _FARTHEST and abs(v) <= _FASTEST else 1.0


@compiled
def moved(x, v, t, m, damping, stiffness, force):
    """Return (x, v) of m x'' = force - damping x' - stiffness x after t seconds."""
    a, b, c, d, g0, _, g1, _ = transition(m, damping, stiffness, t)
    return a * x + b * v + g0 * force, c * x + d * v + g1 * force


@compiled
def measured(what, x, v, m, damping, stiffness, force):
    """Return position, velocity or acceleration, as ``what`` selects, and its rate of change."""
    a = (force - damping * v - stiffness * x) / m
    if what == _POSITION:
        return x, v
    if what == _VELOCITY:
        return v, a
    return a, -(damping * a + stiffness * v) / m


@compiled
def until(what, level, x, v, span, end, m, damping, stiffness, force):
    """Return (t, x, v) when ``what`` crosses ``level``; after ``span`` seconds it has the value ``end``.

    There is exactly one crossing. Newton's method is used in a shrinking bracket. The time of a reversal only
    splits a piece, so it is computed with less accuracy.
    """
    enough = (1e-6 if what == _ACCELERATION else 1e-15) * span
    start, _ = measured(what, x, v, m, damping, stiffness, force)
    if (start - level) * (end - level) >= 0.0:
        return 0.0, x, v
    low, high = 0.0, span
    t = span * (level - start) / (end - start)
    q, u = x, v
    for _ in range(60):
        q, u = moved(x, v, t, m, damping, stiffness, force)
        value, slope = measured(what, q, u, m, damping, stiffness, force)
        if (value - level) * (end - level) < 0.0:
            low = t
        else:
            high = t
        guess = t - (value - level) / slope if slope != 0.0 else high
        if not low < guess < high:
            guess = 0.5 * (low + high)
        if abs(guess - t) <= enough:
            break
        t = guess
    if what == _POSITION:
        return t, level, u
    if what == _VELOCITY:
        return t, q, level
    return t, q, u


@compiled
def first_event(touching, beyond, turned, x, v, span, friction, m, b, k, f, touch, side, speed, pad, reach):
    """Return (t, x, v, event) at the end of a piece: after ``span``, or at the first earlier event.

    Each search shortens the span for the next search. In a piece the velocity has at most one zero. The
    velocity may equal the handle's velocity twice. If this is possible, the piece is therefore split at the
    extremum of the velocity.
    """
    event = _NONE
    q, u = moved(x, v, span, m, b, k, f)
    now, ahead = (f - b * v - k * x) / m, (f - b * u - k * q) / m
    swing = span * (abs(now) + 0.5 * span * abs(b * now + k * v) / m)
    damped = touching * pad > 0.0
    if damped and turned == 0.0 and now * ahead < 0.0 and abs(v - speed) <= swing:
        event = _TURN
        span, q, u = until(_ACCELERATION, 0.0, x, v, span, ahead, m, b, k, f)
    nearest = min(abs(x - touch), abs(abs(x) - reach))
    if v * u < 0.0 and (friction > 0.0 or nearest <= (abs(v) + swing) * span):
        event = _STOP
        span, q, u = until(_VELOCITY, 0.0, x, v, span, u, m, b, k, f)
    if damped and (v - speed) * (u - speed) < 0.0:
        event = _STOP
        span, q, u = until(_VELOCITY, speed, x, v, span, u, m, b, k, f)
    depth = side * (touch - q)
    if (touching > 0.0 and depth < 0.0) or (touching == 0.0 and depth > 0.0):
        event = _MEET
        span, q, u = until(_POSITION, touch, x, v, span, q, m, b, k, f)
    if (beyond == 0.0 and abs(q) > reach) or beyond * q < abs(beyond) * reach:
        event = _WALL
        level = beyond * reach if beyond != 0.0 else math.copysign(reach, q)
        span, q, u = until(_POSITION, level, x, v, span, q, m, b, k, f)
    return span, q, u, event


@compiled
def approaching(v, side, speed, pull, friction):
    """Return 1 if object and handle approach each other, else 0; at equal speed the force decides."""
    rate = side * (speed - v)
    if rate == 0.0:
        rate = -side * (projected(pull, friction) if v == 0.0 else pull - math.copysign(friction, v))
    return 1.0 if rate > 0.0 else 0.0


@compiled
def forces(touching, beyond, x, v, friction, b, k, f, touch, side, speed, contact, pad, reach, wall):
    """Return (damping, stiffness, force) until the next change of contact, and 1 if nothing moves, else 0."""
    damping, stiffness, force = linear(
        touching, 0.0, beyond, b, k, f, touch, speed, contact, pad, reach, wall
    )
    if touching * pad > 0.0:
        closing = approaching(v, side, speed, force - damping * v - stiffness * x, friction)
        damping, stiffness, force = linear(
            touching, closing, beyond, b, k, f, touch, speed, contact, pad, reach, wall
        )
    pull = force - damping * v - stiffness * x
    stuck = 1.0 if v == 0.0 and abs(pull) <= friction else 0.0
    return damping, stiffness, force - math.copysign(friction, v if v != 0.0 else pull), stuck


@compiled
def exact(x, v, h, friction, m, b, k, f, touch, side, speed, contact, pad, reach, wall):
    """Return (x, v) after h seconds; after 64 pieces with contact, the object rests until the end."""
    if friction == 0.0 and contact == 0.0 and pad == 0.0 and wall == 0.0:
        x, v = moved(x, v, h, m, b, k, f)
        return x, v
    touching, _, beyond = place(x, v, touch, side, speed, reach)
    left, turned = h, 0.0
    for _ in range(64):
        b1, k1, f1, stuck = forces(
            touching, beyond, x, v, friction, b, k, f, touch, side, speed, contact, pad, reach, wall
        )
        if stuck > 0.0:
            return x, 0.0
        span = left
        if k1 > 0.0:
            span = min(left, _PIECE_ANGLE * math.sqrt(m / k1))
        span, x, v, event = first_event(
            touching, beyond, turned, x, v, span, friction, m, b1, k1, f1, touch, side, speed, pad, reach
        )
        turned = 1.0 if event == _TURN else 0.0
        if event == _MEET:
            touching = 1.0 - touching
        elif event == _WALL:
            beyond = 0.0 if beyond != 0.0 else math.copysign(1.0, x)
        left -= span
        if left <= 0.0:
            break
    return x, v
