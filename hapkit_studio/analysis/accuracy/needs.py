"""Which terms of device and loop a scene needs: how strongly people feel each term, and what it costs.

The reference is a simulation with every term. Then one term at a time is removed, and the simulation without
the term is compared with the reference. This is done for each of the scene's hands, and for a hand that
pushes beyond the force limit.
A term is needed if people feel the difference, that is, if it exceeds one just-noticeable difference (JND).
Of the other terms, as many as possible are removed together without a felt difference. If no hand shows a
difference, the hands also throw the handle at other speeds, run longer, and release it at various times.

A term of a law is a parameter that may be zero. Its cost is measured in cycles of the board.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.analysis.accuracy import trials
from hapkit_studio.analysis.accuracy.scene import ON_BOARD, Option, SceneRequest, hertz, limit_of, loop_of
from hapkit_studio.analysis.accuracy.trials import Trial
from hapkit_studio.analysis.perception import FORCE_SHARE, RATE, Difference
from hapkit_studio.analysis.sweeps import Progress, no_progress
from hapkit_studio.devices.simulated import TERMS, SimulatedHapkit
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.base import Environment
from hapkit_studio.formatting import MINUS
from hapkit_studio.haptics import headless
from hapkit_studio.parameters import Parameter

FINE_RATE = 16_000.0  # Hz: rate of the reference loop, which is practically continuous
DELAY = 1e-3
ESTIMATOR: Spec = ("iir", {"cutoff": 35.5})
PUSH = "push"  # script of the hand that pushes beyond the force limit
# rates in Hz, delays in s and relative stiffnesses at which a term is tested
RATES = np.geomspace(500.0, 8000.0, 9)
DELAYS = np.geomspace(0.05e-3, 12.8e-3, 9)
LEAST = 0.02  # terms that take a smaller fraction of a law's cycles are not listed
STIFFER = np.geomspace(1.0 / 16.0, 16.0, 9)


@dataclass(frozen=True)
class Effect:
    """The largest effect of removing a term, over all senses and all motions of a hand.

    ``felt`` is the effect in JND, None if it was not evaluated. ``strict`` is the effect in the JND of the
    most sensitive people. ``since`` is the value at which the term begins to be felt: for sampling a rate in
    Hz, for other terms a delay in s or a stiffness in N/m; NaN if it was not found. ``limit`` and
    ``without`` are the released handle's exact stiffness limits in N/m with and without the term.
    """

    scene: str
    term: str
    felt: float | None
    sense: str = ""
    hand: str = ""
    strict: float | None = None
    since: float = math.nan
    limit: float = math.nan
    without: float = math.nan

    @property
    def since_text(self) -> str:
        """Format the highest rate, or the least delay or stiffness, at which the term is felt."""
        if math.isnan(self.since):
            return "–"
        if self.since == 0.0:
            return "always"
        if self.term == "sampling":
            return f"up to {hertz(float(f'{self.since:.2g}'))}"
        number, unit = (1e3 * self.since, "ms") if self.term == "delay" else (self.since, "N/m")
        return f"from {float(f'{number:.2g}'):,g} {unit}"

    @property
    def gain_text(self) -> str:
        """Format the change of the exact stiffness limit that follows from removing the term."""
        gain = self.without - self.limit
        return "–" if math.isnan(gain) or abs(gain) < 0.5 else f"{gain:+,.0f} N/m".replace("-", MINUS)

    @property
    def needed(self) -> bool:
        """Return True if most people feel the effect of this term alone."""
        return self.felt is not None and self.felt > 1.0

    @property
    def differs(self) -> bool:
        """Return True if only the most sensitive people feel the effect."""
        return self.strict is not None and (self.strict > 1.0) != self.needed


@dataclass(frozen=True)
class LawTerm:
    """A law's cycles per tick, rate in Hz and limit in N/m on the board, with and without a parameter."""

    key: str
    label: str
    cycles: tuple[float, float]
    rate: tuple[float, float]
    limit: tuple[float, float]

    @property
    def text(self) -> str:
        """Describe how much faster the law is without the term."""
        shown = self.cycles, [round(rate, -1) for rate in self.rate], self.limit  # rates as in ``hertz``
        cycles, rate, limit = (f"{a:,.0f} → {b:,.0f}" for a, b in shown)
        return f"{self.label} = 0: {cycles} processor cycles per period, {rate} Hz, stable up to {limit} N/m"


