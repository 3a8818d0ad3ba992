"""Recomputes every row of the tables of methods: integrators, contact, servo rate and friction."""

import math
from functools import cache, partial
from itertools import product

import numpy as np
import pytest
from scipy.linalg import expm, inv

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy import contact, friction, integrators, servo
from hapkit_studio.analysis.accuracy.plan import error
from hapkit_studio.analysis.accuracy.trials import Trial, script
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.contact import located
from hapkit_studio.dynamics.hand import Hand
from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.dynamics.stick_slip import MODELS
from hapkit_studio.environments.friction import MODELS as RENDERED
from hapkit_studio.haptics import rows
from tests.analysis.accuracy.reference_loop import Difference, rendered

LIBRARY = environments.discover()


@cache
def one_step(method, h, k, b):
    """Return the matrix of one step of (x, v, previous a) for x'' = -k x - b v."""
    half, eye, a = 0.5 * h, np.eye(2), np.array([[0.0, 1.0], [-k, -b]])
    if method == "lecture":  # the mean of the last two accelerations, and then of the last two velocities
        u = np.array([-half * k, 1.0 - half * b, half])
        return np.array([[1.0, half, 0.0] + half * u, u, [-k, -b, 0.0]])
    drift, late = np.array([[1.0, h], [0.0, 1.0]]), 1.0 / (1.0 + half * b)
    step = {
        "explicit_euler": eye + h * a, "implicit_euler": inv(eye - h * a), "exact": expm(h * a),
        "semi_implicit": drift @ [[1.0, 0.0], [-h * k, 1.0 - h * b]],
        "verlet": [[1.0, 0.0], [-half * k * late, late]] @ drift @ [[1.0, 0.0], [-half * k, 1.0 - half * b]],
        "rk4": sum(np.linalg.matrix_power(h * a, n) / math.factorial(n) for n in range(5)),
        "trapezoid": inv(eye - half * a) @ (eye + half * a),
    }[method]  # fmt: skip
    return np.pad(step, (0, 1))


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["free", "damped"])
@pytest.mark.parametrize("method", INTEGRATORS)
def test_the_error_of_an_oscillating_mass_follows_from_powers_of_the_methods_step(scene, method):
    k, b = 300.0 / 2.0, 1.0 / 2.0 * (scene == "damped")
    for h in integrators.STEPS:
        state, true = np.array([0.010, 0.0, -k * 0.010]), expm(h * np.array([[0.0, 1.0], [-k, -b]]))
        exact, apart, step = state[:2], 0.0, one_step(method, h, k, b)
        for _ in range(round(1.0 / h)):
            state, exact = step @ state, true @ exact
            apart = max(apart, abs(state[0] - exact[0]) / 0.010)
        found = error(partial(integrators.MOTIONS[scene][0], method, h))
        assert found == pytest.approx(apart, rel=0.01, abs=1e-9)


@pytest.mark.slow
def test_the_error_of_a_tap_on_a_wall_agrees_with_plain_python():
    wall, device = LIBRARY["wall"], SimulatedHapkit(quantum=0.0)
    scene = script("tap"), device, wall, wall.values({"stiffness": 800.0})
    true = rendered(*scene)[:, rows.TRUE_POSITION]
    for rate, delay in product((250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0, 10_000.0), (0.0, 1e-3)):
        found = rendered(*scene, ("rate", "delay"), rate, delay)[:, rows.TRUE_POSITION]
        apart = np.abs(found - true)[:: max(round(1000.0 / rate), 1)].max() / (true.max() - 0.005)
        assert error(partial(servo.tap, rate, delay)) == pytest.approx(apart, rel=0.08)


@pytest.mark.slow
@pytest.mark.parametrize("model", RENDERED)
def test_the_drift_of_a_stuck_handle_agrees_with_plain_python(model):
    """Only models with an anchor move by less than a count in two seconds."""
    hand = Hand(stiffness=1.0, target=lambda t: 0.3 + 0.15 * np.sin(40.0 * math.pi * t), vectorised=True)
    device = SimulatedHapkit(coulomb_force=0.0, max_force=math.inf)
    values = LIBRARY["friction"].values({"model": model, "static_force": 1.0, "kinetic_force": 0.5})
    scene = Trial("held", hand, 3.0, 0.02), device, LIBRARY["friction"], values
    for dt in friction.STEPS:
        x = rendered(*scene, ("rate", "velocity", "sensor"), 1.0 / dt, 0.0, Difference)[:, rows.TRUE_POSITION]
        drift, found = abs(x[-1] - x[1000]) / 2.0, error(partial(friction.at_rest, model, dt))
        if model in ("tether", "projection"):
            assert max(drift, found) < 1e-5
        else:
            assert found == pytest.approx(drift, rel=0.06)
            assert found > 1e-3


def test_the_error_of_the_period_decreases_with_the_step():
    for key in ("lecture", "exact"):
        fine, coarse = (error(partial(integrators.stick_slip, key, h)) for h in (0.125e-3, 4e-3))
        assert fine < min(0.01, coarse)


@pytest.mark.parametrize("method", ["held", "semi_implicit", "verlet"])
def test_the_energy_of_each_flight_with_a_penalty_method_agrees_with_plain_python(method):
    def pull(x):
        return -1000.0 * math.copysign(max(abs(x) - 0.035, 0.0), x)

    for h in integrators.STEPS[1:]:
        x, v, free, speeds, bounces = 0.010, 0.5, True, [0.5], 100
        while len(speeds) <= bounces:
            a = pull(x)
            if method == "semi_implicit":
                v += h * a
                x += h * v
            else:
                x += h * v + 0.5 * h * h * a
                v += h * a if method == "held" else 0.5 * h * (a + pull(x))
            if abs(x) < 0.035 and not free:
                speeds.append(v)
            free = abs(x) < 0.035
        energies = np.square(speeds) / 0.25
        wanted = math.sqrt(np.mean((np.diff(energies) / energies[:-1]) ** 2)), abs(energies[-1] - 1.0)
        found = [error(partial(contact.bouncing, method, h, drift)) for drift in (False, True)]
        assert found == pytest.approx(wanted, rel=0.05, abs=1e-9)


def test_located_contact_preserves_the_energy_and_the_exact_method_all_of_it():
    found = {key: error(partial(contact.bouncing, key, 1e-3, True)) for key in contact.LABELS}
    assert found["exact"] < 1e-9 < found["located"] < 1e-6 < found["verlet"] < 1e-3 < found["held"]


def test_the_path_with_located_contact_agrees_with_the_closed_form():
    """The path is a uniform motion, half a period of a sine in the wall, and a uniform motion back."""
    h, omega = 0.25e-3, math.sqrt(500.0 / 0.5)
    x, v = np.full(801, 0.010), np.full(801, 0.5)
    located(1, h, 0.5, 500.0, 0.035, x, v)
    since = h * np.arange(801) - 0.025 / 0.5
    inside, back = 0.5 / omega * np.sin(omega * since), -0.5 * (since - math.pi / omega)
    true = 0.035 + np.where(since < 0.0, 0.5 * since, np.where(omega * since < math.pi, inside, back))
    assert x == pytest.approx(true, abs=1e-6)


# stick-slip of a mass pulled by a spring

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
