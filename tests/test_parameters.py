"""Parameter values are validated; errors have the value, the limit and the unit."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import compact
from hapkit_studio.parameters import Choice, Parameter, check_number, resolve

STIFFNESS = Parameter("stiffness", "Stiffness", "N/m", 250.0, 0.0, 5000.0)
RATIO = Parameter("ratio", "Ratio", "", 1.8, 1.0, 3.0)
SIDE = Choice("side", "Side", ("right", "left"), "left")


@pytest.mark.slow
@given(st.floats(0.0, 5000.0))
def test_every_number_within_the_limits_is_accepted(value):
    assert STIFFNESS.check(value) == value
    assert STIFFNESS.check(repr(value)) == value


@given(st.floats().filter(lambda v: not 0.0 <= v <= 5000.0))
def test_every_number_beyond_the_limits_is_rejected(value):
    with pytest.raises(ParameterError) as error:
        STIFFNESS.check(value)
    assert str(error.value) == f"Stiffness must be between 0 and 5,000 N/m, not {compact(value)}."


@pytest.mark.parametrize("value", ["stiff", "", True, None, [1.0], {}, object, 1j, 10**400])
def test_non_numbers_are_rejected(value):
    with pytest.raises(ParameterError, match=r"^Stiffness must be a number in N/m, not .*\.$"):
        STIFFNESS.check(value)


def test_an_error_without_unit():
    with pytest.raises(ParameterError, match=r"^Ratio must be between 1 and 3, not 0\.5\.$"):
        RATIO.check(0.5)
    with pytest.raises(ParameterError, match=r"^Ratio must be a number, not 'much'\.$"):
        RATIO.check("much")
    assert (RATIO.text(2.5), STIFFNESS.text(2.5)) == ("2.5", "2.5 N/m")


def test_a_choice_is_made_by_name_or_index():
    given = ("right", "left", 0, 1.0, np.int64(1), np.float32(1))
    assert [SIDE.check(value) for value in given] == [0, 1, 0, 1, 1, 1]
    assert (SIDE.default, SIDE.low, SIDE.high) == (1.0, 0.0, 1.0)
    assert Choice("mode", "Mode", ("a", "b")).default == 0.0
    assert [SIDE.text(v) for v in (0.0, 1.0)] == ["right", "left"]


@pytest.mark.parametrize("value", ["up", "Right", "", 2, -1, 0.5, True, None, math.nan, math.inf, [0]])
def test_a_choice_rejects_other_values(value):
    with pytest.raises(ParameterError, match=r"^Side must be one of right, left, not .*\.$"):
        SIDE.check(value)


def test_resolve_fills_in_defaults_in_order():
    assert resolve((STIFFNESS, SIDE), {"side": "right"}, "Wall") == [250.0, 0.0]
    assert resolve((), {}, "Free") == []


def test_resolve_lists_the_known_parameters():
    with pytest.raises(
        ParameterError, match=r"^Wall has no parameter 'stifness'; it has: stiffness, side\.$"
    ):
        resolve((STIFFNESS, SIDE), {"stifness": 1.0}, "Wall")
    with pytest.raises(ParameterError, match=r"^Free has no parameter 'stiffness'; it has: none\.$"):
        resolve((), {"stiffness": 1.0}, "Free")


def test_an_option_is_shown_by_its_label_and_checked_by_its_name():
    rule = Choice("rule", "Rule", ("rk4", "semi_implicit"), labels=("RK4", "Semi-implicit"))
    assert (rule.option_labels, rule.option_label(1.0)) == (("RK4", "Semi-implicit"), "Semi-implicit")
    assert rule.text(1.0) == "semi_implicit"
    assert Choice("a", "A", ("up", "half_way")).option_labels == ("Up", "Half way")
    with pytest.raises(ParameterError):
        rule.check("RK4")


@pytest.mark.parametrize("labels", [("A",), ("A", "B", "C"), ("A", 2)])
def test_either_every_option_has_a_label_or_none(labels):
    with pytest.raises(ParameterError, match=r"^Rule must have one label for each of its 2 options\.$"):
        Choice("rule", "Rule", ("a", "b"), labels=labels)


@pytest.mark.parametrize(
    ("value", "limits", "text"),
    [
        ("much", {}, "The mass must be a number in kg, not 'much'."),
        (True, {}, "The mass must be a number in kg, not True."),
        (math.nan, {"endless": True}, "The mass must be a number in kg, not nan."),
        (math.inf, {}, "The mass must be a number in kg, not inf."),
        (-1.0, {}, "The mass must be 0 or more kg, not −1 kg."),
        (0.0, {"above": True}, "The mass must be more than 0 kg, not 0 kg."),
        (3, {"high": 2.0}, "The mass must be 2 kg or less, not 3 kg."),
    ],
)
def test_a_number_without_a_slider_is_rejected_with_its_unit(value, limits, text):
    with pytest.raises(ParameterError) as error:
        check_number(value, "mass", "kg", **limits)
    assert str(error.value) == text


@pytest.mark.parametrize(
    ("value", "limits"), [(0, {}), (-3.5, {"low": -math.inf}), (math.inf, {"endless": True})]
)
def test_a_number_within_its_limits_passes(value, limits):
    check_number(value, "mass", "kg", **limits)
