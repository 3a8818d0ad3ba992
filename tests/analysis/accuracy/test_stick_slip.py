"""Stick-slip of a mass pulled by a spring: plain Python recomputes the period error of every row."""

import math
from functools import partial

import numpy as np
import pytest

from hapkit_studio.analysis.accuracy import friction, integrators
from hapkit_studio.analysis.accuracy.plan import error
from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.dynamics.stick_slip import MODELS
from tests.analysis.accuracy.test_methods import one_step

MASS, SPRING, STATIC, KINETIC, SPEED = 0.05, 300.0, 1.0, 0.5, 0.02
TRUE_PERIOD = 0.211193  # in s, computed by a solver that locates every stop


def period_error(forces, dt):
    """Return the relative error of the mean time between upward crossings of the middle force."""
    late = forces[len(forces) // 4 :]
    if np.ptp(late) < 0.05:
        return math.inf
    above = forces >= 0.5 * (late.max() + late.min())
    rises = np.flatnonzero(above[1:] & ~above[:-1])[2:]
    return abs((rises[-1] - rises[0]) * dt / (len(rises) - 1) / TRUE_PERIOD - 1.0)


def toward_zero(value, most):
    return math.copysign(max(abs(value) - most, 0.0), value)


def level(v, decay):
    return KINETIC + (STATIC - KINETIC) * math.exp(-((v / decay) ** 2))


class Bristles:
    """Dahl's model, or LuGre's with damping and a Stribeck curve: z' = v - stiffness |v| z / level."""

    def __init__(self, damping, decay):
        self.damping, self.decay, self.z = damping, decay, 0.0

    def __call__(self, x, v, dt):
        top = level(v, self.decay) if self.decay else KINETIC
        end, before = math.copysign(top / 1e4, v), self.z
        self.z = end - (end - before) * math.exp(-1e4 * abs(v) * dt / top)
        return -1e4 * self.z - self.damping * (self.z - before) / dt


class Tether:
    """A spring and damper to an anchor.

    Above the static force the anchor slides until the motion reverses.
    """

    def __init__(self):
        self.anchor = self.last = self.sliding = 0.0

    def __call__(self, x, v, dt):
        moved, self.last = x - self.last, x
        if self.sliding and moved * self.sliding <= 0.0:
            return self.sliding * KINETIC
        if self.sliding:
            self.anchor = x - moved + self.sliding * KINETIC / 2e4
        force, self.sliding = 2e4 * (self.anchor - x) - 20.0 * moved / dt, 0.0
        if abs(force) > STATIC:
            self.sliding = math.copysign(1.0, force)
            return self.sliding * KINETIC
        return force


class HaywardArmstrong:
    """A spring to an anchor, which follows a growing fraction of each motion as the strain increases."""

    def __init__(self):
        self.anchor = self.last = 0.0

    def __call__(self, x, v, dt):
        moved, self.last = abs(x - self.last), x
        longest, strain = KINETIC / 5e3, x - self.anchor
        alpha = strain**8 / ((STATIC / 5e3) ** 8 + strain**8) / longest
        if alpha * abs(strain) > 1.0:
            self.anchor = x - math.copysign(longest, strain)
        else:
            self.anchor += moved * alpha * strain
        return -5e3 * (x - self.anchor)


ELASTIC = {
    "tether": Tether,
    "lugre": lambda: Bristles(45.0, 0.005),
    "dahl": lambda: Bristles(0.0, 0.0),
    "hayward_armstrong": HaywardArmstrong,
    "smoothed": lambda: lambda x, v, dt: -level(v, 0.03) * math.tanh(v / 0.01),
}


def next_velocity(model, v, pull, dt):
    """Return the velocity after one step of a friction model that has no state."""
    step = dt / MASS
    breaking = step * toward_zero(pull, KINETIC) if abs(pull) > STATIC else 0.0
    if model == "stribeck":
        return toward_zero(v + step * pull, step * level(v, 0.02))
    if model == "projection":
        return 0.0 if v == 0.0 and abs(pull) <= STATIC else toward_zero(v + step * pull, step * KINETIC)
    if model == "coulomb":
        return v + step * (pull - math.copysign(KINETIC, v)) if v else step * toward_zero(pull, STATIC)
    if v == 0.0 or (model == "karnopp_band" and abs(v) < 0.005):
        return (v if breaking and model == "karnopp_band" else 0.0) + breaking
    after = v + step * (pull - math.copysign(KINETIC, v))
    return after if model == "karnopp_band" or after * v > 0.0 else 0.0


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS)
def test_every_friction_models_period_is_that_of_plain_python(model):
    for dt in friction.STEPS:
        x, v, forces = 0.0, 0.0, []
        elastic = ELASTIC[model]() if model in ELASTIC else None
        for n in range(round(6.0 / dt) + 1):
            pull = SPRING * (SPEED * n * dt - x)
            forces.append(pull)
            v = v + dt / MASS * (pull + elastic(x, v, dt)) if elastic else next_velocity(model, v, pull, dt)
            x += dt * v
        with np.errstate(all="ignore"):
            wanted = period_error(np.array(forces), dt)
        assert error(partial(friction.drawn, model, dt)) == pytest.approx(wanted, rel=0.04, abs=2e-3), dt


