"""The errors of all ways to render a scene, their causes, and the recommended way.

The ideal of a scene is its law with the exact method, with an ideal sensor, the true velocity and no force
limit. Its rate is so high and its delay so short that twice the rate changes the felt difference by less than
KNOWN. An option's error is the felt difference from the ideal in just-noticeable differences (JND), for
the scene's hand with the largest difference. It is split into PARTS by Shapley values: the contribution of a
part is its mean effect over all orders in which ideal components are replaced by real ones. Contributions add
up to the error and may be negative.

Options are combinations of the scene's methods. The velocity estimator is not a method of the scene but a
setting of the loop. Its contribution to the error is shown here; the charts of methods compare the
estimators.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations, product
from types import MappingProxyType

import numpy as np

from hapkit_studio.analysis.accuracy import trials
from hapkit_studio.analysis.accuracy.trials import Trial
from hapkit_studio.analysis.perception import PLACE, Difference
from hapkit_studio.analysis.stability import kb_plane, objects
from hapkit_studio.analysis.sweeps import Progress, no_progress
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import USUAL, Spec
from hapkit_studio.dynamics.loop_settings import BOARD, COMPUTER, RATE, LoopSettings
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.formatting import plain, significant
from hapkit_studio.haptics import board_plan, headless, rows
from hapkit_studio.haptics.board_plan import CLOCK, BoardPlanner, PlanRequest
from hapkit_studio.laws.machine import ARENA, FRAME, REST_AT_MOST
from hapkit_studio.parameters import Choice

PARTS = ("method", "rate", "delay", "velocity", "sensor", "limit")
PART_WORDS = {"velocity": "velocity estimate", "sensor": "sensor steps", "limit": "force limit"}
METHOD, REAL_RATE, REAL_DELAY, VELOCITY, SENSOR, LIMIT = PARTS
SLOWEST_IDEAL, FASTEST_IDEAL = 16_000.0, 256_000.0  # Hz: range of the ideal's rate
LIVE_IDEAL = 32_000.0  # Hz: highest rate of the ideal if the result is needed within 50 ms
KNOWN = 0.05  # JND: accuracy of the ideal; errors that differ by less are considered equal
MARGIN = 1.5  # required ratio of an option's stiffness limit to the scene's stiffness
# If no option has the margin, an option's limit must reach this fraction of the highest limit. A smaller
# difference has no meaning: measured limits differ from the computed ones by up to 3 %.
_LEAST_LIMIT = 0.98
_MOST = 100.0  # JND: upper bound of a difference that is split into parts
# for each choice between methods, its key and the index of its option
Options = tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Place:
    """Computer or board, with its highest rate in Hz and its delay from sample to force in s.

    If the delay was not measured, it is None; one period is then assumed on the computer, and the duration of
    the tick on the board.
    """

    name: str
    rate: float
    delay: float | None = None


ON_COMPUTER = Place(COMPUTER, RATE.default)  # the rate at which a Hapkit sends its position
ON_BOARD = Place(BOARD, float(board_plan.RATES[0]))


@dataclass(frozen=True)
class SceneRequest:
    """A scene with its values, velocity estimator and handle, and the places that can render it."""

    environment: Environment
    values: Values
    estimator: Spec = USUAL
    places: tuple[Place, ...] = (ON_COMPUTER, ON_BOARD)
    device: SimulatedHapkit = field(default_factory=SimulatedHapkit)

    @property
    def choices(self) -> tuple[Choice, ...]:
        return tuple(p for p in self.environment.parameters if isinstance(p, Choice) and p.method)

    @property
    def options(self) -> Options:
        """Return the methods that are currently selected."""
        return tuple((c.key, self.values[c.key]) for c in self.choices)

    @property
    def exact(self) -> Options:
        """Return the methods of the ideal scene."""
        return tuple((c.key, c.check(c.exact) if c.exact else c.default) for c in self.choices)

    @property
    def stiffness(self) -> float:
        """Return the scene's stiffness in N/m; 0 if no stiffness limits the scene's stability."""
        impedance = self.environment.impedance
        return impedance(self.with_options(self.exact))[0] if impedance else 0.0

    def spec(self, place: str) -> Spec:
        """Return the estimator that a place uses."""
        return board_plan.spec_on_board(self.estimator) if place == BOARD else self.estimator

    def with_options(self, options: Options) -> dict[str, float]:
        """Return the values, with the methods replaced by ``options``."""
        return {**self.values, **dict(options)}

    def methods(self) -> Iterator[Options]:
        """Yield every valid combination of methods."""
        for options in product(*([(c.key, float(n)) for n in range(len(c.options))] for c in self.choices)):
            if not self.environment.check(self.with_options(options)):
                yield options

    def options_text(self, options: Options) -> str:
        """Return a text with the methods; "" for a scene that has none."""
        chosen = dict(options)
        return ", ".join(choice.option_label(chosen[choice.key]) for choice in self.choices)


@dataclass(frozen=True)
class Option:
    """One way to render a scene, in SI units.

    ``cycles`` and ``tick`` are the board's cycles per second and per tick, NaN on the computer. ``method``
    describes the methods, "" for a scene that has none. ``limit`` is the exact stiffness limit, NaN for a
    nonlinear estimator. ``error`` is in JND, for this sense and hand. ``parts`` is the contribution of each
    of PARTS, () before the split. ``own`` is the method's own error at the rate and at twice the rate, each
    with the board's cycles per second; it is () before the split, and for the computer.
    """

    place: str
    options: Options
    estimator: Spec = field(hash=False)
    method: str
    rate: float
    delay: float
    cycles: float
    tick: float
    limit: float
    error: float = math.nan
    sense: str = ""
    hand: str = ""
    parts: tuple[float, ...] = ()
    own: tuple[tuple[float, float], ...] = ()

    def row(self) -> dict[str, object]:
        """Return the option as an object of JSON data."""
        parts = dict(zip(PARTS, self.parts, strict=False))
        return plain(self) | {"options": dict(self.options), "parts": parts}


class Ideal:
    """Renders a scene with ideal and real components; each combination is rendered only once."""

    def __init__(self, question: SceneRequest, rates: Mapping[str, float] = MappingProxyType({})):
        self._question, self.trials = question, trials.scripts(question.environment)
        self.rendered: dict[tuple, np.ndarray] = {}
        self.rates = dict(rates)  # rates in Hz, by a trial's label

    def rate(self, trial: Trial) -> float:
        """Return the ideal's rate in Hz: at twice this rate the result differs by less than KNOWN."""
        q, rate = self._question, self.rates.get(trial.label, SLOWEST_IDEAL)
        while trial.label not in self.rates:
            one, other = (self._render(trial, q.exact, at) for at in (2.0 * rate, rate))
            change = trials.felt(q.environment, trial, one, other).most
            if rate >= FASTEST_IDEAL or change < KNOWN:
                self.rates[trial.label] = rate
            else:
                rate *= 2.0
        return rate

    def error(self, trial: Trial, option: Option, real: frozenset[str] = frozenset(PARTS)) -> Difference:
        """Return the felt difference of an option from the ideal, if only the given parts are real."""
        one, other = (self.render(trial, option, parts) for parts in (frozenset[str](), real))
        return trials.felt(self._question.environment, trial, one, other)

    def render(self, trial: Trial, option: Option, real: frozenset[str]) -> np.ndarray:
        """Return the rows of an option of which only the given parts are real."""
        q = self._question
        return self._render(
            trial,
            option.options if METHOD in real else q.exact,
            option.rate if REAL_RATE in real else self.rate(trial),
            option.delay if REAL_DELAY in real else 0.0,
            option.estimator if VELOCITY in real else None,
            q.device.quantum if SENSOR in real else 0.0,
            q.device.max_force if LIMIT in real else math.inf,
        )

    def parts(self, option: Option) -> tuple[float, ...]:
        """Return the contribution of each of PARTS to an option's error in JND, for the option's hand.

        A part contributes 0 if making it ideal in the real loop, or real in the ideal loop, changes no bit of
        the result. The other contributions are computed from all combinations of the remaining parts.
        """
        trial = next(t for t in self.trials if t.label == option.hand)
        seen = rows.TRUE_POSITION, rows.HAND_FORCE, *range(rows.STATE, rows.ROW_WIDTH)

        def differ(*pair: set[str]) -> bool:
            one, other = (self.render(trial, option, frozenset(real))[:, seen] for real in pair)
            return not np.array_equal(one, other, equal_nan=True)

        every = set(PARTS)
        live = [part for part in PARTS if differ(every, every - {part}) or differ({part}, set())]
        value = {
            real: min(self.error(trial, option, real).most, _MOST)
            for size in range(len(live) + 1)
            for real in map(frozenset, combinations(live, size))
        }
        return tuple(shapley(value, live).get(part, 0.0) for part in PARTS)

    def own(self, option: Option) -> tuple[tuple[float, float], ...]:
        """Return (board cycles per second, the method's own error) at an option's rate and at double rate.

        This error is the largest difference in position from the exact method at the same rate, as a multiple
        of the JND of 0.4 mm. All other components of the loop are ideal.
        """
        found = []
        for times in (1.0, 2.0):
            rate, apart = times * option.rate, 0.0
            for trial in self.trials:
                both = self._question.exact, option.options
                exact, own = (self._render(trial, one, rate)[:, rows.TRUE_POSITION] for one in both)
                apart = max(apart, float(np.abs(exact - own).max()) / PLACE)
            telemetry = FRAME * (board_plan.frames(rate) - times * board_plan.frames(option.rate))
            found.append((times * option.cycles + telemetry, apart))
        return tuple(found)

    def _render(self, trial: Trial, options, rate, delay=0.0, spec=None, quantum=0.0, force=math.inf):
        key = trial.label, options, rate, delay, repr(spec), quantum, force
        if key not in self.rendered:
            q, loop = self._question, LoopSettings(rate, delay, "difference" if spec is None else spec)
            device = replace(q.device, quantum=quantum, max_force=force)
            given = q.environment, q.with_options(options), device, loop
            scene = headless.Scene(*given, true_velocity=spec is None, designed_for=q.device.quantum)
            self.rendered[key] = trials.render(scene, trial)
        return self.rendered[key]


