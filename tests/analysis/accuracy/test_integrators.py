"""Integrators' scenes against theory's tables, closed forms against a fine solver."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import StateSpace, lsim

from hapkit_studio.analysis.accuracy import integrators
from hapkit_studio.analysis.accuracy.plan import Point
from hapkit_studio.dynamics.integrators import INTEGRATORS, instants
from hapkit_studio.dynamics.stick_slip import period_error
from tests.dynamics.test_integrators import ERRORS as WORK_PRECISION

NUMBER = {key: n for n, key in enumerate(INTEGRATORS)}


def test_the_work_precision_table():
    light = integrators.oscillating(0.05, 0.4, 300.0)
    for key in ("lecture", "rk4"):
        found = [light.error(NUMBER[key], h) for h in integrators.STEPS]
        assert found == pytest.approx(WORK_PRECISION[key], rel=0.10)


@pytest.mark.parametrize("scene", ["free", "damped", "contact"])
def test_exact_is_where_the_closed_form_is(scene):
    for h in integrators.STEPS:
        assert integrators.MOTIONS[scene]().error(NUMBER["exact"], h) < 1e-11


def solved(acceleration, x, v, seconds, t):
    """Return positions by a solver that knows nothing of closed forms, in pieces of at most 1 ms."""
    found = solve_ivp(
        lambda t, s: (s[1], acceleration(t, s[0], s[1])), (0.0, seconds), (x, v),
        t_eval=t, rtol=1e-10, atol=1e-13, max_step=1e-3,
    )  # fmt: skip
    return found.y[0]


def test_the_stirred_object_is_where_scipy_moves_it_under_the_held_handle():
    """A handle that moved on between samples would take it elsewhere: the hold is no integrator's error."""
    m, b, k, contact = 2.0, 1.0, 300.0, 500.0
    system = StateSpace(
        [[0.0, 1.0], [-(k + contact) / m, -b / m]], [[0.0], [contact / m]], [[1.0, 0.0]], [[0.0]]
    )
    for h in integrators.STEPS[::2]:
        t = instants(1.0, h)
        handle = 0.010 + 0.005 * np.sin(4.0 * math.pi * t)
        start = [contact * 0.010 / (k + contact), 0.0]
        held, between = (lsim(system, handle, t, start, interp=interp)[1] for interp in (False, True))
        assert (handle > held).all()
        found = integrators.driven().trace(NUMBER["exact"], h)
        assert found.true == pytest.approx(held, abs=1e-12)
        assert found.x == pytest.approx(held, abs=1e-12)
        assert np.abs(held - between).max() / found.scale > 0.5 * h


def test_the_puck_is_where_a_fine_solver_finds_it():
    t = np.linspace(0.0, 2.0, 401)
    reach = 0.035

    def acceleration(t, x, v):
        return -500.0 / 0.5 * (x - math.copysign(reach, x)) if abs(x) > reach else 0.0

    assert integrators.bounced(0.5, 500.0)(t) == pytest.approx(
        solved(acceleration, 0.01, 0.5, 2.0, t), abs=2e-7
    )


@pytest.mark.parametrize("scene", ["free", "driven", "contact"])
def test_a_trace_is_as_far_off_as_its_point(scene):
    motion = integrators.MOTIONS[scene]()
    found = integrators.trace(Point("integrators", scene, "verlet", 1e-3, 0.0, 0.0))
    assert np.abs(found.x - found.true).max() / found.scale == motion.error(NUMBER["verlet"], 1e-3)
    assert len(found.t) == len(found.x) == 1 + round(1000 * motion.seconds)


def test_the_period_comes_nearer_with_the_step():
    slip = integrators.stick_slip()
    for key in ("lecture", "exact"):
        assert slip.error(NUMBER[key], 0.125e-3) < min(0.01, slip.error(NUMBER[key], 4e-3))


def test_the_true_path_of_stick_slip_has_the_period_of_the_literature():
    found = integrators.stick_slip().trace(NUMBER["exact"], 1e-3)
    force = 300.0 * (0.02 * found.t - found.true)
    assert period_error(found.t, force, 0.211193) < 1e-3
    assert math.isnan(found.scale)
