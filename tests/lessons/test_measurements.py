"""Every measurement recovers the value from which its samples were computed."""

import math

import numpy as np
import pytest

from hapkit_studio.lessons.measurements import MEASUREMENTS, NotMeasured
from tests.lessons.made import RATE, samples

TIME = np.arange(4000) / RATE
CASES = {}


def case(key, value, tolerance, made, region=None):
    CASES[key] = (value, tolerance, made, region)


def stroke(reach=0.02, hertz=1.0):
    return reach * np.sin(math.tau * hertz * TIME)


def speed(reach=0.02, hertz=1.0):
    return reach * math.tau * hertz * np.cos(math.tau * hertz * TIME)


case("slope", 123.0, 0.1, lambda: samples("spring", {"stiffness": 123.0}, stroke(), -123.0 * stroke()))
case("stiffness", 123.0, 1.0, lambda: samples("spring", {"stiffness": 123.0}, stroke(), -123.0 * stroke()))
case("damping", 5.0, 0.1, lambda: samples("damping", {"damping": 5.0}, stroke(), -5.0 * speed()))
case("peak_force", 1.5, 1e-3, lambda: samples("spring", {}, stroke(), -75.0 * stroke()))
case("travel", 0.04, 1e-5, lambda: samples("free", {}, stroke(), 0.0 * TIME))
case("peak_speed", 0.02 * math.tau, 2e-3, lambda: samples("free", {}, stroke(), 0.0 * TIME))
case("position", 0.003, 1e-9, lambda: samples("free", {}, 0.003 + 0.0 * TIME, 0.0 * TIME))
case("rate", 1000.0, 1e-6, lambda: samples("free", {}, stroke(), 0.0 * TIME))
case("rest", 0.0004, 1e-6, lambda: samples("free", {}, stroke(0.0002, 2.0), 0.0 * TIME))
case("oscillation_frequency", 23.0, 0.1, lambda: samples("wall", {}, stroke(0.001, 23.0), 0.0 * TIME))
case("oscillation_amplitude", 0.001, 2e-5, lambda: samples("wall", {}, stroke(0.001, 23.0), 0.0 * TIME))
case("vibration", 40.0, 0.2, lambda: samples("texture", {}, 0.01 * TIME, np.sin(math.tau * 40.0 * TIME)))
case("clicks", 3.0, 0.0, lambda: samples("button", {}, stroke(), 0.0 * TIME, state=clicked(3)))


def clicked(count):
    state = np.zeros((len(TIME), 5))
    for at in range(count):
        state[500 + 1000 * at :, 3] += 1.0
    return state


def friction():
    return samples(
        "friction", {"kinetic_force": 0.5, "viscous": 2.0}, stroke(), -0.5 * np.sign(speed()) - 2.0 * speed()
    )


case("friction", 0.5, 0.02, friction)


def sticking(static=0.7, viscous=0.0):
    """Return samples of friction: 0.5 N while sliding, and up to 0.7 N below 2 mm/s."""
    level = np.where(np.abs(speed()) < 0.002, static, 0.5) + viscous * np.abs(speed())
    return samples("friction", {}, stroke(), -level * np.sign(speed()))


case("friction_ratio", 1.4, 0.01, sticking)


VISCOUS = 4.0  # N·s/m
# the median of a sine's speeds above half of the peak speed is the peak speed times cos 30°
VISCOUS_RATIO = (0.5 + VISCOUS * 0.005) / (0.5 + VISCOUS * 0.04 * math.pi * math.cos(math.pi / 6.0))


@pytest.mark.parametrize(("viscous", "ratio"), [(0.0, 1.0), (VISCOUS, VISCOUS_RATIO)])
def test_the_friction_ratio_tells_coulomb_and_viscous_friction(viscous, ratio):
    found = MEASUREMENTS["friction_ratio"].compute(sticking(0.5, viscous), None)
    assert found.value == pytest.approx(ratio, abs=0.01)


def grating():
    place = np.linspace(-0.02, 0.02, len(TIME))
    return samples("texture", {"wavelength": 0.004}, place, 0.3 * np.sin(math.tau * place / 0.004))


case("spatial_period", 0.004, 5e-5, grating)


def bump():
    """Return samples of a motion through a force of −0.2 N over 10 mm; the device's work is −2 mJ."""
    place = np.linspace(-0.01, 0.01, len(TIME))
    return samples("bump_valley", {}, place, np.where(np.abs(place) < 0.005, -0.2, 0.0))


case("work", -0.002, 1e-5, bump, (-0.009, 0.009))


