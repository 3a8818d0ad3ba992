"""Hard surface: the vibration follows its formula and starts once per entry; the wall never pulls."""

import math

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.dynamics.hand import SCRIPTS
from hapkit_studio.environments.base import Conditions
from hapkit_studio.haptics.board_plan import BoardPlanner, PlanRequest
from hapkit_studio.laws.machine import ARENA
from tests.environments import calling
from tests.environments.calling import along
from tests.wide import wide

COUNT = 20.7e-6
SURFACE = calling.LIBRARY["hard_surface"]
# theory §6, with the accelerations as forces on a handle of 0.044 kg
MATERIALS = {"rubber": (116.7, 60.0, 18.0), "wood": (150.0, 80.0, 100.0), "aluminium": (300.0, 90.0, 300.0)}


def entered(speed, rate=1000.0, seconds=0.25, **given):
    """Return a run that enters the wall at constant speed with an ideal sensor, and its first row inside."""
    motion = hs.Prescribed(lambda t: 0.003 + speed * t)
    device = hs.SimulatedHapkit(quantum=0.0, max_force=math.inf)
    run = hs.simulate("hard_surface", given, hand=motion, device=device, rate=rate, seconds=seconds)
    return run, int(np.flatnonzero(run.position > 0.005)[0])


def sounds(run, first, amplitude, decay, frequency, speed, stiffness=250.0):
    """Return the forces (n,) in N of wall and vibration by their formula, at the samples after the entry."""
    tau = run.time[first:] - run.time[first]
    ringing = amplitude * speed * np.exp(-decay * tau) * np.sin(2.0 * np.pi * frequency * tau)
    return -stiffness * (run.position[first:] - 0.005) - ringing


@pytest.mark.parametrize("speed", [0.1, 0.037])
def test_the_vibration_is_exact_at_the_sample_instants(speed):
    run, first = entered(speed, limit=3.0)
    assert not run.force[:first].any()
    assert run.force[first:] == pytest.approx(sounds(run, first, 15.0, 60.0, 50.0, speed), abs=1e-9)
    assert run.state[first, 0] == 0.0
    assert run.state[first, 1] == pytest.approx(speed, rel=1e-9)


@pytest.mark.parametrize("material", MATERIALS)
def test_materials_have_their_own_vibration_independent_of_the_custom_values(material):
    acceleration, decay, frequency = MATERIALS[material]
    amplitude = round(0.044 * acceleration, 1)
    given = {"material": material, "amplitude": 77.0, "decay": 7.0, "frequency": 77.0}
    run, first = entered(0.1, limit=3.0, rate=4000.0, **given)
    assert run.force[first:] == pytest.approx(sounds(run, first, amplitude, decay, frequency, 0.1), abs=1e-9)


@pytest.mark.parametrize(
    ("material", "t_peak", "peak"),
    [("rubber", 9.576e-3, 58.03), ("wood", 2.298e-3, 123.81), ("aluminium", 0.808e-3, 278.64)],
)
def test_the_peak_is_at_the_theoretical_time(material, t_peak, peak):
    """Theory §6 gives the time of the peak, and its height per speed of entry."""
    run, first = entered(0.1, rate=100_000.0, seconds=0.05, material=material, stiffness=0.0, limit=3.0)
    highest = np.argmin(run.force)
    assert run.time[highest] - run.time[first] == pytest.approx(t_peak, abs=1.1e-5)
    assert -run.force[highest] == pytest.approx(0.1 * 0.044 * peak, rel=0.01)


def test_the_amplitude_limit_applies_to_the_vibration_only():
    run, first = entered(0.5, seconds=0.06, amplitude=100.0, limit=0.8)
    ringing = run.force[first:] + 250.0 * (run.position[first:] - 0.005)
    assert ringing.min() == pytest.approx(-0.8, abs=1e-12)
    assert ringing.max() == pytest.approx(0.8, abs=1e-12)
    assert run.force.min() < -0.8 - 250.0 * 0.01
    plain = sounds(run, first, 100.0, 60.0, 50.0, 0.5, 0.0)
    assert ringing == pytest.approx(np.clip(plain, -0.8, 0.8), abs=1e-9)


