"""The passivity line agrees with closed forms, and with the worst motion found by optimisation."""

import math

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.analysis.stability.passivity import passive_damping, passive_stiffness
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import estimate_velocity
from hapkit_studio.dynamics.hand import Prescribed
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.haptics import headless, rows
from tests.wide import wide

B = 0.5
PERIOD = 1e-3


def largest(damping, late, estimator="difference", viscous=B, rate=1000.0):
    return float(passive_stiffness(viscous, np.array([damping]), rate, late / rate, estimator)[0])


def test_the_passive_stiffness_with_a_delay_of_whole_periods_agrees_with_theory():
    """Colgate & Schenkel's condition is b > K T/2 times 1, 3 or 5 for a delay of 0, 1 or 2 periods."""
    for late, factor in ((0, 1.0), (1, 3.0), (2, 5.0)):
        for rate in (230.0, 1000.0, 4000.0):
            assert largest(0.0, late, rate=rate) == pytest.approx(2.0 * B * rate / factor, rel=1e-6)


def test_backward_difference_damping_reduces_the_limit():
    """The condition is b > K T/2 + B."""
    for damping in (0.05, 0.2, 0.45):
        assert largest(damping, 0) == pytest.approx(2.0 * (B - damping) / PERIOD, rel=1e-9)


def test_a_filter_reduces_the_cost_of_damping():
    """The condition is b > K T/2 + B alpha/(2 - alpha), to the table's third digit."""
    for cutoff, cost in ((200.0, 0.557), (100.0, 0.304), (60.0, 0.186), (35.5, 0.111), (20.0, 0.063)):
        found = largest(1.0, 0, ("iir", {"cutoff": cutoff}), viscous=1.0)
        alpha = -math.expm1(-2.0 * math.pi * cutoff * PERIOD)
        assert found == pytest.approx(2.0 * (1.0 - alpha / (2.0 - alpha)) / PERIOD, rel=1e-9)
        assert found == pytest.approx(2.0 * (1.0 - cost) / PERIOD, abs=1.2)


def test_the_passive_stiffness_with_a_fractional_delay_agrees_with_theory():
    """The slowest motion is the worst: for w -> 0, the condition is b² > b K (T/2 + td) + K² θ (T - θ)/4.

    θ is the fraction of a period in the delay td, in s.
    """
    for late in (0.1, 0.5, 0.9, 1.5, 3.3):
        stiffness = largest(0.0, late)
        rest = (late - math.floor(late)) * PERIOD
        spent = B * stiffness * (0.5 + late) * PERIOD + stiffness**2 * rest * (PERIOD - rest) / 4.0
        assert spent == pytest.approx(B**2, rel=1e-6)


def knots(late, periods):
    """Return the times in periods, up to ``periods``, at which the loop samples or a force starts to act."""
    rest = late - math.floor(late)
    parts = (0.0, rest) if rest else (0.0,)
    return np.array([k + part for k in range(periods) for part in parts])


def energy_form(stiffness, damping, late, estimator, periods=160):
    """Return the symmetric matrix of the energy that handle and loop absorb from a motion.

    The motion is given by its positions at the ``knots``, starts and ends at rest, and lasts until the last
    command. Each column is the response to moving one knot, so that no transfer function is needed.
    """
    t = knots(late, periods)
    whole, fine = math.floor(late), 2 if late % 1.0 else 1
    count = len(t)
    taken = np.zeros((count, count))
    lengths = np.diff(t) * PERIOD
    for i, length in enumerate(lengths):
        taken[np.ix_([i, i + 1], [i, i + 1])] += B / length * np.array([[1.0, -1.0], [-1.0, 1.0]])
    pulse = np.zeros(periods)
    pulse[1] = 1.0
    answer = damping * estimate_velocity(pulse, 1.0 / PERIOD, estimator)[1:]
    answer[0] += stiffness
    ordered = np.zeros((count, count))
    for k in range(periods - whole - 1):
        arrival = fine * (k + whole) + fine - 1
        past = np.arange(1, k + 1)
        for knot, sign in ((arrival + fine, 1.0), (arrival, -1.0)):
            if knot < count:
                ordered[fine * past, knot] += sign * answer[k - past]
    taken += 0.5 * (ordered + ordered.T)
    keep = slice(fine, fine * (periods - whole - 3))
    return taken[keep, keep]


