"""Noise beyond quantisation widens the intervals; without such noise, the intervals stay the same."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from hapkit_studio.analysis.identify import identify
from hapkit_studio.analysis.identify.windows import lay, noise_ratio
from hapkit_studio.haptics.rows import CLAMPED
from tests.analysis.identify import noisy_loop
from tests.analysis.identify.noisy_loop import GRIP, HANDLE, QUANTUM, RATE

THERE = np.ones(2000, bool)
TIME = np.arange(2000) / RATE


def counted(position, noise=0.0, seed=0):
    """Return a sensor's readings in m (n,) of positions in m (n,), with noise in counts."""
    random = np.random.default_rng(seed)
    return QUANTUM * np.floor(position / QUANTUM + random.normal(0.0, 1.0, len(position)) * noise)


@pytest.mark.parametrize("counts", [0.0, 0.01, 0.2, 0.49, 0.5, 0.51, 1.0, 3.7])
def test_a_constant_speed_is_not_noise(counts):
    position = (counts * np.arange(2000) + 0.3) * QUANTUM
    assert noise_ratio(counted(position), THERE, QUANTUM) == 0.0


@pytest.mark.parametrize("hertz", [0.3, 1.0, 5.0, 19.7])
def test_a_sine_is_not_noise(hertz):
    assert noise_ratio(counted(0.01 * np.sin(2.0 * np.pi * hertz * TIME)), THERE, QUANTUM) == 0.0


@pytest.mark.parametrize("noise", [0.3, 0.7, 1.5])
def test_the_noise_variance_is_estimated_correctly(noise):
    found = np.mean(
        [noise_ratio(counted(0.01 * np.sin(6.0 * TIME), noise, seed), THERE, QUANTUM) for seed in range(10)]
    )
    assert found == pytest.approx(12.0 * noise**2, rel=0.1)


def test_lost_samples_are_not_noise():
    there = np.random.default_rng(1).random(2000) > 0.2
    moved = 0.01 * np.sin(2.0 * np.pi * 5.0 * TIME)
    jumps = np.where(there, counted(moved), 0.0)
    assert noise_ratio(jumps, there, QUANTUM) == 0.0


def noisy(recording, noise, seed):
    """Return a recording with added noise in whole counts, to which the loop did not react."""
    errors = np.round(np.random.default_rng(seed).normal(0.0, noise, len(recording)))
    return replace(recording, position=recording.position + QUANTUM * errors)


def test_a_recording_without_noise_keeps_its_intervals():
    for held in (False, True):
        (recording,), _ = noisy_loop.recordings([3], 0.0, held=held, seconds=0.3)
        assert lay(recording).step == QUANTUM
        assert lay(noisy(recording, 0.3, 0)).step > 1.2 * QUANTUM


def test_interval_of_a_released_spring_covers_the_effect_of_noise():
    """Neighbouring windows share the noise of their samples, which widens the interval."""
    (recording,), _ = noisy_loop.recordings([5], 0.0, held=False, seconds=0.6)
    truth = identify(recording, released=True).rendered["stiffness"].value
    found = [identify(noisy(recording, 1.5, seed), released=True).rendered["stiffness"] for seed in range(16)]
    assert sum(e.holds(truth) for e in found) >= 15
    spread = np.std([e.value for e in found])
    assert 1.5 * spread < np.median([e.half for e in found]) < 4.0 * spread


def test_noise_is_reported_only_if_present():
    (recording,), _ = noisy_loop.recordings([3], 0.0, held=True, seconds=1.0)
    quiet, loud = identify(recording), identify(noisy(recording, 0.7, 1))
    assert quiet.noise == 0.0
    assert not any("noise" in line for line in quiet.sentences(quiet.rendered))
    of_rounding = 1.0 / 12.0
    assert loud.noise == pytest.approx(math.sqrt(0.7**2 + of_rounding) * QUANTUM, rel=0.1)
    assert loud.as_json()["position_noise_m"] == loud.noise
    wanted = f"The positions have noise of {loud.noise / QUANTUM:.2g} counts"
    assert loud.sentences(loud.rendered)[-1].startswith(wanted)
    assert loud.notes(loud.rendered)[-1].startswith(wanted)


def test_samples_at_the_force_limit_are_marked_by_the_reference_loop():
    (recording,), _ = noisy_loop.recordings([0], 0.0, held=False, stiffness=600.0, seconds=0.1)
    assert (recording.flags[np.abs(recording.applied_force) >= 3.0] == CLAMPED).all()
    assert (recording.flags == CLAMPED).any()


TRUTHS = {"mass": HANDLE.mass, "viscous": HANDLE.viscous, "coulomb": HANDLE.coulomb}


def coverage(recordings, expected, held):
    """Return the fraction of intervals that contain the truth, by quantity.

    ``expected`` has the true values of each recording.
    """
    inside: dict[str, list[bool]] = {}
    for recording, of_law in zip(recordings, expected, strict=True):
        found = identify(recording, released=not held)
        truths = TRUTHS | of_law | ({"mass": HANDLE.mass + GRIP.mass} if held else {})
        for e in (*found.rendered.estimates, *found.handle.estimates):
            if e.key in truths:
                inside.setdefault(e.key, []).append(e.holds(truths[e.key]))
    return {key: float(np.mean(holds)) for key, holds in inside.items()}


SECONDS = {True: 2.0, False: 1.2}


@cache
def quiet_recordings(held):
    """Return 200 recordings without noise, and the values that their law should render."""
    found, _ = noisy_loop.recordings(range(200), 0.0, held=held, seconds=SECONDS[held])
    parts = [identify(one, released=not held).rendered for one in found]
    return found, [{e.key: e.expected for e in part.estimates if e.key != "centre"} for part in parts]


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 0.3, 0.7, 1.5])
@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("seen", [False, True])
def test_95_percent_of_the_intervals_contain_the_truth(held, noise, seen):
    """If ``seen``, the loop renders the noise too; otherwise only the recording contains it."""
    quiet, of_law = quiet_recordings(held)
    if seen:
        found, _ = noisy_loop.recordings(range(200), noise, held=held, seconds=SECONDS[held])
    else:
        found = [noisy(one, noise, 1000 + seed) for seed, one in enumerate(quiet)]
    shares = coverage(found, of_law, held)
    print(f"held {held}, {noise} counts, seen {seen}: {shares}")
    assert min(shares.values()) >= 0.93
    assert set(shares) == {"stiffness", "damping", *TRUTHS}
