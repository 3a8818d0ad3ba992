"""Speed buys stiffness: the chain from a scene's method to the hand, on the computer and on the board.

A method and a velocity estimator are off by so much, and cost so much time; that allows a rate and makes a
delay, and both allow a stiffness. What a hand feels of the error is counted in just-noticeable differences
(JND). Error: forces beside those of the exact method with the true velocity, at the same rate and delay,
under every hand of the scene, those that hold and those that let go.

Less than 1 JND is sufficient: nobody can tell. Of what is sufficient and as stiff as any, the choice that
costs least is the one to take. Costs that are as low as measured are equal: the error decides.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import product

import numpy as np

from hapkit_studio.analysis import fidelity, perception
from hapkit_studio.analysis.accuracy import plan
from hapkit_studio.analysis.accuracy.velocity import SHORT
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability import kb_plane, objects
from hapkit_studio.analysis.sweeps import Progress, no_progress
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import ESTIMATORS, USUAL, Spec, parse
from hapkit_studio.dynamics.hand import hand_named
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.formatting import plain, significant
from hapkit_studio.haptics import board_plan, headless, rows
from hapkit_studio.haptics.board_plan import CLOCK, BoardPlanner, PlanRequest
from hapkit_studio.haptics.engine import BOARD, COMPUTER
from hapkit_studio.haptics.settings import RATE, LoopSettings
from hapkit_studio.laws.machine import ARENA, REST_AT_MOST
from hapkit_studio.parameters import Choice

SUFFICIENT = 1.0  # JND
SHARE = 0.8
"""Of a processor, which rendering takes at most."""
_AS_STIFF = 0.99
_TIMED_TICKS = 2000
Options = tuple[tuple[str, float], ...]
"""The key of each choice between methods, and the option taken."""


@dataclass(frozen=True)
class Place:
    """What renders, at a rate in Hz at most; delay in s from a sample to its force, None: not measured.

    A computer answers a period late then; the board's force is in effect as soon as its tick is computed.
    """

    name: str
    rate: float
    delay: float | None = None


ON_COMPUTER = Place(COMPUTER, RATE.default)  # as often as a Hapkit sends its position
ON_BOARD = Place(BOARD, float(board_plan.RATES[0]))


@dataclass(frozen=True)
class Question:
    """A scene as it is set, the velocity estimator in force, what may render it, and the handle."""

    environment: Environment
    values: Values
    estimator: Spec = USUAL
    places: tuple[Place, ...] = (ON_COMPUTER, ON_BOARD)
    device: SimulatedHapkit = field(default_factory=SimulatedHapkit)

    @property
    def choices(self) -> tuple[Choice, ...]:
        """Return the scene's choices between methods."""
        return tuple(p for p in self.environment.parameters if isinstance(p, Choice) and p.method)

    @property
    def options(self) -> Options:
        """Return the options in force."""
        return tuple((c.key, self.values[c.key]) for c in self.choices)

    @property
    def exact(self) -> Options:
        """Return the options that the others are judged by."""
        return tuple((c.key, c.check(c.exact) if c.exact else c.default) for c in self.choices)

    def spec(self, key: str) -> Spec:
        """Return an estimator, the one in force with its options."""
        return self.estimator if parse(self.estimator)[0].key == key else key

    def with_options(self, options: Options) -> dict[str, float]:
        """Return the values with other methods."""
        return {**self.values, **dict(options)}

    def ways(self, place: Place) -> Iterator[tuple[Options, str]]:
        """Yield every choice of methods with every estimator of a place."""
        known = board_plan.ESTIMATORS if place.name == BOARD else ESTIMATORS
        every = product(*([(c.key, float(n)) for n in range(len(c.options))] for c in self.choices))
        for options, key in product(every, known):
            if not self.environment.check(self.with_options(options)):
                yield options, key

    def words(self, options: Options) -> str:
        """Write methods as a person reads them."""
        chosen = dict(options)
        return ", ".join(choice.word(chosen[choice.key]) for choice in self.choices)