def shapley(value: Mapping[frozenset[str], float], players: list[str]) -> dict[str, float]:
    """Return each player's Shapley value, which is its mean gain over all orders of the players."""
    count = len(players)
    weight = [1.0 / (count * math.comb(count - 1, size)) for size in range(count)]
    return {
        one: sum(
            weight[len(others)] * (value[frozenset((*others, one))] - value[frozenset(others)])
            for size in range(count)
            for others in combinations([p for p in players if p != one], size)
        )
        for one in players
    }


@dataclass(frozen=True)
class SceneResult:
    """Every option of a scene; ``refused`` has the reason why the board cannot render a method.

    ``refused`` is indexed by the method's description. ``ideal_rate`` is the highest rate in Hz of the ideal
    over all trials.
    """

    question: SceneRequest
    options: tuple[Option, ...]
    refused: Mapping[str, str]
    ideal_rate: float
    ideal: Ideal = field(repr=False, compare=False)

    def at(self, place: str) -> tuple[Option, ...]:
        """Return the options of a place."""
        return tuple(o for o in self.options if o.place == place)

    def find(self, place: str, options: Options) -> Option | None:
        """Return the option of a place with these methods."""
        return next((o for o in self.at(place) if o.options == options), None)

    def default(self, place: str) -> Option | None:
        """Return the option with the scene's default methods."""
        return self.find(place, tuple((c.key, c.default) for c in self.question.choices))

    def in_force(self, place: str) -> Option | None:
        """Return the option with the selected methods."""
        return self.find(place, self.question.options)

    def knows(self, question: SceneRequest) -> bool:
        """Return True if the options apply to another request, which may differ only in its methods."""
        before = self.question
        return replace(question, values=question.with_options(before.options)) == before

    def admissible(self, place: str) -> list[Option]:
        """Return the options that may be recommended: those with a stability margin of MARGIN.

        If there are none, return those within 2 % of the highest limit. The limit of a nonlinear estimator
        is unknown; then no option is excluded because of its limit.
        """
        options = self.at(place)
        enough = [o for o in options if self.is_stable_enough(o)]
        if enough or not options:
            return enough
        top = max(o.limit for o in options)
        return [o for o in options if math.isnan(top) or o.limit >= _LEAST_LIMIT * top]

    def is_stable_enough(self, option: Option) -> bool:
        """Return True if an option is stable up to MARGIN times the scene's stiffness."""
        wanted = MARGIN * self.question.stiffness
        return wanted == 0.0 or option.limit >= wanted

    def recommended(self, place: str) -> Option | None:
        """Return the admissible option with the least error.

        If errors are equal, the cheapest option is preferred, then the default option.

        On a computer every method takes less than a thousandth of a period, so its cost is ignored.
        """
        options, default = self.admissible(place), self.default(place)
        tied = [o for o in options if o.error <= min(p.error for p in options) + KNOWN]
        cost = {o: 0.0 if place == COMPUTER else o.cycles for o in tied}
        return min(tied, key=lambda o: (cost[o], o is not default), default=None)

    def sentence(self, place: str) -> str:
        """Return a sentence on the best option on the computer or on the board (``place``)."""
        best = self.recommended(place)
        if best is None:
            return next(iter(self.refused.values()), "")
        where = f"On the {place}{f', use {best.method}' * bool(best.method)} at {hertz(best.rate)}"
        limit, error = limit_text(best.limit), jnd(best.error)
        if best.error < 1.0:
            return f"{where}: the scene feels like the ideal scene. Stiffness without a hand: {limit}."
        felt = f"most people feel that the scene differs from the ideal scene ({error})"
        return f"{where}: {felt}. Stiffness without a hand: {limit}."

    def reason(self, place: str) -> str:
        """Return the reason for the choice: the cost of a more accurate method, or the error's main parts."""
        best = self.recommended(place)
        if best is None:
            return ""
        wanted, warning = f"{self.question.stiffness:,.0f} N/m", ""
        if not (self.is_stable_enough(best) or math.isnan(best.limit)):
            warning = f"No option is stable up to {MARGIN:g} times this scene's stiffness ({wanted})."
            near = best.limit >= self.question.stiffness
            warning += (
                " The best option is close to its limit."
                if near
                else " The best option needs a hand or friction to come to rest."
            )
        return " ".join(filter(None, (warning, self._cause(best))))

    def _cause(self, best: Option) -> str:
        if not best.parts or best.error < KNOWN:
            return ""
        own = best.parts[0]
        truer = [o for o in self.at(best.place) if o.parts and abs(o.parts[0]) < abs(own)]
        other = min(truer, key=lambda o: o.error, default=best)
        if other.error > best.error + KNOWN and other.rate < 0.95 * best.rate:
            return (
                f"{other.method} is more accurate, but on this {best.place} it lowers the rate to "
                f"{hertz(other.rate)}. Your hand feels the lower rate more than the method's error."
            )
        size, part = max(zip(best.parts, PARTS, strict=True))
        most = f"The largest part of the error is the {PART_WORDS.get(part, part)}: {jnd(size)}."
        most += " You can choose a different velocity filter under Loop, for all scenes." * (part == VELOCITY)
        if own >= -KNOWN:
            return most
        pairs = zip(self.question.choices, best.options, strict=True)
        ahead = any(choice.text(value) == "semi_implicit" for choice, (_, value) in pairs)
        lead = "runs half a step ahead" if ahead else "has an error of the opposite sign"
        return f"{most} {best.method} {lead}, which cancels {jnd(-own)} of the total error."


