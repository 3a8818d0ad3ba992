"""A wall hit in plain Python: closed forms between the samples, nothing of the studio's."""

import math

M, VISCOUS, COULOMB, QUANTUM, T = 0.05, 0.5, 0.1, 15e-6, 1e-3
SPEED, PUSH = 0.1, 1.0


def slide(v, force, t):
    """Return (distance, speed) after t of m v' = force - b v."""
    end = force / VISCOUS
    fall = math.exp(-VISCOUS / M * t)
    return end * t + (v - end) * (1.0 - fall) * M / VISCOUS, end + (v - end) * fall


def period(x, v, force):
    """Return (x, v) after a period of a constant force and Coulomb friction: at most one stop."""
    left = T
    for _ in range(2):
        if v == 0.0:
            if abs(force) <= COULOMB:
                return x, 0.0
            sign = math.copysign(1.0, force)
        else:
            sign = math.copysign(1.0, v)
        net = force - sign * COULOMB
        end = net / VISCOUS
        stops = v != 0.0 and end * sign < 0.0
        stop = M / VISCOUS * math.log((v - end) / -end) if stops else math.inf
        if stop >= left:
            way, v = slide(v, net, left)
            return x + way, v
        x, v, left = x + slide(v, net, stop)[0], 0.0, left - stop
    return x, v


def rests(stiffness, damping, phase):
    """Return whether the handle stays near and ends within two counts."""
    x, v = -phase * SPEED * T, SPEED
    before = QUANTUM * math.floor(x / QUANTUM)
    low, high = math.inf, -math.inf
    for k in range(4000):
        seen = QUANTUM * math.floor(x / QUANTUM)
        wall = -(stiffness * seen + damping * (seen - before) / T) if seen > 0.0 else 0.0
        before = seen
        if k >= 3500:
            low, high = min(low, x), max(high, x)
        x, v = period(x, v, PUSH + wall)
        if abs(x) > 0.2:
            return False
    return high - low <= 2.0 * QUANTUM


def plain_holds(stiffness, damping):
    """Return whether the wall holds at three phases of the sample."""
    return all(rests(stiffness, damping, phase) for phase in (1 / 6, 3 / 6, 5 / 6))
