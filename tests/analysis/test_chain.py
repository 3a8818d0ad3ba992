"""Which way to render a scene: cost, rate and limit computed independently, the rule at its edges, words."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio import environments
from hapkit_studio.analysis import chain
from hapkit_studio.analysis.chain import ON_BOARD, ON_COMPUTER, Candidate, Chain, Place, Question
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability.objects import contact_limit
from hapkit_studio.cli import main
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics.board_plan import RATES
from hapkit_studio.laws import board, machine

HANDLE = SimulatedHapkit()
PLACES = ON_COMPUTER, ON_BOARD


def question(key, places=PLACES, estimator="kalman", **values):
    scene = environments.named(key)
    return Question(scene, scene.values(values), estimator, places)


def made_up(place, limit, error, work=100.0, option=0.0, parts=None, rate=1000.0):
    options = (("model", option),)
    numbers = (work, 0.0, work, 2000.0, rate, 1e-3, limit, error)
    return Candidate(place, options, "kalman", f"Model {option:g}", *numbers, "force", "tap", parts or {})


@pytest.mark.parametrize("integrator", ["semi_implicit", "verlet", "rk4"])
def test_cycles_rate_and_delay_are_those_of_the_counted_program(integrator):
    asked = question("mass_spring_damper", (ON_BOARD,), integrator=integrator)
    (found,) = chain.in_force(asked)
    program = board.compile(asked.environment.force, asked.values, 1.0 / found.rate, machine.ARENA)
    cycles = machine.mean_cycles(program.code, program.slots, program.given)[0]
    assert found.cost == cycles
    rest = machine.REST + machine.ESTIMATE  # its damping reads the velocity
    rates = [2e6 / round(2e6 / rate) for rate in RATES]  # periods of whole half microseconds
    frames = [rate / math.ceil(rate / 1000.0 - 1e-9) for rate in rates]
    spent = [r * (cycles + rest) + f * machine.FRAME for r, f in zip(rates, frames, strict=True)]
    fits = [16e6 / rate >= program.most + machine.REST_AT_MOST for rate in rates]
    possible = [rate for rate, c, ok in zip(rates, spent, fits, strict=True) if c <= 0.8 * 16e6 and ok]
    assert found.rate == pytest.approx(max(possible))
    assert found.delay == pytest.approx((cycles + machine.REST_AT_MOST) / 16e6)


@pytest.mark.parametrize("key", ["spring", "damping", "friction"])
@pytest.mark.parametrize("estimator", ["difference", "kalman"])
def test_the_limit_is_that_of_the_loop_at_this_rate_and_delay(key, estimator):
    asked = question(key, estimator=estimator)
    damping = asked.environment.impedance(asked.values)[1]
    for found in chain.in_force(asked):
        limit = hs.stiffness_limit(
            HANDLE.mass, HANDLE.viscous, damping=damping, rate=found.rate, delay=found.delay,
            estimator=estimator, quantum=HANDLE.quantum,
        )  # fmt: skip
        assert found.limit == pytest.approx(limit, rel=1e-6)


def test_with_an_object_the_limit_is_that_of_both_pressed_together():
    """It lies below that of a wall, which gives way to nothing."""
    (found,) = chain.in_force(question("puck", (Place("computer", 1000.0, 0.4e-3),)))
    setting = Setting(delay=0.4e-3, estimator="kalman")
    assert found.limit == pytest.approx(contact_limit(setting, "puck", environments.named("puck").values()))
    assert found.limit < hs.stiffness_limit(HANDLE.mass, HANDLE.viscous, delay=0.4e-3, rate=1000.0)


def test_a_computer_answers_a_period_late_or_as_measured():
    late, measured = (
        chain.in_force(question("spring", (Place("computer", 1000.0, delay),)))[0] for delay in (None, 0.2e-3)
    )
    assert (late.delay, measured.delay) == (1e-3, 0.2e-3)
    # a handle without rendered damping: about b / (T / 2 + delay)
    assert late.limit == pytest.approx(0.5 / 1.5e-3, rel=0.01)
    assert measured.limit == pytest.approx(0.5 / 0.7e-3, rel=0.01)


def test_the_front_is_what_nothing_beats_by_brute_force():
    rng = np.random.default_rng(16)
    some = [made_up("board", *rng.uniform(1.0, 9.0, 2).round(), option=float(n)) for n in range(60)]
    some.append(made_up("board", math.nan, 0.0))
    for one in chain._marked(some):
        better = [
            o for o in some
            if o.limit >= one.limit and o.error <= one.error and (o.limit, o.error) != (one.limit, one.error)
        ]  # fmt: skip
        assert one.pareto == (not better and not math.isnan(one.limit)), one


def chosen(*candidates):
    """Return what is recommended in the friction scene, whose tether has 500 N/m."""
    return answered(*candidates).recommendation("board")


def answered(*candidates):
    return Chain(question("friction"), candidates, {"A": "A needs 900 bytes, the board has 768."})


@pytest.mark.parametrize(("margin", "best"), [(1.49, 0.0), (1.51, 1.0)])
def test_only_a_limit_of_half_as_much_again_as_the_scene_s_stiffness_is_enough(margin, best):
    sure, close = made_up("board", 900.0, 3.0), made_up("board", margin * 500.0, 2.0, option=1.0)
    found = chosen(sure, close)
    assert found.margin
    assert found.best.options == (("model", best),)


@pytest.mark.parametrize(("more", "best"), [(0.04, 1.0), (0.06, 0.0)])
def test_of_equal_errors_the_law_of_fewest_cycles_is_recommended(more, best):
    """An error that is 0.05 JND larger is equal."""
    dear, cheap = made_up("board", 900.0, 1.0, 200.0), made_up("board", 900.0, 1.0 + more, 100.0, 1.0)
    assert chosen(dear, cheap).best.options == (("model", best),)


@pytest.mark.parametrize(("share", "best"), [(0.94, 0.0), (0.96, 1.0)])
def test_without_margin_the_least_error_of_those_nearly_as_stiff_as_the_stiffest(share, best):
    stiffest, softer = made_up("board", 300.0, 3.0), made_up("board", share * 300.0, 2.0, option=1.0)
    found = chosen(stiffest, softer)
    assert not found.margin
    assert found.best.options == (("model", best),)


def test_the_recommended_one_by_the_definition_for_candidates_drawn_by_lot():
    rng = np.random.default_rng(27)
    for _ in range(300):
        some = [
            made_up("board", *rng.uniform((100.0, 0.0), (1200.0, 0.5)), float(rng.integers(1, 4)), float(n))
            for n in range(rng.integers(1, 7))
        ]
        enough = [c for c in some if c.limit >= 750.0]
        stiff = [c for c in some if c.limit >= 0.95 * max(c.limit for c in some)]
        least = min(c.error for c in enough or stiff)
        tied = [c for c in enough or stiff if c.error <= least + 0.05]
        found = chosen(*some)
        assert found.margin == bool(enough)
        assert found.best in tied
        assert found.best.work == min(c.work for c in tied)


def test_a_limit_that_is_unknown_is_no_reason_to_recommend():
    known, unknown = made_up("board", 900.0, 2.0), made_up("board", math.nan, 1.0, option=1.0)
    assert chosen(known, unknown).best is known
    assert chosen(unknown).best is unknown


def test_the_recommendation_in_words():
    best = made_up("board", 900.0, 3.2, 100.0, 0.0, {"method": -0.24, "rate": 2.0}, 2000.0)
    slow = made_up("board", 600.0, 4.9, 100.0, 1.0, {"method": 0.0, "rate": 4.9}, 1500.0)
    first, why = answered(best, slow).sentences("board")
    assert first == "On the board, Model 0 at 2,000 Hz: 3.2 JND from the friction itself, up to 900 N/m."
    assert why == (
        "Model 1 is the more accurate method, but renders at 1,500 Hz here, and the rate matters more to "
        "your hand."
    )
    as_fast = replace(slow, rate=2000.0, limit=900.0)
    assert answered(best, as_fast).sentences("board")[1] == (
        "Model 1 is the more accurate method, but 4.9 JND off in all: Model 0's own error makes up for part "
        "of the rate's."
    )
    assert answered(best).sentences("board")[1] == "Most of the error is the rate: 2.0 JND."
    soft = replace(best, limit=300.0)
    assert answered(soft).sentences("board")[1].startswith("No method is stiff enough here for a contact of")
    near = replace(best, limit=600.0)
    assert answered(near).sentences("board")[1].startswith("No method's stiffness limit is 1.5 times the 500")
    unfelt = answered(replace(best, error=0.9)).sentences("board")[0]
    assert (
        unfelt
        == "On the board, Model 0 at 2,000 Hz: no hand tells it from the friction itself, up to 900 N/m."
    )
    assert answered().sentences("board")[0] == "A needs 900 bytes, the board has 768."


@pytest.mark.slow
@pytest.mark.parametrize("key", ["friction", "mass_spring_damper", "puck"])
def test_ten_answers_are_the_same_and_are_the_scene_s_default(key):
    """The board's cycles are counted, and differ in no answer; the computer's times differ in each."""
    for places in (PLACES, *9 * [(ON_COMPUTER,)]):
        chain._TICKS.clear()
        found = chain.compute(question(key, places), parts=False)
        for place in places:
            best = found.recommendation(place.name).best
            assert best is found.default(place.name), best.name


@pytest.mark.slow
def test_tables_one_object_and_a_picture(capsys, tmp_path):
    picture = tmp_path / "chain.png"
    words = ["speed-accuracy", "friction", "-p", "viscous=2", "--plot", str(picture), "--json"]
    assert main(words) == 0
    (scene,) = json.loads(capsys.readouterr().out)["scenes"]
    assert scene["values"]["viscous"] == 2.0
    split = [row for row in scene["rows"] if row["parts"]]
    assert len(split) == 2 * 7
    assert all(sum(row["parts"].values()) == pytest.approx(row["error"], abs=1e-9) for row in split)
    assert " JND" in scene["recommendations"]["board"]["sentences"][0] or "no hand" in str(scene)
    assert all(("cycles" in row) == (row["place"] == "board") for row in scene["rows"])
    assert picture.read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize("name", ["speed-accuracy", "chain"])
def test_parameters_are_of_one_scene(capsys, name):
    assert main([name, "spring", "wall", "-p", "stiffness=3"]) != 0
    assert "Parameters are of one environment" in capsys.readouterr().err