def jnd(error: float) -> str:
    """Format an error in JND."""
    small = "0" if abs(error) < 0.005 else significant(error, 3 if abs(error) >= 10.0 else 2)
    return f"{'> 999' if error > 999.0 else small} JND"


def delay_text(options: Iterable[Option]) -> str:
    """Format each place's delay in ms; on the board it depends on the method."""
    found: dict[str, list[float]] = {}
    for option in options:
        found.setdefault(option.place, []).append(1e3 * option.delay)
    ends = {place: [f"{float(f'{end(ms):.2g}'):g}" for end in (min, max)] for place, ms in found.items()}
    return ", ".join(f"{place} {' to '.join(dict.fromkeys(pair))} ms" for place, pair in ends.items())


def hertz(rate: float) -> str:
    """Format a rate, rounded to 10 Hz."""
    return f"{round(rate, -1):,.0f} Hz"


def limit_text(limit: float) -> str:
    """Format a loop's stiffness limit."""
    if math.isnan(limit):
        return "limit unknown"
    if limit < 0.5:  # the loop is unstable at any stiffness
        return "never stable"
    return "any stiffness" if math.isinf(limit) else f"stable up to {limit:,.0f} N/m"


def limit_of(question: SceneRequest, options: Options, rate: float, delay: float, spec: Spec) -> float:
    """Return the exact stiffness limit of a released handle or, with an object, of a handle that presses it.

    The damping is that of the exact method: additional damping near zero speed, such as the slope of a
    smoothed friction, does not permit a stiffer spring.
    """
    device, environment = question.device, question.environment
    setting = LoopSettings(
        rate, delay, spec, mass=device.mass, viscous=device.viscous, quantum=device.quantum
    )
    if setting.linear and objects.has_object(environment):
        return objects.contact_limit(setting, environment.key, question.with_options(options))
    values, impedance = question.with_options(question.exact), environment.impedance
    return float(kb_plane.limit(setting, impedance(values)[1] if impedance else 0.0))


