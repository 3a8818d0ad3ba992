"""Texture: its frequency, its grains, and its warnings about undersampling."""

from functools import partial

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.environments.base import Conditions
from hapkit_studio.environments.texture import grain
from hapkit_studio.haptics.board_plan import BoardPlanner, PlanRequest
from hapkit_studio.laws.machine import ARENA
from tests.environments import calling
from tests.environments.calling import LIBRARY, force, forces, frequency

TEXTURE = LIBRARY["texture"]


def swept(speed, seconds=1.0, **given):
    """Return a run at constant speed with an ideal sensor."""
    motion = hs.Prescribed(lambda t: -0.03 + speed * t)
    return hs.simulate("texture", given, hand=motion, device=hs.SimulatedHapkit(quantum=0.0), seconds=seconds)


@pytest.mark.parametrize("kind", ["bands", "grating"])
@pytest.mark.parametrize(("speed", "wavelength"), [(0.06, 0.005), (0.05, 0.002), (0.04, 0.0005)])
def test_the_frequency_is_speed_over_wavelength(kind, speed, wavelength):
    run = swept(speed, kind=kind, wavelength=wavelength)
    assert frequency(run.force[1:], 1000.0) == pytest.approx(speed / wavelength, rel=0.01)


def test_grating_is_a_sine():
    x = np.linspace(-0.05, 0.05, 997)
    got = forces("texture", x, kind="grating", amplitude=1.3, wavelength=0.007)
    assert got == pytest.approx(1.3 * np.sin(2.0 * np.pi * x / 0.007), abs=1e-12)
    steepest = TEXTURE.impedance(TEXTURE.values({"kind": "grating", "amplitude": 1.3, "wavelength": 0.007}))
    assert steepest == (pytest.approx(2.0 * np.pi * 1.3 / 0.007), 0.0)


@pytest.mark.parametrize("band", [-9, -4, 0, 1, 6])
def test_every_other_band_is_damped(band):
    bands = partial(force, "texture", kind="bands")
    for place in (0.0, 0.01, 0.99 * 0.5):
        assert bands((band + place) * 0.005 + 1e-12, 0.2) == pytest.approx(-8.0 * 0.2)
    for place in (1.005 * 0.5, 0.75, 0.999):
        assert bands((band + place) * 0.005, 0.2) == 0.0
    assert bands(0.001, 0.0) == 0.0


def grains(seed):
    """Return the 251 heights 0 to 250 as integers, permuted by cubing modulo 251 twice."""
    first = [((n + 17 * seed) % 251) ** 3 % 251 for n in range(251)]
    return np.array([((m + seed + 1) % 251) ** 3 % 251 for m in first])


@pytest.mark.parametrize("seed", [0, 1, 57, 99])
def test_sandpaper_is_minus_the_slope_of_smooth_grains(seed):
    """Between grains the height is 6 u⁵ − 15 u⁴ + 10 u³; its slope, at most 15 / 8, is normalised to 1."""
    heights = grains(seed) / 250.0
    u = np.linspace(0.0, 0.999, 37)
    step = np.polynomial.Polynomial([0, 0, 0, 10, -15, 6]).deriv()
    for n in (-20, -1, 0, 7, 19):
        rise = heights[(n + 1) % 251] - heights[n % 251]
        got = forces("texture", (n + u) * 0.0025, kind="sandpaper", amplitude=1.7, seed=seed)
        assert got == pytest.approx(-1.7 * rise * step(u) * 8.0 / 15.0, abs=1e-9)


def test_stored_grains_follow_the_handle(rng):
    """The handle rests, moves within a cell, over one cell, and over many cells.

    Then the seed changes while the position stays.
    """
    x = np.cumsum(rng.choice([0.0, 1e-5, -1e-4, 2e-3, -2e-3, 9e-3, -9e-3], 2000)) * 0.3
    state = None
    for place, seed in [*((one, 3) for one in x), (x[-1], 4)]:
        values = TEXTURE.values({"kind": "sandpaper", "seed": seed})
        kept, state, _ = calling.call(TEXTURE, values, place, 0.0, state)
        n, u = divmod(place / 0.0025, 1.0)
        rise = np.diff(grains(seed)[[int(n) % 251, int(n + 1.0) % 251]])[0] / 250.0
        assert kept == pytest.approx(-0.25 * rise * 16.0 * (u * (1.0 - u)) ** 2, abs=1e-9)


