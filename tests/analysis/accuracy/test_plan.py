"""The front by brute force, what a row holds, and which answer a sheet gives."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hapkit_studio.analysis.accuracy.plan import beats, mark_front
from hapkit_studio.analysis.accuracy.words import error_words, sentence, verdict
from tests.analysis.accuracy.sheets import point, sheet

ROW = {"chart", "scene", "method", "step_s", "error", "ns_per_simulated_s", "pareto"}
# few values, so that equal errors, equal costs and equal points are common
NUMBERS = st.sampled_from([0.0, 1e-15, 1e-3, 0.01, 0.02, 1.0, 7.0, math.inf, math.nan])
COSTS = st.sampled_from([1.0, 2.0, 2.5, 40.0])


@given(st.lists(st.tuples(NUMBERS, COSTS), max_size=30))
def test_the_front_is_what_nothing_beats(pairs):
    points = [point(error=error, ns=ns) for error, ns in pairs]
    marked = mark_front(points)
    assert [replace(p, pareto=False) for p in marked if p.error == p.error] == [
        p for p in points if p.error == p.error
    ]
    for p, (error, ns) in zip(marked, pairs, strict=True):
        rivals = [q for q in pairs if q[0] <= error and q[1] <= ns and (q[0] < error or q[1] < ns)]
        assert p.pareto == (math.isfinite(error) and not rivals)


def test_beating_is_strict():
    assert beats(point(error=0.01, ns=1.0), point(error=0.02, ns=1.0))
    assert not beats(point(error=0.01, ns=1.0), point(error=0.01, ns=1.0))
    assert not beats(point(error=0.01, ns=2.0), point(error=0.02, ns=1.0))


def test_a_row_has_exactly_these_keys_and_what_its_chart_measures_besides():
    row = point(options=(("cutoff", 20.0),), extra=(("lag_s", 0.004),)).row()
    assert set(point().row()) == ROW
    assert set(row) == {*ROW, "options", "lag_s"}
    assert row["options"] == {"cutoff": 20.0}
    assert point(error=math.inf).row()["error"] is None


def test_the_cheapest_within_the_tolerance_at_the_loops_own_step():
    cheap_but_off = point("euler", 0.0201, 500.0)
    coarse = point("verlet", 0.001, 100.0, step_s=4e-3)
    fits, dear = point("verlet", 0.02, 1000.0), point("rk4", 1e-9, 2000.0)
    made = sheet([cheap_but_off, coarse, dear, fits])
    assert made.answer.cheapest.label == "verlet"
    assert made.answer.cheapest.step_s == 1e-3
    assert made.answer.right
    assert sentence(made) == "Cheapest within 2 % at a 1 ms step: verlet, 1.0 µs per simulated second."
    assert verdict(made) == "It is the default."


@pytest.mark.parametrize(("cost", "right"), [(1.09, True), (1.11, False)])
def test_costs_within_ten_percent_are_equal(cost, right):
    made = sheet([point("euler", 0.01, 1000.0), point("verlet", 0.01, 1000.0 * cost)])
    assert made.answer.right is right
    assert made.answer.cheapest.method == ("verlet" if right else "euler")
    words = "As cheap, to 10 %: euler" if right else "The default, verlet, costs 1.1 times as much"
    assert words in verdict(made)


def test_a_default_outside_of_the_tolerance_is_not_right_however_cheap():
    made = sheet([point("euler", 0.01, 1000.0), point("verlet", 0.03, 10.0)])
    assert not made.answer.right
    assert verdict(made) == "The default, verlet, is off by 3.0 %."
    nothing = sheet([point("verlet", math.inf, 10.0)])
    assert nothing.answer.cheapest is None
    assert sentence(nothing) == "Nothing is within 2 % at a 1 ms step."


def test_where_the_step_is_chosen_every_step_competes():
    slow, fast = point("verlet", 0.03, 100.0, step_s=4e-3), point("verlet", 0.01, 400.0)
    made = sheet([slow, fast], step_s=None)
    assert made.answer.cheapest is made.answer.default
    assert sentence(made) == "Cheapest within 2 %: 1 kHz, 0.40 µs per simulated second."


def test_numbers_as_people_read_them():
    assert error_words(0.0391) == "3.9 %"
    assert error_words(2e-6) == "2·10⁻⁶"
    assert error_words(2180.0) == "2·10³"
    assert error_words(0.0049, "m/s") == "4.9 mm/s"
    assert error_words(3.2e-6, "m/s") == "3.2 µm/s"
    assert error_words(math.inf) == "none"
