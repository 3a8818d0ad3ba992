"""A run's warning that the handle oscillates by itself agrees with its motion."""

import math

import numpy as np
import pytest

import hapkit_studio as hs

MASS, VISCOUS, COUNT = 0.044, 0.5, 20.7e-6

# columns: scene, further settings, the values for a stiffness in N/m, centre of the force in m
PLACES = {
    "grating": (
        "texture",
        {"kind": "grating"},
        lambda k: {"amplitude": k * 0.005 / math.tau},
        lambda k: 0.0025,
    ),
    "tether": (
        "friction",
        {"viscous": 0.0, "model": "tether"},
        lambda k: {"tether_stiffness": k},
        lambda k: 0.0,
    ),
    "stribeck": (
        "friction",
        {"viscous": 0.0, "model": "stribeck"},
        lambda k: {"tether_stiffness": k},
        lambda k: 0.0,
    ),
}


def swings(run):
    """Return True if the amplitude is larger at the end than at the start."""
    tenth = len(run.time) // 10
    return np.ptp(run.true_position[-tenth:]) > np.ptp(run.true_position[:tenth])


def warned(run):
    """Return True if a warning says that the released handle does not settle."""
    return any("let go" in line for line in run.warnings)


@pytest.mark.parametrize("late", [0.0, 0.5e-3, 1e-3])
@pytest.mark.parametrize("place", PLACES)
def test_the_handle_oscillates_exactly_if_warned(place, late):
    """The limit b / (T/2 + delay) without friction and quantisation (theory §1.3) is exact to 0.3 %.

    It is tested 1 % above and below.
    """
    key, others, given, centre = PLACES[place]
    rule = VISCOUS / (0.5e-3 + late)
    for share in (0.99, 1.01):
        stiffness = share * rule
        start = {"initial_velocity": 1e-3} if key == "friction" else {}
        device = hs.SimulatedHapkit(
            coulomb_force=0.0, quantum=0.0, initial_position=centre(stiffness) + 1e-6, **start
        )
        run = hs.simulate(key, others | given(stiffness), device=device, delay=late, seconds=12.0)
        assert warned(run) == swings(run) == (share > 1.0)


@pytest.mark.parametrize("late", [0.0, 1e-3])
@pytest.mark.parametrize("estimator", ["difference", "kalman", "iir"])
def test_late_damping_counts_with_its_effective_value(estimator, late):
    """A filter weakens the tether's damping of 5 N·s/m; stiffness is tested 3 % above and below the limit."""
    limit = hs.stiffness_limit(MASS, VISCOUS, damping=5.0, delay=late, estimator=estimator)
    device = hs.SimulatedHapkit(coulomb_force=0.0, quantum=0.0, initial_velocity=1e-4)
    for share in (0.97, 1.03):
        values = {"model": "tether", "tether_stiffness": share * limit, "viscous": 5.0}
        run = hs.simulate("friction", values, device=device, delay=late, estimator=estimator, seconds=8.0)
        assert warned(run) == swings(run) == (share > 1.0)


def balance(stiffness, late, viscous):
    """Return the ratio of the energy added by delay to the energy dissipated by friction of 0.1 N.

    The tether's force is 0.4 N.
    """
    limit = hs.stiffness_limit(MASS, VISCOUS, damping=viscous, delay=late)
    amplitude = 0.4 / stiffness
    given = math.pi * math.sqrt(stiffness / MASS) * amplitude**2 * (stiffness - limit) * (0.5e-3 + late)
    return given / (4.0 * 0.1 * amplitude)


def hunts(values, late):
    """Return True if the handle keeps oscillating after at least one of four flicks.

    Assert that a warning is given exactly in this case.
    """
    hunted = []
    for speed in (0.01, 0.05, 0.2, 0.5):
        device = hs.SimulatedHapkit(initial_velocity=speed)
        run = hs.simulate("friction", values, device=device, delay=late, seconds=3.0)
        hunted.append(np.ptp(run.true_position[-500:]) > 5.0 * COUNT)
    assert warned(run) == any(hunted)
    return any(hunted)


@pytest.mark.parametrize(("late", "viscous"), [(1e-3, 1.0), (2e-3, 1.0), (2e-3, 0.0)])
def test_a_tether_oscillates_if_it_adds_more_energy_than_dissipated(late, viscous):
    """If only 90 % of the dissipated energy is added, the handle does not oscillate, and there is no warning.

    If twice the dissipated energy is added, it oscillates, and there is a warning.
    """
    stiff = np.geomspace(200.0, 2e4, 400)
    gives = np.array([balance(k, late, viscous) for k in stiff])
    for share in (0.9, 2.0):
        stiffness = stiff[np.argmax(gives > share)]
        values = {"model": "tether", "tether_stiffness": stiffness, "viscous": viscous}
        assert hunts(values, late) == (share > 1.0)


@pytest.mark.parametrize(
    ("model", "stiffness", "late", "goes_on"),
    [
        ("karnopp", 4400.0, 1e-3, False),
        ("tether", 3000.0, 2e-3, True),
        ("lugre", 3000.0, 2e-3, False),
        ("lugre", 10_000.0, 2e-3, True),
    ],
)
def test_karnopp_and_bristles_oscillate_less_than_a_tether(model, stiffness, late, goes_on):
    """Karnopp's band of 22 mm/s limits the force to 0.31 N.

    Bristles dissipate energy in every oscillation.
    """
    values = {"model": model, "tether_stiffness": stiffness, "stick_velocity": 0.022}
    assert hunts(values, late) == goes_on


def test_the_limit_of_the_projection_model_includes_its_own_damping():
    """The model's damping is K T, so the limit of K depends on K; it is tested 4 % above and below."""
    stiff = np.geomspace(300.0, 3000.0, 300)
    limit = next(k for k in stiff if hs.stiffness_limit(MASS, VISCOUS, damping=k * 1e-3, delay=1e-3) < k)
    device = hs.SimulatedHapkit(coulomb_force=0.0, quantum=0.0, initial_velocity=1e-4)
    for share in (0.96, 1.04):
        values = {"model": "projection", "tether_stiffness": share * limit, "viscous": 0.0}
        run = hs.simulate("friction", values, device=device, delay=1e-3, seconds=8.0)
        assert warned(run) == swings(run) == (share > 1.0)


def test_friction_of_the_handle_stabilises_ridges_of_a_third_of_a_newton():
    """With 0.1 N of friction the handle does not drift, although the ridges are steeper than the limit.

    The steepest slope of 0.3 N on 5 mm is 377 N/m; the limit at 1 ms is 333 N/m. The drift without friction
    is 1.5 mm.
    """
    for friction in (0.0, 0.1):
        device = hs.SimulatedHapkit(coulomb_force=friction, initial_position=0.002)
        grating = {"kind": "grating", "amplitude": 0.3}
        run = hs.simulate("texture", grating, device=device, delay=1e-3, seconds=10.0)
        assert warned(run) == (np.ptp(run.true_position[-1000:]) > 1e-3) == (friction == 0.0)