# Cache of the reasons why the board has no code for a law. The key contains the law, its choices, and whether
# each number is 0, because the code does not depend on other values of the numbers.
_REFUSED: dict[tuple, str] = {}


def loop_of(question: SceneRequest, place: Place, options: Options) -> Option | str:
    """Return an option with its rate, delay, cost and limit, or the reason why the board cannot render it."""
    spec = question.spec(place.name)
    rate, cycles, tick = place.rate, math.nan, math.nan
    delay = 1.0 / rate if place.delay is None else place.delay
    if place.name == BOARD:
        values, environment = question.with_options(options), question.environment
        numbers = [(values[p.key], p.discrete) for p in environment.parameters]
        shape = environment.force, tuple(v if discrete else v == 0.0 for v, discrete in numbers)
        request = PlanRequest(environment, values, rate=place.rate)
        planned = _REFUSED.get(shape) or BoardPlanner(ARENA).plan(request)
        if isinstance(planned, str):
            return _REFUSED.setdefault(shape, planned)
        rate, cycles, tick = planned.rate, CLOCK * planned.share, planned.program.usual
        if place.delay is None:
            delay = (tick + REST_AT_MOST) / CLOCK
    limit = limit_of(question, options, rate, delay, spec)
    return Option(place.name, options, spec, question.options_text(options), rate, delay, cycles, tick, limit)


