import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import hapkit_studio as hs
from hapkit_studio.analysis.identify import Handle, Recording, Setup, from_run, identify
from hapkit_studio.haptics import rows
from tests.analysis.identify.motions import shaken

TRUTH = {"mass": 0.094, "viscous": 0.5, "coulomb": 0.10}


@pytest.mark.parametrize(
    ("quantum", "rate", "delay"),
    [(20.7e-6, 1000.0, 1e-3), (61e-6, 1000.0, 0.5e-3), (20.7e-6, 500.0, 1e-3), (20.7e-6, 4000.0, 0.4e-3)],
)
def test_a_shaken_handle_is_found_with_the_hands_mass(quantum, rate, delay):
    part = shaken(11, values={"stiffness": 150.0}, quantum=quantum, rate=rate, delay=delay).handle
    for key, truth in TRUTH.items():
        assert part[key].asked == pytest.approx(truth)
        assert abs(part[key].value - truth) < 2.0 * part[key].half
        assert part[key].half < 0.05 * truth
    assert not part.released


def test_a_handle_let_go_is_found_alone():
    device = hs.SimulatedHapkit(damping=0.3, coulomb_force=0.02, initial_position=0.015)
    run = hs.simulate("spring", {"stiffness": 150.0}, device=device, seconds=1.5, rate=2000.0)
    part = identify(from_run(run)).handle
    assert part.released
    for key, truth in {"mass": 0.044, "viscous": 0.3, "coulomb": 0.02}.items():
        assert part[key].holds(truth)
    assert part["mass"].half < 0.001


def test_let_go_in_the_middle_only_one_half_counts():
    device = hs.SimulatedHapkit(coulomb_force=0.01, damping=0.2)
    run = hs.simulate("spring", {"stiffness": 100.0}, hand="pluck", device=device, seconds=2.5, rate=2000.0)
    part = identify(from_run(run)).handle
    assert part.released
    assert abs(part["mass"].value - 0.044) < 2.0 * part["mass"].half
    assert part["mass"].half < 0.001


def recorded(time, position, commands, hand, quantum, delay):
    """Return the recording of data that nothing of the studio made."""
    measured = quantum * np.floor(position / quantum) if quantum else position
    rate = 1.0 / (time[1] - time[0])
    zeros = np.zeros(len(time))
    setup = Setup(rate=rate, delay=delay, quantum=quantum, handle=Handle(0.06, 0.8, 0.15))
    velocity = np.gradient(measured, time)
    return Recording(time, measured, velocity, commands, commands, zeros.astype(int), hand, zeros, setup)


def integrated(random, mass, viscous, coulomb, delay, count=700, period=2e-3):
    """Return (time, position, commands, hand's force) of a handle by solve_ivp, from step to step.

    Held random commands and a smooth force of a hand; friction changes sign where the speed does, and the
    forces are so large that it never sticks.
    """
    time = period * np.arange(count)
    commands = 0.8 * np.repeat(random.uniform(-1.0, 1.0, count // 25 + 1), 25)[:count]
    phases = random.uniform(0.0, 6.28, 2)

    def hand(t):
        slow = 1.8 * np.sin(2.0 * math.pi * 2.1 * t + phases[0])
        return slow + 1.5 * np.sin(2.0 * math.pi * 4.7 * t + phases[1])

    def turns(t, y):
        return y[1]

    turns.terminal = True
    state, positions = np.array([0.0, 0.02]), np.zeros(count)
    for k in range(count - 1):
        positions[k] = state[0]
        edges = [time[k], time[k] + delay, time[k + 1]] if delay else [time[k], time[k + 1]]
        for low, high in pairwise(edges):
            force = commands[k] if low > time[k] or not delay else commands[k - 1] if k else 0.0
            state = advanced(
                state, low, high, lambda t, f=force: f + hand(t), (mass, viscous, coulomb), turns
            )
    positions[-1] = state[0]
    return time, positions, commands, hand(time)


def advanced(state, low, high, push, constants, turns):
    mass, viscous, coulomb = constants
    while high - low > 1e-12:
        sign = math.copysign(1.0, state[1] if state[1] != 0.0 else push(low))

        def motion(t, y, sign=sign):
            return [y[1], (push(t) - viscous * y[1] - sign * coulomb) / mass]

        turns.direction = -sign
        done = solve_ivp(motion, (low, high), state, events=turns, rtol=1e-8, atol=1e-11)
        state, low = done.y[:, -1].copy(), done.t[-1]
        if done.status == 1:
            state[1] = 0.0
            low = min(low + 1e-9, high)
            state[1] = 1e-9 * (push(low) - math.copysign(coulomb, push(low))) / mass
    return state


@pytest.mark.parametrize(("quantum", "delay"), [(0.0, 0.0), (20.7e-6, 0.7e-3)])
def test_a_handle_integrated_by_scipy_is_found(quantum, delay):
    random = np.random.default_rng(21)
    data = integrated(random, 0.06, 0.8, 0.15, delay)
    part = identify(recorded(*data, quantum, delay)).handle
    for key, truth in {"mass": 0.06, "viscous": 0.8, "coulomb": 0.15}.items():
        assert part[key].value == pytest.approx(truth, rel=0.02)
        assert part[key].holds(truth)


def test_an_unknown_hand_is_said_and_a_released_one_can_be_told():
    device = hs.SimulatedHapkit(damping=0.3, coulomb_force=0.02, initial_position=0.015)
    run = hs.simulate("spring", {"stiffness": 150.0}, device=device, seconds=1.5, rate=2000.0)
    record = from_run(run)
    unknown = Recording(**{**vars(record), "hand_force": np.full(len(record), math.nan)})
    refused = identify(unknown).handle
    assert not refused.estimates
    assert "Let go" in refused.advice
    assert identify(unknown, released=True).handle["mass"].holds(0.044)


def test_stopped_samples_are_left_out_and_clamped_ones_are_not():
    run = hs.simulate("spring", {"stiffness": 1000.0}, hand="shake", seconds=4.0)
    found = identify(from_run(run))
    assert found.handle["mass"].holds(0.144)
    record = from_run(run)
    flags = record.flags.copy()
    flags[1000:] |= rows.STOPPED
    less = identify(Recording(**{**vars(record), "flags": flags})).handle
    assert less.left_out["stopped"] == 3000
    assert less.seconds < found.handle.seconds


def test_a_still_handle_tells_nothing():
    part = identify(from_run(hs.simulate("spring", hand="hold", seconds=1.0))).handle
    assert not part.estimates
    assert "Move farther and faster" in part.advice
