"""Stick-slip agrees with closed forms, and each friction model behaves as in the table."""

import math

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.dynamics.stick_slip import MODELS, period_error, slide
from hapkit_studio.errors import ParameterError

# columns: mass in kg, spring in N/m, static and kinetic friction in N, speed in m/s; duration of a slip in s,
# period in s, greatest speed in m/s, largest spring force in N
SETS = [
    (0.05, 300.0, 1.0, 0.5, 0.02, 0.044526, 0.211193, 0.150639, 1.005964),
    (0.05, 300.0, 1.0, 0.5, 0.05, 0.050098, 0.116765, 0.188444, 1.036190),
    (0.05, 1000.0, 1.0, 0.5, 0.02, 0.026113, 0.076113, 0.093485, 1.019615),
    (0.10, 300.0, 0.8, 0.6, 0.02, 0.075655, 0.142321, 0.061633, 0.828035),
    (1.0, 2.0, 1.5, 1.0, 0.1, 2.611259, 7.611259, 0.467423, 1.519615),
]
FIRST = {"mass": 0.05, "spring": 300.0, "static": 1.0, "kinetic": 0.5}


def measured(dt, v):
    """Return the mean duration of a slip and the mean period, in s, over whole cycles except the first."""
    starts = np.flatnonzero((v[:-1] == 0.0) & (v[1:] != 0.0))[1:]
    cycles = len(starts) - 1
    moving = np.count_nonzero(v[starts[0] + 1 : starts[-1] + 1])
    return moving * dt / cycles, (starts[-1] - starts[0]) * dt / cycles