@dataclass(frozen=True)
class Candidate(plan.Rival):
    """One way to render a scene in one place: SI units; error in JND, of what and under which hand.

    cost and spread of a tick: cycles of the law on the board, else ns. fastest: the rate within SHARE, rate
    the one it renders at. limit: the exact stiffness limit, nan where the estimator is not linear. The other
    errors are root mean squares, the largest of all hands.
    """

    place: str
    options: Options
    estimator: str
    method: str
    cost: float
    spread: float
    fastest: float
    rate: float
    delay: float
    limit: float
    force_error: float
    velocity_error: float
    error: float
    felt: str
    hand: str
    pareto: bool = False

    @property
    def price(self) -> tuple[float, float]:
        return self.cost, self.spread

    @property
    def label(self) -> str:
        """Return methods and estimator in words."""
        return ", ".join(filter(None, (self.method, SHORT[self.estimator])))

    @property
    def sufficient(self) -> bool:
        """Return whether nobody can tell it from the exact one."""
        return self.error < SUFFICIENT

    def row(self) -> dict[str, object]:
        """Return it as an object for programs."""
        unit = "cycles" if self.place == BOARD else "ns"
        found = plain(self) | {"options": dict(self.options), unit: self.cost, f"{unit}_spread": self.spread}
        return {key: value for key, value in found.items() if key not in ("cost", "spread")}


@dataclass(frozen=True)
class Chain:
    """Every candidate, in each place those marked that no other beats in error and stiffness.

    refused: why the board cannot render a method, by its words.
    """

    question: Question
    candidates: tuple[Candidate, ...]
    refused: Mapping[str, str]

    def at(self, place: str) -> tuple[Candidate, ...]:
        """Return the candidates of a place."""
        return tuple(c for c in self.candidates if c.place == place)

    def find(self, place: str, options: Options, estimator: str) -> Candidate | None:
        """Return one candidate, None where there is none."""
        same = (c for c in self.at(place) if (c.options, c.estimator) == (options, estimator))
        return next(same, None)

    def default(self, place: str, estimator: str = USUAL) -> Candidate | None:
        """Return the candidate that the scene begins with."""
        return self.find(place, tuple((c.key, c.default) for c in self.question.choices), estimator)

    def in_force(self, place: str) -> Candidate | None:
        """Return the candidate that is set."""
        spec = self.question.estimator
        spec = board_plan.spec_on_board(spec) if place == BOARD else spec
        return self.find(place, self.question.options, parse(spec)[0].key)

    def answer(self, place: str, estimator: str = "") -> plan.Answer[Candidate]:
        """Return the cheapest sufficient choice of those that are as stiff as any; of one estimator if named.

        As stiff: to 1 %.
        """
        enough = [c for c in self.at(place) if c.sufficient and estimator in ("", c.estimator)]
        stiffest = max((c.limit for c in enough if not math.isnan(c.limit)), default=0.0)
        as_stiff = [c for c in enough if c.limit >= _AS_STIFF * stiffest]
        return plan.Answer.among(as_stiff, self.default(place, estimator or USUAL))

    def sentence(self, place: str) -> str:
        """Write the answer of a place, with its reason."""
        best = self.answer(place).cheapest
        if best is None:
            return self._nothing(place)
        best_words = f"{best.label}: {jnd(best.error)}, {cost_words(best)}"
        found = f"{best_words}, {best.rate:,.0f} Hz, {stiffness_words(best.limit)}"
        other = self._beside(best)
        if other is None:
            return f"{found}."
        name, more = other.method if best.method else SHORT[other.estimator], other.cost - best.cost
        if other.limit >= _AS_STIFF * best.limit:
            unit = "cycles" if place == BOARD else "ns"
            less = f"{abs(more):,.0f} {unit} {'more' if more > 0.0 else 'less'}"
        else:
            less = f"{best.limit - other.limit:,.0f} N/m less"
        return f"{found}; {name} is {jnd(other.error)} and {less}."

    def _nothing(self, place: str) -> str:
        least = min(self.at(place), key=lambda c: c.error, default=None)
        if least is None:
            return next(iter(self.refused.values()), "")
        return f"Nothing is below 1 JND; {least.label} comes nearest: {jnd(least.error)}, {why_words(least)}."

    def _beside(self, best: Candidate) -> Candidate | None:
        """Return the stiffest of what is more accurate, else of all others, that differs in one choice."""
        same = [
            c for c in self.at(best.place)
            if (c.estimator == best.estimator if best.method else True)
            and (c.options, c.estimator) != (best.options, best.estimator) and not math.isnan(c.limit)
        ]  # fmt: skip
        return max(same, key=lambda c: (c.error < best.error, c.limit, -c.error), default=None)


def jnd(error: float) -> str:
    """Write an error in JND."""
    return f"{'∞' if math.isinf(error) else significant(error) if error >= 0.005 else '0'} JND"


