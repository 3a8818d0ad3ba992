"""Which answer a sheet gives: the front by brute force, ties, what a cost is; its picture."""

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure

from hapkit_studio.analysis.accuracy import plan
from hapkit_studio.analysis.accuracy.plan import (
    Accuracy,
    Chart,
    Choice,
    Default,
    Method,
    Point,
    Scene,
    Sheet,
    mark_front,
)
from hapkit_studio.analysis.accuracy.words import reason, sentence, verdict
from hapkit_studio.charts import accuracy as charts
from hapkit_studio.charts.accuracy import AccuracyAxes, accuracy_figure
from hapkit_studio.charts.style import colors


def point(method="verlet", error=0.01, ns=1000.0, step_s=1e-3, **more):
    return Point("servo", "scene", method, step_s, error, ns, label=method, **more)


def scene(default="verlet", tolerance=0.02, **more):
    return Scene("scene", "A scene", "error / scale", tolerance, "a reason", Default(default), **more)


def sheet(points, **more):
    methods = tuple(Method(key, key.capitalize()) for key in dict.fromkeys(p.method for p in points))
    return Sheet("servo", scene(**more), methods, mark_front(points))


def accuracy(*sheets):
    return Accuracy((Chart("servo", "Made up", sheets),), 1.0)


ROW = {"chart", "scene", "method", "step_s", "error", "ns_per_simulated_s", "ns_spread", "pareto"}
# few values, so that equal errors, equal costs and equal points are common
NUMBERS = st.sampled_from([0.0, 1e-15, 1e-3, 0.01, 0.02, 1.0, 7.0, math.inf, math.nan])
COSTS = st.sampled_from([1.0, 2.0, 2.5, 40.0])


SPREADS = st.sampled_from([0.0, 0.4, 0.5])


@settings(max_examples=50)
@given(st.lists(st.tuples(NUMBERS, COSTS, SPREADS), max_size=12))
def test_the_front_is_what_nothing_beats(found):
    points = [point(error=error, ns=ns, ns_spread=spread) for error, ns, spread in found]
    marked = mark_front(points)
    assert [replace(p, pareto=False) for p in marked if p.error == p.error] == [
        p for p in points if p.error == p.error
    ]
    for p, (error, ns, spread) in zip(marked, found, strict=True):
        tied = {q for q in found if abs(q[1] - ns) <= max(q[2], spread)}
        as_cheap = [q for q in found if q in tied or q[1] < ns]
        rivals = [q for q in as_cheap if q[0] < error or (q[0] == error and q not in tied)]
        assert p.pareto == (math.isfinite(error) and not rivals)
    costs_and_errors = sorted((p.ns_per_simulated_s, -p.error) for p in marked if p.pareto)
    errors = [-error for _, error in costs_and_errors]
    assert errors == sorted(errors, reverse=True)  # the dearer, the more accurate


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
    where = "In this scene the cheapest method within 2 % at a 1 ms step"
    assert sentence(made) == f"{where} is verlet: 1.0 µs per simulated second."
    assert verdict(made) == "It is the default."


@pytest.mark.parametrize(("cost", "tied"), [(1.019, True), (1.021, False)])
def test_costs_within_their_measured_spread_are_equal_and_the_error_decides(cost, tied):
    euler = point("euler", 0.01, 1000.0, ns_spread=20.0)
    for error, wins in ((0.01, tied), (0.009, tied), (0.011, False)):
        made = sheet([euler, point("verlet", error, 1000.0 * cost, ns_spread=10.0)])
        assert made.answer.right is wins
        assert made.answer.cheapest.method == ("verlet" if wins else "euler")
        assert [p.method for p in made.front] == (
            ["euler", "verlet"] if error == 0.01 and tied else
            ["verlet"] if wins else ["euler", "verlet"] if error < 0.01 else ["euler"]
        )  # fmt: skip
        assert sentence(made).startswith(
            f"In this scene {'2 methods' if tied else 'the cheapest method'} within 2 %"
        )
        costs = "costs the same as euler" if tied else "costs 2 % more than euler"
        others = "It is the default. Just as cheap: euler." if wins else f"The default, verlet, {costs}; its"
        assert verdict(made).startswith(others)


def over(*errors, ns=1000.0, key="verlet"):
    """Return a method's points in one scene each; the tolerance is 0.02."""
    lag = (("lag_s", 0.0031),)
    return [point(key, error, ns, ns_spread=10.0, extra=lag) for error in errors]


@pytest.mark.parametrize(
    ("rival", "right", "words"),
    [
        (over(0.01, 0.03, key="rk4", ns=2.0), True, "none is in more, and none in as many costs less"),
        (over(0.0, 0.0, 0.03, key="rk4", ns=1005.0), True, "none in as many costs less on average"),
        (over(0.0, 0.0, 0.024, key="rk4", ns=1005.0), False, "rk4 is in as many, costs the same"),
        (over(0.0, 0.0, 0.03, key="rk4", ns=500.0), False, "the default costs 2.0 times as much as rk4"),
        (over(0.0, 0.0, 0.02, key="rk4", ns=1e6), False, "in 2 of them, rk4 in 3"),
    ],
)  # fmt: skip
def test_one_default_for_several_scenes_and_what_it_gives_up(rival, right, words):
    rival += over(*[math.inf] * (3 - len(rival)), key="rk4")
    pairs = zip(over(0.01, 0.02, 0.025), rival, strict=True)
    choice = Choice(tuple(sheet(pair) for pair in pairs))
    assert choice.answer.right is right
    assert words in reason(choice)
    assert reason(choice).startswith("One default serves 3 scenes: verlet is within the tolerance in 2")
    assert reason(choice).endswith("Not in “A scene”: its error is 2.5 %, 3.1 ms late.")


