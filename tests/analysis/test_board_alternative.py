"""What a board can render in the place of what is too much for it, if a person cannot tell."""

import pytest

from hapkit_studio.analysis import board_alternative
from hapkit_studio.environments import named
from hapkit_studio.haptics.board_plan import BoardPlanner, PlanRequest
from tests.wide import wide

ARENA = 700


def found(key, **values):
    environment = named(key)
    wish = PlanRequest(environment, environment.values(values), "kalman")
    offer = BoardPlanner(ARENA)
    assert isinstance(offer.plan(wish), str)
    return board_alternative.find(board_alternative.RefusedRequest(offer, wish)).found


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "method"),
    wide(
        [("mass_spring_damper", "exact"), ("puck", "exact"), ("puck", "trapezoid")],
        lambda key, method: method == "trapezoid",
    ),
)
def test_a_cheaper_method_feels_the_same(key, method):
    one = found(key, integrator=method)
    assert one.choice.options[one.option] in ("semi_implicit", "verlet")
    assert one.plan.program.size <= ARENA
    assert 0.0 < one.apart <= board_alternative.FELT * one.force
    assert f"{one.plan.program.size} bytes" in one.words
    assert f"{one.apart:.2f} N apart at most, of {one.force:.1f} N." in one.words


def test_a_method_that_takes_energy_away_feels_like_no_other():
    assert found("puck", integrator="implicit_euler") is None