def cost_words(candidate: Candidate) -> str:
    """Write what a tick costs."""
    if candidate.place == BOARD:
        return f"{candidate.cost:,.0f} cycles"
    return f"{candidate.cost:,.0f} ± {candidate.spread:,.0f} ns"


def stiffness_words(limit: float) -> str:
    """Write a stiffness limit."""
    return "limit unknown" if math.isnan(limit) else "no limit" if math.isinf(limit) else f"{limit:,.0f} N/m"


def why_words(candidate: Candidate) -> str:
    """Write what is felt of an error, and under which hand."""
    return f"{candidate.felt}, {candidate.hand}"


_PLANNER = BoardPlanner(ARENA)
_TICKS: dict[tuple, tuple[float, float]] = {}


def _hands(environment: Environment) -> tuple[str, ...]:
    return environment.hands or fidelity.HANDS


def _rendered(
    question: Question, options: Options, spec: Spec, rate: float, delay: float, name: str, true: bool = False
) -> np.ndarray:
    """Return the rows at perception.RATE of the scene under a hand; true: with the true velocity."""
    trial = fidelity.script(name)
    handle = replace(question.device, initial_velocity=trial.thrown)
    values, loop = question.with_options(options), LoopSettings(rate, delay, spec)
    scene = headless.Scene(question.environment, values, handle, loop, true_velocity=true)
    out = headless.prepare_run(scene, trial.hand, math.ceil(trial.seconds * rate) + 1).run()
    moments = np.arange(round(trial.seconds * perception.RATE)) * (rate / perception.RATE)
    return out[moments.astype(int)]


def _told(environment: Environment, name: str, exact: np.ndarray, other: np.ndarray) -> perception.Difference:
    """Return what is told apart of two runs under a hand."""
    outcomes = [fidelity.outcome_named(key, environment.state_names) for key in environment.outcomes]
    counts = [outcome.column for outcome in outcomes if outcome.column is not None]
    return perception.difference_under(hand_named(name), exact, other, counts)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values * values)))


def _time_ticks(question: Question, ways: list[tuple[Options, str]]) -> None:
    """Time a tick of the loop with the simulated handle, of those that were not timed yet, twice over."""
    wanted = [way for way in ways if (question.environment.force, *way) not in _TICKS]
    name = next((name for name in _hands(question.environment) if hand_named(name).release > 0.0), "press")

    def work(options: Options, key: str) -> plan.Work:
        loop, values = LoopSettings(estimator=question.spec(key)), question.with_options(options)
        scene = headless.Scene(question.environment, values, question.device, loop)
        return headless.prepare_run(scene, hand_named(name), _TIMED_TICKS).run

    if not wanted:
        return
    works = [plan.always(work(*way)) for way in wanted]
    for way, *found in zip(wanted, plan.shortest(works), plan.shortest(works), strict=True):
        (ns, other), spreads = zip(*found, strict=True)
        spread = max(*spreads, abs(ns - other))
        _TICKS[question.environment.force, *way] = min(ns, other) / _TIMED_TICKS, spread / _TIMED_TICKS


@dataclass(frozen=True)
class _Cost:
    """What a tick costs, cycles or ns, its spread, and the rates in Hz and delay in s that it allows."""

    cost: float
    spread: float
    fastest: float
    rate: float
    delay: float


_COUNTED: dict[tuple, _Cost] = {}
"""What the board's laws took when they were last counted, by all their choices."""


def _cost(question: Question, place: Place, options: Options, key: str, live: bool) -> _Cost | str:
    """Return what a way costs, or why the board cannot go it; live: as it was last counted, if ever."""
    if place.name == COMPUTER:
        _time_ticks(question, [(options, key)])
        ns, spread = _TICKS[question.environment.force, options, key]
        delay = 1.0 / place.rate if place.delay is None else place.delay
        return _Cost(ns, spread, min(SHARE * 1e9 / ns, RATE.high), place.rate, delay)
    values = question.with_options(options)
    chosen = tuple(values[p.key] for p in question.environment.parameters if p.discrete)
    law = question.environment.force, chosen, place
    if live and law in _COUNTED:
        return _COUNTED[law]
    planned = _PLANNER.plan(PlanRequest(question.environment, values, rate=place.rate))
    if isinstance(planned, str):
        return planned
    cycles, fastest = planned.program.usual, board_plan.fastest(planned.program)
    delay = (cycles + REST_AT_MOST) / CLOCK if place.delay is None else place.delay
    _COUNTED[law] = _Cost(cycles, 0.0, fastest, float(planned.rate), delay)
    return _COUNTED[law]


