"""Which method to render a scene with, on the computer and on the board: error, rate and stiffness of each.

A method costs time, which sets the rate that a place can keep; rate, delay and method together set the error
and the stiffness limit. The error is measured against the scene itself (see scene_error), so that a method
that lowers the rate is charged for it.

Recommended is the least error among the methods whose stiffness limit is at least MARGIN times the scene's
stiffness. Errors that differ by less than TIE are equal: the law that takes the fewest cycles decides. Where
no method has that margin, it is the least error among those nearly as stiff as the stiffest.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product

from hapkit_studio.analysis.accuracy import plan
from hapkit_studio.analysis.accuracy.velocity import SHORT
from hapkit_studio.analysis.scene_error import COMPONENTS, METHOD, SceneError, Way
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability import kb_plane, objects
from hapkit_studio.analysis.sweeps import Progress, no_progress
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import ESTIMATORS, USUAL, Spec, parse
from hapkit_studio.dynamics.hand import hand_named
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.errors import LawError
from hapkit_studio.formatting import on_screen, plain, significant
from hapkit_studio.haptics import board_plan, headless
from hapkit_studio.haptics.board_plan import CLOCK, BoardPlanner, PlanRequest
from hapkit_studio.haptics.engine import BOARD, COMPUTER
from hapkit_studio.haptics.settings import RATE, LoopSettings
from hapkit_studio.laws.machine import ARENA, REST_AT_MOST
from hapkit_studio.parameters import Choice

UNFELT = 1.0  # JND: a hand does not tell a smaller error
MARGIN = 1.5
"""Of the scene's stiffness: what the limit of a recommended method is at least."""
NEARLY_AS_STIFF = 0.95  # of the stiffest, where no method has the margin
TIE = 0.05  # JND: smaller differences are not more than those of a faster reference
SHARE = 0.8
"""Of a processor, which rendering takes at most."""
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

    @property
    def stiffness(self) -> float:
        """Return the scene's stiffness in N/m by the exact method, 0 where it has none."""
        impedance = self.environment.impedance
        return float(impedance(self.with_options(self.exact))[0]) if impedance else 0.0

    def key_at(self, place: Place) -> str:
        """Return the estimator that a place uses for the one in force."""
        spec = board_plan.spec_on_board(self.estimator) if place.name == BOARD else self.estimator
        return parse(spec)[0].key

    def ways(self, place: Place) -> Iterator[tuple[Options, str]]:
        """Yield every choice of methods with the estimator in force, then those set with every other one."""
        every = product(*([(c.key, float(n)) for n in range(len(c.options))] for c in self.choices))
        for options in every:
            if not self.environment.check(self.with_options(options)):
                yield options, self.key_at(place)
        for key in board_plan.ESTIMATORS if place.name == BOARD else ESTIMATORS:
            if key != self.key_at(place):
                yield self.options, key

    def words(self, options: Options) -> str:
        """Write methods as a person reads them."""
        chosen = dict(options)
        return ", ".join(choice.word(chosen[choice.key]) for choice in self.choices)


@dataclass(frozen=True)
class Candidate(plan.Rival):
    """One way to render a scene in one place: SI units; error in JND, of which sense and under which hand.

    cost and spread of a tick: cycles of the law on the board, else ns; work: cycles of the law, inf where the
    board cannot hold it. fastest: the rate within SHARE, rate the one it renders at. limit: the exact
    stiffness limit, nan where the estimator is not linear. parts: of the error, by component in JND; empty
    where they were not asked for.
    """

    place: str
    options: Options
    estimator: str
    method: str
    cost: float
    spread: float
    work: float
    fastest: float
    rate: float
    delay: float
    limit: float
    error: float
    felt: str
    hand: str
    parts: Mapping[str, float] = field(default_factory=dict, hash=False)
    pareto: bool = False

    @property
    def price(self) -> tuple[float, float]:
        return self.cost, self.spread

    @property
    def label(self) -> str:
        """Return methods and estimator in words."""
        return ", ".join(filter(None, (self.method, SHORT[self.estimator])))

    @property
    def name(self) -> str:
        """Return what tells it from the others of its scene: its methods, or its estimator."""
        return self.method or SHORT[self.estimator]

    @property
    def unfelt(self) -> bool:
        """Return whether no hand of the scene tells it from the scene itself."""
        return self.error < UNFELT

    def row(self) -> dict[str, object]:
        """Return it as an object for programs."""
        unit = "cycles" if self.place == BOARD else "ns"
        found = plain(self) | {"options": dict(self.options), unit: self.cost, f"{unit}_spread": self.spread}
        return {key: value for key, value in found.items() if key not in ("cost", "spread")}


