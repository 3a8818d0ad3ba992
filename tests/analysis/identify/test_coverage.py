"""Whether 95 % of the intervals hold the truth, over many hands and motions."""

import numpy as np
import pytest

from hapkit_studio.analysis.identify import from_run, identify
from tests.analysis.identify.motions import impedance, shaken, sine_run
from tests.wide import wide

TRUTH = np.array([0.094, 0.5, 0.10])


@pytest.mark.parametrize(
    ("quantum", "rate", "delay", "first"),
    wide(
        [(20.7e-6, 1000.0, 1e-3, 0), (61e-6, 1000.0, 0.5e-3, 100), (20.7e-6, 500.0, 1e-3, 200)],
        lambda quantum, rate, delay, first: first == 0,
    ),
)
def test_handle(quantum, rate, delay, first):
    errors, halves = [], []
    for seed in range(first, first + 60):
        part = shaken(seed, values={"stiffness": 150.0}, quantum=quantum, rate=rate, delay=delay).handle
        if not part.estimates:
            continue
        values = [part[key] for key in ("mass", "viscous", "coulomb")]
        errors.append([e.value for e in values] - TRUTH)
        halves.append([e.half for e in values])
    assert len(errors) >= 57
    errors, halves = np.array(errors), np.array(halves)
    inside = np.abs(errors) <= halves
    assert 0.90 <= inside.mean() <= 0.998
    assert (inside.mean(axis=0) >= 0.85).all()
    # unbiased: the mean error is that of 60 draws
    assert (np.abs(errors.mean(axis=0)) < 3.5 * errors.std(axis=0) / np.sqrt(60)).all()
    # and of use: twice the spread that there is, not ten times
    assert (np.median(halves, axis=0) < 4.0 * errors.std(axis=0)).all()


def test_rendered():
    inside = []
    for seed in range(40):
        random = np.random.default_rng(seed)
        stiffness, hertz = random.uniform(60.0, 700.0), random.uniform(0.8, 5.0)
        amplitude, phase = random.uniform(0.002, 0.012), random.uniform(0.0, 6.28)
        run = sine_run(stiffness, 2.0, hertz, amplitude, phase, quantum=61e-6, delay=0.5e-3, seconds=2.0)
        part = identify(from_run(run)).rendered
        truth = impedance(stiffness, 2.0, hertz, 1000.0, 0.5e-3)
        inside.append([part["stiffness"].holds(truth[0]), part["damping"].holds(truth[1])])
    assert np.mean(inside) >= 0.9