Exact = Callable[[float, float, str], np.ndarray]


def _exact(question: Question) -> Exact:
    """Return what renders the exact method with the true velocity, at a rate and delay, once for each."""

    @cache
    def rendered(rate: float, delay: float, name: str) -> np.ndarray:
        return _rendered(question, question.exact, "difference", rate, delay, name, true=True)

    return rendered


def judge(
    question: Question, place: Place, options: Options, key: str, exact: Exact, live: bool = False
) -> Candidate | str:
    """Return one way to render in one place, or why the board cannot."""
    cost, spec = _cost(question, place, options, key, live), question.spec(key)
    if isinstance(cost, str):
        return cost
    errors = _errors(question, options, spec, cost.rate, cost.delay, exact)
    limit, words = _limit(question, options, cost.rate, cost.delay, spec), question.words(options)
    times = cost.cost, cost.spread, cost.fastest, cost.rate, cost.delay
    return Candidate(place.name, options, key, words, *times, limit, *errors)


def _limit(question: Question, options: Options, rate: float, delay: float, spec: Spec) -> float:
    """Return the exact stiffness limit of a released handle, or of it and the object that it is pressed to.

    With the damping of the exact method: what another adds near rest, such as the slope of a smoothed
    friction, makes no spring stiffer.
    """
    device, environment = question.device, question.environment
    setting = Setting(
        device.mass, device.viscous, quantum=device.quantum, rate=rate, delay=delay, estimator=spec
    )
    if setting.linear and objects.holds(environment):
        return objects.contact_limit(setting, environment.key, question.with_options(options))
    values, impedance = question.with_options(question.exact), environment.impedance
    return float(kb_plane.limit(setting, impedance(values)[1] if impedance else 0.0))


def _errors(
    question: Question, options: Options, spec: Spec, rate: float, delay: float, exact: Exact
) -> tuple[float, float, float, str, str]:
    """Return the largest error of force and velocity, and what is felt most: in JND, of what, which hand."""
    forces, velocities, felt = [], [], []
    for name in _hands(question.environment):
        reference, found = exact(rate, delay, name), _rendered(question, options, spec, rate, delay, name)
        forces.append(_rms(found[:, rows.APPLIED] - reference[:, rows.APPLIED]))
        velocities.append(_rms(found[:, rows.VELOCITY] - found[:, rows.TRUE_VELOCITY]))
        told = _told(question.environment, name, reference, found)
        felt.append((told.most, told.word, name))
    return max(forces), max(velocities), *max(felt)


def in_force(question: Question) -> tuple[Candidate | str, ...]:
    """Return what is set, in each place, or why it cannot render that: a live answer."""
    exact, found = _exact(question), []
    for place in question.places:
        spec = board_plan.spec_on_board(question.estimator) if place.name == BOARD else question.estimator
        found.append(judge(question, place, question.options, parse(spec)[0].key, exact, live=True))
    return tuple(found)


def compute(question: Question, progress: Progress = no_progress) -> Chain:
    """Return every way to render a scene, in each place."""
    ways = [(place, *way) for place in question.places for way in question.ways(place)]
    _time_ticks(question, [way for place, *way in ways if place.name == COMPUTER])  # type: ignore[misc]
    exact, found, refused = _exact(question), [], {}
    for done, (place, options, key) in enumerate(ways):
        progress(done, len(ways))
        judged = judge(question, place, options, key, exact)
        if isinstance(judged, str):
            refused[question.words(options)] = judged
        else:
            found.append(judged)
    progress(len(ways), len(ways))
    marked = [
        one for place in question.places for one in _marked([c for c in found if c.place == place.name])
    ]
    return Chain(question, tuple(marked), refused)


def _marked(candidates: list[Candidate]) -> list[Candidate]:
    """Return a place's candidates, those marked that no other beats in error and stiffness."""
    known = [c for c in candidates if c.limit > 0.0]
    soft = plan.mark_front([replace(c, cost=1.0 / c.limit, spread=0.0) for c in known])
    front = {id(c) for c, one in zip(known, soft, strict=True) if one.pareto}
    return [replace(c, pareto=id(c) in front) for c in candidates]
