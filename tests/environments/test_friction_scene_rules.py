"""Friction on a handle: its curves, its corners without friction, what is warned of."""

import math

import numpy as np
import pytest

from hapkit_studio.environments.base import Conditions
from hapkit_studio.environments.friction import MODELS
from tests.environments.asking import along, force
from tests.environments.calling import LIBRARY

FRICTION = LIBRARY["friction"]


def test_curves_have_stribecks_shape_where_the_model_has():
    v = np.array([-0.2, -1e-4, 1e-4, 0.02, 0.2])
    got = FRICTION.over_velocity(FRICTION.values({"model": "stribeck", "viscous": 0.0}), v)
    assert got == pytest.approx([0.4, 0.6, -0.6, -(0.4 + 0.2 / math.e), -0.4], rel=1e-3)
    smooth = FRICTION.over_velocity(FRICTION.values({"model": "smoothed", "viscous": 2.0}), v)
    assert smooth == pytest.approx(-0.4 * np.tanh(v / 0.03) - 2.0 * v)
    for model in MODELS:
        two = FRICTION.over_position(FRICTION.values({"model": model}), np.linspace(-0.04, 0.04, 5))
        assert (two[0] == -two[1]).all()
        assert two[1] == pytest.approx(0.6 if model in ("stribeck", "lugre", "karnopp") else 0.4)


def test_what_holds_is_drawn_at_rest():
    """Up to the static force either way at no speed at all; a thousandth of a mm per second slides."""
    v = np.array([-2e-6, -1e-9, 1e-9, 2e-6])
    for model, at_rest in (("tether", 0.6), ("projection", 0.6), ("stribeck", 0.6), ("coulomb", 0.4)):
        got = FRICTION.over_velocity(FRICTION.values({"model": model}), v)
        sliding = 0.6 if model == "stribeck" else 0.4
        assert got == pytest.approx([sliding, at_rest, -at_rest, -sliding], rel=1e-3)


@pytest.mark.parametrize("model", MODELS)
def test_it_takes_hold_where_the_handle_is(model):
    got, states = along("friction", [0.03, 0.03], model=model)
    assert not got.any()
    assert (states[:, 0] == 0.03).all()


@pytest.mark.parametrize("model", MODELS)
def test_without_friction_only_the_viscous_part_is_left(model):
    path = 0.01 * np.sin(np.arange(400) / 20.0)
    speeds = np.gradient(path) * 1e3
    got, _ = along("friction", path, speeds, model=model, kinetic_force=0.0, static_force=0.0, viscous=3.0)
    assert got == pytest.approx(-3.0 * speeds, abs=1.001e-3)  # a thousandth of a newton tells the direction


@pytest.mark.parametrize("model", ["tether", "projection"])
def test_without_kinetic_friction_it_sticks_again_when_it_turns_back(model):
    path = np.concatenate([np.arange(0, 30), np.arange(30, 20, -1)]) * 1e-4
    _, states = along("friction", path, model=model, kinetic_force=0.0)
    assert states[5, 1] == 1.0
    assert states[30, 1] == 0.0
    assert states[31:, 1].all()


@pytest.mark.parametrize("model", ["stribeck", "projection", "tether", "lugre"])
def test_static_friction_is_never_below_the_kinetic_one(model):
    path = np.arange(100) * 1e-4
    low, _ = along("friction", path, model=model, kinetic_force=1.0, static_force=0.2)
    same, _ = along("friction", path, model=model, kinetic_force=1.0, static_force=1.0)
    assert np.array_equal(low, same)


def test_coulomb_and_smoothed_by_their_formulas():
    for v in (-0.3, -1e-4, 0.0, 1e-4, 0.3):
        assert force("friction", 0.01, v, model="coulomb") == pytest.approx(-0.4 * np.sign(v) - v)
        assert force("friction", 0.01, v, model="smoothed") == pytest.approx(-0.4 * np.tanh(v / 0.03) - v)


def warned(conditions=None, **given):
    return list(FRICTION.warnings(FRICTION.values(given), conditions or Conditions()))


def test_nothing_is_warned_of_by_default():
    assert warned() == []
    assert warned(Conditions(speed=3.0)) == []
    for model in set(MODELS) - {"coulomb"}:
        assert warned(model=model) == []


@pytest.mark.parametrize(
    ("inside", "outside", "words"),
    [
        ({"model": "coulomb", "kinetic_force": 1.352}, {"kinetic_force": 1.380}, "above 1.4 N"),
        ({"model": "smoothed", "stick_velocity": 0.00459}, {"stick_velocity": 0.00450}, "above 88 N·s/m"),
        ({"model": "karnopp", "stick_velocity": 0.0209}, {"stick_velocity": 0.0205}, "20.7 mm/s"),
        ({"model": "tether", "tether_stiffness": 2970.0}, {"tether_stiffness": 3030.0}, "above 3000 N/m"),
    ],
)
def test_what_is_beyond_a_models_limit_is_said_in_one_line(inside, outside, words):
    assert not any(words in line.replace("Above", "above") for line in warned(**inside))
    (line,) = warned(**(inside | outside))
    assert words in line.replace("Above", "above")
    assert "\n" not in line


def test_bristles_at_their_end_within_a_period_are_warned_of():
    """0.4 N over 500 N/m twice in a period: 1.6 m/s."""
    assert warned(Conditions(speed=1.58), model="lugre") == []
    (line,) = warned(Conditions(speed=1.62), model="lugre")
    assert "1.6 m/s" in line


def test_an_ideal_sensor_has_no_counts_to_chatter_over():
    values = LIBRARY["friction"].values({"model": "coulomb", "kinetic_force": 3.0})
    assert list(LIBRARY["friction"].warnings(values, Conditions(quantum=20.7e-6)))
    (said,) = LIBRARY["friction"].warnings(values, Conditions(quantum=0.0))
    assert "flips near rest" in said


def test_plain_coulomb_friction_is_always_told_to_flip():
    assert "flips near rest" in warned(model="coulomb")[0]
    assert not warned(model="coulomb", kinetic_force=0.0)
