"""On the page *This scene*, errors, Shapley values and recommended rows agree with an independent loop."""

import math
from dataclasses import replace
from functools import cache
from itertools import combinations, permutations

import numpy as np
import pytest
from scipy.linalg import expm

from hapkit_studio import environments
from hapkit_studio.analysis import perception
from hapkit_studio.analysis.accuracy import scene, trials
from hapkit_studio.analysis.accuracy.scene import KNOWN, Ideal, Option, Place, SceneRequest, SceneResult
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.haptics import headless, rows
from tests.analysis.accuracy.reference_loop import Kalman, rendered
from tests.laws.twins import Plain

LIBRARY = environments.discover()
HANDLE = SimulatedHapkit()
PLACES = "computer", "board"


@pytest.mark.parametrize("rate", [1000.0, 2401.0, 900.9])
def test_rows_are_at_whole_milliseconds_for_every_rate(rate):
    """A handle is thrown at 0.5 m/s and decelerated by damping of 0.5 N·s/m and friction of 0.1 N.

    The closed form is valid until the handle stops.
    """
    free = LIBRARY["free"]
    scene = headless.Scene(free, free.values(), HANDLE, LoopSettings(rate))
    found = trials.render(scene, trials.script("released"))
    t, decay, drift = np.arange(len(found)) / perception.RATE, 0.5 / 0.044, 0.1 / 0.5
    stops = math.log((0.5 + drift) / drift) / decay
    t = np.minimum(t, stops)
    wanted = (0.5 + drift) * -np.expm1(-decay * t) / decay - drift * t
    assert len(found) == 1001
    assert np.abs(found[:, rows.TRUE_POSITION] - wanted).max() < 2e-8


@cache
def computed(key):
    return scene.split(scene.compute(SceneRequest(LIBRARY[key], LIBRARY[key].values())))


@pytest.mark.slow
def test_parts_add_up_and_a_lead_of_half_a_step_compensates_a_delay():
    puck, parts = LIBRARY["puck"], []
    for integrator in ("semi_implicit", "exact"):
        question = SceneRequest(puck, puck.values({"integrator": integrator}), "kalman")
        option = Option(
            "computer", question.options, "kalman", "", 1000.0, 1e-3, 0.0, 0.0, 0.0, hand="released"
        )
        ideal = Ideal(question, {"released": 32e3})
        parts.append(ideal.parts(option))
        error = ideal.error(trials.script("released"), option).most
        assert sum(parts[-1]) == pytest.approx(error, abs=1e-9)
    assert parts[0][0] < -0.1
    assert parts[1][0] == 0.0  # the exact method has no error of its own


@pytest.mark.slow
@pytest.mark.parametrize(
    ("integrator", "order"), [("semi_implicit", 1), ("implicit_euler", 1), ("trapezoid", 2)]
)
def test_a_methods_own_error_decreases_by_its_order_at_twice_the_rate(integrator, order):
    mass = LIBRARY["mass_spring_damper"]
    question = SceneRequest(mass, mass.values({"integrator": integrator}), "kalman")
    option = scene.loop_of(question, scene.ON_BOARD, question.options)
    (cycles, error), (twice, smaller) = Ideal(question).own(option)
    assert error / smaller == pytest.approx(2.0**order, rel=0.15)
    assert cycles == pytest.approx(option.cycles)
    # the cycles do not quite double, because the rate of the telemetry is unchanged
    assert 1.7 * cycles < twice < 2.0 * cycles


def test_a_scene_without_methods_has_one_row_per_place_with_the_present_estimator():
    damping = computed("damping")
    assert [(o.place, o.method) for o in damping.options] == [("computer", ""), ("board", "")]
    iir = replace(damping.question, estimator="iir")
    assert not damping.knows(iir)
    now = scene.in_force(iir, damping)
    # with the Kalman filter, the errors would be 1.08 and 0.83
    assert [o.error for o in now] == pytest.approx([1.98, 1.33], abs=0.05)
    assert "velocity estimate: " in damping.reason("computer")
    assert damping.reason("computer").endswith(
        "You can choose a different velocity filter under Loop, for all scenes."
    )


