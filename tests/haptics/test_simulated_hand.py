"""The hand on the live simulated device first approaches the pointer slowly, then follows it.

Further tests: strokes on the cat, and the handle after its release.
"""

import math
from dataclasses import astuple
from itertools import pairwise

import numpy as np
import pytest
from numba import njit

from hapkit_studio import environments
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import grip_named
from hapkit_studio.haptics import clock, headless, rows, simulated_loop
from hapkit_studio.haptics.rows import new_ring
from hapkit_studio.haptics.tick import adopt
from hapkit_studio.lessons import library
from hapkit_studio.lessons.evaluate import evaluate
from hapkit_studio.lessons.play import settings_in
from hapkit_studio.lessons.samples import Samples

FRAME = 16  # time in ms between updates of the pointer in a window


@njit
def play(r, body, out, pointers, releases):
    """Render a sample per pointer position (n,) in m (NaN: no hand), like a live loop without waits."""
    for k in range(len(pointers)):
        r.settings.hand_on = 0 if math.isnan(pointers[k]) else 1
        r.settings.hand_target = pointers[k]
        r.settings.releases = releases[k]
        simulated_loop.render_sample(r, body, out, clock.now(), 0.0)


def live(key, pointers, values=None, grip="medium", releases=None, **device):
    """Return the rows of a live simulated Hapkit whose pointer (n,) in m is updated once per frame."""
    environment, device = environments.named(key), SimulatedHapkit(**device)
    r, body = headless.Scene(environment, environment.values(values or {}), device).prepare()
    pointers = np.asarray(pointers)[np.arange(len(pointers)) // FRAME * FRAME]
    out = new_ring(r.control, 1 << len(pointers).bit_length())
    releases = np.zeros(len(pointers), np.int64) if releases is None else releases
    adopt(r, simulated_loop.measure(body))
    r.settings.hand = astuple(grip_named(grip))
    simulated_loop.follow_settings(body, r)
    play(r, body, out, pointers, releases)
    return out.rows[: len(pointers)]


def dragged(*points, speed):
    """Return the pointer's position in every ms on its way between points in m, at a speed in m/s."""
    parts = [np.linspace(a, b, max(round(1e3 * abs(b - a) / speed), 1), False) for a, b in pairwise(points)]
    return np.concatenate([*parts, [points[-1]]])


def held(place, seconds):
    return np.full(round(1e3 * seconds), place)


@pytest.mark.slow
@pytest.mark.parametrize("place", [-0.05, -0.02, 0.004, 0.05])
@pytest.mark.parametrize("grip", ["light", "medium", "firm"])
def test_a_hand_that_takes_the_handle_far_away_approaches_at_10_cm_per_second(place, grip):
    """The handle exceeds the hand's speed by less than half, because the grip's damping ratio is 0.5."""
    out = live("free", held(place, 1.2), grip=grip)
    speed, there = np.abs(np.diff(out[1:, rows.HAND_TARGET])) * 1e3, np.abs(out[1:, rows.HAND_TARGET])
    assert speed.max() == pytest.approx(0.10, rel=1e-6)
    arrived = np.argmax(there > 0.95 * abs(place)) / 1e3
    assert arrived == pytest.approx(abs(place) / 0.10, abs=0.03)
    assert np.abs(out[:, rows.TRUE_VELOCITY]).max() < 0.15
    assert out[-1, rows.TRUE_POSITION] == pytest.approx(place, abs=1.5e-3)


def test_a_hand_that_has_arrived_leads_at_the_pointers_speed_up_to_that_of_a_reach():
    pointer = np.concatenate(
        [held(0.0, 0.2), held(0.05, 0.4), dragged(0.05, -0.05, speed=0.4), held(-0.05, 0.1)]
    )
    target = live("free", pointer)[1:, rows.HAND_TARGET]
    speed = np.abs(np.diff(target)) * 1e3
    assert speed[:350].max() == pytest.approx(1.0, rel=1e-6)
    assert np.abs(target[300:] - pointer[300 : len(target)]).max() < 0.4 * (FRAME + 12.0 + 4.0) * 1e-3
    again = np.concatenate([pointer, held(np.nan, 0.05), held(0.05, 0.3)])
    speed = np.abs(np.diff(live("free", again)[len(pointer) + 60 :, rows.HAND_TARGET])) * 1e3
    assert np.nanmax(speed) == pytest.approx(0.10, rel=1e-6)


@pytest.mark.parametrize("key", sorted(environments.discover()))
def test_an_approaching_hand_causes_no_more_force_than_a_slow_one(key):
    """The limit is 1.5 times the force at a fifth of the speed, plus the law's damping times 0.15 m/s."""
    environment = environments.named(key)
    damping = environment.impedance(environment.values())[1] if environment.impedance else 0.0
    quick = live(key, held(-0.03, 2.5))[:, rows.FORCE]
    slow = live(key, dragged(0.0, -0.03, speed=0.02))[:, rows.FORCE]
    assert np.abs(quick).max() <= 1.5 * np.abs(slow).max() + 0.15 * damping + 0.1


def strokes(speed, count, back):
    """Return the pointer's positions (n,) in m while a person strokes 60 mm of fur, starting at the head."""
    there = dragged(-0.03, 0.03, speed=speed)
    if back == "dragged":
        return np.concatenate([held(-0.03, 0.5), *[there, there[::-1]] * count])
    return np.concatenate([held(-0.03, 1.0), there, held(np.nan, 0.3)] * count)


@pytest.mark.parametrize("back", ["let go", "dragged"])
@pytest.mark.parametrize(("speed", "purrs"), [(0.01, True), (0.05, True), (0.10, True), (0.30, False)])
def test_the_cat_purrs_within_six_strokes_at_1_to_10_cm_per_second(speed, purrs, back):
    """If ``back`` is "let go", the hand releases the handle at the tail and takes it again at the head.

    If it is "dragged", the hand leads the handle back at the speed of the stroke.
    """
    out = live("cat", strokes(speed, 6, back))
    names = environments.named("cat").state_names
    contentment, swats = (out[:, rows.STATE + names.index(name)] for name in ("contentment", "swats"))
    assert (contentment.max() > 0.3) == purrs
    assert bool(swats[-1]) != purrs


def test_a_handle_released_at_rest_starts_at_its_position():
    """The handle is led at 0.2 m/s against a spring of 100 N/m.

    After the release, the handle of 44 g starts at this speed, or at zero speed if it was released at rest.
    """
    pointer = np.concatenate([held(0.0, 0.1), dragged(0.0, 0.03, speed=0.2), held(np.nan, 0.3)])
    off = np.flatnonzero(np.isnan(pointer[np.arange(len(pointer)) // FRAME * FRAME]))[0]
    quiet = {"damping": 0.0, "coulomb_force": 0.0, "quantum": 0.0}
    values = {"stiffness": 100.0, "damping": 0.0}
    for let_go in (False, True):
        releases = (let_go & (np.arange(len(pointer)) >= off)).astype(np.int64)
        out = live("spring", pointer, values, releases=releases, **quiet)
        x, v = out[off + 1 :, rows.TRUE_POSITION], out[off + 1 :, rows.TRUE_VELOCITY]
        swing = math.hypot(x[0], v[0] / math.sqrt(100.0 / 0.044))
        assert x[:80].max() == pytest.approx(swing, rel=0.03)
        assert (x[:80].max() == x[0]) == let_go


def stick_and_slip(grip, speed):
    """Return the states of the step's two checks if a student drags the handle over 70 mm at a speed."""
    step = next(step for step in library().lessons["friction"].steps if step.title == "Stick and slip")
    pointer = np.concatenate([held(-0.035, 1.0), dragged(-0.035, 0.035, speed=speed)])
    out = live("friction", pointer, step.scene.values, grip or step.scene.grip)
    out[:, rows.HOST_TIME] = out[:, rows.BOARD_TIME]
    samples = Samples.of_rows(out, [(0.0, settings_in(step.plays[0]))])
    return {check.measure: evaluate(check, samples).state for check in step.checks}


@pytest.mark.parametrize("speed", [0.007, 0.010, 0.015])
def test_the_steps_rubber_band_sticks_and_slips_behind_a_mouse(speed):
    found = stick_and_slip("", speed)
    assert found == {"stick_slip_period": "correct", "stick_slip_amplitude": "correct"}


@pytest.mark.parametrize("grip", ["light", "medium", "firm"])
def test_a_persons_grip_is_too_damped_to_stick_and_slip(grip):
    assert set(stick_and_slip(grip, 0.010).values()) == {"waiting"}
