"""Tests of work-precision charts: Pareto front, order of convergence, best methods, costs and figures."""

import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure

from hapkit_studio.analysis import accuracy
from hapkit_studio.analysis.accuracy import plan
from hapkit_studio.analysis.accuracy.plan import Point, Scene, Sheet, front
from hapkit_studio.charts.accuracy import draw_methods
from hapkit_studio.charts.style import colors
from hapkit_studio.cli import main
from hapkit_studio.haptics.board_plan import frames
from hapkit_studio.laws import board, machine


def point(method="verlet", error=0.01, ns=1000.0, step_s=1e-3, cycles=math.nan, **more):
    return Point(method, method.capitalize(), step_s, error, cycles, ns, **more)


def sheet(points, chart="servo", scene="contact", **more):
    made = Scene(scene, "A scene", "error / scale", 0.02, plan.FELT, **more)
    return Sheet(chart, made, {p.method: p.method.capitalize() for p in points}, tuple(points))


# there are few different values, so that equal errors, equal costs and equal points are frequent
NUMBERS = st.sampled_from([0.0, 1e-15, 1e-3, 0.01, 0.02, 1.0, math.inf])
COSTS = st.sampled_from([1.0, 2.0, 2.5, 40.0, math.nan])


@settings(max_examples=50)
@given(st.lists(st.tuples(NUMBERS, COSTS), max_size=12), st.booleans())
def test_the_front_contains_every_point_that_is_not_dominated(found, on_board):
    points = [point(error=e, ns=1.0 if on_board else c, cycles=c, spread=9.0) for e, c in found]
    best = front(points, on_board)
    for p, (error, cost) in zip(points, found, strict=True):
        better = [q for q in found if q[0] <= error and q[1] <= cost and q != (error, cost)]
        assert (p in best) == (math.isfinite(error + cost) and not better)
    errors = [p.error for p in best]
    assert errors == sorted(errors, reverse=True)  # errors decrease while costs increase


@pytest.mark.parametrize("order", [1.0, 2.0, 4.0])
def test_the_order_is_the_exponent_of_the_step(order):
    steps = (4e-3, 2e-3, 1e-3, 0.5e-3)
    points = [point(error=0.05 * (h / 4e-3) ** order, step_s=h) for h in steps]
    assert sheet(points).order("verlet") == pytest.approx(order)
    uneven = [point(error=e, step_s=h) for e, h in zip((0.01, 0.09, 0.001), steps, strict=False)]
    assert math.isnan(sheet(uneven).order("verlet"))


def test_winners_are_the_cheapest_points_within_each_tolerance_and_those_of_equal_cost():
    euler, fine = point("euler", 0.05, 100.0), point("rk4", 1e-6, 900.0, cycles=5e6)
    verlet = point("verlet", 0.005, 500.0, spread=20.0, cycles=3e6)
    near = point("exact", 0.0, 515.0)
    made = sheet([euler, fine, verlet, near])
    found = [[p.method for p in made.winners(t)] for t in plan.TOLERANCES]
    assert found == [["euler"], ["verlet", "exact"], ["exact"], ["exact"]]
    assert [p.method for p in made.winners(1e-3, board=True)] == ["rk4"]
    assert made.sentence() == (
        "The cheapest method with an error within 2 % is Verlet: 0.50 µs per simulated second. "
        "1 more costs the same."
    )
    assert sheet([point("verlet", math.inf, 10.0)]).sentence() == "No method has an error within 2 %."


@pytest.mark.parametrize("rate", [500.0, 1000.0])
def test_the_boards_cycles_per_second_equal_the_compiled_laws(rate):
    from hapkit_studio import environments

    friction = environments.named("friction")
    values = friction.values({"model": "tether"})
    program = board.compile(friction.force, values, 1.0 / rate, machine.ARENA)
    law = machine.mean_cycles(program.code, program.slots, program.given)[0]
    found = plan.board_cycles("friction", "model", "tether", rate)
    # the friction law reads the velocity, so the estimator's cycles are added
    rest = machine.REST + machine.ESTIMATE
    assert found == pytest.approx(rate * (law + rest) + frames(rate) * machine.FRAME, rel=1e-3)


