"""Oscillations are detected in synthetic signals and in a sampled spring, but not in other motions."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

import hapkit_studio as hs
from hapkit_studio.analysis.oscillation import sustained

QUANTUM = 20.7e-6


def seconds(rate=1000.0, length=1.0):
    return 7.3 + np.arange(round(rate * length)) / rate


def counted(position):
    return QUANTUM * np.floor(position / QUANTUM)


@pytest.mark.parametrize("rate", [500.0, 1000.0, 4000.0])
@pytest.mark.parametrize("amplitude", [0.1e-3, 1.2e-3, 20e-3])
@pytest.mark.parametrize("hertz", [5.7, 12.3, 31.0, 97.0])
def test_a_sine_in_counts_is_measured(hertz, amplitude, rate):
    t = seconds(rate)
    found = sustained(t, counted(0.005 + amplitude * np.sin(math.tau * hertz * t + 0.7)))
    assert found.frequency == pytest.approx(hertz, rel=0.02)
    assert found.amplitude == pytest.approx(amplitude, abs=max(0.05 * amplitude, QUANTUM))


def test_sensor_jitter_has_no_cycles(rng):
    t = seconds(4000.0)
    wave = 0.3e-3 * np.sin(math.tau * 6.0 * t) + 2.0 * QUANTUM * rng.uniform(-1.0, 1.0, t.size)
    assert sustained(t, counted(wave)).frequency == pytest.approx(6.0, rel=0.02)


def sampled_spring(stiffness, mass, viscous, period, start, count):
    """Return the positions of a mass on a sampled and held spring, and its frequency in Hz."""
    motion = expm(period * np.array([[0, 1, 0], [0, -viscous / mass, -stiffness / mass], [0, 0, 0]]))
    step = motion[:2, :2] + np.outer(motion[:2, 2], (1.0, 0.0))
    x = [np.array([start, 0.0])]
    for _ in range(count - 1):
        x.append(step @ x[-1])
    return np.array(x)[:, 0], abs(np.angle(np.linalg.eigvals(step)[0])) / (math.tau * period)


@pytest.mark.parametrize(("mass", "viscous"), [(0.044, 0.5), (0.1, 0.9)])
def test_a_spring_at_its_limit_oscillates_at_the_theoretical_frequency(mass, viscous):
    stiffness = hs.stiffness_limit(mass, viscous)
    device = hs.SimulatedHapkit(mass, viscous, 0.0, 0.0, math.inf, initial_position=2e-3)
    values = {"stiffness": stiffness, "damping": 0.0}
    run = hs.simulate("spring", values, hand="released", device=device, seconds=1.0)
    theory, hertz = sampled_spring(stiffness, mass, viscous, 1e-3, 2e-3, 1000)
    found = sustained(run.time, run.position)
    assert found.frequency == pytest.approx(hertz, rel=0.02)
    assert found.amplitude == pytest.approx(np.ptp(theory) / 2.0, rel=0.05)


@pytest.mark.parametrize(("kept", "lasts"), [(0.808, True), (0.792, False)])
def test_an_oscillation_is_sustained_above_80_percent(kept, lasts):
    """The first and last quarters are 15 cycles of 20 Hz apart, so they differ only by the decay."""
    since = seconds(4000.0) - 7.3
    wave = 5e-3 * kept ** (since / 0.75) * np.sin(math.tau * 20.0 * since)
    assert (sustained(since, wave) is not None) == lasts


@pytest.mark.parametrize("half_life", [0.1, 0.5, 2.0])
@pytest.mark.parametrize("release", [0.02, 0.2, 0.4, 0.6, 0.8])
def test_a_handle_that_rings_after_a_release_does_not_oscillate(release, half_life):
    since = seconds() - 7.3 - release
    ringing = 8e-3 * 0.5 ** (since / half_life) * np.cos(math.tau * 30.0 * since)
    assert sustained(since, np.where(since < 0.0, 8e-3, ringing)) is None


def test_without_a_spectral_peak_there_is_no_frequency():
    """The frequency rises from 8 to 40 Hz within the second, so the spectrum has no peak."""
    t = seconds()
    since = t - t[0]
    found = sustained(t, 2e-3 * np.sin(math.tau * (8.0 * since + 16.0 * since**2) - 0.7))
    assert found.amplitude == pytest.approx(2e-3, rel=0.05)
    assert math.isnan(found.frequency)


def test_decaying_or_slow_motion_is_not_an_oscillation():
    t = seconds()
    swing = 2e-3 * np.sin(math.tau * 20.0 * t)
    since = t - t[0]
    for none in (
        swing * np.exp(-since),  # the amplitude is halved in 0.7 s
        np.where(since < 0.8, swing, 0.0),
        np.full(t.size, 0.003),
        counted(0.5 * QUANTUM * np.sin(math.tau * 20.0 * t)),
        0.03 * np.sin(math.tau * 2.0 * t),  # this is the motion of a hand that strokes
        # this is the motion of a hand that crosses ridges
        0.05 * since + 0.2e-3 * np.sin(math.tau * 20.0 * t),
        swing * (since > 0.95),
        np.empty(0),
    ):
        assert sustained(t[: none.size], none) is None
    assert sustained(t, swing * np.exp(since)).amplitude == pytest.approx(2e-3 * math.e, rel=0.05)
