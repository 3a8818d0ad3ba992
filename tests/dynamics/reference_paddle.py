"""Independent simulation of the paddle by matrix exponentials and event-driven ODEs."""

import math
from functools import cache

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm


@cache
def _map(mass, damping, hand_damping, hand_stiffness, h):
    """Return exp(A h) for the states x, v, motor force, the hand's target, and the target's rate."""
    a = np.zeros((5, 5))
    a[0, 1] = 1.0
    a[1] = (-hand_stiffness, -damping - hand_damping, 1.0, hand_stiffness, hand_damping)
    a[1] /= mass
    a[3, 4] = 1.0
    return expm(a * h)


def run(law, targets, mass, damping, hand, period, delay, x0, v0):
    """Return (x, v) at len(targets) samples; law(k, x) is evaluated at sample k and acts ``delay`` later."""
    hand_mass, hand_damping, hand_stiffness = hand
    x, v, motor, pending, out = x0, v0, 0.0, [], []
    for k in range(len(targets)):
        out.append((x, v))
        if k + 1 == len(targets):
            break
        pending.append((delay / period + k, law(k, x)))
        rate = (targets[k + 1] - targets[k]) / period
        y, now = np.array([x, v, motor, targets[k], rate]), float(k)
        while True:
            due = pending[0][0] if pending else math.inf
            until = min(max(due, now), k + 1.0)
            m = _map(mass + hand_mass, damping, hand_damping, hand_stiffness, round(until - now, 12) * period)
            y, now = m @ y, until
            if due > until or due >= k + 1.0 - 1e-9:
                break
            y[2] = pending.pop(0)[1]
        x, v, motor = y[0], y[1], y[2]
    return np.array(out)


def slide(x, v, force, force_rate, coulomb, mass, damping, stiffness, h):
    """Return (x, v) after h with Coulomb friction, by an adaptive ODE solver with events."""
    t = 0.0
    while t < h:
        net = force + force_rate * t - stiffness * x
        direction = math.copysign(1.0, v) if abs(v) > 1e-13 else 0.0
        if direction == 0.0:
            if abs(net) <= coulomb * (1.0 + 1e-9):
                t = _leaves(net, force_rate, coulomb, t)
                if t >= h:
                    return x, 0.0
                direction = math.copysign(1.0, force_rate)
            else:
                direction = math.copysign(1.0, net)
            v = 0.0

        def pull(s, y, direction=direction):
            return (
                y[1],
                (force + force_rate * s - direction * coulomb - damping * y[1] - stiffness * y[0]) / mass,
            )

        def rest(s, y, direction=direction):
            return direction * y[1]

        rest.terminal, rest.direction = True, -1.0
        found = solve_ivp(
            pull, (t, h), (x, v), "DOP853", events=rest, rtol=1e-12, atol=1e-15, max_step=h / 60.0
        )
        x, v = found.y[:, -1]
        if found.status == 1:
            v = 0.0
        t = found.t[-1]
    return x, v


def _leaves(net, rate, coulomb, t):
    """Return the time at which a force, which is ``net`` at t and grows at ``rate``, exceeds the friction."""
    if rate == 0.0:
        return math.inf
    return t + max((math.copysign(coulomb, rate) - net) / rate, 0.0)
