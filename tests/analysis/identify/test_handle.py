import math

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.analysis.identify import Recording, from_run, identify
from hapkit_studio.haptics import rows
from tests.analysis.identify.motions import shaken

TRUTH = {"mass": 0.094, "viscous": 0.5, "coulomb": 0.10}


@pytest.mark.parametrize(
    ("quantum", "rate", "delay"),
    [(61e-6, 1000.0, 0.5e-3), (20.7e-6, 500.0, 1e-3), (20.7e-6, 4000.0, 0.4e-3)],
)
def test_a_shaken_handle_is_identified_with_the_hands_mass(quantum, rate, delay):
    part = shaken(11, values={"stiffness": 150.0}, quantum=quantum, rate=rate, delay=delay).handle
    for key, truth in TRUTH.items():
        assert part[key].asked == pytest.approx(truth)
        assert abs(part[key].value - truth) < 2.0 * part[key].half
        assert part[key].half < 0.05 * truth
    assert not part.released


def test_a_released_handle_is_identified_and_an_unknown_hand_needs_the_option():
    device = hs.SimulatedHapkit(damping=0.3, coulomb_force=0.02, initial_position=0.015)
    run = hs.simulate("spring", {"stiffness": 150.0}, device=device, seconds=1.5, rate=2000.0)
    record = from_run(run)
    part = identify(record).handle
    assert part.released
    for key, truth in {"mass": 0.044, "viscous": 0.3, "coulomb": 0.02}.items():
        assert part[key].holds(truth)
    assert part["mass"].half < 0.001
    unknown = Recording(**{**vars(record), "hand_force": np.full(len(record), math.nan)})
    refused = identify(unknown).handle
    assert not refused.estimates
    assert "Let go" in refused.advice
    assert identify(unknown, released=True).handle["mass"].holds(0.044)


def test_stopped_samples_are_excluded_and_clamped_ones_are_not():
    run = hs.simulate("spring", {"stiffness": 1000.0}, hand="shake", seconds=4.0)
    found = identify(from_run(run))
    assert found.handle["mass"].holds(0.144)
    record = from_run(run)
    flags = record.flags.copy()
    flags[1000:] |= rows.STOPPED
    less = identify(Recording(**{**vars(record), "flags": flags})).handle
    assert less.left_out["stopped"] == 3000
    assert less.seconds < found.handle.seconds
