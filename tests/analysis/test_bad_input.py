"""Whoever asks with what is no number, or with one that no device has, reads one line."""

import math

import numpy as np
import pytest

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability import kb_plane, rendered
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.analysis.stability.rendered import largest_stable, measured_stiffness_limit
from hapkit_studio.analysis.sweeps import sweep
from hapkit_studio.analysis.zwidth import simulation
from hapkit_studio.errors import ParameterError
from tests.analysis import sweep_tasks

ROWS = {
    "exact": lambda row: kb_plane.exact_boundary(Setting(), row),
    "passive": lambda row: kb_plane.passivity_line(Setting(), row),
    "measured": lambda row: rendered.boundary(Setting(), row),
    "columns": lambda row: rendered.classes(Setting(), row, [100.0]),
    "lines": lambda row: rendered.classes(Setting(), [0.0], row),
    "zwidth": lambda row: simulation.compute(Setting(), row),
}
NO_ROWS = [
    [math.nan],
    [math.inf],
    [-1.0],
    [1e300],
    ["1"],
    "x",
    None,
    [[1.0, 2.0]],
    [[1.0], []],
    [True],
    [None],
    {},
]


def said(ask, *args, **named):
    with pytest.raises(ParameterError) as e:
        ask(*args, **named)
    words = str(e.value)
    assert "\n" not in words
    assert len(words) < 200
    return words


@pytest.mark.parametrize("name", ROWS)
def test_a_row_that_is_none(name):
    for bad in NO_ROWS:
        assert "amping" in said(ROWS[name], bad) or name == "lines"


def test_rows_of_any_kind_of_numbers():
    want = kb_plane.exact_boundary(Setting(), np.array([0.0, 2.0]))
    for good in ([0, 2], (0.0, 2.0), np.array([0, 2], dtype=np.int16)):
        assert kb_plane.exact_boundary(Setting(), good).tolist() == want.tolist()
    assert kb_plane.exact_boundary(Setting(), []).size == 0


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0, 1e300, "x", None, [], True])
def test_a_number_that_is_none(bad):
    assert "rendered stiffness" in said(kb_plane.plane, Setting(), bad, 0.0)
    assert "rendered damping" in said(kb_plane.plane, Setting(), 1.0, bad)
    assert "virtual damping" in said(kb_plane.limit, Setting(), bad)
    for name in ("mass", "viscous", "damping", "rate", "delay", "quantum"):
        numbers = {"mass": 0.05, "viscous": 0.5, name: bad}
        assert name in said(stiffness_limit, **numbers)


def test_axes_that_no_plane_has():
    for bad in (math.nan, -1.0, "x"):
        said(kb_plane.plane, Setting(), 300.0, 0.0, width=bad, top=100.0)
        said(kb_plane.plane, Setting(), 300.0, 0.0, width=2.0, top=bad)
    for bad in (1, 0, 2.5, "x", True):
        said(kb_plane.plane, Setting(), 300.0, 0.0, columns=bad)


@pytest.mark.parametrize("chunk", ["x", 1.5, 0, True])
def test_a_chunk_that_is_no_whole_number(chunk):
    assert "whole number" in said(sweep, sweep_tasks.roots, [1.0], chunk=chunk)


def test_a_delay_of_2000_periods_is_the_longest():
    assert stiffness_limit(0.05, 0.5, delay=2.0) > 0.0
    for late in ({"delay": 2.001}, {"delay": 0.01, "rate": 1e6}):
        assert "2000 at most" in said(stiffness_limit, 0.05, 0.5, **late)
        assert "2000 at most" in said(Setting, **late)


@pytest.mark.parametrize("rate", [9.0, 1.01e5, 1e6])
def test_a_wall_is_hit_for_a_number_of_samples_that_fits(rate):
    words = said(simulation.compute, Setting(rate=rate), [0.0])
    assert words == f"A hit of 4 s is simulated at 10 to 100000 Hz, not at {rate:g} Hz."


def test_the_softest_limit_is_1_mn_per_m():
    """Above the softest it is found, below it is 0, whatever the steps on the way."""
    for limit in (1.01e-3, 2e-3, 3.9e-3, 0.3, 5.0, 1e8):
        assert largest_stable(lambda k, limit=limit: k <= limit) == pytest.approx(limit, rel=1e-4)
    assert largest_stable(lambda k: k <= 0.99e-3) == 0.0
    assert largest_stable(lambda k: True) == math.inf


def test_a_very_soft_limit_is_measured():
    """b / (T/2 + d): with so little damping and so late, 2 mN/m."""
    late, viscous = 1.0, 2e-3
    exact = stiffness_limit(0.05, viscous, delay=late)
    assert 1e-3 < exact < 1.0 / 256.0
    assert measured_stiffness_limit(0.05, viscous, delay=late) == pytest.approx(exact, rel=0.01)