@dataclass(frozen=True)
class Recommendation:
    """The candidate to use in a place, or None; margin: its limit is at least MARGIN times the stiffness.

    rivals: those it was chosen from, by error.
    """

    best: Candidate | None
    margin: bool
    rivals: tuple[Candidate, ...] = ()


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

    def compared(self, place: str) -> tuple[Candidate, ...]:
        """Return the candidates that differ in what the scene chooses: its methods, else the estimator."""
        named = Place(place, 0.0)
        key = self.question.key_at(named)
        return tuple(c for c in self.at(place) if not c.method or c.estimator == key)

    def recommendation(self, place: str) -> Recommendation:
        """Return what to use in a place: the same at every run."""
        rivals = sorted(self.compared(place), key=lambda c: c.error)
        known = [c for c in rivals if not math.isnan(c.limit)] or rivals
        enough = [c for c in known if not c.limit < MARGIN * self.question.stiffness]
        stiffest = max((c.limit for c in known), default=0.0)
        chosen = enough or [c for c in known if c.limit >= NEARLY_AS_STIFF * stiffest]
        if not chosen:
            return Recommendation(None, False)
        default = self.default(place, chosen[0].estimator)
        tied = [c for c in chosen if c.error <= chosen[0].error + TIE]
        best = min(tied, key=lambda c: (c.work, c is not default, c.options))
        return Recommendation(best, bool(enough), tuple(chosen))

    def sentences(self, place: str) -> tuple[str, str]:
        """Write what to use in a place, and why."""
        found = self.recommendation(place)
        best = found.best
        if best is None:
            return next(iter(self.refused.values()), ""), ""
        scene = self.question.environment.title.lower()
        same = "no hand tells it from" if best.unfelt else f"{jnd(best.error)} from"
        where = "On the board" if place == BOARD else "On the computer"
        first = f"{where}, {best.name} at {best.rate:,.0f} Hz: {same} the {scene} itself, up to "
        first += f"{stiffness_words(best.limit)}."
        return first, self._reason(found, best)

    def _reason(self, found: Recommendation, best: Candidate) -> str:
        needed = on_screen(self.question.stiffness, "N/m")
        if not found.margin and best.limit >= self.question.stiffness:
            return (
                f"No method's stiffness limit is {MARGIN:g} times the {needed} of this scene: it is near its "
                "limit here."
            )
        if not found.margin:
            return (
                f"No method is stiff enough here for a contact of {needed}: it needs a hand or friction to "
                "come to rest."
            )
        own = best.parts.get(METHOD, 0.0)
        truer = [
            c for c in self.compared(best.place)
            if abs(c.parts.get(METHOD, math.inf)) < abs(own) - TIE and c.error > best.error + TIE
        ]  # fmt: skip
        worst = max(best.parts, key=lambda key: best.parts[key], default="")
        if truer:
            other = min(truer, key=lambda c: c.error)
            if other.rate < 0.99 * best.rate:
                costs = f"renders at {other.rate:,.0f} Hz here, and the rate matters more to your hand"
            elif own < 0.0:
                lead = f"{best.name}'s own error makes up for part of the {COMPONENTS[worst]}'s"
                costs = f"{jnd(other.error)} off in all: {lead}"
            else:
                costs = f"{jnd(other.error)} off in all"
            return f"{other.name} is the more accurate method, but {costs}."
        if worst:
            return f"Most of the error is the {COMPONENTS[worst]}: {jnd(best.parts[worst])}."
        return ""


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


