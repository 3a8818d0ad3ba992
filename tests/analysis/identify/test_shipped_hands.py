"""Whether what is told of the handle is true for every movement that the studio brings."""

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.analysis.identify import from_run, identify
from hapkit_studio.dynamics.hand import SCRIPTS

HANDS = ("stroke", "pet", "rub", "tap", "shake", "sweep")
SCENES = (
    ("free", {}),
    ("damping", {"damping": 1.0}),
    ("damping", {"damping": 3.0}),
    ("spring", {"stiffness": 120.0, "damping": 1.0}),
    ("wall", {}),
)
DEVICE = {"viscous": 0.5, "coulomb": 0.10}


def told(hand, scene, values, estimator):
    """Return (|error| / half, whether it holds) of all that is told of the handle."""
    part = identify(from_run(hs.simulate(scene, values, hand=hand, estimator=estimator, seconds=8.0))).handle
    truth = {**DEVICE, "mass": 0.044 + SCRIPTS[hand].mass}
    return [(abs(e.value - truth[e.key]) / e.half, e.holds(truth[e.key])) for e in part.estimates if e.told]


def test_what_is_told_is_true():
    found = {
        hand: [x for i, scene in enumerate(SCENES) for x in told(hand, *scene, ("difference", "iir")[i % 2])]
        for hand in HANDS
    }
    everything = np.array([holds for one in found.values() for _, holds in one])
    assert everything.mean() >= 0.90
    assert all(np.mean([holds for _, holds in one]) >= 0.8 for one in found.values() if len(one) >= 9)
    assert max(ratio for one in found.values() for ratio, _ in one) < 3.0
    # motions that are rich enough are told, not refused
    for hand in ("shake", "rub", "tap"):
        assert len(found[hand]) >= 12


@pytest.mark.parametrize("hand", ["stroke", "pet"])
def test_a_constant_speed_is_never_told_as_a_negative_mass(hand):
    run = hs.simulate("damping", {"damping": 3.0}, hand=hand, estimator="iir", seconds=8.0)
    part = identify(from_run(run)).handle
    assert not any(e.told for e in part.estimates)
    assert "Cannot tell" in part.advice
    assert "shake" in part.advice