CASES = [
    (0.0, 0.0, "difference"),
    (0.3, 0.4, "difference"),
    (0.1, 1.0, "difference"),
    (0.4, 1.7, "difference"),
    (2.0, 0.0, "iir"),
    (0.6, 1.3, ("iir", {"cutoff": 100.0})),
    (0.5, 0.6, "butterworth"),
    (0.3, 1.6, "kalman"),
]


@pytest.mark.parametrize(
    ("damping", "late", "estimator"), wide(CASES, lambda _damping, late, _estimator: late in (0.0, 0.6, 1.6))
)
def test_no_motion_gains_energy_inside_the_line_and_one_does_outside(damping, late, estimator):
    limit = largest(damping, late, estimator)
    assert limit > 20.0
    inside, outside = (energy_form(part * limit, damping, late, estimator) for part in (0.99, 1.01))
    assert np.linalg.eigvalsh(inside)[0] > 0.0
    assert np.linalg.eigvalsh(outside)[0] < 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("damping", "late", "estimator"), [(0.2, 0.0, "difference"), (0.3, 0.4, "difference"), (0.5, 0.6, "iir")]
)
def test_the_simulated_worst_motion_gains_energy_only_outside(damping, late, estimator):
    """The worst motion is imposed on the handle, with springs 1 % below and above the limit."""
    limit = largest(damping, late, estimator)
    gained = []
    for part in (0.99, 1.01):
        form = energy_form(part * limit, damping, late, estimator)
        worst = np.linalg.eigh(form)[1][:, 0]
        gained.append(
            rendered_gain(worst / np.abs(worst).max() * 1e-3, part * limit, damping, late, estimator)
        )
    assert gained[0] < 0.0 < gained[1]


def rendered_gain(moved, stiffness, damping, late, estimator, periods=160):
    """Return the energy in J that the hand gains from the spring, less the loss in the handle's damping."""
    t = knots(late, periods)
    fine = 2 if late % 1.0 else 1
    x = np.zeros(len(t))
    x[fine : fine + len(moved)] = moved
    motion = Prescribed(lambda time: float(np.interp(time / PERIOD, t, x)))
    device = SimulatedHapkit(0.05, 0.0, 0.0, 0.0, math.inf)
    scene = headless.Scene(
        environments.named("spring"),
        {"stiffness": stiffness, "damping": damping, "center": 0.0},
        device,
        LoopSettings(1.0 / PERIOD, late * PERIOD, estimator),
    )
    forces = headless.render(scene, motion, periods)[0][:, rows.APPLIED_FORCE]
    acts = np.interp(np.arange(periods + 1) + late, t, x)
    return float(np.sum(forces * np.diff(acts)) - np.sum(B * np.diff(x) ** 2 / np.diff(t)) / PERIOD)


@pytest.mark.parametrize(("late", "estimator"), [(0.0, "difference"), (0.3, "difference"), (1.0, "iir")])
def test_the_line_ends_at_the_largest_passive_damping(late, estimator):
    most = passive_damping(B, 1000.0, late * PERIOD, estimator)
    assert largest(1.01 * most, late, estimator) == 0.0
    assert np.linalg.eigvalsh(energy_form(1e-3, 1.01 * most, late, estimator))[0] < 0.0
    low = largest(0.99 * most, late, estimator)
    assert np.linalg.eigvalsh(energy_form(0.99 * low, 0.99 * most, late, estimator))[0] > 0.0
