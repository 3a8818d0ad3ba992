"""The damping of nonlinear laws agrees with the work per cycle in an independent simulation."""

import math

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.analysis.bode import simulation
from hapkit_studio.cli import main
from hapkit_studio.dynamics.loop_settings import LoopSettings

WALL = environments.named("wall")
MODES = ("into", "both", "none")


def reference(tone, place, amplitude, stiffness, damping, mode, rate, delay):
    """Return the damping in N·s/m of a sampled wall at 5 mm, from the work of 1 s of a sine inside it.

    The result is exact: each force acts for one period, which starts one delay after the sample.
    """
    position = lambda t: place + amplitude * np.sin(2.0 * math.pi * tone * t + 0.3)  # noqa: E731
    instants = np.arange(-2, round(rate) + 1) / rate
    depth = position(instants) - 0.005
    closing = np.diff(depth) * rate
    drag = {"into": np.maximum(closing, 0.0), "both": closing, "none": np.zeros_like(closing)}[mode]
    force = -(stiffness * depth[1:] + damping * drag)[:-1]
    ends = position(instants[1:] + delay)
    work = (force * np.diff(ends))[-round(rate) :].sum() / tone
    return -work / (math.pi * amplitude**2 * 2.0 * math.pi * tone)


def drawn_setting(seed):
    """Return (stiffness, damping, mode, rate, delay) of a random wall."""
    draw = np.random.default_rng(seed)
    rate = float(round(draw.uniform(500.0, 4000.0)))
    delay = draw.uniform(0.0, 2.0) / rate
    return draw.uniform(20.0, 1500.0), draw.uniform(0.2, 6.0), MODES[seed % 3], rate, delay


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", [*range(3), *(pytest.param(n, marks=pytest.mark.slow) for n in range(3, 42))]
)
def test_damping_has_the_sign_and_size_of_the_work_per_cycle(seed):
    stiffness, damping, mode, rate, delay = drawn_setting(seed)
    values = WALL.values({"stiffness": stiffness, "damping": damping, "damping_mode": mode})
    found = simulation.measure(
        WALL, values, [LoopSettings(quantum=0.0, rate=rate, delay=delay)], max_force=math.inf
    )
    (curve,) = found.curves
    assert (curve.theory is None) == (mode == "into")
    assert curve.clamped == 0.0
    scale = damping + stiffness * (0.5 / rate + delay)
    for k in np.flatnonzero(curve.measured.frequency <= 0.2 * rate)[::3]:
        tone = curve.measured.frequency[k]
        want = reference(tone, found.place, found.amplitude, stiffness, damping, mode, rate, delay)
        got = curve.measured.damping[k]
        assert got == pytest.approx(want, rel=0.05, abs=0.01 * scale), (tone, mode)
        if abs(want) > 0.05 * scale:
            assert np.sign(got) == np.sign(want)


def test_one_way_damping_is_half_of_the_damping_minus_the_holds_energy():
    """The damping at low frequencies is B/2 − K T/2: 0.875 N·s/m for 2 N·s/m and 250 N/m at 1 kHz."""
    values = WALL.values({"damping": 2.0})
    (ideal,) = simulation.measure(WALL, values, [LoopSettings(quantum=0.0)]).curves
    assert ideal.measured.damping[0] == pytest.approx(0.875, rel=1e-3)
    assert math.isnan(ideal.gives_energy) or ideal.gives_energy > 300.0
    assert ideal.negative > 100.0
    (real,) = simulation.measure(WALL, values, [LoopSettings()]).curves
    away = np.abs(real.measured.damping - ideal.measured.damping)
    inside = away <= real.damping_interval + 0.01
    assert inside.mean() > 0.8  # fewer than 95 %, because quantisation biases the lowest tones slightly
    assert np.all(real.damping_interval > 0.0)


@pytest.mark.slow
def test_the_interval_of_a_stiff_wall_covers_its_error_from_sensor_steps():
    values = WALL.values({"stiffness": 5000.0})
    (curve,) = simulation.measure(WALL, values, [LoopSettings()]).curves
    exact = np.interp(curve.measured.frequency, curve.theory.frequency, curve.theory.impedance)
    assert np.mean(np.abs(curve.measured.impedance.real - exact.real) <= curve.interval.real) > 0.8
    share, degrees = curve.error
    assert share < 0.01
    assert degrees < 0.6


def test_command_states_intervals_and_dissipation(capsys):
    assert main(["bode", "wall", "-p", "damping=2", "--quantum", "0"]) == 0
    out = capsys.readouterr().out
    assert "by single sines" in out
    assert "± 95 %" in out
    assert "on, the loop adds energy" not in out
