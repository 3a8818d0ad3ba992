"""The hysteresis area of the felt force agrees with theory and with the energy; lost samples are NaN."""

import math

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.analysis.felt import as_felt, last_cycle
from hapkit_studio.dynamics.hand import Prescribed


def sine(amplitude=2e-3, tone=4.0, rate=1000.0, seconds=3.0):
    """Return the times and the values of a sine, both (n,)."""
    time = np.arange(round(rate * seconds)) / rate
    return time, amplitude * np.sin(2.0 * math.pi * tone * time)


@pytest.mark.parametrize("delay", [0.0, 0.4e-3, 2e-3, 5.3e-3])
def test_a_delayed_spring_gives_the_area_of_its_ellipse(delay):
    """With a hold of T, the area of a cycle is π k a² sin(ω (t_d + T/2)) times the sinc of the hold."""
    stiffness, amplitude, tone = 300.0, 2e-3, 4.0
    time, x = sine(amplitude, tone)
    cycle = last_cycle(time, x, -stiffness * x, delay, 1e-3)
    want = math.pi * stiffness * amplitude**2 * math.sin(2.0 * math.pi * tone * (delay + 0.5e-3))
    assert cycle.energy == pytest.approx(want, rel=2e-3)
    assert cycle.seconds == pytest.approx(1.0 / tone, abs=1e-3)


def test_a_spring_is_a_line_as_computed_and_a_loop_as_felt():
    time, x = sine()
    places, force = as_felt(time, x, -300.0 * x, 2e-3)
    seen = np.isfinite(places)
    width = np.abs(force[seen] + 300.0 * places[seen]).max()
    # the loop's width is k v (t_d + T), where v is the peak speed
    assert width == pytest.approx(300.0 * 2e-3 * 2.0 * math.pi * 4.0 * 3e-3, rel=0.02)


def test_the_energy_agrees_with_a_simulated_loop_with_delay():
    """The simulated motion is imposed; its energy is the integral of force over the handle's true path."""
    delay, rate = 1.7e-3, 1000.0
    moved = lambda t: 0.008 + 0.002 * np.sin(2.0 * math.pi * 3.0 * t)  # noqa: E731
    run = hs.simulate(
        "wall", {"stiffness": 400.0}, hand=Prescribed(moved), seconds=2.0, delay=delay, rate=rate,
        device=hs.SimulatedHapkit(quantum=0.0, initial_position=0.008),
    )  # fmt: skip
    fine = np.arange(0.5, 1.5, 1e-5)
    acting = run.applied_force[np.floor((fine - delay) * rate + 1e-9).astype(int)]
    want = np.sum(acting[:-1] * np.diff(moved(fine)))
    part = slice(round((0.5 - delay) * rate), None)
    time, x, f = run.time[part], run.true_position[part], run.applied_force[part]
    f = np.where((time + delay >= 0.5 - 1e-9) & (time + delay < 1.5 - 1e-9), f, 0.0)
    places, forces = as_felt(time, x, f, delay)
    given = np.nansum(forces[::2] * np.diff(places.reshape(-1, 2), axis=1)[:, 0])
    assert given == pytest.approx(want, rel=0.02)


def test_lost_and_pending_samples_are_nan():
    time, x = sine(seconds=0.1)
    time[40] = x[40] = np.nan
    places, force = as_felt(time, x, -x, 2e-3)
    assert len(places) == len(force) == 200
    assert np.isnan(places[78:82]).all()
    assert np.isnan(places[-6:]).any()
    assert np.isfinite(places[:78]).all()
    places, force = as_felt(np.empty(0), np.empty(0), np.empty(0), 1e-3)
    assert len(places) == len(force) == 0


@pytest.mark.parametrize(("size", "found"), [(0.99, False), (1.01, True)])
def test_motion_below_the_threshold_is_not_a_cycle(size, found):
    time, x = sine(amplitude=0.5e-3 * size)
    assert (last_cycle(time, x, -x, 0.0, 1e-3) is not None) is found
    assert last_cycle(time[:200], x[:200], -x[:200], 0.0, 1e-9) is None, "less than one cycle"


def test_a_complete_cycle_remains_known_as_samples_arrive():
    """The newest cycle is complete one delay after its end; until then the previous one is returned."""
    time, x = sine()
    known = [last_cycle(time[:n], x[:n], -300.0 * x[:n], 5.3e-3, 1e-3) for n in range(2740, 3001, 2)]
    assert all(known)
