"""The exact boundary over whole ranges of damping, and the recurrence that a rendered spring obeys."""

import math

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.analysis.stability.limits import (
    checked_loop,
    damping_limit,
    stiffness_limit,
    stiffness_limits,
)
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings_writer import LoopSettings

# delay in periods; damping and stiffness of the highest point, largest damping, as multiples of m/T, m/T²
PEAKS = [(0.0, 0.828, 0.688, 2.00), (0.5, 0.552, 0.268, 1.144), (1.0, 0.425, 0.145, 0.829)]
PEAKS += [(2.0, 0.291, 0.0628, 0.537)]
# delay in periods, characteristic polynomial for 0.05 kg, 0.5 N·s/m, 1 ms, 500 N/m, 1 N·s/m
POLYNOMIALS = [
    (0.0, (1.0, -1.975099708998752, 0.9949834579176372, -0.009933582668053186)),
    (
        0.5,
        (1.0, -1.9863060759444742, 1.0099418537299814, -0.011206356580991414, -0.002479254953683939),
    ),
    (1.0, (1.0, -1.990049833749168, 1.0049999584995841, 0.004933624168469068, -0.009933582668053186)),
]


@pytest.mark.parametrize(("late", "at", "highest", "most"), PEAKS)
def test_the_highest_point_and_the_largest_damping_of_a_handle_without_its_own(late, at, highest, most):
    loop = checked_loop(1.0, 1e-6, 0.0, 1.0, late, "difference", None)
    damping = np.linspace(0.002, most, 2000)
    limits = stiffness_limits(loop, damping)
    assert damping[np.argmax(limits)] == pytest.approx(at, abs=0.003)
    assert limits.max() == pytest.approx(highest, rel=0.007)
    assert damping_limit(loop) == pytest.approx(most, rel=0.0025)


@pytest.mark.parametrize("estimator", ["difference", ("iir", {"cutoff": 20.0}), "butterworth", "kalman"])
@pytest.mark.parametrize("delay", [0.0, 0.4e-3, 1e-3, 7.7e-3])
def test_many_dampings_together_give_what_each_gives_alone(estimator, delay):
    loop = checked_loop(0.044, 0.5, 0.0, 1000.0, delay, estimator, "light")
    damping = np.array([0.0, 0.3, 2.0, 9.0, 60.0, 300.0] * 7)
    together = stiffness_limits(loop, damping)
    alone = [
        stiffness_limit(0.044, 0.5, damping=b, delay=delay, estimator=estimator, hand="light")
        for b in damping[:6]
    ]
    assert list(together) == alone * 7


@pytest.mark.parametrize(("late", "polynomial"), POLYNOMIALS)
def test_a_rendered_spring_obeys_its_characteristic_polynomial(late, polynomial):
    device = SimulatedHapkit(0.05, 0.5, 0.0, 0.0, math.inf, initial_position=1e-3)
    values = {"stiffness": 500.0, "damping": 1.0, "center": 0.0}
    loop = LoopSettings(1000.0, late * 1e-3)
    out = headless.spring_rows(environments.named("spring"), values, device, loop, None, 300)
    x = out[10:, rows.TRUE_POSITION]
    left = np.convolve(x, polynomial, "valid")
    assert np.abs(left).max() < 1e-15
