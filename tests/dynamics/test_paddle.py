"""The paddle agrees with closed forms, matrix exponentials and an event-driven ODE solver."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from hapkit_studio.dynamics import paddle
from tests.dynamics.reference_paddle import slide


def through(x, v, force, force_rate, coulomb, mass, damping, stiffness, h):
    step = paddle.transition(mass, damping, stiffness, h)
    return paddle.advance(x, v, force, force_rate, coulomb, mass, damping, stiffness, h, step)


def exact_map(mass, damping, stiffness, h):
    a = np.zeros((4, 4))
    a[0, 1], a[2, 3] = 1.0, 1.0
    a[1, :3] = -stiffness / mass, -damping / mass, 1.0 / mass
    e = expm(a * h)
    return np.array([e[0, 0], e[0, 1], e[1, 0], e[1, 1], e[0, 2], e[0, 3], e[1, 2], e[1, 3]])


def test_the_map_is_the_matrix_exponential(rng):
    for _ in range(200):
        mass, h = 10 ** rng.uniform(-2, 0.5), 10 ** rng.uniform(-5, -1)
        damping, stiffness = 10 ** rng.uniform(-3, 1.5), 10 ** rng.uniform(-1, 4)
        damping, stiffness = damping * (rng.random() > 0.2), stiffness * (rng.random() > 0.2)
        got, want = paddle.transition(mass, damping, stiffness, h), exact_map(mass, damping, stiffness, h)
        assert np.allclose(got, want, rtol=1e-11, atol=1e-14 * np.abs(want).max())


def test_a_free_mass_follows_a_parabola_to_the_last_digit():
    a, b, c, d, g0, h0, g1, h1 = paddle.transition(0.05, 0.0, 0.0, 0.002)
    assert (a, b, c, d) == (1.0, 0.002, 0.0, 1.0)
    assert (g0, h0, g1, h1) == pytest.approx(
        (0.002**2 / 0.1, 0.002**3 / 0.3, 0.002 / 0.05, 0.002**2 / 0.1), rel=1e-15
    )


@pytest.mark.parametrize("damping", [1e-9, 1e-3, 0.5, 50.0, 5e4])
def test_damped_mass_agrees_with_its_closed_form(damping):
    """Under 1 N, x = t/b - m r / b^2 and v = r / b with r = 1 - e^(-b t/m), which expm1 computes exactly."""
    m, h = 0.05, 0.004
    rise = -math.expm1(-damping * h / m)
    step = paddle.transition(m, damping, 0.0, h)
    assert step[6] == pytest.approx(rise / damping, rel=1e-13)
    assert step[3] == pytest.approx(1.0 - rise, rel=1e-12, abs=1e-14)
    if damping * h / m > 1e-2:
        assert step[4] == pytest.approx((h - m * rise / damping) / damping, rel=1e-11)


def test_a_slow_mode_keeps_its_digits_next_to_a_stiff_one():
    m, c, k, h = 0.05, 5e4, 10.0, 0.01
    slow = 2.0 * k / (c * (1.0 + math.sqrt(1.0 - 4.0 * m * k / c**2)))
    a = paddle.transition(m, c, k, h)[0]
    assert 1.0 - a == pytest.approx(slow * h, rel=1e-3)
    assert a == pytest.approx(math.exp(-slow * h), abs=2e-15 + (slow * m / c))


@settings(max_examples=60)
@given(
    mass=st.floats(0.01, 5.0),
    damping=st.floats(0.0, 50.0),
    stiffness=st.floats(0.0, 5000.0),
    h1=st.floats(1e-6, 0.02),
    h2=st.floats(1e-6, 0.02),
    motion=st.tuples(*[st.floats(-1.0, 1.0)] * 4),
)
def test_two_consecutive_maps_equal_one(mass, damping, stiffness, h1, h2, motion):
    x, v, force, rate = motion
    halfway = paddle.apply(paddle.transition(mass, damping, stiffness, h1), x, v, force, rate)
    twice = paddle.apply(paddle.transition(mass, damping, stiffness, h2), *halfway, force + rate * h1, rate)
    once = paddle.apply(paddle.transition(mass, damping, stiffness, h1 + h2), x, v, force, rate)
    scale = 1.0 + math.sqrt(stiffness / mass) + 1.0 / mass
    assert np.allclose(twice, once, rtol=0.0, atol=1e-13 * scale)


def test_it_slides_to_a_stop_and_stays():
    """The time is t = m v0 / F_c = 10 ms, and the distance is s = m v0^2 / (2 F_c) = 0.5 mm."""
    x, v, seen = 0.0, 0.1, []
    for _ in range(30):
        x, v = through(x, v, 0.0, 0.0, 0.5, 0.05, 0.0, 0.0, 0.0007)
        seen.append((x, v))
    assert seen[13][1] == pytest.approx(0.1 - 10.0 * 14 * 0.0007, abs=1e-12)
    assert all(moving > 0.0 for _, moving in seen[:14])
    assert all(pair == seen[14] for pair in seen[14:])
    assert seen[-1][0] == pytest.approx(0.5e-3, rel=1e-12)
    assert seen[-1][1] == 0.0


@pytest.mark.parametrize(("coulomb", "start", "step"), [(0.1, 0.010, 2 / 3 * 1e-3), (0.3, 0.020, 2e-3)])
def test_a_spring_with_friction_loses_amplitude_linearly(coulomb, start, step):
    """In each half period pi sqrt(m / k) the amplitude falls by 2 F_c / k, until |x| <= F_c / k."""
    half = math.pi * math.sqrt(0.05 / 300.0)
    x, v = start, 0.0
    for n in range(1, 40):
        x, v = through(x, v, 0.0, 0.0, coulomb, 0.05, 0.0, 300.0, half)
        size = max(start - n * step, 0.0)
        if size >= coulomb / 300.0:
            assert abs(x) == pytest.approx(size, abs=1e-12)
            assert math.copysign(1.0, x) == (-1.0) ** n
    assert v == 0.0
    assert abs(x) <= coulomb / 300.0


def test_break_away_by_a_spring_touches_zero_speed_without_sticking():
    """After break-away at k V t = F_c, v = V (1 - cos wt) touches 0 every period without sticking."""
    m, k, speed, coulomb, h = 0.05, 300.0, 0.02, 0.4, 1e-3
    omega, x, v = math.sqrt(k / m), 0.0, 0.0
    leaves = coulomb / (k * speed)
    for n in range(400):
        x, v = through(x, v, k * speed * n * h, k * speed, coulomb, m, 0.0, k, h)
        t = max((n + 1) * h - leaves, 0.0)
        assert v == pytest.approx(speed * (1.0 - math.cos(omega * t)), abs=2e-9)
        assert x == pytest.approx(speed * t - speed / omega * math.sin(omega * t), abs=2e-9)


def test_it_resists_forces_below_friction_and_yields_above():
    assert through(0.003, 0.0, 0.0999999, 0.0, 0.1, 0.05, 0.5, 0.0, 1.0) == (0.003, 0.0)
    x, v = through(0.0, 0.0, -0.3, 0.0, 0.1, 0.05, 0.0, 0.0, 0.01)
    assert (x, v) == pytest.approx((-0.2 / 0.05 * 0.5e-4, -0.2 / 0.05 * 0.01), rel=1e-12)


def test_a_brief_stop_within_a_step_is_detected():
    """The handle is pushed back and then forth: it moves forward at the end, but stops in between."""
    args = (0.0, 0.02, -2.0, 1000.0, 0.05, 0.05, 0.1, 0.0, 0.004)
    free = paddle.apply(paddle.transition(*args[5:]), args[0], args[1], args[2] - args[4], args[3])
    got = through(*args)
    assert free[1] > 0.0
    assert got[1] > 0.0
    assert abs(got[1] - free[1]) > 1e-4
    assert got == pytest.approx(slide(*args), rel=1e-8)


@pytest.mark.slow
def test_friction_agrees_with_an_event_driven_solver(rng):
    stops = 0
    for _ in range(120):
        mass, damping = 10 ** rng.uniform(-1.5, -0.5), rng.choice([0.0, 0.2, 4.0])
        stiffness = rng.choice([0.0, 100.0, 400.0, 3000.0])
        x, v = rng.normal(0.0, 0.002), rng.normal(0.0, 0.02) * (rng.random() > 0.2)
        force, rate = rng.normal(0.0, 0.5), rng.normal(0.0, 100.0) * (rng.random() > 0.3)
        case = (x, v, force, rate, 10 ** rng.uniform(-1.5, -0.2), mass, damping, stiffness, 0.012)
        got, want = through(*case), slide(*case)
        assert got == pytest.approx(want, rel=1e-7, abs=1e-9), case
        stops += got[1] == 0.0
    assert 5 < stops < 100
