"""Theory curves agree with closed forms: peaks, jumps, waves, and the cost of a slow law."""

import math

import numpy as np
import pytest

from hapkit_studio.analysis import theory
from hapkit_studio.analysis.theory import TOLERANCE, over_position, over_velocity, sampled
from tests.environments.calling import LIBRARY

FAR = 0.06


def curve_of(key, low=-FAR, high=FAR, over=over_position, **given):
    return over(LIBRARY[key], LIBRARY[key].values(given), low, high)


@pytest.mark.parametrize("pitch", [0.02, 0.0173205, 0.03141])
@pytest.mark.parametrize("half_width", [0.003, 0.0011])
def test_a_detent_has_its_peak_force_at_both_edges(pitch, half_width):
    """The peak is k·w at every edge, 1.20 N at 400 N/m and 3 mm, independent of the samples' positions."""
    curve = curve_of("detents", pitch=pitch, half_width=half_width)
    for n in range(math.ceil(-FAR / pitch + 0.5), math.floor(FAR / pitch - 0.5) + 1):
        near = np.abs(curve.x - n * pitch) < 1.2 * half_width
        assert curve.force[0, near].max() == pytest.approx(400.0 * half_width, abs=1e-5)
        assert curve.force[0, near].min() == pytest.approx(-400.0 * half_width, abs=1e-5)


@pytest.mark.parametrize(("wavelength", "steps"), [(0.6e-3, 300), (0.6e-3, 1000), (0.5e-3, 400), (5e-3, 300)])
def test_a_grating_is_drawn_with_its_true_shape(wavelength, steps):
    whole = curve_of("texture", wavelength=wavelength, amplitude=0.3)
    curve = sampled(whole.force_at, -0.02, 0.02, steps)
    x = np.linspace(-0.02, 0.02, 9973)
    error = np.interp(x, curve.x, curve.force[0]) - 0.3 * np.sin(2.0 * np.pi * x / wavelength)
    assert np.sqrt(np.mean(error**2)) < 0.1 * 0.3
    waves = np.floor(curve.x / wavelength)
    for n in range(round(-0.02 / wavelength) + 1, round(0.02 / wavelength) - 1):
        force = curve.force[0, waves == n]
        assert force.max() == pytest.approx(0.3, abs=0.03)
        assert force.min() == pytest.approx(-0.3, abs=0.03)


@pytest.mark.parametrize("steps", [60, 120, 600])
@pytest.mark.parametrize("share", [1.0, 0.5, 1.0 / 3.0])
def test_waves_as_long_as_a_step_are_detected(steps, share):
    long = share * 0.06 / steps
    force = sampled(lambda x: np.sin(2.0 * np.pi * x / long)[np.newaxis], -0.03, 0.03, steps).force
    # waves shorter than a step are sampled at random, so their peaks may be missed
    least = 0.9 if share == 1.0 else 0.4
    assert force.max() > least
    assert force.min() < -least


@pytest.mark.parametrize("seed", range(20))
def test_piecewise_laws_are_sampled_at_their_jumps_and_bends(seed):
    """The laws have linear pieces with jumps and bends at random places, like students' laws."""
    random = np.random.default_rng(seed)
    edges = np.cumsum(random.uniform(0.5e-3, 8e-3, 14)) - 0.05
    slopes, starts = random.uniform(-900.0, 900.0, 15), random.uniform(-2.0, 2.0, 15)
    bends = random.random(15) < 0.5
    firsts = np.append(-FAR, edges)
    for i in range(1, 15):
        if bends[i]:
            starts[i] = starts[i - 1] + slopes[i - 1] * (edges[i - 1] - firsts[i - 1])

    def law(x):
        at = np.searchsorted(edges, x, side="right")
        return (starts[at] + slopes[at] * (x - firsts[at]))[np.newaxis]

    curve = sampled(law, -FAR, FAR, 1000)
    x = np.append(random.uniform(-FAR, FAR, 4000), np.repeat(edges, 2) + np.tile([-1e-8, 1e-8], len(edges)))
    assert np.abs(np.interp(x, curve.x, curve.force[0]) - law(x)[0]).max() <= TOLERANCE


def test_a_curve_ends_at_undefined_values():
    curve = sampled(lambda x: np.array([np.where(x < 0.0101, 100.0 * x, np.nan), 0.0 * x]), -FAR, FAR)
    there = curve.x[np.isfinite(curve.force[0])]
    assert there.max() == pytest.approx(0.0101, abs=1e-9)
    assert curve.force.shape == (2, len(curve.x))


def test_even_steps_are_even_and_samples_ascend():
    curve = curve_of("wall", position=0.00512)
    assert np.diff(curve.x).min() > 0.0
    assert curve.x[curve.even] == pytest.approx(np.linspace(-FAR, FAR, theory.WHOLE + 1), abs=0.0)


def test_friction_curve_has_static_and_kinetic_forces():
    curve = curve_of(
        "friction",
        -0.6,
        0.6,
        over_velocity,
        model="projection",
        static_force=0.7,
        kinetic_force=0.4,
        viscous=0.0,
    )
    assert curve.force.max() == pytest.approx(0.7, abs=1e-9)
    assert curve.force[0, np.abs(curve.x) > 0.01] == pytest.approx(
        -0.4 * np.sign(curve.x[np.abs(curve.x) > 0.01])
    )


@pytest.mark.parametrize(
    ("key", "given", "position", "velocity"),
    [
        ("wall", {}, True, False),
        ("damping", {}, False, True),
        ("free", {}, True, True),
        ("texture", {"kind": "bands"}, False, True),
        ("texture", {"wavelength": 0.6e-3}, True, False),
        # the force is 0 at every multiple of 5 mm
        ("detents", {"pitch": 0.005, "half_width": 0.0005}, True, False),
        ("puck", {}, False, False),
        ("friction", {}, True, True),
    ],
)
def test_a_law_has_curves_over_its_variables(key, given, position, velocity):
    assert (curve_of(key, **given) is not None) == position
    assert (curve_of(key, -0.6, 0.6, over_velocity, **given) is not None) == velocity


def counted(law):
    calls = []

    def force_at(x):
        calls.append(len(x))
        return law(x)

    return force_at, calls


@pytest.mark.parametrize("long", [1e-6, 0.1e-3, 1e-3, 1.0])
def test_samples_per_step_are_limited(long):
    """At any wavelength, at most 4.33 samples per step are taken, in few calls."""
    force_at, calls = counted(lambda x: np.sin(2.0 * np.pi * x / long)[np.newaxis])
    sampled(force_at, -FAR, FAR, 1000)
    assert sum(calls) <= 1000 * (4 + 0.33)
    assert len(calls) <= 14


@pytest.mark.parametrize(("milliseconds", "most"), [(10.0, 70), (1.0, 320), (0.001, 5000)])
def test_a_slow_law_gets_fewer_samples(monkeypatch, milliseconds, most):
    """Sampling stops at the end of the pass in which its processor time exceeds 50 ms."""
    force_at, calls = counted(lambda x: -300.0 * np.maximum(x, 0.0)[np.newaxis])
    monkeypatch.setattr(theory.time, "thread_time", lambda: 1e-3 * milliseconds * sum(calls))
    curve = sampled(force_at, -FAR, FAR, 1000)
    assert sum(calls) <= most
    assert len(curve.x) >= 60
    assert curve.even.sum() >= 60
