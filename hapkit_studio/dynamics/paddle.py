"""Exact physics of the paddle: mass, damper, spring and Coulomb friction, and a force linear in time.

m x'' + c x' + k x = F + F' t - (Coulomb friction). The solution is accurate for any step and damping: the
linear part is its exact discrete map, and friction is event-driven (stop, stick, break away).
"""

import math

from hapkit_studio.dynamics.jit import compiled, internal

# zeros of the acceleration are at least pi / omega apart, so a shorter piece has at most one zero
_PIECE_ANGLE = 3.0
_MAX_EVENTS = 256
_SERIES_REACH = 0.5
_TERMS = 13  # 0.5¹³ / 16! is smaller than the last digit of 1 / 3!
_SERIES = tuple(1.0 / math.factorial(n + 3) for n in reversed(range(_TERMS)))
_SMALL = 1e-9  # for smaller x, log(1 + x) equals the first two terms of its series


@internal
def _responses(alpha, beta, t):
    """Return the velocity impulse response b(t) and its first and second integrals, by series.

    b solves b' + alpha b + beta (integral of b) = 1 with b(0) = 0. The series is valid for alpha t +
    sqrt(beta) t <= 0.5.
    """
    before, term = 0.0, 1.0 / 6.0
    b, once, twice = 1.0, 0.5, term
    for n in range(4, 20):
        before, term = term, -(alpha * t * term + beta * t * t * before / (n - 1)) / n
        b += n * (n - 1) * term
        once += n * term
        twice += term
        if abs(term) + abs(before) < 1e-20:
            break
    return b * t, once * t * t, twice * t * t * t


@compiled
def transition(mass: float, damping: float, stiffness: float, h: float) -> tuple[float, ...]:
    """Return the exact map (a, b, c, d, g0, h0, g1, h1) of m x'' + c x' + k x = F + F' t over h seconds.

    x1 = a x + b v + g0 F + h0 F', v1 = c x + d v + g1 F + h1 F'. The series is evaluated for h / 2^s. Then
    the map minus the identity is doubled s times, which preserves the digits of slow modes in stiff systems.
    All loops are bounded, because laws also use this function.
    """
    alpha, beta = damping / mass, stiffness / mass
    fastest = alpha + math.sqrt(beta)
    doublings, t = 0, h
    for _ in range(200):
        if fastest * t <= _SERIES_REACH:
            break
        t *= 0.5
        doublings += 1
    b, once, twice = _responses(alpha, beta, t)
    for n in range(200):
        if n >= doublings:
            break
        twice, once, b = (
            twice * (2.0 - beta * once) + once * (b + t),
            once * (2.0 - beta * once) + b * b,
            b * (2.0 - alpha * b - 2.0 * beta * once),
        )
        t *= 2.0
    inertia = 1.0 / mass
    fall = beta * once
    return (
        1.0 - fall,
        b,
        -beta * b,
        1.0 - alpha * b - fall,
        once * inertia,
        twice * inertia,
        b * inertia,
        once * inertia,
    )


@internal
def _part(mass, damping, stiffness, h):
    """Return ``transition`` over a part of a sample; without a spring, a faster series is used."""
    a = damping / mass * h
    if stiffness != 0.0 or a > _SERIES_REACH:
        return transition(mass, damping, stiffness, h)
    twice = 0.0
    for n in range(_TERMS):
        twice = _SERIES[n] - a * twice
    once = 0.5 - a * twice
    moved, push = h * (1.0 - a * once), h / mass
    return (
        1.0,
        moved,
        0.0,
        1.0 - a * (1.0 - a * once),
        h * push * once,
        h * h * push * twice,
        moved / mass,
        h * push * once,
    )


@compiled
def apply(m: tuple[float, ...], x: float, v: float, force: float, force_rate: float) -> tuple[float, float]:
    """Return (x, v) after one map of ``transition``."""
    return (
        m[0] * x + m[1] * v + m[4] * force + m[5] * force_rate,
        m[2] * x + m[3] * v + m[6] * force + m[7] * force_rate,
    )


@internal
def _break_away(net, rate, coulomb):
    """Return the time in s until a resting handle moves under the force net + rate t, and the direction."""
    if net > coulomb:
        return 0.0, 1.0
    if net < -coulomb:
        return 0.0, -1.0
    if rate > 0.0:
        return (coulomb - net) / rate, 1.0
    if rate < 0.0:
        return (-coulomb - net) / rate, -1.0
    return math.inf, 1.0


