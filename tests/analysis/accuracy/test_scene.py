"""This scene: errors against an independent loop, Shapley values by permutations, the rule, every scene."""

import math
from dataclasses import replace
from functools import cache
from itertools import permutations

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio import environments
from hapkit_studio.analysis import perception
from hapkit_studio.analysis.accuracy import scene, trials
from hapkit_studio.analysis.accuracy.scene import KNOWN, Ideal, Option, Place, Question, SceneResult
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability.objects import contact_limit
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import Hand
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.board_plan import BoardPlanner
from hapkit_studio.haptics.settings import LoopSettings
from hapkit_studio.laws.machine import ARENA

LIBRARY = environments.discover()
HANDLE = SimulatedHapkit()
FINE = 32_000  # Hz of the plain loop's own steps
PLACES = "computer", "board"


class Object:
    """The puck, or the mass: moves by a step of a method, the handle held, and then pushes the handle."""

    def __init__(self, verlet, place=0.010, mass=0.5, spring=0.0, damping=0.0, radius=0.005, reach=0.035):
        self.verlet, self.place, self.mass, self.spring, self.damping = verlet, place, mass, spring, damping
        self.radius, self.reach, self.x, self.v, self.handle, self.side = radius, reach, place, 0.0, 0.0, 1.0

    def push(self):
        return 500.0 * self.side * max(0.0, self.side * (self.handle - self.x) + self.radius)

    def acceleration(self):
        beyond = math.copysign(max(abs(self.x) - self.reach, 0.0), self.x)
        pulled = self.spring * (self.x - self.place) + self.damping * self.v + 500.0 * beyond
        return (self.push() - pulled) / self.mass

    def __call__(self, handle, dt):
        now = self.acceleration()
        if self.verlet:
            self.x += dt * self.v + 0.5 * dt * dt * now
            self.v += 0.5 * dt * (now + self.acceleration())
        else:
            self.v += dt * now
            self.x += dt * self.v
        self.handle = handle
        if self.radius and abs(handle - self.x) >= self.radius:
            self.side = 1.0 if handle < self.x else -1.0
        return -self.push()


LAWS = {
    "puck": Object,
    "mass_spring_damper": lambda verlet: Object(verlet, 0.010, 2.0, 300.0, 1.0, 0.0, math.inf),
    "wall": lambda _verlet: lambda x, dt: -250.0 * max(x - 0.005, 0.0),
    "spring": lambda _verlet: lambda x, dt: -80.0 * x,
}