@pytest.mark.parametrize("key", ["damping", "wall"])
def test_a_live_answer_agrees_with_that_of_all_options(key):
    before, values = computed(key), LIBRARY[key].values({"damping": 3.0})
    asked = SceneRequest(LIBRARY[key], values)
    every, live = scene.compute(asked), scene.in_force(asked, before)
    for one, place in zip(live, PLACES, strict=True):
        same = every.in_force(place)
        assert one.error == pytest.approx(same.error, abs=KNOWN)
        assert one.limit == pytest.approx(same.limit, rel=0.03)  # only the cycles are not recomputed


def made_up(*options, stiffness=500.0, place="board"):
    """Return a friction scene with a tether of ``stiffness`` N/m; ``options`` are (error, limit, cycles)."""
    friction = LIBRARY["friction"]
    values = friction.values({"tether_stiffness": stiffness})
    blank = Option(place, (), "kalman", "", 1000.0, 0.0, 1.0, 1.0, 1.0, sense="force", hand="tap")
    found = tuple(
        replace(blank, options=(("model", n),), method=f"M{n}", error=error, limit=limit, cycles=cycles)
        for n, (error, limit, cycles) in enumerate(options)
    )
    question = SceneRequest(friction, values, places=(Place(place, 1000.0),))
    return SceneResult(question, found, {}, 64e3, Ideal(question))


@pytest.mark.parametrize(
    ("options", "best"),
    [
        # the limit must exceed 1.5 × 500 N/m; the error is compared after that
        ([(2.0, 751.0, 3.0), (1.0, 749.0, 1.0), (3.0, 9e9, 1.0)], "M0"),
        # the first two errors are equal, so the cheaper model is selected
        ([(1.00, 900.0, 3.0), (1.04, 900.0, 2.0), (1.06, 900.0, 1.0)], "M1"),
        # no limit is high enough: the least error is selected among the limits within 2 % of the highest
        ([(2.0, 300.0, 1.0), (1.9, 293.0, 1.0), (2.1, 298.0, 1.0)], "M0"),
        ([(2.0, 295.0, 1.0), (9.0, 300.0, 1.0)], "M0"),
        ([(2.0, 293.0, 1.0), (9.0, 300.0, 1.0)], "M1"),
        # the limits are unknown, so only the errors are compared
        ([(2.0, math.nan, 2.0), (1.0, math.nan, 1.0)], "M1"),
    ],
)
def test_the_recommended_option_has_the_least_error_of_the_stable_ones(options, best):
    found = made_up(*options)
    assert found.recommended("board").method == best
    text = found.reason("board")
    assert ("needs a hand or friction" in text) == (options[0][1] < 750.0)


def test_the_answer_and_its_reason_are_stated_as_text():
    """The cases: the rate matters more than the method; an error is below 1 JND; one part cancels another."""
    found = made_up((3.0, 900.0, 1.0), (5.0, 800.0, 1.0))
    best = replace(found.options[0], parts=(2.0, 1.0, 0.0, 0.0, 0.0, 0.0), rate=2000.0)
    truer = replace(found.options[1], parts=(0.1, 4.9, 0.0, 0.0, 0.0, 0.0))
    near = replace(best, error=0.99, parts=(-0.5, 0.19, 0.0, 1.3, 0.0, 0.0))
    unnamed = replace(best, method="", error=1.0, parts=())
    texts = {
        (best, truer): (
            "On the board, use M0 at 2,000 Hz: most people feel that the scene differs from the ideal scene "
            "(3.0 JND). Stiffness without a hand: stable up to 900 N/m.",
            "M1 is more accurate, but on this board it lowers the rate to 1,000 Hz. Your hand feels the "
            "lower rate more than the method's error.",
        ),
        (near,): (
            "On the board, use M0 at 2,000 Hz: the scene feels like the ideal scene. Stiffness without a "
            "hand: stable up to 900 N/m.",
            "The largest part of the error is the velocity estimate: 1.3 JND. You can choose a different "
            "velocity filter under Loop, for all scenes. M0 has an error of the opposite sign, which "
            "cancels 0.50 JND of the total error.",
        ),
        (unnamed,): (
            "On the board at 2,000 Hz: most people feel that the scene differs from the ideal scene (1.0 "
            "JND). Stiffness without a hand: stable up to 900 N/m.",
            "",
        ),
    }
    for options, (answer, reason) in texts.items():
        result = replace(found, options=options)
        assert (result.sentence("board"), result.reason("board")) == (answer, reason)


