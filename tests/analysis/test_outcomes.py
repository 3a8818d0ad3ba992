"""Outcomes of rows made by hand, and the bounce of a damped spring in closed form."""

import math

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.analysis import fidelity
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings_writer import LoopSettings


def table(**columns):
    names = {"force": rows.APPLIED, "x": rows.TRUE_POSITION, "v": rows.TRUE_VELOCITY, "energy": rows.ENERGY}
    made = np.zeros((len(next(iter(columns.values()))), rows.ROW_WIDTH))
    for name, values in columns.items():
        made[:, names[name]] = values
    return made


def change(key, reference, other):
    return fidelity.outcome_named(key).change(reference, other)


@pytest.mark.parametrize(
    ("before", "after", "share"), [(2.0, -2.1, 0.05), (0.1, 0.115, 0.05), (0.0, 0.3, 1.0)]
)
def test_force_is_felt_beside_itself_but_not_below_a_third_of_a_newton(before, after, share):
    found = change("peak_force", table(force=[0.0, before, -before / 2]), table(force=[after, 0.0, 0.0]))
    assert found == pytest.approx(share, rel=1e-9)


def test_positions_are_felt_to_four_tenths_of_a_millimetre():
    still, moved = table(x=[0.0, -0.02, 0.010]), table(x=[0.0, -0.0196, 0.0102])
    assert change("final_position", still, moved) == pytest.approx(0.5)
    assert change("peak_position", still, moved) == pytest.approx(1.0)


def test_energy_is_measured_by_what_went_to_and_fro():
    spring = table(energy=np.cumsum([0.0, -4e-3, 3e-3]))
    lossy = table(energy=np.cumsum([0.0, -4e-3, 2.3e-3]))
    assert change("energy", spring, lossy) == pytest.approx(0.1)
    nothing, little = table(energy=[0.0, 0.0]), table(energy=[0.0, 1.2e-5])
    assert change("energy", nothing, little) == pytest.approx(0.1)  # of 0.3 N times 0.4 mm


@pytest.mark.parametrize(
    ("velocity", "ratio"),
    [
        ([0.5, 0.2, -0.1, -0.3, -0.2, 0.4], 0.6),
        ([-0.5, 0.0, 0.6], 1.2),
        ([0.5, 0.1, 0.0, -0.0009, 0.0], 0.0),
        ([0.0005, -0.0009, 0.2, -0.1], 0.5),
        ([0.0, 0.0], 0.0),
    ],
)
def test_restitution_is_speed_back_over_speed_in(velocity, ratio):
    assert fidelity.restitution(table(v=velocity)) == pytest.approx(ratio)


@pytest.mark.parametrize(("stiffness", "viscous"), [(250.0, 0.5), (900.0, 3.0), (40.0, 0.1)])
def test_the_bounce_of_a_mass_on_a_damped_spring(stiffness, viscous):
    """Schwager and Pöschel (2007): exp(−2 ζ acos ζ / √(1 − ζ²)), the contact left at zero force."""
    mass, rate = 0.044, 200_000.0
    device = SimulatedHapkit(mass, viscous, 0.0, 0.0, math.inf, initial_velocity=0.5)
    wall = environments.named("wall")
    values = wall.values({"stiffness": stiffness, "position": 0.0})
    scene = headless.Scene(wall, values, device, LoopSettings(rate))
    swing = math.pi / math.sqrt(stiffness / mass)
    out, _ = headless.render(scene, None, round(1.2 * swing * rate))
    ratio = viscous / (2.0 * math.sqrt(stiffness * mass))
    expected = math.exp(-2.0 * ratio * math.acos(ratio) / math.sqrt(1.0 - ratio**2))
    assert fidelity.restitution(out) == pytest.approx(expected, rel=2e-3)


def test_what_is_no_number_has_changed_more_than_anything():
    assert change("final_position", table(x=[0.0, 0.0]), table(x=[0.0, math.nan])) == fidelity.MOST


def test_a_count_is_right_or_wrong():
    outcome = fidelity.outcome_named("count:ups", ("downs", "ups"))
    one, two = np.zeros((3, rows.ROW_WIDTH)), np.zeros((3, rows.ROW_WIDTH))
    one[-1, rows.STATE + 1], two[-1, rows.STATE + 1] = 3.0, 4.0
    two[:, rows.STATE] = 7.0
    assert outcome.change(one, two) == 1.0
    assert outcome.change(one, one) == 0.0
