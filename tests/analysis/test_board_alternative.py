"""If a board cannot render an option, the studio offers an alternative that feels the same."""

import pytest

from hapkit_studio.analysis import board_alternative
from hapkit_studio.environments import named
from hapkit_studio.haptics.board_plan import BoardPlanner, PlanRequest


def found(key, arena, **values):
    environment = named(key)
    wish = PlanRequest(environment, environment.values(values), "kalman")
    offer = BoardPlanner(arena)
    assert isinstance(offer.plan(wish), str)
    return board_alternative.find(board_alternative.RefusedRequest(offer, wish)).found


def test_the_cheapest_imperceptible_option_is_offered():
    one = found("wall", 100, damping_mode="both", damping=0.0)
    assert one.choice.options[one.option] == "none"
    assert (one.plan.program.size <= 100, one.apart) == (True, 0.0)
    assert f"{one.plan.program.size} bytes" in one.text
    assert f"the forces differ by at most 0.00 N (largest force: {one.force:.1f} N)." in one.text
    assert found("wall", 100, damping_mode="both", damping=20.0) is None


@pytest.mark.slow
@pytest.mark.parametrize(("key", "method"), [("mass_spring_damper", "exact"), ("puck", "trapezoid")])
def test_a_cheaper_method_feels_the_same(key, method):
    one = found(key, 700, integrator=method)
    assert one.choice.options[one.option] in ("semi_implicit", "verlet")
    assert 0.0 < one.apart <= board_alternative.FELT * one.force


@pytest.mark.slow
def test_a_dissipative_method_has_no_alternative():
    assert found("puck", 700, integrator="implicit_euler") is None