def test_a_limit_of_zero_is_never_stable():
    """Explicit Euler gains energy in a spring at any stiffness, by a factor of 1 + (h w)² per step."""
    puck = LIBRARY["puck"]
    question = SceneRequest(puck, puck.values({"integrator": "explicit_euler"}), "kalman")
    limit = scene.limit_of(question, question.options, 1000.0, 1e-3, "kalman")
    assert (limit, scene.limit_text(limit)) == (0.0, "never stable")
    assert scene.limit_text(1.0) == "stable up to 1 N/m"


def test_delays_are_shown_as_one_number_or_a_range_per_place():
    one = made_up((1.0, 900.0, 1.0)).options[0]
    options = [replace(one, place=place, delay=s) for place, s in (("computer", 1e-3), ("computer", 1e-3))]
    options += [replace(one, delay=s) for s in (0.3912e-3, 0.1249e-3)]
    assert scene.delay_text(options) == "computer 1 ms, board 0.12 to 0.39 ms"


def scenes(*quick):
    return [pytest.param(key, marks=[] if key in quick else pytest.mark.slow) for key in LIBRARY]


@cache
def ideals(key):
    """Return the rows of an ideal loop in plain Python, for each hand of a scene."""
    q = computed(key).question
    at = q.device, q.environment, q.with_options(q.exact)
    return {trial: rendered(trial, *at) for trial in trials.scripts(q.environment)}


def plain_error(key, option, hands=(), real=scene.PARTS):
    """Return an option's largest error in JND over the hands, computed by the loop in plain Python."""
    q, ideal = computed(key).question, ideals(key)
    values = q.with_options(option.options if "method" in real else q.exact)
    errors = [
        trials.felt(
            q.environment, trial, ideal[trial],
            rendered(trial, q.device, q.environment, values, real, option.rate, option.delay),
        ).most
        for trial in ideal if trial.label in (hands or [t.label for t in ideal])
    ]  # fmt: skip
    return max(errors)


# every noisy count reverses the force of these models, so their vibration differs between runs
CHATTER = "Coulomb", "Karnopp"


@pytest.mark.parametrize("key", scenes("damping"))
def test_the_error_of_every_row_agrees_with_plain_python(key):
    for option in computed(key).options:
        wanted = plain_error(key, option)
        near = {"rel": 0.5} if option.method in CHATTER else {"abs": 0.1, "rel": 0.08}
        assert option.error == pytest.approx(wanted, **near), option.method
        if option.place == "computer":
            assert (option.rate, option.delay) == (1000.0, 1e-3)
        else:
            assert option.cycles <= 0.8 * 16e6


@pytest.mark.parametrize("key", scenes())
def test_the_parts_of_a_recommended_row_agree_with_plain_python(key):
    """A part's value is the mean of the error that it adds, over all orders in which parts become real."""
    found = computed(key)
    for place in PLACES:
        best = found.recommended(place)
        if best.error < 0.1:
            continue
        free = [part for part in scene.PARTS if part != "method" or found.question.choices]
        worth = {
            real: plain_error(key, best, (best.hand,), real)
            for size in range(len(free) + 1) for real in map(frozenset, combinations(free, size))
        }  # fmt: skip
        wanted = dict.fromkeys(scene.PARTS, 0.0)
        for order in permutations(free):
            for k, part in enumerate(order):
                wanted[part] += worth[frozenset(order[: k + 1])] - worth[frozenset(order[:k])]
        means = [gain / math.factorial(len(free)) for gain in wanted.values()]
        assert best.parts == pytest.approx(means, abs=0.1 + 0.03 * best.error)