@pytest.mark.slow
def test_a_method_that_does_not_fit_the_board_has_no_cycles():
    assert math.isnan(plan.board_cycles("mass_spring_damper", "integrator", "exact", 1000.0))


def test_the_shortest_runs_count_and_candidates_alternate():
    now, order = [0], []

    def works(name, durations):
        left = list(durations)

        def do():
            order.append(name)
            now[0] += left.pop(0) if len(left) > 1 else left[0]

        def prepare():
            now[0] += 1_000_000  # the preparation advances the clock, but must not be timed
            return do

        return prepare

    candidates = [works("a", [90_000, 5000, 700, 80_000, 500, 600]), works("b", [300])]
    assert plan.shortest(candidates, lambda: now[0]) == [(600, 100), (300, pytest.approx(18))]
    assert order[:8] == ["a", "b", "a", "b", "b", "a", "a", "b"]
    assert len(order) / 2 >= plan.LEAST_TURNS


def test_every_error_is_drawn_inside_the_axes():
    """The axes are in µs and in %."""
    figure, strange = Figure(), [("verlet", 0.0, 1000.0), ("rk4", math.inf, 3000.0), ("exact", 3e-15, 8000.0)]
    draw_methods(figure, colors(), sheet([point(*each) for each in strange]))
    (axes,), places = figure.axes, [bar.lines[0].get_xydata()[0] for bar in figure.axes[0].containers]
    assert (places[0][0], places[2][1]) == pytest.approx((1.0, 3e-13))
    assert all(axes.viewLim.contains(*place) for place in places)


@pytest.mark.slow
def test_the_orders_of_the_integrators_agree_with_theory():
    found = accuracy.of_methods(["integrators"]).sheets[0]
    orders = {"explicit_euler": 1.0, "lecture": 1.0, "semi_implicit": 1.0, "verlet": 2.0, "rk4": 4.0}
    assert {key: found.order(key) for key in orders} == pytest.approx(orders, abs=0.03)


@pytest.mark.slow
def test_json_and_pictures_of_methods_and_of_a_scene(capsys, tmp_path):
    picture = str(tmp_path / "chart.png")
    args = ["--methods", "servo", "contact", "--json", "--plot", picture, "--board"]
    assert main(["accuracy", *args]) == 0
    found, *others = json.loads(capsys.readouterr().out)["methods"]
    assert len(found["rows"]) == 14
    # these methods do not run on the board, so they have no cycles
    assert not any(row["cycles"] for sheet in others for row in sheet["rows"])
    assert {"cycles", "ns"} <= set(found["rows"][0])
    assert found["orders"]["prompt"] == pytest.approx(1.0, abs=0.05)
    # "chain" is the former name of the command
    assert main(["chain", "friction", "-p", "viscous=2", "--json", "--plot", picture]) == 0
    (scene,) = json.loads(capsys.readouterr().out)["scenes"]
    assert scene["values"]["viscous"] == 2.0
    for place in ("computer", "board"):
        best = scene["answers"][place]["recommended"]
        assert sum(best["parts"].values()) == pytest.approx(best["error"])
        assert all(unit in scene["answers"][place]["answer"] for unit in (" Hz", " N/m"))


def test_parameters_require_a_single_scene(capsys):
    assert main(["accuracy", "spring", "wall", "-p", "stiffness=3"]) != 0
    assert "Parameters belong to one environment" in capsys.readouterr().err
    assert main(["accuracy", "wall", "--needs", "-p", "stiffness=400"]) == 2
    assert "--needs takes each scene's default parameters" in capsys.readouterr().err
