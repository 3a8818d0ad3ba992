"""The limit for the worst of all hands is compared with the passivity line and with random hands."""

import numpy as np
import pytest

from hapkit_studio.analysis.stability import hands
from hapkit_studio.analysis.stability.passivity import passive_damping, passive_stiffness
from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.dynamics.loop_settings import LoopSettings
from tests.analysis.stability.test_limits import closed_loop

FILTERS = ("difference", ("iir", {"cutoff": 20.0}), "iir", "kalman", "butterworth")


def some_setting(rng):
    rate = 10 ** rng.uniform(2.5, 3.7)
    delay = rng.choice([0.0, 1.0, rng.random(), 3.0 * rng.random()]) / rate
    mass, viscous = 10 ** rng.uniform(-1.7, -0.7), 10 ** rng.uniform(-0.7, 0.7)
    return LoopSettings(
        rate, delay, FILTERS[rng.integers(len(FILTERS))], mass=mass, viscous=viscous, coulomb=0.0
    )


def passivity(setting, shares):
    """Return dampings, as fractions of the largest passive damping, and the passive stiffness at each."""
    sampling = setting.rate, setting.delay, setting.estimator, setting.quantum
    damping = passive_damping(setting.viscous, *sampling) * np.asarray(shares)
    return damping, passive_stiffness(setting.viscous, damping, *sampling)


@pytest.mark.parametrize("count", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_the_envelope_is_above_passivity_and_below_random_hands(count):
    rng = np.random.default_rng(412)
    ranges = hands.MASS, hands.DAMPING, hands.STIFFNESS
    for _ in range(count):
        setting = some_setting(rng)
        damping, line = passivity(setting, (0.0, 0.5, 1.0))
        found = hands.family(setting, damping)
        assert (found.people > line).all()
        names = "rate", "delay", "estimator", "mass", "viscous"
        loop = {name: getattr(setting, name) for name in names}
        for b, limit, worst in zip(damping, found.people, found.worst, strict=True):
            grips = [Grip(*(10 ** rng.uniform(*np.log10(ends)) for ends in ranges)) for _ in range(30)]
            roots = [largest(loop, b, grip, 0.95 * limit) for grip in grips]
            assert max(roots) < 1.0
            assert largest(loop, b, worst, 0.99 * limit) < 1.0 < largest(loop, b, worst, 1.01 * limit)


def largest(loop, damping, grip, stiffness):
    matrices = closed_loop(**{**loop, "damping": damping, "hand": grip})
    return np.abs(np.linalg.eigvals(matrices(np.array(stiffness)))).max()