@dataclass(frozen=True)
class Needs:
    """A scene's effects (one per term), the needed terms, and the effect of removing all other terms.

    ``law`` contains the cost of each term of the scene's law.
    """

    scene: str
    effects: tuple[Effect, ...]
    needs: tuple[str, ...]
    together: Effect
    law: tuple[LawTerm, ...]


class _Rendered:
    """Renders a scene at its default values without some terms; runs with all terms are cached."""

    def __init__(self, environment: Environment, force_share: float = FORCE_SHARE):
        self.environment, self._force_share = environment, force_share
        self._whole: dict[tuple, np.ndarray] = {}

    def hands(self, gone: Sequence[str]) -> list[Trial]:
        """Return the trials that show the effect of removing some terms; PUSH is the last one."""
        scripted = [*trials.scripts(self.environment), trials.script(PUSH)]
        return [trial for trial in scripted if tuple(gone) != ("mass",) or trial.holds]

    def run(
        self,
        trial: Trial,
        gone: Iterable[str],
        rate: float = RATE,
        delay: float = DELAY,
        stiffer: float = 1.0,
    ) -> np.ndarray:
        """Return the rows of a trial; ``stiffer`` multiplies the scene's default stiffness."""
        removed = set(gone)
        if not trial.holds:
            removed.discard("mass")
        environment, values = self.environment, self.environment.values()
        if stiffer != 1.0:
            values[stiffness_of(environment).key] *= stiffer  # type: ignore[union-attr]
        rate = FINE_RATE if "sampling" in removed else rate
        loop = LoopSettings(rate, 0.0 if "delay" in removed else delay, ESTIMATOR)
        device = SimulatedHapkit().without(removed)
        scene = headless.Scene(environment, values, device, loop, true_velocity="filter" in removed)
        return trials.render(scene, trial)

    def difference(self, trial: Trial, gone: Iterable[str], **how: float) -> Difference:
        """Return the felt difference between a trial with all terms and the same trial without some terms.

        ``how`` are arguments of ``run``.
        """
        key = trial.label, *how.items()
        if key not in self._whole:
            self._whole[key] = self.run(trial, (), **how)
        one, other = self._whole[key], self.run(trial, gone, **how)
        return trials.felt(self.environment, trial, one, other, self._force_share)

    def effect(self, label: str, gone: Sequence[str]) -> Effect:
        """Return the largest felt difference, over all hands, that is caused by removing some terms."""
        scripted = self.hands(gone)
        tried = [(self.difference(trial, gone), trial.label) for trial in scripted]
        if max((one.most for one, _ in tried), default=0.0) <= 1.0:
            for trial in (variant for one in scripted[:-1] for variant in trials.variants(one)):
                tried.append((self.difference(trial, gone), trial.label))
        if not tried:
            return Effect(self.environment.key, label, None)
        most, hand = max(tried, key=lambda one: one[0].most)
        strict = max(one.strict.most for one, _ in tried)
        return Effect(self.environment.key, label, most.most, most.word, hand, strict)

    def since(self, term: str) -> float:
        """Return the highest rate, or the least delay or stiffness, at which a term is felt."""

        def found(setting: str, places: np.ndarray) -> float:
            hands = self.hands((term,))
            tried = [[self.difference(t, (term,), **{setting: at}).most for t in hands] for at in places]
            return crossing(places, [max(felt, default=0.0) for felt in tried])

        if term == "sampling":
            return found("rate", RATES[::-1])
        if term == "delay":
            return found("delay", DELAYS)
        wanted = stiffness_of(self.environment)
        return wanted.default * found("stiffer", STIFFER) if wanted else math.nan