def test_sandpaper_takes_half_the_cycles_and_more_than_twice_the_rate_on_the_board():
    """The law stores the slope between two grains; computing it in every tick would take 9,468 cycles.

    With 9,468 cycles the rate would be 500 Hz. The board's delay is 135 µs.
    """
    values = TEXTURE.values({"kind": "sandpaper"})
    plan = BoardPlanner(ARENA).plan(PlanRequest(TEXTURE, values))
    assert plan.program.usual <= 9468 / 2
    assert plan.rate == pytest.approx(1100.0, rel=1e-3)
    gained = [hs.stiffness_limit(0.044, 0.5, rate=rate, delay=135e-6) for rate in (500.0, 1100.0)]
    assert gained[1] > 1.5 * gained[0]


def test_each_height_occurs_once_and_no_seed_is_a_shift_of_another():
    orders = [[round(250.0 * grain(float(n), float(seed))) for n in range(251)] for seed in range(100)]
    assert all(sorted(order) == list(range(251)) for order in orders)
    assert orders == [grains(seed).tolist() for seed in range(100)]
    from_lowest = {tuple(np.roll(order, -order.index(0))) for order in orders}
    assert len(from_lowest) == 100


@pytest.mark.parametrize("seed", [1, 2, 31])
def test_sandpaper_is_bounded_reproducible_and_of_zero_mean(seed):
    x = np.arange(251 * 40) * 0.00025 / 40.0 - 0.03
    got = forces("texture", x, kind="sandpaper", amplitude=2.0, wavelength=0.0005, seed=seed)
    assert np.abs(got).max() <= 2.0
    assert np.abs(got).max() > 1.8
    assert np.std(got) > 0.4
    assert abs(np.mean(got)) < 1e-3
    stiffness, _ = TEXTURE.impedance({"kind": 2.0, "amplitude": 2.0, "wavelength": 0.0005})
    assert np.abs(np.diff(got)).max() <= stiffness * (x[1] - x[0])
    assert np.abs(np.diff(got)).max() > 0.8 * stiffness * (x[1] - x[0])


warned = partial(calling.warned, "texture")


@pytest.mark.parametrize("kind", ["bands", "grating", "sandpaper"])
def test_warns_of_fewer_than_10_samples_or_counts_per_ridge(kind):
    """There are warnings for v > λ / (10 T), which is 0.5 m/s for 5 mm at 1 kHz, and for λ < 10 counts."""
    assert not warned(Conditions(speed=0.99 * 0.5), kind=kind)
    (line,) = warned(Conditions(speed=1.01 * 0.5), kind=kind)
    assert "10 samples" in line
    assert "0.505 m/s" in line
    calm = {"kind": kind, "amplitude": 0.01}
    assert not warned(Conditions(quantum=100e-6), **calm, wavelength=1.01e-3)
    (line,) = warned(Conditions(quantum=100e-6), **calm, wavelength=0.99e-3)
    assert "(10 sensor steps)" in line


def test_the_theory_curve_is_over_the_laws_variable():
    x, v = np.linspace(-0.02, 0.02, 81), np.linspace(-0.2, 0.2, 41)
    bands, grating = TEXTURE.values({"kind": "bands"}), TEXTURE.values({"kind": "grating"})
    assert np.isnan(TEXTURE.over_position(bands, x)).all()
    assert TEXTURE.over_velocity(bands, v) == pytest.approx(np.array([-8.0 * v, 0.0 * v]))
    want = 0.25 * np.sin(2.0 * np.pi * x / 0.005)
    assert TEXTURE.over_position(grating, x) == pytest.approx(want, abs=1e-12)
    assert np.isnan(TEXTURE.over_velocity(grating, v)).all()


@pytest.mark.parametrize("start", np.linspace(0.0, 0.005, 7, endpoint=False))
def test_the_default_ridges_are_below_the_limit_and_a_released_handle_comes_to_rest(start):
    """With 1 ms of delay, the steepest slope is below the exact limit; the last second has no motion."""
    slope, _ = TEXTURE.impedance(TEXTURE.values())
    assert slope == pytest.approx(2.0 * np.pi * 0.25 / 0.005)
    assert slope < 0.95 * hs.stiffness_limit(0.044, 0.5, rate=1000.0, delay=1e-3)
    device = hs.SimulatedHapkit(initial_position=start, initial_velocity=0.1)
    run = hs.simulate("texture", device=device, delay=1e-3, seconds=3.0)
    assert np.ptp(run.position[:1000]) > 1e-3
    assert np.ptp(run.position[-1000:]) == 0.0
