"""The rendered impedance agrees with an independent implementation of the theory of the sampled loop."""

import json
import math

import numpy as np
import pytest
from scipy.signal import butter, freqz

from hapkit_studio import environments
from hapkit_studio.analysis.bode import AMPLITUDE, simulation
from hapkit_studio.analysis.bode.drive import Drive, staircase
from hapkit_studio.analysis.simulated_handle import simulated_handle
from hapkit_studio.dynamics.hand import Hand
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.headless import Scene, render
from tests.wide import wide

SPRING = environments.named("spring")
WALL = environments.named("wall")
SHARE, DEGREES, UP_TO = 0.01, 0.5, 0.4


def velocity(spec, rate, turn):
    """Return the transfer function (n,) of an estimator at angles per sample in rad (n,)."""
    name, options = spec
    back = rate * (1.0 - np.exp(-1j * turn))
    if name == "difference":
        return back
    if name == "iir":
        share = 1.0 - math.exp(-2.0 * math.pi * options["cutoff"] / rate)
        return back * freqz([share], [1.0, share - 1.0], turn)[1]
    if name == "butterworth":
        return back * freqz(*butter(2, options["cutoff"], fs=rate), turn)[1]
    # steady-state Kalman filter: iterate the covariance of (position, velocity) until it converges
    step, noise = 1.0 / rate, 20.7e-6**2 / 12.0
    move = np.array([[1.0, step], [0.0, 1.0]])
    drift = options["q"] * np.array([[step**3 / 3.0, step**2 / 2.0], [step**2 / 2.0, step]])
    spread = np.eye(2)
    for _ in range(20_000):
        ahead = move @ spread @ move.T + drift
        gain = ahead[:, :1] / (ahead[0, 0] + noise)
        spread = ahead - gain @ ahead[:1]
    keep = move - gain @ move[:1]
    z = np.exp(1j * turn)
    return np.array([np.linalg.solve(one * np.eye(2) - keep, one * gain)[1, 0] for one in z])


def impedance(stiffness, damping, rate, delay, spec, frequency):
    """Return the impedance in N/m (n,): K + B V(z), times the factors of the hold and of the delay."""
    turn = 2.0 * math.pi * frequency
    middle = np.sinc(frequency / rate) * np.exp(-0.5j * turn / rate)
    law = stiffness + (damping * velocity(spec, rate, turn / rate) if damping else 0.0)
    return law * middle * np.exp(-1j * turn * delay)


def off(measured, expected):
    """Return the largest relative error of the magnitude, and the largest error of the angle in degrees."""
    ratio = measured / expected
    return np.abs(np.abs(ratio) - 1.0).max(), np.degrees(np.abs(np.angle(ratio))).max()


def random_loop(seed):
    """Return (stiffness, damping, setting, estimator) of a random loop with an ideal sensor."""
    draw = np.random.default_rng(seed)
    rate = float(round(draw.uniform(500.0, 4000.0)))
    name = str(draw.choice(["difference", "iir", "butterworth", "kalman"]))
    given = {
        "iir": {"cutoff": draw.uniform(10.0, 200.0)},
        "butterworth": {"cutoff": draw.uniform(20.0, 200.0)},
        "kalman": {"q": 10.0 ** draw.uniform(-3.0, 0.0)},
    }
    options = given.get(name, {})
    setting = LoopSettings(
        mass=draw.uniform(0.02, 0.2), viscous=draw.uniform(0.1, 2.0), coulomb=0.0, quantum=0.0, rate=rate,
        delay=draw.uniform(0.0, 2.0) / rate, estimator=(name, options),
    )  # fmt: skip
    return draw.uniform(20.0, 2000.0), draw.uniform(0.0, 8.0), setting, (name, options)