def test_a_default_outside_of_the_tolerance_is_not_right_however_cheap():
    made = sheet([point("euler", 0.01, 1000.0), point("verlet", 0.03, 10.0)])
    assert not made.answer.right
    assert verdict(made) == "The default, verlet, is outside the tolerance here: its error is 3.0 %."
    nothing = sheet([point("verlet", math.inf, 10.0)])
    assert nothing.answer.cheapest is None
    assert sentence(nothing) == "In this scene no method is within 2 % at a 1 ms step."


class Clock:
    """A clock that stands still but for the work done."""

    def __init__(self):
        self.now = 0
        self.order = []

    def __call__(self):
        return self.now

    def work(self, name, durations):
        """Return what prepares work that takes one duration after the other, the last for ever."""
        left = list(durations)

        def do():
            self.order.append(name)
            self.now += left.pop(0) if len(left) > 1 else left[0]

        def prepare():
            self.now += 1_000_000  # making ready costs, outside of the time
            return do

        return prepare


def test_the_shortest_turns_count_and_candidates_take_turns():
    clock = Clock()
    disturbed = clock.work("a", [90_000, 5000, 700, 80_000, 500, 600])
    steady = clock.work("b", [300])
    assert plan.shortest([disturbed, steady], clock) == [(600, 100), (300, pytest.approx(18))]
    assert clock.order[:8] == ["a", "b", "a", "b", "b", "a", "a", "b"]
    assert len(clock.order) / 2 >= plan.LEAST_TURNS


def test_one_lucky_turn_is_not_believed_until_others_are_as_short():
    """Slow for 60 turns but one: the turns go on until the short time came HITS times."""
    clock = Clock()
    slow = clock.work("a", [1400] * 5 + [1000] + [1400] * 55 + [1010])
    assert plan.shortest([slow, clock.work("b", [900])], clock) == [(1010, 400), (900, pytest.approx(54))]
    assert clock.order.count("a") - 1 == 60 + plan.HITS - 1


@pytest.mark.parametrize(("longer", "equal"), [(1.05, True), (1.07, False)])
def test_costs_that_are_both_believed_within_three_per_cent_may_be_equal(longer, equal):
    clock = Clock()
    works = [clock.work("a", [100_000]), clock.work("b", [round(100_000 * longer)])]
    one, other = (point(ns=ns, ns_spread=spread) for ns, spread in plan.shortest(works, clock))
    assert one.as_cheap(other) == equal


STRANGE = [
    point("verlet", 0.0, 1000.0),
    point("verlet", 1e-3, 2000.0, step_s=5e-4),
    point("rk4", math.inf, 3000.0),
    point("rk4", 2180.0, 500.0, step_s=2e-3),
    point("exact", 3e-16, 8000.0),
]


def test_no_error_stands_on_a_row_of_its_own_inside_the_frame():
    frame = AccuracyAxes(sheet(STRANGE))
    assert frame.has_zero
    cost, bottom = frame.place(STRANGE[0])
    assert cost == 1.0  # µs
    assert frame.bottom < bottom < frame.place(STRANGE[4])[1] == pytest.approx(3e-14)  # %
    assert not AccuracyAxes(sheet(STRANGE[1:])).has_zero


@pytest.mark.slow
def test_a_picture_of_several_sheets(tmp_path):
    sheets = [sheet(STRANGE), sheet([point()], step_s=None), sheet([point("rk4", 0.5)], unit="m/s")]
    path = tmp_path / "chart.png"
    accuracy_figure(accuracy(*sheets, *sheets[:2]), path)
    assert path.stat().st_size > 10_000


@pytest.mark.parametrize(("method", "drawn"), [("", "Verlet, 1 ms"), ("rk4", "RK4, 1 ms")])
def test_a_picture_shows_the_motion_of_a_method_the_defaults_unless_told(monkeypatch, method, drawn):
    keys = {"verlet": "Verlet", "rk4": "RK4"}
    points = [replace(point(key), chart="integrators", scene="damped", label=keys[key]) for key in keys]
    shown = replace(sheet(points), chart="integrators")
    figure = Figure(figsize=(12.0, 14.0), layout="constrained")
    monkeypatch.setattr(charts, "save", lambda paint, *_args, **_more: paint(figure, colors()))
    accuracy_figure(accuracy(shown), "", method)
    axes = figure.subfigs[0].axes
    assert [each.get_ylabel() for each in axes] == ["error / scale, %", "position, mm", "error, %"]
    assert [text.get_text() for text in axes[1].get_legend().get_texts()] == ["true motion", drawn]