def bounce(ratio=0.8):
    """Return samples of a mass of 0.05 kg that bounces off a wall at 5 mm.

    The speed is 0.1 m/s before the bounce and 80 % of this speed after it. The wall's work is −0.09 mJ.
    """
    t = TIME - 2.0
    inside = (t > 0.0) & (t < 0.1)
    place = np.where(t <= 0.0, 0.005 + 0.1 * t, 0.005 - 0.1 * ratio * (t - 0.1))
    place[inside] = 0.005 + 1e-3 + 3e-3 * np.sin(math.pi * t[inside] / 0.1)
    energy = np.where(t < 0.05, 0.0, 0.5 * 0.05 * 0.1**2 * (ratio**2 - 1.0))
    return samples("wall", {"position": 0.005}, place, np.where(inside, -1.0, 0.0), energy)


case("restitution", 0.8, 0.01, bounce)
case("energy_per_bounce", 0.5 * 0.05 * 0.01 * (0.64 - 1.0), 1e-6, bounce)


def ringing():
    since = np.maximum(TIME - 1.0, 0.0)
    depth = np.where(TIME >= 1.0, 0.002, -0.001)
    ring = 0.6 * np.exp(-70.0 * since) * np.sin(math.tau * 45.0 * since)
    return samples(
        "hard_surface",
        {"position": 0.005, "stiffness": 200.0},
        0.005 + depth,
        -200.0 * np.maximum(depth, 0.0) - ring,
    )


case("transient_frequency", 45.0, 0.5, ringing)
case("transient_decay", 70.0, 1.0, ringing)


def settled():
    return samples("spring", {}, 0.008 * np.exp(-4.0 * TIME) * np.cos(math.tau * 5.0 * TIME), 0.0 * TIME)


case("largest_push", 0.008, 1e-4, settled)


def purr():
    force = 0.2 * np.sin(math.tau * 26.0 * TIME) - 0.5 * np.sign(speed(0.02, 0.5))
    return samples("cat", {}, stroke(0.02, 0.5), force)


case("purring", 26.0, 0.5, purr)


def sawtooth():
    """Return samples of a handle that repeatedly sticks for 0.4 s and slips by 3 mm within 20 ms."""
    phase = np.mod(TIME, 0.42)
    place = 0.003 * np.floor(TIME / 0.42) + 0.003 * np.clip((phase - 0.4) / 0.02, 0.0, 1.0)
    return samples("friction", {}, place, 0.0 * TIME)


case("stick_slip_period", 0.42, 0.005, sawtooth)
case("stick_slip_amplitude", 0.003, 3e-4, sawtooth)


def swinging(growth=-0.3, hertz=2.0):
    state = np.zeros((len(TIME), 6))
    state[:, 0] = 0.01 + 0.005 * np.exp(growth * TIME) * np.cos(math.tau * hertz * TIME)
    return samples("mass_spring_damper", {}, 0.0 * TIME, 0.0 * TIME, state=state)


case("object_growth", -0.3, 0.005, swinging)
case("object_frequency", 2.0, 0.01, swinging)


def flying():
    """Return samples of an object between two walls, which keeps 90 % of its speed in each bounce."""
    place, velocity, track = 0.0, 0.2, []
    for _ in TIME:
        place += velocity / RATE
        if abs(place) > 0.03 and place * velocity > 0.0:
            velocity = -0.9 * velocity
        track.append(place)
    state = np.zeros((len(TIME), 7))
    state[:, 0] = track
    return samples("puck", {}, -0.05 + 0.0 * TIME, 0.0 * TIME, state=state)


case("object_restitution", 0.9, 0.002, flying)
case("object_speed", 0.2, 0.005, flying)


def delayed(delay=0.003):
    """Return samples of a spring with a delayed command; the recording contains the delay and the command."""
    return samples("spring", {"stiffness": 200.0}, stroke(), -200.0 * stroke(), delay_s=delay)


case("delay", 0.003, 2e-4, delayed)


def measured_or_advice(key, made):
    try:
        return MEASUREMENTS[key].compute(made, (-0.01, 0.01)).value, ""
    except NotMeasured as error:
        return 0.0, str(error)


def test_every_measurement_has_a_case():
    assert set(CASES) == set(MEASUREMENTS)


@pytest.mark.parametrize("key", CASES)
def test_a_measurement_recovers_its_value(key):
    value, tolerance, made, region = CASES[key]
    found = MEASUREMENTS[key].compute(made(), region)
    assert found.value == pytest.approx(value, abs=max(tolerance, 1e-12))
    assert found.half >= 0.0


@pytest.mark.parametrize(
    "key", sorted(set(CASES) - {"travel", "peak_speed", "position", "rate", "rest", "peak_force"})
)
def test_a_still_handle_without_force_is_answered_with_advice_or_zero(key):
    made = samples("button", {}, 0.0 * TIME, 0.0 * TIME, state=np.zeros((len(TIME), 5)))
    value, advice = measured_or_advice(key, made)
    assert abs(value) < 1e-9
    assert not advice or (advice.endswith(".") and len(advice) > 20)
