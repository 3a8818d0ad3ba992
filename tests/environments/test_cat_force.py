"""What a hand feels of the cat: fur, purr and paw, and a handle that is let go."""

import math

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.environments import cat
from tests.environments.cat_runs import RESTED, column, contented, moved


@pytest.mark.parametrize("frequency", [20.0, 26.3, 30.0])
def test_purr_is_higher_and_louder_breathing_out(frequency):
    run = moved(contented, RESTED + 4.0, purr_frequency=frequency, purr_force=1.0, hair=0.0)
    rest = slice(round(RESTED * 1000), None)
    out = column(run, "breath")[rest] < math.pi
    c = column(run, "contentment")[rest]
    hum = (run.force[rest] - -0.35) / c
    for breathing, pitch, strength in ((out, frequency + 1.2, 1.2), (~out, frequency - 1.2, 0.8)):
        first = np.flatnonzero(np.diff(breathing.astype(int)) > 0)[0] + 1
        part = hum[first : first + 1200]
        assert breathing[first : first + 1200].all()
        rising = np.flatnonzero((part[:-1] < 0.0) & (part[1:] >= 0.0))
        exact = rising - part[rising] / (part[rising + 1] - part[rising])
        assert 1000.0 / np.diff(exact).mean() == pytest.approx(pitch, rel=2e-3)
        assert np.abs(part).max() == pytest.approx(strength, rel=0.02)


def test_purr_has_one_line_in_each_half_of_the_breath():
    """By the spectrum of 4 s: 25.1 and 27.5 Hz stand out, nothing between 40 Hz and the Nyquist rate."""
    run = moved(contented, RESTED + 4.0, hair=0.0)
    hum = run.force[-4000:] / column(run, "contentment")[-4000:]
    lines = np.abs(np.fft.rfft((hum - hum.mean()) * np.hanning(4000)))
    frequency = np.fft.rfftfreq(4000, 1e-3)
    near = (frequency > 24.0) & (frequency < 28.6)
    assert lines[near].max() == lines[frequency > 2.0].max()
    assert lines[frequency > 40.0].max() < 0.02 * lines.max()
    both = np.array([lines[np.abs(frequency - f) < 0.3].max() for f in (25.1, 27.5)])
    assert both.min() > 0.3 * lines[near].max()


@pytest.mark.parametrize(("ratio", "friction"), [(1.0, 0.35), (1.8, 0.35), (3.0, 1.5)])
def test_the_nap_is_felt(ratio, friction):
    """Without tufts and damping the fur slips at its friction with the nap, at ratio times it against it."""
    run = moved(
        lambda t: 0.025 * np.sin(2.0 * np.pi * 0.2 * t), 5.0,
        fur_friction=friction, nap_ratio=ratio, hair=0.0, fur_damping=0.0, purr_force=0.0,
    )  # fmt: skip
    assert np.median(run.force[200:1200]) == pytest.approx(-friction, rel=1e-9)
    assert np.median(run.force[2000:3500]) == pytest.approx(ratio * friction, rel=1e-9)
    assert run.force.min() >= -friction * (1.0 + 1e-12)
    assert run.force.max() <= ratio * friction * (1.0 + 1e-12)


def test_theory_is_a_slow_stroke():
    """Both branches, once the hair is bent; the tufts ripple around them."""
    for branch, sign in ((0, 1.0), (1, -1.0)):
        run = moved(
            lambda t, sign=sign: sign * (-0.02 + 0.005 * t),
            6.0,
            fur_damping=0.0,
            purr_force=0.0,
            nap_ratio=2.5,
        )
        ripple = 0.06 * np.sin(2.0 * np.pi * run.position / 0.003)
        theory = cat.over_position(cat.ENVIRONMENT.values({"nap_ratio": 2.5}), run.position)
        assert theory.shape == (2, run.position.size)
        assert run.force[2000:] - ripple[2000:] == pytest.approx(theory[branch, 2000:], abs=1e-9)
        assert theory[branch, 0] == (-0.35, 0.875)[branch]


def test_tufts_are_3_mm_apart_and_six_hundredths_of_a_newton():
    run = moved(lambda t: 0.005 * t, 6.0, fur_friction=0.0, fur_damping=0.0, purr_force=0.0)
    assert run.force == pytest.approx(0.06 * np.sin(2.0 * np.pi * run.position / 0.003), abs=1e-12)


def test_the_swat_is_one_push_back_the_way_the_hand_came():
    """As the difference from the same hand on a cat that cannot be provoked: 0.3 s, at most 1.5 N."""
    for sign in (1.0, -1.0):  # too fast with the nap, fast against it
        run = moved(lambda t, s=sign: s * np.minimum(0.26 * t, 0.2), 1.5, purr_force=0.0, hair=0.0)
        fur = np.clip(run.force + 1.5 * run.velocity, -0.35, 0.63)
        push = run.force + 1.5 * run.velocity - fur
        swat = column(run, "swat")
        assert (swat > 0.0).sum() == pytest.approx(300, abs=1)
        assert np.abs(push[swat == 0.0]).max() < 1e-9
        assert 1.4 < np.abs(push).max() <= 1.5 + 1e-9
        assert np.all(sign * push[swat > 0.0] <= 1e-9)


@pytest.mark.parametrize("rate", [500.0, 1000.0, 4000.0])
@pytest.mark.parametrize("delay", [0.0, 0.5e-3])
def test_a_released_handle_comes_to_rest_in_the_fur(rate, delay):
    """From anywhere, thrown as well, with a cat that has no reason to purr; no fur keeps it going."""
    for x, v in ((0.006, 0.0), (-0.02, 0.05), (0.0, 0.3), (0.01, -0.3)):
        for damping in (0.0, 1.5):
            device = hs.SimulatedHapkit(initial_position=x, initial_velocity=v)
            run = hs.simulate(
                "cat", {"fur_damping": damping}, device=device, rate=rate, delay=delay, seconds=2.0
            )
            assert np.ptp(run.true_position[-int(rate / 2) :]) < 20.7e-6


def test_the_fur_alone_only_takes():
    """Energy given by the device never exceeds what the bent hair and the tufts hold."""
    run = hs.simulate("cat", {"purr_force": 0.0}, hand="pet", seconds=10.0)
    stored = (0.35 * 1.8) ** 2 / (2.0 * cat.FUR_STIFFNESS) + 0.06 * 0.003 / math.pi
    assert run.energy.max() <= stored
    assert run.energy[-1] < -0.1
