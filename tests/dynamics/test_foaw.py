"""Adaptive windowing on a sensor's grid: the same motion gives the same velocity anywhere."""

import numpy as np
import pytest

from hapkit_studio.dynamics.estimators import estimate_velocity
from hapkit_studio.errors import ParameterError

QUANTUM = 20.7e-6


@pytest.mark.parametrize("place", [1, 1234, -77777])
@pytest.mark.parametrize("seed", range(5))
def test_rounding_decides_nothing(place, seed):
    """A residual of just half a count is common; at another place it may not fall to the other side."""
    counts = np.cumsum(np.random.default_rng(seed).integers(-1, 2, 2000))
    here = estimate_velocity(QUANTUM * counts, 1000.0, "foaw", quantum=QUANTUM)
    there = estimate_velocity(QUANTUM * (counts + place), 1000.0, "foaw", quantum=QUANTUM)
    assert there == pytest.approx(here, abs=1e-9)


@pytest.mark.parametrize("quantum", [-1.0, float("nan"), float("inf"), "fine", None])
def test_a_quantum_is_a_length(quantum):
    with pytest.raises(ParameterError, match="quantum must be 0 m or more"):
        estimate_velocity(np.zeros(5), 1000.0, "foaw", quantum=quantum)