def in_plain_python(trial, law, rate=None, delay=0.0):
    """Return rows at perception.RATE of a law(handle, dt); without a rate everything is continuous.

    The handle moves by steps of 1 / FINE: half a step, the force where it is then, half a step.
    """
    grip = trial.hand if trial.hand.release > 0.0 else Hand()
    mass, damping, h = HANDLE.mass + grip.mass, HANDLE.damping + grip.damping, 1.0 / FINE
    t = np.arange(round(trial.seconds * FINE) + 1) * h
    target = grip.target(t)
    pull = grip.stiffness * grip.target(t + 0.5 * h) + grip.damping * np.gradient(grip.target(t + 0.5 * h), h)
    dry, loss = HANDLE.coulomb_force / mass * h, 0.5 * h * damping / mass
    x, v, motor, pending, motion = 0.0, trial.thrown, 0.0, [], []
    for n, tug in enumerate(pull):
        motion.append((x, v))
        if rate is None:
            motor = law(x + 0.5 * h * v, h)
        elif n % round(FINE / rate) == 0:
            asked = law(HANDLE.quantum * (x // HANDLE.quantum), 1.0 / rate)
            pending.append((n + round(delay * FINE), min(max(asked, -HANDLE.max_force), HANDLE.max_force)))
        while pending and pending[0][0] <= n:
            motor = pending.pop(0)[1]
        x += 0.5 * h * v
        w = (v * (1.0 - loss) + h * (tug - grip.stiffness * x + motor) / mass) / (1.0 + loss)
        v = math.copysign(max(abs(w) - dry, 0.0), w)
        x += 0.5 * h * v
    every = FINE // round(perception.RATE)
    place, speed = np.array(motion[::every]).T
    found, moved = np.zeros((len(place), rows.ROW_WIDTH)), np.gradient(target, h)[::every]
    found[:, rows.TRUE_POSITION] = place
    found[:, rows.HAND_FORCE] = grip.stiffness * (target[::every] - place) + grip.damping * (moved - speed)
    return found


@pytest.mark.parametrize(
    ("key", "hand"),
    [("puck", "tap"), ("puck", "shake"), ("puck", "released"), ("mass_spring_damper", "tap"),
     ("mass_spring_damper", "released"), ("wall", "tap"), ("wall", "released"), ("spring", "released")],
)  # fmt: skip
@pytest.mark.parametrize(("verlet", "rate", "late"), [(False, 2000.0, 9), (True, 1000.0, 12)])
def test_the_error_is_that_of_a_loop_in_plain_python(key, hand, verlet, rate, late):
    """A low rate counts, and the ideal has no loop: no sample, no delay, no sensor step."""
    trial, law, values = trials.script(hand), LAWS[key], LIBRARY[key].values()
    if "integrator" in values:
        values = LIBRARY[key].values({"integrator": "verlet" if verlet else "semi_implicit"})
    question = Question(LIBRARY[key], values, "kalman")
    option = Option("board", question.options, "kalman", "", rate, late / FINE, math.nan, math.nan, math.nan)
    plain = in_plain_python(trial, law(True)), in_plain_python(trial, law(verlet), rate, late / FINE)
    wanted = perception.difference_under(trial.hand, *plain).most
    assert Ideal(question).error(trial, option).most == pytest.approx(wanted, abs=0.1)


@pytest.mark.parametrize("rate", [1000.0, 2401.0, 900.9])
def test_rows_lie_on_whole_milliseconds_whatever_the_rate(rate):
    """A handle thrown with 0.5 m/s, slowed by 0.5 N·s/m and 0.1 N: in closed form until it stops."""
    free = LIBRARY["free"]
    scene = headless.Scene(free, free.values(), HANDLE, LoopSettings(rate))
    found = trials.render(scene, trials.script("released"))
    t, decay, drift = np.arange(len(found)) / perception.RATE, 0.5 / 0.044, 0.1 / 0.5
    stops = math.log((0.5 + drift) / drift) / decay
    t = np.minimum(t, stops)
    wanted = (0.5 + drift) * -np.expm1(-decay * t) / decay - drift * t
    assert len(found) == 1001
    assert np.abs(found[:, rows.TRUE_POSITION] - wanted).max() < 2e-8


def test_every_part_is_its_mean_effect_over_all_orders():
    rng = np.random.default_rng(27)
    players = list("abcd")
    value = {
        frozenset(p for k, p in enumerate(players) if at >> k & 1): float(rng.normal()) for at in range(16)
    }
    gains = {p: [] for p in players}
    for order in permutations(players):
        for k, p in enumerate(order):
            gains[p].append(value[frozenset(order[: k + 1])] - value[frozenset(order[:k])])
    found = scene.shapley(value, players)
    assert found == pytest.approx({p: np.mean(g) for p, g in gains.items()})


@cache
def computed(key):
    return scene.split(scene.compute(Question(LIBRARY[key], LIBRARY[key].values())))


def test_parts_add_up_and_a_lead_of_half_a_step_makes_up_for_delay():
    puck, parts = LIBRARY["puck"], []
    for integrator in ("semi_implicit", "exact"):
        question = Question(puck, puck.values({"integrator": integrator}), "kalman")
        option = Option(
            "computer", question.options, "kalman", "", 1000.0, 1e-3, 0.0, 0.0, 0.0, hand="released"
        )
        ideal = Ideal(question, {"released": 32e3})
        parts.append(ideal.parts(option))
        error = ideal.error(trials.script("released"), option).most
        assert sum(parts[-1]) == pytest.approx(error, abs=1e-9)
    assert parts[0][0] < -0.1
    assert parts[1][0] == 0.0  # the exact method has no error of its own


@pytest.mark.parametrize(
    ("integrator", "order"), [("semi_implicit", 1), ("implicit_euler", 1), ("trapezoid", 2)]
)
def test_a_methods_own_error_falls_by_its_order_when_the_rate_doubles(integrator, order):
    mass = LIBRARY["mass_spring_damper"]
    question = Question(mass, mass.values({"integrator": integrator}), "kalman")
    option = scene.loop_of(question, (scene.ON_BOARD, question.options, "kalman"), BoardPlanner(ARENA))
    (cycles, error), (twice, smaller) = Ideal(question).own(option)
    assert error / smaller == pytest.approx(2.0**order, rel=0.15)
    assert cycles == pytest.approx(option.cycles)
    assert 1.7 * cycles < twice < 2.0 * cycles  # telemetry stays as it is


def test_a_scene_without_methods_offers_the_estimators_if_its_law_has_a_velocity():
    damping, wall = (
        scene.compute(Question(LIBRARY[key], LIBRARY[key].values())) for key in ("damping", "wall")
    )
    assert [o.method for o in damping.at("board")] == ["Difference", "IIR", "Kalman"]
    assert len(damping.at("computer")) == 5
    assert damping.default("board") is damping.in_force("board") is damping.at("board")[-1]
    assert [(o.place, o.method) for o in wall.options] == [("computer", ""), ("board", "")]
    iir = replace(damping.question, estimator="iir")
    assert damping.knows(iir)
    assert replace(damping, question=iir).in_force("board").method == "IIR"
    assert not computed("spring").knows(replace(computed("spring").question, values={"stiffness": 1.0}))


@pytest.mark.parametrize("key", ["damping", "wall"])
def test_a_live_answer_is_that_of_all_options(key):
    before, values = computed(key), LIBRARY[key].values({"damping": 3.0})
    asked = Question(LIBRARY[key], values)
    every, live = scene.compute(asked), scene.in_force(asked, before)
    for one, place in zip(live, PLACES, strict=True):
        same = every.in_force(place)
        assert one.error == pytest.approx(same.error, abs=KNOWN)
        assert one.limit == pytest.approx(same.limit, rel=0.03)  # cycles are those of before


def made_up(*options, stiffness=500.0, place="board"):
    """Return a friction scene with a tether of so many N/m, whose models have (error, limit, cycles)."""
    friction = LIBRARY["friction"]
    values = friction.values({"tether_stiffness": stiffness})
    blank = Option(place, (), "kalman", "", 1000.0, 0.0, 1.0, 1.0, 1.0, sense="force", hand="tap")
    found = tuple(
        replace(blank, options=(("model", n),), method=f"M{n}", error=error, limit=limit, cycles=cycles)
        for n, (error, limit, cycles) in enumerate(options)
    )
    question = Question(friction, values, places=(Place(place, 1000.0),))
    return SceneResult(question, found, {}, 64e3, Ideal(question))


@pytest.mark.parametrize(
    ("options", "best"),
    [
        ([(2.0, 751.0, 3.0), (1.0, 749.0, 1.0), (3.0, 9e9, 1.0)], "M0"),  # 1.5 × 500 N/m, then the error
        ([(1.00, 900.0, 3.0), (1.04, 900.0, 2.0), (1.06, 900.0, 1.0)], "M1"),  # equal errors: the cheapest
        ([(2.0, 300.0, 1.0), (1.9, 296.0, 1.0), (2.1, 298.0, 1.0)], "M0"),  # none: 1 % of the stiffest
        ([(2.0, 300.0, 1.0), (4.1, 310.0, 1.0)], "M0"),  # stiffer, but with more than twice the error
        ([(2.0, math.nan, 2.0), (1.0, math.nan, 1.0)], "M1"),  # no limit known
        ([(1.0, math.nan, 1.0), (2.0, 300.0, 1.0)], "M1"),  # a known limit goes first
    ],
)
def test_the_least_error_of_those_that_hold_the_scene(options, best):
    found = made_up(*options)
    assert found.recommended("board").method == best
    said = found.reason("board")
    assert ("needs a hand or friction" in said) == (not options[0][1] >= 750.0)


def test_the_rate_may_outweigh_the_method_and_the_answer_says_so():
    found = made_up((3.0, 900.0, 1.0), (5.0, 800.0, 1.0))
    best, truer = found.options
    best = replace(best, parts=(2.0, 1.0, 0.0, 0.0, 0.0, 0.0), rate=2000.0)
    truer = replace(truer, parts=(0.1, 4.9, 0.0, 0.0, 0.0, 0.0))
    found = replace(found, options=(best, truer))
    said = "M1 is the more accurate method, but on this board it lowers the rate to 1,000 Hz, and the rate "
    assert found.reason("board") == f"{said}matters more to your hand."
    said = "On the board, use M0 at 2,000 Hz: 3.0 JND from the ideal scene, stable up to 900 N/m."
    assert found.sentence("board") == said


def test_an_answer_below_one_jnd_feels_like_the_ideal_and_a_lead_cancels_a_part():
    found = made_up((0.99, 900.0, 1.0))
    said = "On the board, use M0 at 1,000 Hz: feels like the ideal scene, stable up to 900 N/m."
    assert found.sentence("board") == said
    unnamed = replace(found, options=(replace(found.options[0], method="", error=1.0),))
    said = "On the board at 1,000 Hz: 1.0 JND from the ideal scene, stable up to 900 N/m."
    assert unnamed.sentence("board") == said
    split = replace(found.options[0], parts=(-0.5, 0.19, 0.0, 1.3, 0.0, 0.0))
    said = "Largest part: velocity estimate, 1.3 JND. M0 has an error that cancels 0.50 JND of the total."
    assert replace(found, options=(split,)).reason("board") == said


def test_each_closer_method_of_unknown_limit_is_a_sentence():
    found = made_up((2.0, 900.0, 1.0), (1.0, math.nan, 1.0), (1.5, math.nan, 1.0))
    closer = "M{} is closer, but its stiffness limit is not known."
    assert found.reason("board") == f"{closer.format(1)} {closer.format(2)}"


def test_a_limit_of_zero_is_never_stable():
    """Explicit Euler gains energy in a spring at any stiffness: 1 + (h w)² a step."""
    puck = LIBRARY["puck"]
    question = Question(puck, puck.values({"integrator": "explicit_euler"}), "kalman")
    limit = scene.limit_of(question, question.options, 1000.0, 1e-3, "kalman")
    assert (limit, scene.limit_words(limit)) == (0.0, "never stable")
    assert scene.limit_words(1.0) == "stable up to 1 N/m"


def test_delays_are_one_number_or_a_range_a_place():
    one = made_up((1.0, 900.0, 1.0)).options[0]
    options = [replace(one, place=place, delay=s) for place, s in (("computer", 1e-3), ("computer", 1e-3))]
    options += [replace(one, delay=s) for s in (0.3912e-3, 0.1249e-3)]
    assert scene.delay_words(options) == "computer 1 ms, board 0.12 to 0.39 ms"


def scenes(*quick):
    return [pytest.param(key, marks=[] if key in quick else pytest.mark.slow) for key in LIBRARY]


def limit_of(question, option):
    key, impedance = question.environment.key, question.environment.impedance
    if key in ("puck", "mass_spring_damper"):
        setting = Setting(rate=option.rate, delay=option.delay, estimator="kalman")
        return contact_limit(setting, key, question.with_options(option.options))
    damping = impedance(question.with_options(question.exact))[1] if impedance else 0.0
    loop = {"rate": option.rate, "delay": option.delay, "estimator": option.estimator, "quantum": 20.7e-6}
    return hs.stiffness_limit(0.044, 0.5, damping=damping, **loop)


@pytest.mark.parametrize("key", scenes("spring", "damping"))
def test_every_scene_begins_with_the_least_error_that_holds_it(key):
    """Limits and cycles are computed anew, and the rule is applied anew."""
    found = computed(key)
    wanted = 1.5 * found.question.stiffness
    for place in PLACES:
        options, best = found.at(place), found.recommended(place)
        for option in options:
            assert option.cycles <= 0.8 * 16e6 or place == "computer"
            if option.estimator == "foaw":
                assert math.isnan(option.limit)
            else:
                assert option.limit == pytest.approx(limit_of(found.question, option), rel=1e-6)
        stiff = [o for o in options if o.limit >= wanted or not wanted]
        if not stiff:
            true = [o for o in options if o.error <= 2.0 * min(p.error for p in options)]
            stiff = [o for o in true if o.limit >= 0.99 * max(p.limit for p in true)]
        assert best in stiff
        assert best.error <= min(o.error for o in stiff) + KNOWN
        assert best is found.default(place) or not found.question.choices  # the loop has the estimator


@pytest.mark.parametrize("key", scenes("spring"))
def test_ten_answers_are_identical(key):
    question = Question(LIBRARY[key], LIBRARY[key].values())
    answers = {repr(scene.compute(question).options) for _ in range(10)}
    assert len(answers) == 1