def worst_of(seed):
    stiffness, damping, setting, spec = random_loop(seed)
    values = SPRING.values({"stiffness": stiffness, "damping": damping})
    (curve,) = simulation.measure(SPRING, values, [setting]).curves
    low = curve.measured.frequency <= UP_TO * 0.5 * setting.rate
    assert curve.clamped == 0.0
    assert curve.coherence[low].min() > 0.9999
    frequency = curve.measured.frequency[low]
    expected = impedance(stiffness, damping, setting.rate, setting.delay, spec, frequency)
    assert frequency[-1] > 0.75 * UP_TO * 0.5 * setting.rate
    off_theory = off(np.interp(frequency, curve.theory.frequency, curve.theory.impedance), expected)
    return np.max([off(curve.measured.impedance[low], expected), off_theory], axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", wide(range(4), lambda seed: seed in (0, 3)))
def test_random_loops_agree_with_theory(seed):
    share, degrees = worst_of(seed)
    assert share < SHARE
    assert degrees < DEGREES


@pytest.mark.slow
def test_fifty_random_loops_agree_with_theory():
    found = np.array([worst_of(seed) for seed in range(100, 150)])
    assert np.all(found < (SHARE, DEGREES)), found.max(axis=0)


def test_a_slightly_different_loop_is_distinguished_from_theory():
    setting = LoopSettings(quantum=0.0, delay=0.5e-3)
    (curve,) = simulation.measure(SPRING, SPRING.values({"stiffness": 300.0}), [setting]).curves
    at = curve.measured.impedance[curve.measured.frequency <= 200.0]
    tones = curve.measured.frequency[curve.measured.frequency <= 200.0]
    late = 1.2 * DEGREES / 360.0 / tones[-1]
    assert off(at, impedance(303.6, 0.0, 1000.0, 0.5e-3, None, tones))[0] > SHARE
    assert off(at, impedance(300.0, 0.0, 1000.0, 0.5e-3 + late, None, tones))[1] > DEGREES
    inside = off(at, impedance(302.4, 0.0, 1000.0, 0.5e-3 + 0.8 / 1.2 * late, None, tones))
    assert inside[0] < SHARE
    assert inside[1] < DEGREES
    assert curve.error[0] < SHARE
    assert curve.error[1] < DEGREES


def test_impedance_is_the_hands_force_minus_own_mass_and_damping():
    """A hand moves the handle while the loop renders a spring.

    Z is the hand's force divided by the motion, minus the force for the handle's own mass m and damping b.
    """
    stiffness, rate, delay, mass, viscous = 400.0, 2000.0, 0.7e-3, 0.05, 3.0
    tones = np.array([2.0, 5.0, 11.0, 23.0, 41.0])
    target = lambda t: 1e-3 * sum(np.sin(2 * math.pi * f * t + k) for k, f in enumerate(tones))  # noqa: E731
    hand = Hand(0.0, 4.0, 300.0, target, vectorised=True)
    setting = LoopSettings(rate, delay, mass=mass, viscous=viscous, coulomb=0.0, quantum=0.0)
    values = SPRING.values({"stiffness": stiffness})
    out, _ = render(Scene(SPRING, values, simulated_handle(setting), setting), hand, int(3 * rate))
    last = slice(int(2 * rate), None)
    phasor = np.exp(-2j * math.pi * np.outer(tones, np.arange(rate) / rate)) * 2.0 / rate
    moved, led = (phasor @ out[last, column] for column in (rows.TRUE_POSITION, rows.HAND_TARGET))
    turn = 2.0 * math.pi * tones
    led *= np.sinc(tones / rate) ** 2  # the hand's target is piecewise linear between samples
    pulled = (hand.stiffness + 1j * turn * hand.damping) * (led - moved)
    felt = pulled / moved - (1j * turn * viscous - mass * turn**2)
    (curve,) = simulation.measure(SPRING, values, [setting]).curves
    found = np.interp(tones, curve.theory.frequency, curve.theory.impedance)
    assert np.abs(felt / found - 1.0).max() < SHARE


def test_staircase_components_are_those_of_continuous_time():
    edges = np.array([0.0, 0.1, 0.35, 0.8, 1.0])
    values = np.array([1.0, -2.0, 0.5, 3.0])
    fine = (np.arange(400_000) + 0.5) / 400_000
    steps = values[np.searchsorted(edges, fine) - 1]
    for tone in (1.0, 3.0):
        expected = 2.0 * np.mean(steps * np.exp(-2j * math.pi * tone * fine))
        assert staircase(np.array([tone]), edges, values)[0] == pytest.approx(expected, abs=1e-5)


def test_tones_have_whole_cycles_and_the_crest_is_the_amplitude():
    for rate in (500.0, 1234.5, 4000.0):
        drive = Drive(0.01, 2e-3, rate)
        np.testing.assert_allclose(drive.tones * drive.period, np.rint(drive.tones * drive.period), atol=1e-9)
        times = np.arange(0.0, 4 * drive.slot, 0.2 / rate)
        away = np.abs(drive.position(times) - drive.place)
        looked_at = times % drive.slot > drive.settle
        assert 0.95 * 2e-3 < away[looked_at].max() <= 1.01 * 2e-3
        for motion in range(5):
            one = drive.begin(motion) + np.arange(drive.samples // 2) / rate
            around = motion * drive.slot + np.array([-1e-9, 1e-9])
            assert np.ptp(drive.position(around)) < 1e-8, "the handle does not jump"
            np.testing.assert_allclose(
                drive.position(one[:1]), drive.position(one[:1] + drive.period - 1e-12), atol=1e-8
            )


def where(softness):
    """Solve sin(2 y) / (2 y) = softness, with y = pi f T, by Newton's method; return the product f T."""
    y = 1.0
    for _ in range(50):
        y -= (math.sin(2 * y) / (2 * y) - softness) / (math.cos(2 * y) / y - math.sin(2 * y) / (2 * y * y))
    return y / math.pi


@pytest.mark.parametrize("rate", [1000.0, 4000.0])
def test_the_end_of_a_wall_is_the_3_db_frequency_of_its_stiffness(rate):
    """If a spring's force is held for a period T, the real part of its impedance is K sin(wT) / (wT)."""
    found = simulation.measure(
        WALL, WALL.values({"stiffness": 300.0}), [LoopSettings(quantum=0.0, rate=rate)]
    )
    (curve,) = found.curves
    assert curve.ends == curve.softens == pytest.approx(rate * where(math.sqrt(0.5)), rel=1e-3)
    assert math.isnan(curve.gives_energy)
    assert curve.outweighed == pytest.approx(math.sqrt(300.0 / 0.044) / (2.0 * math.pi), rel=2e-3)
    # the motion is centred 1.1 amplitudes behind the surface at 5 mm, so that it stays inside the wall
    assert found.place == pytest.approx(0.005 + 1.1 * found.amplitude)
    assert "drops to 71 %" in curve.sentence


@pytest.mark.parametrize(("times", "gives"), [(0.99, False), (1.01, True)])
def test_a_spring_beyond_2b_over_t_adds_energy_from_the_lowest_frequency_on(times, gives):
    """The damping of a held spring is -K T / 2 at low frequencies (Colgate and Schenkel 1997)."""
    viscous, rate = 0.5, 1000.0
    values = SPRING.values({"stiffness": times * 2.0 * viscous * rate})
    (curve,) = simulation.measure(SPRING, values, [LoopSettings(quantum=0.0, viscous=viscous)]).curves
    assert (curve.gives_energy == 1.0) is gives
    assert ("on, the loop adds energy" in curve.sentence) is gives


@pytest.mark.slow
def test_default_amplitude_is_reduced_if_the_motor_saturates():
    values, setting = WALL.values({"stiffness": 4000.0}), LoopSettings(quantum=0.0)
    found = simulation.measure(WALL, values, [setting])
    # (1.1 + 1) * 4000 N/m * 0.328 mm = 2.75 N is below 3 N; the next larger amplitude needs 3.44 N
    assert found.amplitude == pytest.approx(0.8**5 * AMPLITUDE.default)
    assert found.curves[0].clamped == 0.0
    (forced,) = simulation.measure(WALL, values, [setting], 1e-3).curves
    assert forced.clamped > 0.5
    assert forced.coherence.min() < 0.99


def test_coherence_is_low_and_theory_missing_for_a_nonlinear_force():
    setting = LoopSettings(quantum=0.0)
    (inside,) = simulation.measure(WALL, WALL.values(), [setting]).curves
    (across,) = simulation.measure(WALL, WALL.values(), [setting], place=0.005).curves
    assert inside.theory is not None
    assert inside.coherence.min() > 0.9999
    assert across.theory is None
    assert across.coherence.max() < 0.9
    # the handle is in the wall for half of the time, so the measured stiffness is half of the wall's
    assert across.stiffness == pytest.approx(0.5 * inside.stiffness, rel=0.01)


def test_results_are_plain_json_and_invalid_numbers_are_rejected():
    found = simulation.measure(environments.named("free"), {}, [LoopSettings()])
    assert "no force" in found.sentence
    json.loads(json.dumps(found.as_json(), allow_nan=False))
    with pytest.raises(ParameterError, match="Amplitude must be between"):
        simulation.measure(SPRING, SPRING.values(), [LoopSettings()], 1.0)