def crossing(places: np.ndarray, felt: Sequence[float]) -> float:
    """Return the first value at which 1 JND is felt, by logarithmic interpolation.

    Return NaN if it is not felt at any value, and 0 if it is felt at the first one.
    """
    at = next((k for k, jnd in enumerate(felt) if jnd >= 1.0), None)
    if not at:
        return math.nan if at is None else 0.0
    low, high = math.log(max(felt[at - 1], 1e-6)), math.log(min(felt[at], 1e6))
    ratio = places[at] / places[at - 1]
    return float(places[at - 1] * ratio ** (-low / (high - low)))


def stiffness_of(environment: Environment) -> Parameter | None:
    """Return a scene's stiffness parameter; None for a scene without a stiffness."""
    wanted = SceneRequest(environment, environment.values()).stiffness
    own = (p for p in environment.parameters if isinstance(p, Parameter) and p.unit == "N/m")
    return next((p for p in own if p.default == wanted), None)


def _limit(environment: Environment, gone: str = "") -> float:
    """Return the exact stiffness limit in N/m without a term; NaN if this term is the mass."""
    if gone == "mass":
        return math.nan
    device = SimulatedHapkit().without((gone,) if gone else ())
    rate, delay = FINE_RATE if gone == "sampling" else RATE, 0.0 if gone == "delay" else DELAY
    spec: Spec = "difference" if gone == "filter" else ESTIMATOR
    question = SceneRequest(environment, environment.values(), device=device)
    return limit_of(question, question.options, rate, delay, spec)


def law_terms(environment: Environment) -> tuple[LawTerm, ...]:
    """Return the cost of those parameters of a law that may be 0; the most expensive one is first.

    The limits are those of the law with and without the term, each at its own rate and delay.
    """
    found = []
    for parameter in environment.parameters:
        if not isinstance(parameter, Parameter) or not parameter.low <= 0.0 < parameter.high:
            continue
        pair = []
        for value in (parameter.default or 0.5 * parameter.high, 0.0):
            question = SceneRequest(environment, {**environment.values(), parameter.key: value})
            pair.append(loop_of(question, ON_BOARD, question.options))
        full, bare = pair
        if isinstance(full, Option) and isinstance(bare, Option) and full.tick >= (1.0 + LEAST) * bare.tick:
            limits = [limit_of(question, bare.options, o.rate, o.delay, "kalman") for o in (full, bare)]
            shown = (full.tick, bare.tick), (full.rate, bare.rate), (limits[0], limits[1])
            found.append(LawTerm(parameter.key, parameter.label, *shown))
    return tuple(sorted(found, key=lambda term: term.cycles[1] - term.cycles[0]))


def compute(
    environment: Environment, progress: Progress = no_progress, force_share: float = FORCE_SHARE
) -> Needs:
    """Compute the effect of each term in a scene at its default values.

    ``progress`` is called with the number of completed steps and the total number. ``force_share`` is the
    relative JND of a force.
    """
    rendered, steps = _Rendered(environment, force_share), len(TERMS) + 2
    effects: list[Effect] = []
    for key in TERMS:
        progress(len(effects) + 1, steps)
        found, limit, without = rendered.effect(key, (key,)), _limit(environment), _limit(environment, key)
        effects.append(replace(found, since=rendered.since(key), limit=limit, without=without))
    progress(steps - 1, steps)
    spare = sorted((e for e in effects if not e.needed), key=lambda e: e.felt or 0.0)
    while (together := rendered.effect("together", [e.term for e in spare])).needed:
        spare.pop()
    progress(steps, steps)
    needs = tuple(e.term for e in effects if e not in spare)
    return Needs(environment.key, tuple(effects), needs, together, law_terms(environment))
