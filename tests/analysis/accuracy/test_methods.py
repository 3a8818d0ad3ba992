"""Recomputes every row of the tables of methods: integrators, contact, servo rate and friction."""

import math
from functools import cache

import numpy as np
import pytest
from scipy.linalg import expm, inv

from hapkit_studio import environments
from hapkit_studio.analysis.accuracy import contact, friction, integrators, servo
from hapkit_studio.analysis.accuracy.trials import Trial, script
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import Hand
from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.environments.friction import MODELS as RENDERED
from hapkit_studio.haptics import rows
from tests.analysis.accuracy.reference_loop import Difference, rendered

NUMBER = {key: n for n, key in enumerate(INTEGRATORS)}
LIBRARY = environments.discover()


@cache
def one_step(method, h, k, b):
    """Return the matrix of one step of (x, v, previous a) for x'' = -k x - b v."""
    eye, a = np.eye(2), np.array([[0.0, 1.0], [-k, -b]])
    now = a[1]
    u = {"explicit_euler": [0.0, 1.0] + h * now, "semi_implicit": [0.0, 1.0] + h * now}.get(method)
    # "lecture" updates the velocity by Adams-Bashforth and the position by the trapezoid rule
    if method == "lecture":
        u = np.array([0.0, 1.0, 0.5 * h]) + 0.5 * h * np.array([*now, 0.0])
        return np.array([np.array([1.0, 0.5 * h, 0.0]) + 0.5 * h * u, u, [*now, 0.0]])
    if method == "verlet":
        x = [1.0, h] + 0.5 * h * h * now
        step = [x, ([0.0, 1.0] + 0.5 * h * now - 0.5 * h * k * x) / (1.0 + 0.5 * h * b)]
    elif u is not None:
        step = [[1.0, h] if method == "explicit_euler" else [1.0, 0.0] + h * u, u]
    else:
        powers = [np.linalg.matrix_power(h * a, n) / math.factorial(n) for n in range(5)]
        step = {
            "rk4": sum(powers), "implicit_euler": inv(eye - h * a), "exact": expm(h * a),
            "trapezoid": inv(eye - 0.5 * h * a) @ (eye + 0.5 * h * a),
        }[method]  # fmt: skip
    whole = np.zeros((3, 3))
    whole[:2, :2] = step
    return whole


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
        assert integrators.error(scene, NUMBER[method], h) == pytest.approx(apart, rel=0.01, abs=1e-9)


@pytest.mark.slow
def test_the_error_of_a_tap_on_a_wall_agrees_with_plain_python():
    wall, device = LIBRARY["wall"], SimulatedHapkit(quantum=0.0)
    scene = script("tap"), device, wall, wall.values({"stiffness": 800.0})
    true = rendered(*scene)[:, rows.TRUE_POSITION]
    for delay in (0.0, 1e-3):
        for rate in (250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0, 10_000.0):
            found = rendered(*scene, ("rate", "delay"), rate, delay)[:, rows.TRUE_POSITION]
            apart = np.abs(found - true)[:: max(round(1000.0 / rate), 1)].max() / (true.max() - 0.005)
            assert servo.contact_error(rate, delay) == pytest.approx(apart, rel=0.08)


@pytest.mark.slow
@pytest.mark.parametrize(
    "model", [pytest.param(m, marks=[pytest.mark.slow] * (m != "tether")) for m in RENDERED]
)
def test_the_drift_of_a_stuck_handle_agrees_with_plain_python(model):
    """Only models with an anchor move by less than a count in two seconds."""
    hand = Hand(stiffness=1.0, target=lambda t: 0.3 + 0.15 * np.sin(40.0 * math.pi * t), vectorised=True)
    device = SimulatedHapkit(coulomb_force=0.0, max_force=math.inf)
    values = LIBRARY["friction"].values({"model": model, "static_force": 1.0, "kinetic_force": 0.5})
    scene = Trial("held", hand, 3.0, 0.02), device, LIBRARY["friction"], values
    for dt in friction.STEPS:
        x = rendered(*scene, ("rate", "velocity", "sensor"), 1.0 / dt, 0.0, Difference)[:, rows.TRUE_POSITION]
        drift, found = abs(x[-1] - x[1000]) / 2.0, friction.handle_drift(model, dt)
        if model in ("tether", "projection"):
            assert max(drift, found) < 1e-5
        else:
            assert found == pytest.approx(drift, rel=0.06)
            assert found > 1e-3


def test_the_error_of_the_period_decreases_with_the_step():
    for key in ("lecture", "exact"):
        fine, coarse = (integrators.error("stick_slip", NUMBER[key], h) for h in (0.125e-3, 4e-3))
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
        gained = math.sqrt(np.mean((np.diff(energies) / energies[:-1]) ** 2))
        assert contact.error(method, h, False) == pytest.approx(gained, rel=0.05, abs=1e-9)
        assert contact.error(method, h, True) == pytest.approx(abs(energies[-1] - 1.0), rel=0.05, abs=1e-9)


def test_located_contact_preserves_the_energy_and_the_exact_method_all_of_it():
    found = {key: contact.error(key, 1e-3, True) for key in contact.LABELS}
    assert found["exact"] < 1e-9 < found["located"] < 1e-6 < found["verlet"] < 1e-3 < found["held"]
    runs = {h: contact.energies("located", h) for h in (2e-3, 1e-3)}
    assert all(len(one) == contact.BOUNCES + 1 for one in runs.values())


def test_the_path_with_located_contact_agrees_with_the_closed_form():
    """The path is a uniform motion, half a period of a sine in the wall, and a uniform motion back."""
    omega = math.sqrt(500.0 / 0.5)
    work, x, _ = contact.moving("located", 0.25e-3, 0.2)
    work()
    t = 0.25e-3 * np.arange(x.size)
    since = t - (0.035 - contact.PUCK_FROM) / contact.SHOVED
    inside = 0.035 + contact.SHOVED / omega * np.sin(omega * since)
    back = 0.035 - contact.SHOVED * (since - math.pi / omega)
    true = np.where(
        since < 0.0, contact.PUCK_FROM + contact.SHOVED * t, np.where(omega * since < math.pi, inside, back)
    )
    assert x == pytest.approx(true, abs=1e-6)