def period_of(t, force):
    """Return the mean time between downward crossings of the middle force; NaN with few crossings."""
    late = force[len(force) // 4 :]
    middle = 0.5 * (late.max() + late.min())
    if np.ptp(late) < 0.05:
        return math.nan
    falls = np.flatnonzero((force[:-1] >= middle) & (force[1:] < middle))[3:]
    return (t[falls[-1]] - t[falls[0]]) / (len(falls) - 1) if len(falls) > 1 else math.nan


@pytest.mark.parametrize(("dt", "rel"), [(0.1e-3, 0.005), (0.25e-3, 0.005), (1e-3, 0.02)])
@pytest.mark.parametrize("case", SETS)
@pytest.mark.parametrize("model", ["projection", "karnopp"])
def test_period_slip_and_peaks_agree_with_the_closed_form(model, case, dt, rel):
    """At least twenty periods are compared; at the end of a slip the spring force is 2 kinetic − static."""
    mass, spring, static, kinetic, speed, slip, period, fastest, peak = case
    seconds = static / (spring * speed) + 22.0 * period
    _, _, v, force = hs.stick_slip(
        model, mass=mass, spring=spring, static=static, kinetic=kinetic, speed=speed, dt=dt, seconds=seconds
    )
    assert measured(dt, v) == pytest.approx((slip, period), rel=rel)
    assert v.max() == pytest.approx(fastest, rel=rel)
    assert v.min() == 0.0
    assert force.max() == pytest.approx(peak, rel=rel)
    ends = np.flatnonzero((v[:-1] != 0.0) & (v[1:] == 0.0)) + 1
    assert force[ends] == pytest.approx(2.0 * kinetic - static, abs=rel * static + spring * speed * dt)


@pytest.mark.parametrize(
    ("viscous", "critical"), [(0.05, 0.445), (0.1, 0.309), (0.2, 0.211), (0.5, 0.120), (1.0, 0.0715)]
)
def test_viscous_friction_ends_stick_slip_above_a_speed(viscous, critical):
    """The mass sticks repeatedly 1 % below the critical speed, and only at the start 1 % above it."""
    for part in (0.99, 1.01):
        _, _, v, _ = hs.stick_slip(
            "projection", **FIRST, viscous=viscous, speed=part * critical, dt=1e-5, seconds=2.0
        )
        stops = np.count_nonzero((v[:-1] != 0.0) & (v[1:] == 0.0))
        assert (stops > 10) if part < 1.0 else (stops == 0)


# columns: model, options, error of the period in % at 1 ms and at 0.2 ms; NaN: no such stick-slip occurs
SCORES = [
    ("coulomb", {}, math.nan, math.nan),
    ("smoothed", {"smoothing": 0.001, "stribeck_velocity": 0.003}, math.nan, -24.0),
    ("smoothed", {}, 5.8, 5.2),
    ("karnopp_band", {}, 0.0, 0.0),
    ("karnopp", {}, -0.1, 0.0),
    ("projection", {}, -0.1, 0.0),
    ("tether", {}, 0.9, 0.6),
    ("lugre", {}, -30.0, -31.0),
    ("hayward_armstrong", {}, -1.0, -61.0),
]


@pytest.mark.parametrize(("model", "options", "coarse", "fine"), SCORES)
def test_the_period_error_of_each_model_agrees_with_the_table(model, options, coarse, fine):
    """If the mass only chatters, the period is at most that of the spring, which is 62 % too short."""
    exact = SETS[0][6]
    for dt, wanted in ((1e-3, coarse), (0.2e-3, fine)):
        t, _, _, force = hs.stick_slip(model, **FIRST, speed=0.02, dt=dt, seconds=6.0, **options)
        error = 100.0 * (period_of(t, force) / exact - 1.0)
        if math.isnan(wanted):
            assert math.isnan(error) or error < -55.0
        else:
            assert error == pytest.approx(wanted, abs=0.7)


def test_without_slips_there_is_no_period():
    t = np.linspace(0.0, 6.0, 6001)
    assert period_error(t, 0.01 * np.sin(30.0 * t), 0.21) == period_error(t, t, 0.21) == math.inf
    assert period_error(t, np.sin(30.0 * t), 2.0 * math.pi / 30.0) < 1e-5


@pytest.mark.parametrize("dt", [1e-4, 0.25e-3, 1e-3])
def test_lugres_classic_motion_agrees_with_the_literature(dt):
    """Parameters, break-away, period, forces and greatest speed are those of Canudas de Wit."""
    given = {"mass": 1.0, "spring": 2.0, "static": 1.5, "kinetic": 1.0, "viscous": 0.4, "speed": 0.1}
    options = {"stiffness": 1e5, "damping": math.sqrt(1e5), "stribeck_velocity": 0.001}
    t, _, v, force = hs.stick_slip("lugre", **given, **options, dt=dt, seconds=60.0)
    assert t[np.argmax(np.where(t < 9.0, force, 0.0))] == pytest.approx(7.645, abs=0.005)
    assert period_of(t, force) == pytest.approx(6.36, abs=0.01)
    late = force[t > 12.0]
    assert late.max() == pytest.approx(1.508, abs=0.001)
    assert late.min() == pytest.approx(0.741, abs=0.001)
    assert v.max() == pytest.approx(0.370, abs=0.001)


@pytest.mark.parametrize(
    ("bad", "names"),
    [
        ({"model": "sticky"}, "friction model must be one of coulomb, .*, not 'sticky'"),
        ({"static": 0.4}, "Static friction is at least the kinetic one: 0.5 N or more, not 0.4 N"),
        ({"kinetic": -1.0}, "Kinetic friction must be between 0"),
        ({"speed": "fast"}, "Speed must be a number in m/s, not 'fast'"),
        ({"stiffness": 100.0}, "projection has no parameter 'stiffness'; it has: none"),
        ({"model": "lugre", "damping": -1.0}, "Damping must be between 0"),
        ({"dt": 1e-9}, "at most 1e[+]08 steps"),
    ],
)
def test_invalid_arguments_give_a_one_line_error(bad, names):
    given = {"model": "projection", **FIRST, "speed": 0.02, "dt": 1e-3, "seconds": 1.0} | bad
    with pytest.raises(ParameterError, match=names) as caught:
        hs.stick_slip(**given)
    assert "\n" not in str(caught.value)


STOPPING = ("karnopp", "projection", "karnopp_band", "stribeck")


def nothing(seconds, dt):
    return np.zeros(round(seconds / dt) + 1)


@pytest.mark.parametrize("model", STOPPING)
def test_a_slide_to_a_stop_agrees_with_the_closed_form(model):
    """The slide takes m v / F_c = 10 ms and m v^2 / (2 F_c) = 0.5 mm; then the velocity is exactly 0."""
    options = {"band": 1e-4} if model == "karnopp_band" else {}
    t, x, v = slide(
        model, nothing(0.05, 1e-6), mass=0.05, static=0.5, kinetic=0.5, v0=0.1, dt=1e-6, **options
    )
    stop = np.flatnonzero(v == 0.0)[0]
    assert t[stop] == pytest.approx(0.010, rel=2e-3)
    assert x[-1] == pytest.approx(0.5e-3, rel=1e-3)
    assert not v[stop:].any()
    assert (x[stop:] == x[stop]).all()


@pytest.mark.parametrize("model", ["karnopp", "projection"])
@pytest.mark.parametrize(("kinetic", "start", "halves"), [(0.1, 0.010, 15), (0.3, 0.020, 10)])
def test_a_spring_released_against_friction_loses_amplitude_linearly(model, kinetic, start, halves):
    """In every half-cycle of pi sqrt(m / k) the amplitude falls by 2 F_c / k, until the mass sticks."""
    half, turns = 40.558e-3, [start * (-1) ** n * (1.0 - n / halves) for n in range(halves + 1)]
    given = {"mass": 0.05, "spring": 300.0, "static": kinetic, "kinetic": kinetic, "x0": start, "dt": 1e-6}
    t, x, v = slide(model, nothing(half * len(turns), 1e-6), **given)
    at = np.flatnonzero((v[:-1] != 0.0) & ((v[1:] == 0.0) | (v[:-1] * v[1:] < 0.0))) + 1
    assert x[at] == pytest.approx(turns[1:], abs=2e-6)
    assert t[at] == pytest.approx(half * np.arange(1, len(turns)), abs=1e-4)
    assert v[-1] == 0.0
    assert abs(x[-1]) <= kinetic / 300.0


def creep(model, dt, frequency=20.0, mass=0.05, **options):
    """Return the drift in µm/s under a pull of 0.3 N with a tremor of 0.15 N; static friction is 1 N."""
    t = np.arange(round(3.0 / dt) + 1) * dt
    pull = 0.3 + 0.15 * np.sin(2.0 * np.pi * frequency * t)
    _, x, _ = slide(model, pull, mass=mass, static=1.0, kinetic=0.5, dt=dt, **options)
    return 1e6 * (x[-1] - x[round(1.0 / dt)]) / 2.0


@pytest.mark.parametrize("dt", [1e-4, 1e-3])
@pytest.mark.parametrize("model", STOPPING)
def test_sticking_models_have_no_drift(model, dt):
    assert creep(model, dt) == 0.0


@pytest.mark.parametrize(
    ("model", "options", "wanted"),
    [
        ("smoothed", {"smoothing": 0.001, "stribeck_velocity": 0.003}, 316.0),
        ("smoothed", {}, 3165.0),
        ("lugre", {}, 432.0),
    ],
)
def test_models_by_speed_alone_drift(model, options, wanted):
    assert creep(model, 1e-4, **options) == pytest.approx(wanted, rel=0.02)


def test_dahls_creep_agrees_with_its_curve():
    """In slow motion dx = dF / (K (1 -+ F / F_c)) for rising and falling force.

    The creep is the sum of dx over a cycle.
    """
    cycle = 0.5 / 1e4 * (math.log(1.0 - (0.15 / 0.5) ** 2) - math.log(1.0 - (0.45 / 0.5) ** 2))
    assert creep("dahl", 1e-4, frequency=2.0) == pytest.approx(2.0e6 * cycle, rel=0.02)


def test_friction_by_the_sign_of_the_velocity_chatters_and_creeps():
    """A step changes the speed by F_c T / m = 10 mm/s, so the speed changes its sign in every step."""
    _, x, v = slide("coulomb", nothing(2.0, 1e-3), mass=0.05, static=0.5, kinetic=0.5, v0=0.1234)
    late = v[-1000:]
    assert np.abs(late).max() <= 0.01
    assert late[2:] == pytest.approx(late[:-2], abs=1e-12)
    assert (late[1:] * late[:-1] < 0.0).all()
    assert abs(x[-1] - x[-1001]) <= 0.005 + 1e-9
    assert np.abs(late).max() == pytest.approx(6.6e-3)
    assert x[-1] - x[-1001] == pytest.approx(-1.6e-3)


@pytest.mark.parametrize("model", MODELS)
def test_every_model_brakes_a_free_mass_and_never_drives_it(model):
    """The mass stops within 2 mm plus the elastic strain.

    A strained anchor without damping may keep oscillating.
    """
    _, x, v = slide(model, nothing(1.0, 1e-4), mass=0.05, static=0.5, kinetic=0.5, v0=0.2, dt=1e-4)
    assert np.abs(v).max() == 0.2
    assert np.abs(v[-100:]).max() <= (0.02 if model == "hayward_armstrong" else 1.1e-3)
    assert 1.0e-3 < x[-1] < 2.6e-3


def test_invalid_forces_are_rejected():
    for applied, names in (
        (["push"], "must be numbers in N"),
        ([0.0, math.nan], "one row of finite numbers"),
    ):
        with pytest.raises(ParameterError, match=names):
            slide("projection", applied, mass=1.0, static=1.0, kinetic=1.0)