def compute(question: SceneRequest, progress: Progress = no_progress) -> SceneResult:
    """Compute every option of a scene with its error; ``split`` then splits the errors into parts."""
    ideal, found, refused = Ideal(question), [], {}
    every = list(product(question.places, question.methods()))
    for done, (place, options) in enumerate(every):
        progress(done, len(every))
        option = loop_of(question, place, options)
        if isinstance(option, str):
            refused[question.options_text(options)] = option
        else:
            found.append(_judged(option, ideal))
    progress(len(every), len(every))
    return SceneResult(question, tuple(found), refused, max(ideal.rates.values()), ideal)


def _judged(option: Option, ideal: Ideal) -> Option:
    felt = [(ideal.error(trial, option), trial.label) for trial in ideal.trials]
    most, hand = max(felt, key=lambda one: one[0].most)
    return replace(option, error=most.most, sense=most.word, hand=hand)


def in_force(question: SceneRequest, before: SceneResult) -> list[Option | str]:
    """Return each place's option with the selected methods, or the reason why the place cannot render it.

    This is quick, because the earlier result contains the ideal's rates.
    """
    rates = {trial: min(rate, LIVE_IDEAL) for trial, rate in before.ideal.rates.items()}
    ideal, options, found = Ideal(question, rates), question.options, []
    for place in question.places:
        known = before.find(place.name, options) if place in before.question.places else None
        option = known or loop_of(question, place, options)
        if not isinstance(option, str):
            spec = question.spec(place.name)
            limit = limit_of(question, options, option.rate, option.delay, spec)
            option = _judged(replace(option, estimator=spec, limit=limit, parts=()), ideal)
        found.append(option)
    return found


def split(result: SceneResult, progress: Progress = no_progress) -> SceneResult:
    """Return the same options with each error split into its parts."""
    options = []
    for done, option in enumerate(result.options):
        progress(done, len(result.options))
        judged = bool(result.question.choices) and option.place == BOARD
        own = result.ideal.own(option) if judged else ()
        options.append(replace(option, parts=result.ideal.parts(option), own=own))
    progress(len(options), len(options))
    result.ideal.rendered.clear()  # this frees up to 100 MB
    return replace(result, options=tuple(options))
