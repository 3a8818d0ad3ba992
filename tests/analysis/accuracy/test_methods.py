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
