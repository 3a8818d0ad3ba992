"""Percentiles of the lateness histogram against numpy's, to the width of a bin."""

import numpy as np
import pytest

from hapkit_studio.haptics import health


def filled(lateness):
    bins = health.new_histogram()
    for value in lateness:
        health.add_lateness(bins, float(value))
    return bins


def width(us):
    return 1.0 if us < 1e3 else 10.0 if us < 1e4 else 100.0


@pytest.mark.parametrize("median", [5e-6, 40e-6, 2e-3, 20e-3])
def test_percentiles_are_those_of_numpy(median, rng):
    lateness = median * np.exp(rng.normal(0.0, 0.4, 5000))
    found = health.lateness_percentiles(filled(lateness))
    for name, q in (("p50", 50.0), ("p99", 99.0), ("p99.9", 99.9), ("max", 100.0)):
        exact = 1e6 * np.percentile(lateness, q, method="inverted_cdf")
        assert exact <= found[name] <= exact + width(exact) * (1.0 + 1e-9)


def test_every_lateness_is_counted_in_its_bin():
    us = np.concatenate(
        (np.arange(1000) + 0.5, 1000 + 10 * np.arange(900) + 5, 1e4 + 100 * np.arange(900) + 50)
    )
    bins = filled(1e-6 * us)
    assert bins[-1] == 0
    np.testing.assert_array_equal(bins[:-1], 1)
    np.testing.assert_allclose(health.LATENESS_EDGES_US[:-1] - us, [width(u) / 2.0 for u in us])


@pytest.mark.parametrize("lateness", [0.1, 5.0, np.inf, np.nan])
def test_what_lies_beyond_is_counted_as_beyond(lateness):
    assert filled([lateness])[-1] == 1
    assert health.lateness_percentiles(filled([1e-5, lateness]))["max"] == 100_000.0


@pytest.mark.parametrize("lateness", [-1e-6, -5.0, 0.0])
def test_early_is_not_late(lateness):
    assert filled([lateness])[0] == 1


def test_nothing_counted_is_zero():
    assert health.lateness_percentiles(health.new_histogram()) == {"p50": 0, "p99": 0, "p99.9": 0, "max": 0}