# positions in m of handle and object while they are in contact
OBJECTS = {"puck": (0.038, 0.040), "mass_spring_damper": (0.014, 0.012)}


def grows(q, option, stiffness):
    """Return True if handle, law and loop in contact have a root outside the unit circle.

    Each column of the matrix is the result of perturbing one state for one period of the law in plain Python.
    """
    environment, values = q.environment, {**q.with_options(option.options), "contact_stiffness": stiffness}
    # other laws are replaced by a spring with the damping of the scene's exact method
    if environment.key not in OBJECTS:
        damping = environment.impedance(q.with_options(q.exact))[1] if environment.impedance else 0.0
        environment, values = LIBRARY["spring"], {"center": 0.0, "stiffness": stiffness, "damping": damping}
    place, middle = OBJECTS.get(environment.key, (0.0, 0.0))
    begin = {"object": middle, "side": 1.0, "started": 1.0, "handle": place}
    begin = [begin.get(name, 0.0) for name in environment.state_names]
    period, whole = 1.0 / option.rate, int(option.delay * option.rate + 1e-9)
    a = np.array([[0.0, 1.0, 0.0], [0.0, -0.5 / 0.044, 1.0 / 0.044], [0.0, 0.0, 0.0]])
    first, second = expm(a * (option.delay - whole * period)), expm(a * ((whole + 1) * period - option.delay))
    law, kalman = Plain(environment.force, values, period), Kalman(period, 20.7e-6)

    def after(state):
        x, v, kalman.place, kalman.speed, *rest = state
        law.set_state(rest[: len(begin)])
        commands = [law.call(x, kalman(x)), *rest[len(begin) :]]
        x, v, _ = second @ [*(first @ [x, v, commands[whole + 1]])[:2], commands[whole]]
        return np.array([x, v, kalman.place, kalman.speed, *law.state, *commands[: whole + 1]])

    base = np.array([place, 0.0, place, 0.0, *begin, *[0.0] * (whole + 1)])
    flags = [4 + n for n, name in enumerate(environment.state_names) if name in ("side", "started")]
    moved = np.setdiff1d(np.arange(len(base)), flags)
    columns = np.column_stack(
        [(after(base + 1e-5 * unit) - after(base)) / 1e-5 for unit in np.eye(len(base))]
    )
    return np.abs(np.linalg.eigvals(columns[np.ix_(moved, moved)])).max() > 1.0 + 1e-7


@pytest.mark.parametrize("key", scenes("wall"))
def test_every_row_grows_just_above_its_stiffness_limit_and_not_below(key):
    for option in computed(key).options:
        if option.limit == 0.0:
            assert grows(computed(key).question, option, 1.0)
        else:
            found = [grows(computed(key).question, option, share * option.limit) for share in (0.99, 1.01)]
            assert found == [False, True], option.method


def ruled(options, stiffness):
    """Return the option that the rule in how-it-works.md recommends."""
    admissible = [o for o in options if o.limit >= 1.5 * stiffness or not stiffness]
    if not admissible:
        admissible = [o for o in options if o.limit >= 0.98 * max(p.limit for p in options)]
    return min(admissible, key=lambda o: o.error)


@pytest.mark.parametrize("key", scenes("spring", "wall"))
def test_the_recommended_row_is_the_default_with_the_least_error_of_all_admissible_ones(key):
    usual = computed(key)
    # this is the initial state of the window
    at_once = replace(usual.question, places=(Place("computer", 1000.0, 0.0),))
    for place, found in zip((*PLACES, "computer"), (usual, usual, scene.compute(at_once)), strict=True):
        best = found.recommended(place)
        assert best is ruled(found.at(place), found.question.stiffness)
        assert best is found.default(place)


@pytest.mark.slow
@pytest.mark.parametrize("key", scenes("spring"))
def test_ten_answers_are_identical(key):
    question = SceneRequest(LIBRARY[key], LIBRARY[key].values())
    answers = {repr(scene.compute(question).options) for _ in range(10)}
    assert len(answers) == 1