@internal
def _sign_change(order, before, x, v, push, rate, mass, damping, stiffness, low, high):
    """Return the first sign change of velocity (order 0) or acceleration (order 1) in [low, high].

    ``before`` is the sign at low. Newton's method is used in a shrinking bracket with exactly one sign
    change.
    """
    limit = 4e-16 * high
    t = 0.5 * (low + high)
    for _ in range(100):
        xt, vt = apply(transition(mass, damping, stiffness, t), x, v, push, rate)
        at = (push + rate * t - damping * vt - stiffness * xt) / mass
        value, slope = vt, at
        if order == 1:
            value, slope = at, (rate - damping * at - stiffness * vt) / mass
        if before * value > 0.0:
            low = t
        else:
            high = t
        guess = t - value / slope if slope != 0.0 else high
        if not low < guess < high:
            guess = 0.5 * (low + high)
        if abs(guess - t) <= limit:
            break
        t = guess
    return t


@internal
def _too_fast(x, v, push, rate, mass, damping, stiffness, h):
    """Return True if v exceeds the largest possible change of velocity within h.

    The acceleration stays below 2 (|a0| + h |jerk0|) if h (2 c / m + h k / m) is below 1 / 2.
    """
    if h * (2.0 * damping + h * stiffness) > 0.5 * mass:
        return False
    pull = push - damping * v - stiffness * x
    jerk = rate - damping * pull / mass - stiffness * v
    return abs(v) * mass > 2.0 * h * (abs(pull) + h * abs(jerk))


@internal
def _stop_time(sign, x, v, push, rate, mass, damping, stiffness, h, x1, v1):
    """Return when a slide in direction ``sign`` first stops within h; inf if it does not stop.

    Return 0 if rounding errors keep the handle at rest. The time h is so short that the acceleration has at
    most one zero. Without a spring, the velocity under a constant force is monotonic, and the time of the
    stop has a closed form.
    """
    if stiffness == 0.0 and rate == 0.0 and v != 0.0:
        if sign * v1 > 0.0:
            return math.inf
        lost = -damping * v / push
        stop = mass / damping * math.log1p(lost) if lost > _SMALL else -mass * v / push * (1.0 - 0.5 * lost)
        return min(stop, h)
    a0 = sign * (push - damping * v - stiffness * x)
    a1 = sign * (push + rate * h - damping * v1 - stiffness * x1)
    low, high = 0.0, h
    if sign * v1 > 0.0:
        if v == 0.0 or a0 >= 0.0 or a1 <= 0.0 or _too_fast(x, v, push, rate, mass, damping, stiffness, h):
            return math.inf
        high = _sign_change(1, -sign, x, v, push, rate, mass, damping, stiffness, 0.0, h)
        dip = apply(transition(mass, damping, stiffness, high), x, v, push, rate)[1]
        if sign * dip > 0.0:
            return math.inf
    elif v == 0.0:
        if a0 <= 0.0 or a1 >= 0.0:
            return 0.0
        low = _sign_change(1, sign, x, v, push, rate, mass, damping, stiffness, 0.0, h)
    return _sign_change(0, sign, x, v, push, rate, mass, damping, stiffness, low, high)


@internal
def _advance_with_friction(x, v, force, rate, coulomb, mass, damping, stiffness, h, whole):
    """Return (x, v) after h, computed from event to event: slide, stop, stick, break away."""
    left = h
    longest = _PIECE_ANGLE * math.sqrt(mass / stiffness) if stiffness > 0.0 else math.inf
    for _ in range(_MAX_EVENTS):
        sign = math.copysign(1.0, v)
        if v == 0.0:
            wait, sign = _break_away(force - stiffness * x, rate, coulomb)
            if wait >= left:
                return x, 0.0
            force += rate * wait
            left -= wait
        piece = min(left, longest)
        step = whole if piece == h else _part(mass, damping, stiffness, piece)
        push = force - sign * coulomb
        x1, v1 = apply(step, x, v, push, rate)
        stop = _stop_time(sign, x, v, push, rate, mass, damping, stiffness, piece, x1, v1)
        if stop <= 0.0:
            x1, v1 = x, 0.0
        elif stop <= piece:
            x1, v1 = apply(_part(mass, damping, stiffness, stop), x, v, push, rate)[0], 0.0
            piece = stop
        x, v = x1, v1
        force += rate * piece
        left -= piece
        if left <= 0.0:
            break
    return x, v


@compiled
def advance(
    x: float,
    v: float,
    force: float,
    force_rate: float,
    coulomb: float,
    mass: float,
    damping: float,
    stiffness: float,
    h: float,
    map8: tuple[float, ...],
) -> tuple[float, float]:
    """Return (x, v) after h seconds with Coulomb friction; map8 is ``transition`` over the same h."""
    if coulomb == 0.0:
        return apply(map8, x, v, force, force_rate)
    return _advance_with_friction(x, v, force, force_rate, coulomb, mass, damping, stiffness, h, map8)
