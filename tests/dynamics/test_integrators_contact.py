"""Contact, walls and friction of a moving mass; each step agrees with an independent computation."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from hapkit_studio.dynamics import integrators
from hapkit_studio.dynamics.integrators import INTEGRATORS, step
from hapkit_studio.dynamics.moving_mass import exact
from tests.dynamics.reference_mass import World, advance

OF = {name: float(n) for n, name in enumerate(INTEGRATORS)}


def anywhere(rng):
    """Return a random (world, x, v) with contact and walls within reach, and often with a damper."""
    world = World(
        m=10 ** rng.uniform(-1.3, 0.5),
        b=rng.choice([0.0, 0.5, 5.0]),
        k=rng.choice([0.0, 300.0, 2000.0]),
        f=rng.normal(0.0, 1.0),
        touch=rng.normal(0.0, 0.005),
        side=rng.choice([-1.0, 1.0]),
        speed=rng.choice([0.0, rng.normal(0.0, 0.2)]),
        contact=rng.choice([50.0, 500.0, 5000.0]),
        pad=rng.choice([0.0, 3.0, 30.0]),
        reach=rng.uniform(0.004, 0.02),
        wall=rng.choice([500.0, 5000.0]),
    )
    return world, rng.normal(0.0, 0.006), rng.normal(0.0, 0.4)


def test_exact_agrees_with_an_event_driven_solver(rng):
    met = 0
    for _ in range(60):
        world, x, v = anywhere(rng)
        friction = rng.choice([0.0, 0.0, 0.3])
        h = 10 ** rng.uniform(-3.0, -1.8)
        got = exact(x, v, h, friction, *world.numbers)
        want = advance(world, x, v, h, friction)
        scale = 1e-8 * (1.0 + abs(v))
        assert got[0] == pytest.approx(want[0], abs=scale), (world, x, v, h, friction)
        assert got[1] == pytest.approx(want[1], abs=scale * 300.0), (world, x, v, h, friction)
        far = replace(world, contact=0.0, pad=0.0, wall=0.0)
        met += got != exact(x, v, h, friction, *far.numbers)
    assert met > 30


def test_exact_is_independent_of_the_step(rng):
    """The step covers up to three oscillations, including all contacts, walls and reversals."""
    for _ in range(300):
        world, x, v = anywhere(rng)
        friction = rng.choice([0.0, 0.2])
        once = exact(x, v, 40e-3, friction, *world.numbers)
        for _ in range(200):
            x, v = exact(x, v, 0.2e-3, friction, *world.numbers)
        assert once == pytest.approx((x, v), abs=1e-8), world


@pytest.mark.parametrize("lack", [1e-4, 2e-4, 3e-4])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_exact_detects_a_brief_speed_crossing(lack, side):
    """The damper acts briefly within the step, although the object is slower before and after the step."""
    world = World(m=0.5, f=-side, touch=0.0, side=side, speed=side * 0.1, contact=500.0, pad=30.0)
    x, v = -side * 2.3e-3, side * (0.1 - lack)
    got, want = exact(x, v, 10e-3, 0.0, *world.numbers), advance(world, x, v, 10e-3)
    assert side * got[1] < 0.1 < side * advance(world, x, v, 3e-3)[1]
    assert got == pytest.approx(want, abs=1e-9)


def test_exact_keeps_the_energy_over_many_bounces():
    """The object bounces between handle and wall, with few samples per contact."""
    world = World(m=0.05, touch=-0.02, contact=800.0, reach=0.03, wall=300.0)
    x, v = 0.0, 0.7
    start, turns = world.energy(x, v), 0
    for _ in range(20_000):
        before = v
        x, v = exact(x, v, 2e-3, 0.0, *world.numbers)
        turns += before * v < 0.0
    assert turns > 300
    assert world.energy(x, v) == pytest.approx(start, rel=1e-10)


@pytest.mark.parametrize(("method", "weight"), [("implicit_euler", 1.0), ("trapezoid", 0.5)])
def test_implicit_steps_solve_their_equation(method, weight, rng):
    """A root finder solves v1 = v + h ((1 - w) a0 + w a(x1, v1)) and x1 = x + h ((1 - w) v + w v1)."""
    for _ in range(400):
        world, x, v = anywhere(rng)
        h = 10 ** rng.uniform(-3.3, -2.0)
        world = replace(world, pad=0.0) if rng.random() < 0.5 else world
        before = world.acceleration(x, v)

        def lack(u, world=world, x=x, v=v, h=h, before=before):
            place = x + h * ((1.0 - weight) * v + weight * u)
            return u - v - h * ((1.0 - weight) * before + weight * world.acceleration(place, u))

        got = step(OF[method], x, v, 0.0, h, 0.0, *world.numbers)
        want = brentq(lack, -1e4, 1e4, xtol=1e-13, rtol=1e-14)
        assert got[1] == pytest.approx(want, abs=1e-8 * (1.0 + abs(want))), world
        assert got[0] == pytest.approx(x + h * ((1.0 - weight) * v + weight * got[1]), abs=1e-15)


def test_verlet_uses_the_damper_at_the_new_velocity(rng):
    for _ in range(400):
        world, x, v = anywhere(rng)
        h = 10 ** rng.uniform(-3.3, -2.0)
        before = world.acceleration(x, v)
        q, u = integrators.verlet(x, v, before, h, *world.numbers)
        assert q == pytest.approx(x + h * v + 0.5 * h * h * before, abs=1e-15)
        assert u == pytest.approx(v + 0.5 * h * (before + world.acceleration(q, u)), abs=1e-10)


def test_runge_kutta_evaluates_the_force_at_its_stages(rng):
    for _ in range(200):
        world, x, v = anywhere(rng)
        h = 10 ** rng.uniform(-3.3, -2.0)
        rates = [np.array([v, world.acceleration(x, v)])]
        for share in (0.5, 0.5, 1.0):
            y = np.array([x, v]) + share * h * rates[-1]
            rates.append(np.array([y[1], world.acceleration(*y)]))
        want = np.array([x, v]) + h / 6.0 * (rates[0] + 2.0 * rates[1] + 2.0 * rates[2] + rates[3])
        assert step(OF["rk4"], x, v, 0.0, h, 0.0, *world.numbers)[:2] == pytest.approx(tuple(want), rel=1e-11)
