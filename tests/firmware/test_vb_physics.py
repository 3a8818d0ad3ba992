"""The virtual board's paddle agrees with closed forms, and with an adaptive ODE solver with events."""

import math

import numpy as np
import pytest

from tests.dynamics.reference_paddle import slide
from tests.firmware.vb import FULL_FORCE, chip, needs_compiler, run

pytestmark = needs_compiler

MASS, VISCOUS, COULOMB = 0.044, 0.5, 0.10


@pytest.fixture
def asleep(tmp_path):
    return chip("asleep", tmp_path)


def expected(times, pieces, x=0.0, v=0.0, coulomb=COULOMB):
    """Return positions and velocities (n, 2) at n times, from the exact solution of the motion.

    ``pieces`` are intervals of constant conditions: (start, force, rate, mass, damping, stiffness).
    """
    edges = sorted({*times, *(p[0] for p in pieces)})
    out, now = {}, 0.0
    for until in edges:
        start, force, rate, mass, damping, stiffness = [p for p in pieces if p[0] <= now][-1]
        if until > now:
            force += rate * (now - start)
            x, v = slide(x, v, force, rate, coulomb, mass, damping, stiffness, until - now)
        now = until
        out[until] = (x, v)
    return np.array([out[t] for t in times])


def compare(outcome, pieces, **start):
    truth = outcome.truth[1:]
    wanted = expected(truth.time, pieces, **start)
    assert len(truth) > 20
    assert np.ptp(wanted[:, 0]) > 1e-4
    np.testing.assert_allclose(truth.position, wanted[:, 0], rtol=0, atol=1e-10)
    np.testing.assert_allclose(truth.velocity, wanted[:, 1], rtol=0, atol=1e-7)


def test_friction_resists_a_smaller_force_and_stops_a_thrown_paddle_at_the_theoretical_position(
    asleep, tmp_path
):
    held = run(asleep, tmp_path, "--seconds", "0.1", "--log-period", "0.001", script=["0 force 0.0999"])
    assert np.all(held.truth.position == 0.0)
    outcome = run(asleep, tmp_path, "--velocity", "0.2", "--seconds", "0.3", "--log-period", "0.001")
    # the solution of m v' = -b v - Fc is x = m v0 / b - m Fc / b^2 ln(1 + b v0 / Fc)
    stop = MASS * 0.2 / VISCOUS - MASS * COULOMB / VISCOUS**2 * math.log(1 + VISCOUS * 0.2 / COULOMB)
    assert outcome.truth.position[-1] == pytest.approx(stop, rel=1e-12)
    assert outcome.truth.velocity[-1] == 0.0


def test_the_paddle_follows_a_hand_with_steps_ramps_and_a_release(asleep, tmp_path):
    hand, grip = (400.0, 8.0, 0.10), "400 8 0.1"
    script = [f"0.01 hand 0.01 {grip}", f"0.1 hand -0.005 {grip} 0.05", "0.2 release"]
    outcome = run(asleep, tmp_path, "--seconds", "0.25", "--log-period", "0.005", script=script)
    stiffness, damping, mass = hand
    held = (MASS + mass, VISCOUS + damping, stiffness)
    rate = -0.015 / 0.05
    pieces = [
        (0.0, 0.0, 0.0, MASS, VISCOUS, 0.0),
        (0.01, stiffness * 0.01, 0.0, *held),
        (0.1, stiffness * 0.01 + damping * rate, stiffness * rate, *held),
        (0.15, stiffness * -0.005, 0.0, *held),
        (0.2, 0.0, 0.0, MASS, VISCOUS, 0.0),
    ]
    compare(outcome, pieces)
    truth = outcome.truth[outcome.truth.time > 0.16]
    force = np.where(truth.time <= 0.2, stiffness * (-0.005 - truth.position) - damping * truth.velocity, 0.0)
    np.testing.assert_allclose(truth.hand_force, force, atol=1e-12)


@pytest.mark.slow
def test_an_oscillation_under_friction_reverses_and_stops(asleep, tmp_path):
    options = ("--seconds", "0.4", "--log-period", "0.004", "--viscous", "0", "--coulomb", "0.3")
    outcome = run(asleep, tmp_path, *options, script=["0 hand 0.02 300 0 0"])
    compare(outcome, [(0.0, 6.0, 0.0, MASS, 0.0, 300.0)], coulomb=0.3)
    assert np.count_nonzero(np.diff(np.sign(outcome.truth.velocity))) >= 4


def test_end_stops_do_not_bounce(asleep, tmp_path):
    options = ("--seconds", "0.5", "--log-period", "0.001", "--stop", "0.02")
    truth = run(asleep, tmp_path, *options, script=["0 force 2", "0.3 force -2"]).truth
    assert truth.position.max() == 0.02
    assert np.all(truth.velocity[(truth.time > 0.2) & (truth.time <= 0.3)] == 0.0)
    assert truth.position[-1] == -0.02


def test_registers_determine_the_motors_force_and_its_wiring_can_be_reversed(tmp_path):
    options = ("--seconds", "0.03", "--log-period", "0.0005")
    steps = chip("steps", tmp_path)
    truth = run(steps, tmp_path, *options).truth
    changes = [k for k in range(len(truth)) if k == 0 or truth.duty[k] != truth.duty[k - 1]]
    duties = truth.duty[changes].astype(int).tolist()
    assert duties == [0, 1, 64, 128, 255, 0, -1, -64, -128, -255, 0, -255, 0]
    force = np.sign(truth.duty) * FULL_FORCE * (truth.duty / 255.0) ** 2
    np.testing.assert_allclose(truth.motor_force, force, rtol=1e-15)
    assert np.ptp(truth.position) > 1e-4
    turned = run(steps, tmp_path, *options, "--direction", "-1").truth
    np.testing.assert_array_equal(turned.position, -truth.position)
