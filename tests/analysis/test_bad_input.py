"""Invalid numbers and settings give one-line errors."""

import math

import pytest

from hapkit_studio.analysis.stability import kb_plane, rendered
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.analysis.stability.rendered import largest_stable
from hapkit_studio.analysis.sweeps import sweep
from hapkit_studio.analysis.zwidth import simulation
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import ParameterError
from tests.analysis import sweep_tasks

ROWS = {
    "exact": lambda row: kb_plane.exact_boundary(LoopSettings(), row),
    "passive": lambda row: kb_plane.passivity_line(LoopSettings(), row),
    "measured": lambda row: rendered.boundary(LoopSettings(), row),
    "columns": lambda row: rendered.classes(LoopSettings(), row, [100.0]),
    "lines": lambda row: rendered.classes(LoopSettings(), [0.0], row),
    "zwidth": lambda row: simulation.compute(LoopSettings(), row),
}
NO_ROWS = [
    [math.nan], [math.inf], [-1.0], [1e300], ["1"], "x", None, [[1.0, 2.0]], [[1.0], []], [True], [None], {},
]  # fmt: skip


def error_text(ask, *args, **named):
    with pytest.raises(ParameterError) as e:
        ask(*args, **named)
    text = str(e.value)
    assert "\n" not in text
    assert len(text) < 200
    return text


def test_invalid_rows_are_rejected():
    for name, ask in ROWS.items():
        for bad in NO_ROWS:
            assert "amping" in error_text(ask, bad) or name == "lines"


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0, 1e300, "x", None, [], True])
def test_invalid_numbers_are_rejected(bad):
    assert "rendered stiffness" in error_text(kb_plane.plane, LoopSettings(), bad, 0.0)
    assert "rendered damping" in error_text(kb_plane.plane, LoopSettings(), 1.0, bad)
    assert "virtual damping" in error_text(kb_plane.limit, LoopSettings(), bad)
    for name in ("mass", "viscous", "damping", "rate", "delay", "quantum"):
        assert name in error_text(stiffness_limit, **{"mass": 0.05, "viscous": 0.5, name: bad})


def test_an_invalid_chunk_size_is_rejected():
    for chunk in ("x", 1.5, 0, True):
        assert "whole number" in error_text(sweep, sweep_tasks.roots, [1.0], chunk=chunk)


def test_the_longest_delay_is_2000_periods():
    assert stiffness_limit(0.05, 0.5, delay=2.0) > 0.0
    for late in ({"delay": 2.001}, {"delay": 0.01, "rate": 1e6}):
        assert "2,000 at most" in error_text(stiffness_limit, 0.05, 0.5, **late)
        assert "2,000 at most" in error_text(LoopSettings, **late)


def test_the_smallest_limit_is_1_mn_per_m():
    """Limits above it are found with any step of the search; lower limits are reported as 0."""
    for limit in (1.01e-3, 2e-3, 3.9e-3, 0.3, 5.0, 1e8):
        assert largest_stable(lambda k, limit=limit: k <= limit) == pytest.approx(limit, rel=1e-4)
    assert largest_stable(lambda k: k <= 0.99e-3) == 0.0
    assert largest_stable(lambda k: True) == math.inf


@pytest.mark.parametrize(
    ("bad", "says"),
    [
        ({"mass": 0.0}, "The mass must be between 10⁻¹³ and 10⁹ kg, not 0."),
        ({"quantum": "20 µm"}, "The sensor quantum must be a number in m, not '20 µm'."),
        ({"estimator": "guess"}, "The velocity estimator must be one of"),
        ({"hand": []}, "The hand takes a grip's name, not []."),
        (
            {"delay": 0.0101, "rate": 2e5},
            "A delay of 0.0101 s at 200,000 Hz is 2,020 periods; 2,000 at most:",
        ),
    ],
)
def test_impossible_loops_are_rejected(bad, says):
    assert error_text(LoopSettings, **bad).startswith(says)


def test_equal_settings_are_one_key_and_only_windows_are_nonlinear():
    first, second = (LoopSettings(estimator=("iir", {"cutoff": 20.0})) for _ in range(2))
    assert len({first: 0, second: 1}) == 1
    assert first.linear
    assert not LoopSettings(estimator="foaw").linear