_PLANNER = BoardPlanner(ARENA)
_TICKS: dict[tuple, tuple[float, float]] = {}


def _time_ticks(question: Question, ways: list[tuple[Options, str]]) -> None:
    """Time a tick of the loop with the simulated handle, of those that were not timed yet, twice over."""
    wanted = [way for way in ways if (question.environment.force, *way) not in _TICKS]
    hands = question.environment.hands
    name = next((name for name in hands if hand_named(name).release > 0.0), "press")

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


def _work(question: Question, options: Options) -> float:
    """Return the cycles of a law on the board, inf where it cannot be rendered there."""
    from hapkit_studio.laws import board

    try:
        law, values = question.environment.force, question.with_options(options)
        return float(board.compile(law, values, 1.0 / RATE.default, ARENA).usual)
    except LawError:
        return math.inf


def judge(
    question: Question, place: Place, options: Options, key: str, scene: SceneError, live: bool = False
) -> Candidate | str:
    """Return one way to render in one place, or why the board cannot; its error is not split.

    live: the work of a computer's law is inf; it is needed to choose between ways only.
    """
    cost, spec = _cost(question, place, options, key, live), question.spec(key)
    if isinstance(cost, str):
        return cost
    felt = scene.felt(Way(question.with_options(options), cost.rate, cost.delay, spec))
    limit, words = _limit(question, options, cost.rate, cost.delay, spec), question.words(options)
    counted = cost.cost if place.name == BOARD else None
    work = counted or (math.inf if live else _work(question, options))
    times = cost.cost, cost.spread, work, cost.fastest, cost.rate, cost.delay
    return Candidate(place.name, options, key, words, *times, limit, felt.error, felt.sense, felt.hand)


def scene_of(question: Question) -> SceneError:
    """Return what judges the ways to render the scene of a question."""
    return SceneError(question.environment, question.with_options(question.exact), question.device)


def split(question: Question, one: Candidate, scene: SceneError) -> Candidate:
    """Return a candidate with the parts of its error."""
    values = question.with_options(one.options)
    return replace(one, parts=scene.parts(Way(values, one.rate, one.delay, question.spec(one.estimator))))


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


def in_force(question: Question) -> tuple[Candidate | str, ...]:
    """Return what is set, in each place, or why it cannot render that: a live answer."""
    scene = scene_of(question)
    return tuple(
        judge(question, place, question.options, question.key_at(place), scene, live=True)
        for place in question.places
    )


def compute(question: Question, progress: Progress = no_progress, parts: bool = True) -> Chain:
    """Return the ways to render a scene in each place; parts: with the error split of those compared."""
    ways = [(place, *way) for place in question.places for way in question.ways(place)]
    _time_ticks(question, [way for place, *way in ways if place.name == COMPUTER])  # type: ignore[misc]
    scene, found, refused = scene_of(question), [], {}
    for done, (place, options, key) in enumerate(ways):
        progress(done, 2 * len(ways))
        judged = judge(question, place, options, key, scene)
        if isinstance(judged, str):
            refused[question.words(options)] = judged
        else:
            found.append(judged)
    marked = [
        one for place in question.places for one in _marked([c for c in found if c.place == place.name])
    ]
    chain = Chain(question, tuple(marked), refused)
    wanted = {c for place in question.places for c in chain.compared(place.name)} if parts else set()
    for done, one in enumerate(marked):
        progress(len(ways) + done, 2 * len(ways))
        if one in wanted:
            marked[done] = split(question, one, scene)
    progress(2 * len(ways), 2 * len(ways))
    return replace(chain, candidates=tuple(marked))


def _marked(candidates: list[Candidate]) -> list[Candidate]:
    """Return a place's candidates, those marked that no other beats in error and stiffness."""
    known = [c for c in candidates if c.limit > 0.0]
    soft = plan.mark_front([replace(c, cost=1.0 / c.limit, spread=0.0) for c in known])
    front = {id(c) for c, one in zip(known, soft, strict=True) if one.pareto}
    return [replace(c, pareto=id(c) in front) for c in candidates]