def exact_step(x, v, pull, h):
    """Return (x, v) after h seconds under a constant pull; every stop on the way is located exactly."""
    omega, left = math.sqrt(SPRING / MASS), h
    if v == 0.0 and abs(pull - SPRING * x) <= STATIC:
        return x, 0.0
    while True:
        sense = math.copysign(1.0, v or pull - SPRING * x)
        middle = (pull - sense * KINETIC) / SPRING
        a, b = x - middle, v / omega  # the solution is x(t) = middle + a cos(omega t) + b sin(omega t)
        phase = math.atan2(b, a) % math.pi or math.pi
        if v == 0.0:
            phase = math.pi
        if omega * left < phase:
            c, s = math.cos(omega * left), math.sin(omega * left)
            return middle + a * c + b * s, omega * (b * c - a * s)
        left -= phase / omega
        x, v = middle + a * math.cos(phase) + b * math.sin(phase), 0.0
        if abs(pull - SPRING * x) <= KINETIC:
            return x, 0.0


def free_step(method, x, v, before, pull, h):
    """Return (x, v) after a step without friction, and dx/dv in s.

    If friction changes v afterwards, x changes by dx/dv times that change.
    """
    rest = pull / SPRING  # the matrix describes the motion about the position of rest
    q, u, _ = one_step(method, h, SPRING / MASS, 0.0) @ (x - rest, v, before)
    follows = {"explicit_euler": 0.0, "semi_implicit": h, "implicit_euler": h}.get(method, 0.5 * h)
    return q + rest, u, follows


@pytest.mark.slow
@pytest.mark.parametrize("method", INTEGRATORS)
def test_every_integrators_period_is_that_of_plain_python(method):
    for h in integrators.STEPS:
        x, v, before, forces = 0.0, 0.0, 0.0, []
        for n in range(round(3.0 / h) + 1):
            pull = SPRING * SPEED * n * h
            forces.append(pull - SPRING * x)
            if method == "exact":
                x, v = exact_step(x, v, pull, h)
                continue
            most = STATIC if v == 0.0 and abs(forces[-1]) <= STATIC else KINETIC
            q, free, follows = free_step(method, x, v, before, pull, h)
            u = toward_zero(free, most * h / MASS)
            x, v, before = q + follows * (u - free), u, forces[-1] / MASS
        wanted = period_error(np.array(forces), h)
        found = error(partial(integrators.stick_slip, method, h))
        assert found == pytest.approx(wanted, rel=0.02, abs=2e-3), h
