"""The limit of handle, contact and object together agrees with simulations 1 % below and above it."""

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.analysis.simulated_handle import simulated_handle
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.analysis.stability.objects import contact_limit
from hapkit_studio.analysis.stability.verdict import VerdictInput, verdict
from hapkit_studio.dynamics.hand import Hand
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import headless, rows
from tests.wide import wide

SECONDS, PRESSED = 10.0, 4.0


def pressing(t):
    """Return the path of a hand that presses to 40 mm within 3 s, and 1 µm farther after that."""
    return 0.040 * (0.5 - 0.5 * np.cos(np.pi * np.clip(t / 3.0, 0.0, 1.0))) + 1e-6 * (t >= PRESSED)


def growth(setting, key, values):
    """Return the logarithmic growth of the motion of a handle that presses an object."""
    grip = setting.grip
    hand = Hand(grip.mass, grip.damping, grip.stiffness, pressing, vectorised=True)
    scene = headless.Scene(environments.named(key), values, simulated_handle(setting, real=False), setting)
    out, _ = headless.render(scene, hand, round(SECONDS * setting.rate))
    x = out[round((PRESSED + 0.5) * setting.rate) :, rows.TRUE_POSITION]
    halves = np.array_split(np.diff(x, 3), 2)
    return float(np.log(np.square(halves[1]).sum() / np.square(halves[0]).sum()))


LOOPS = [
    ("mass_spring_damper", "semi_implicit", 0.5, 1000.0, 0.0, "difference"),
    ("mass_spring_damper", "semi_implicit", 0.08, 1000.0, 0.3e-3, "iir"),
    ("mass_spring_damper", "verlet", 0.2, 1000.0, 1e-3, "kalman"),
    ("mass_spring_damper", "exact", 1.0, 2000.0, 0.0, "difference"),
    ("mass_spring_damper", "lecture", 2.0, 1000.0, 0.0, "difference"),
    ("puck", "semi_implicit", 0.5, 1000.0, 0.0, "difference"),
    ("puck", "implicit_euler", 0.1, 700.0, 1e-3, "difference"),
    ("puck", "rk4", 0.3, 1000.0, 2.5e-3, "difference"),
    ("puck", "trapezoid", 0.3, 1000.0, 0.0, "butterworth"),
]


def is_quick(key, integrator, *_):
    return (key, integrator) in (("mass_spring_damper", "verlet"), ("puck", "rk4"), ("puck", "trapezoid"))


@pytest.mark.parametrize(("key", "integrator", "mass", "rate", "delay", "estimator"), wide(LOOPS, is_quick))
def test_a_press_decays_inside_and_grows_outside_the_limit(key, integrator, mass, rate, delay, estimator):
    setting = LoopSettings(rate, delay, estimator, hand="light", coulomb=0.0, quantum=0.0)
    given = {"mass": mass, "integrator": integrator, "contact_damping": 0.0}
    limit = contact_limit(setting, key, given)
    for share, grows in ((0.99, False), (1.01, True)):
        values = environments.named(key).values({**given}) | {"contact_stiffness": share * limit}
        assert (growth(setting, key, values) > 0.0) == grows


SCENES = [
    ("mass_spring_damper", "semi_implicit", 0.3, 1000.0, 0.4e-3),
    ("mass_spring_damper", "lecture", 1.5, 1000.0, 1e-3),
    ("puck", "verlet", 0.2, 1000.0, 0.5e-3),
]


@pytest.mark.parametrize(("key", "integrator", "mass", "rate", "delay"), SCENES)
def test_the_verdict_uses_the_objects_limit_not_a_walls(key, integrator, mass, rate, delay):
    setting = LoopSettings(rate, delay, hand="light", mass=0.05, viscous=0.6, coulomb=0.0, quantum=0.0)
    values = environments.named(key).values({"mass": mass, "integrator": integrator})
    limit = verdict(VerdictInput(environments.named(key), values, setting)).margins["light"].limit
    wall = stiffness_limit(0.05, 0.6, rate=rate, delay=delay, hand="light")
    assert abs(limit / wall - 1.0) > 0.03
    for share in (0.99, 1.01):
        asked = VerdictInput(environments.named(key), values | {"contact_stiffness": share * limit}, setting)
        found = verdict(asked)
        assert found.margins["light"].stable == (growth(setting, key, asked.values) < 0.0) == (share < 1.0)
        assert found.margins["light"].limit == limit


def test_an_object_too_heavy_to_move_is_a_wall():
    """The limit equals the limit of a released handle on a spring whose other end is fixed."""
    setting = LoopSettings(viscous=0.5, delay=0.4e-3)
    given = {"mass": 5.0, "stiffness": 2000.0, "damping": 20.0, "integrator": "exact"}
    assert contact_limit(setting, "mass_spring_damper", given) == pytest.approx(
        stiffness_limit(0.044, 0.5, delay=0.4e-3), rel=0.02
    )


def test_explicit_euler_without_damping_has_no_limit_of_its_own():
    """Explicit Euler increases the energy by the fraction h² w² per step, so any stiffness is unstable."""
    setting = LoopSettings(viscous=0.5, hand="firm")
    given = {"mass": 0.05, "damping": 0.0, "stiffness": 2000.0, "integrator": "explicit_euler"}
    assert contact_limit(setting, "mass_spring_damper", given) == 0.0
    with pytest.raises(ParameterError, match="puck"):
        contact_limit(setting, "spring", {})
