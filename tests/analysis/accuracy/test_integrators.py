"""Integrators, contact: theory's table, closed forms, orders, energies of bounces."""

import math

import numpy as np
import pytest

from hapkit_studio.analysis.accuracy import contact, integrators
from hapkit_studio.dynamics.integrators import INTEGRATORS, Body
from tests.dynamics.test_integrators import ERRORS as WORK_PRECISION

NUMBER = {key: n for n, key in enumerate(INTEGRATORS)}


def test_the_work_precision_table():
    for key in ("lecture", "rk4"):
        motions = [integrators.swinging(Body(0.05, 0.4, 300.0), NUMBER[key], h) for h in integrators.STEPS]
        found = [work() or error() for work, error in motions]
        assert found == pytest.approx(WORK_PRECISION[key], rel=0.10)


@pytest.mark.parametrize("scene", ["free", "damped"])
def test_exact_is_where_the_closed_form_is(scene):
    for h in integrators.STEPS:
        assert integrators.error(scene, NUMBER["exact"], h) < 1e-11


def test_the_period_comes_nearer_with_the_step():
    for key in ("lecture", "exact"):
        fine, coarse = (integrators.error("stick_slip", NUMBER[key], h) for h in (0.125e-3, 4e-3))
        assert fine < min(0.01, coarse)


def test_a_held_force_adds_half_pi_omega_h_of_the_energy_at_every_bounce():
    """It is as old as h/2: a negative damping of K h/2 over half a swing in the wall."""
    for h in (0.25e-3, 0.125e-3):
        found = contact.energies("held", h, 20)
        gained = np.mean(found[1:] / found[:-1]) - 1.0
        assert gained == pytest.approx(0.5 * math.pi * math.sqrt(500.0 / 0.5) * h, rel=0.05)


def test_a_contact_that_is_located_keeps_the_energy_and_exact_all_of_it():
    found = {key: contact.error(key, 1e-3, True) for key in contact.LABELS}
    assert found["exact"] < 1e-9 < found["located"] < 1e-6 < found["verlet"] < 1e-3 < found["held"]
    runs = {h: contact.energies("located", h) for h in (2e-3, 1e-3)}
    assert all(len(one) == contact.BOUNCES + 1 for one in runs.values())


def test_the_located_path_is_that_of_the_closed_form():
    """Straight on, half a turn of a sine in the wall, straight back: 2 m/s² off by less than 1 µm."""
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