def test_the_wall_part_never_pulls(rng):
    """Without the vibration, the force is at most 0 on any path, and −k d − b v on entry."""
    x, v = rng.uniform(-0.06, 0.06, 500), rng.uniform(-3.0, 3.0, 500)
    got, _ = along("hard_surface", x, v, amplitude=0.0, damping=30.0)
    assert (got <= 0.0).all()
    depth = np.maximum(x - 0.005, 0.0)
    inside = depth > 0.0
    assert got == pytest.approx(-250.0 * depth - 30.0 * np.maximum(v, 0.0) * inside, abs=1e-12)


@pytest.mark.parametrize(("counts", "again"), [(0.99, False), (1.01, True)])
def test_it_vibrates_again_only_after_leaving_by_two_counts(counts, again):
    """The second entry is 10 ms after the first, at four times its speed."""
    x = np.concatenate([np.full(10, 0.006), [0.005 - counts * 2.0 * COUNT], np.full(30, 0.006)])
    v = np.concatenate([np.full(10, 0.05), [0.0], np.full(30, 0.2)])
    got, states = along("hard_surface", x, v, limit=3.0)
    tau = 1e-3 * np.arange(30) if again else 1e-3 * np.arange(11, 41)
    speed = 0.2 if again else 0.05
    ringing = 15.0 * speed * np.exp(-60.0 * tau) * np.sin(2.0 * np.pi * 50.0 * tau)
    assert got[11:] == pytest.approx(-0.25 - ringing, abs=1e-9)
    assert states[-1, 1] == speed
    assert (states[10, 0] == -1.0) == again


def by_formula(run, rate, decay, hertz):
    """Return the force (n,) in N at every sample of a run; the vibration is computed from its formula."""
    out, since, speed = [], None, 0.0
    for x, v in zip(run.position - 0.005, run.velocity, strict=True):
        since = None if since is None or x <= -2.0 * COUNT else since + 1
        if since is None and x > 0.0:
            since, speed = 0, max(v, 0.0)
        tau = 0.0 if since is None else since / rate
        ringing = 15.0 * speed * math.exp(-decay * tau) * math.sin(2.0 * math.pi * hertz * tau)
        wall = 250.0 * x + 3.0 * max(v, 0.0) if x > 0.0 else 0.0
        out.append(-wall - min(max(ringing, -1.5), 1.5))
    return np.array(out)


@pytest.mark.parametrize("hand", SCRIPTS)
@pytest.mark.parametrize(
    ("rate", "decay", "hertz"),
    wide([(1000.0, 60.0, 50.0), (4000.0, 5.0, 400.0), (500.0, 300.0, 5.0)], lambda rate, *_: rate == 1000.0),
)
def test_the_recursion_feels_like_the_formula(hand, rate, decay, hertz):
    """The recursion agrees with the formula except for rounding: the forces differ by less than 10 nN."""
    device = hs.SimulatedHapkit(initial_velocity=0.3)
    given = {"damping": 3.0, "decay": decay, "frequency": hertz}
    run = hs.simulate("hard_surface", given, hand=hand, device=device, rate=rate, seconds=3.0)
    assert run.position.max() > 0.005
    assert run.force == pytest.approx(by_formula(run, rate, decay, hertz), abs=1e-8)


def test_the_recursion_halves_the_cycles_on_the_board():
    """A sine and an exponential in every tick would take 2,999 cycles."""
    program = BoardPlanner(ARENA).plan(PlanRequest(SURFACE, SURFACE.values())).program
    assert program.usual <= 2999 / 2


@pytest.mark.parametrize("delay", [0.0, 0.5e-3])
def test_a_tapping_hand_causes_one_vibration_per_tap(delay):
    """Four taps in 3 s have one entry each: bounces and sensor jitter cause no further vibration."""
    run = hs.simulate("hard_surface", hand="tap", delay=delay, seconds=3.0)
    assert np.count_nonzero(run.state[:, 0] == 0.0) == 4


def warned(period=1e-3, **given):
    return calling.warned("hard_surface", Conditions(1.0 / period), **given)


def test_warns_of_fewer_than_10_samples_per_cycle():
    """The limit is f > 1 / (10 T), which is 100 Hz at 1 kHz."""
    assert not warned()
    assert not warned(frequency=99.0)
    (line,) = warned(frequency=101.0)
    assert "101 Hz" in line
    assert "100 Hz" in line
    assert not warned(0.25e-3, frequency=396.0)
    assert warned(0.25e-3, material="aluminium") == []
    assert warned(material="rubber") == []
    assert warned(1.01e-3, material="wood")
    assert warned(0.99e-3, material="wood") == []
    (line,) = warned(material="aluminium", frequency=20.0)
    assert "300 Hz" in line
