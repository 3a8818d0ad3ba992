"""The 95 % intervals contain the truth over many hands and motions."""

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.analysis.identify import from_run, identify
from hapkit_studio.dynamics.hand import SCRIPTS
from tests.analysis.identify.motions import impedance, shaken, sine_run

TRUTH = np.array([0.094, 0.5, 0.10])


@pytest.mark.slow
def test_intervals_of_the_handle_contain_the_truth():
    errors, halves = [], []
    for seed in range(60):
        part = shaken(seed, values={"stiffness": 150.0}, delay=1e-3).handle
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
    # unbiased: the mean error of 60 samples is compatible with 0
    assert (np.abs(errors.mean(axis=0)) < 3.5 * errors.std(axis=0) / np.sqrt(60)).all()
    # efficient: an interval is at most twice as wide as the true spread
    assert (np.median(halves, axis=0) < 4.0 * errors.std(axis=0)).all()


def test_intervals_of_the_rendered_impedance_contain_the_truth():
    inside = []
    for seed in range(24):
        random = np.random.default_rng(seed)
        stiffness, hertz = random.uniform(60.0, 700.0), random.uniform(0.8, 5.0)
        amplitude, phase = random.uniform(0.002, 0.012), random.uniform(0.0, 6.28)
        run = sine_run(stiffness, 2.0, hertz, amplitude, phase, quantum=61e-6, delay=0.5e-3, seconds=2.0)
        part = identify(from_run(run)).rendered
        truth = impedance(stiffness, 2.0, hertz, 1000.0, 0.5e-3)
        inside.append([part["stiffness"].holds(truth[0]), part["damping"].holds(truth[1])])
    assert np.mean(inside) >= 0.9


HANDS = ("stroke", "pet", "rub", "tap", "shake", "sweep")
SCENES = (
    ("free", {}),
    ("damping", {"damping": 1.0}),
    ("damping", {"damping": 3.0}),
    ("spring", {"stiffness": 120.0, "damping": 1.0}),
    ("wall", {}),
)
DEVICE = {"viscous": 0.5, "coulomb": 0.10}


def relative_errors(hand, scene, values, estimator):
    """Return |error| / half width, and whether the interval contains the truth, for each reported value."""
    part = identify(from_run(hs.simulate(scene, values, hand=hand, estimator=estimator, seconds=8.0))).handle
    truth = {**DEVICE, "mass": 0.044 + SCRIPTS[hand].mass}
    return [
        (abs(e.value - truth[e.key]) / e.half, e.holds(truth[e.key])) for e in part.estimates if e.determined
    ]


@pytest.mark.slow
def test_identified_values_are_true():
    found = {
        hand: [
            x
            for i, scene in enumerate(SCENES)
            for x in relative_errors(hand, *scene, ("difference", "iir")[i % 2])
        ]
        for hand in HANDS
    }
    everything = np.array([holds for one in found.values() for _, holds in one])
    assert everything.mean() >= 0.90
    assert all(np.mean([holds for _, holds in one]) >= 0.8 for one in found.values() if len(one) >= 9)
    assert max(ratio for one in found.values() for ratio, _ in one) < 3.0
    # motions with enough excitation must be identified, not rejected
    for hand in ("shake", "rub", "tap"):
        assert len(found[hand]) >= 12


def test_a_constant_speed_never_gives_a_negative_mass():
    run = hs.simulate("damping", {"damping": 3.0}, hand="pet", estimator="iir", seconds=8.0)
    part = identify(from_run(run)).handle
    assert not any(e.determined for e in part.estimates)
    assert "Unknown" in part.advice
    assert "shake" in part.advice
