"""The Z-width and its measurement: protocol, search for the stiffest wall, conditions, sentences."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hapkit_studio.analysis.checks import checked_row
from hapkit_studio.analysis.stability.kb_plane import exact_boundary
from hapkit_studio.analysis.stability.margin import hand_text
from hapkit_studio.analysis.zwidth import DAMPING, HIGHEST, MAX_FORCE, PUSH, SPEED
from hapkit_studio.columns import Column, text_lines
from hapkit_studio.dynamics.loop_settings import LoopSettings, estimator_texts
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import compact, plain

_CURVE = 81
# value of the condition "hand" for a wall that a person presses
PERSON = "person"
# reasons why a search ended
BUZZES, GROWS, LEAVES, FAST = "buzzes", "grows", "leaves", "fast"
ENDED = {
    BUZZES: "the handle buzzes",
    GROWS: "the buzz grows",
    LEAVES: "the wall throws the handle away",
    FAST: "the handle moves too fast",
    HIGHEST: "no stiffer wall was tried",
}


@dataclass(frozen=True)
class Condition:
    """A condition of the measurement: key and SI value for programs, name and text for people.

    ``short`` is the name in a list, if it differs.
    """

    key: str
    value: float | str
    name: str
    text: str
    short: str = ""

    @property
    def short_text(self) -> str:
        """Return name and text for a list."""
        return f"{self.short or self.name[0].lower() + self.name[1:]} {self.text}"


class Row(NamedTuple):
    """One damping in N·s/m, its wall, and the exact limit in N/m, NaN for a nonlinear loop."""

    damping: float
    point: "Point"
    linear: float


@dataclass(frozen=True)
class ZWidth:
    """For each damping (n,) in N·s/m, the stiffness in N/m up to which the handle settled at every wall.

    ``linear`` is the exact limit (n,) in N/m, NaN for a nonlinear loop. ``curve`` (2, m) contains
    more closely spaced dampings and their limits. ``where`` is "simulation" or the device's title.
    """

    where: str
    damping: np.ndarray
    points: "tuple[Point, ...]"
    linear: np.ndarray
    curve: np.ndarray
    conditions: tuple[Condition, ...]

    @classmethod
    def of(
        cls,
        where: str,
        levels: Sequence[float],
        points: "Sequence[Point]",
        setting: LoopSettings,
        conditions: "tuple[Condition, ...]",
    ) -> "ZWidth":
        """Combine the points found at each damping with the exact limits of the linear loop."""
        damping, fine = np.array(levels), np.linspace(0.0, levels[-1] or 1.0, _CURVE)
        linear, curve = (
            exact_boundary(setting, across) if setting.linear else np.full(len(across), math.nan)
            for across in (damping, fine)
        )
        return cls(where, damping, tuple(points), linear, np.array([fine, curve]), conditions)

    @property
    def rows(self) -> list[Row]:
        """Return a row per damping."""
        return [Row(*row) for row in zip(self.damping, self.points, self.linear, strict=True)]

    @property
    def stiffness(self) -> np.ndarray:
        """Return the stiffness (n,) in N/m up to which all walls settled, for each damping."""
        return np.array([point.stiffness for point in self.points])

    @property
    def sentence(self) -> str:
        """Return a sentence on the stiffest wall, and one on stiffer walls if only some of them settle."""
        if not len(self.damping) or not (self.stiffness > 0.0).any():
            return f"The handle did not come to rest at any wall ({self.hand})."
        return f"{self.at(self.best)}{self.motor(self.best)}.{self.band(self.best)}"

    @property
    def best(self) -> int:
        """Return the index of the stiffest wall."""
        return int(np.argmax(self.stiffness))

    @property
    def hand(self) -> str:
        """Return the hand as text, such as "no hand" or "medium grip"."""
        grip = next(str(c.value) for c in self.conditions if c.key == "hand")
        return "a person's hand" if grip == PERSON else hand_text(grip)

    def motor(self, index: int) -> str:
        """Return a remark if the motor limits a point; "" if the loop limits the point."""
        if not self.points[index].clamped:
            return ""
        limit = next((c.text for c in self.conditions if c.key == "max_force"), "")
        return ", with the motor at its limit" + (f" of {limit}" if limit not in ("", "none") else "")

    def at(self, index: int) -> str:
        """Describe one point, without a full stop."""
        point = self.points[index]
        least = "at least " if point.ended == HIGHEST else ""
        most = f"{least}{three_digits(point.stiffness)} N/m"
        where = f"With damping b = {self.damping[index]:g} N·s/m ({self.hand})"
        return f"{where}, the handle comes to rest at all tested walls up to {most}"

    def band(self, index: int) -> str:
        """Describe the band in which walls settle or buzz, with a leading space; "" if the limit is sharp."""
        ends = self.points[index].band
        return f" From there to {ends} N/m it rests at some walls and buzzes at others." if ends else ""

    @property
    def place(self) -> str:
        """Return where the Z-width was measured, with a capital letter."""
        return self.where[:1].upper() + self.where[1:]

    @property
    def caption(self) -> str:
        """Return the conditions in one line."""
        return " · ".join(c.short_text for c in self.conditions)

    def as_json(self) -> dict:
        """Return the result as an object of plain numbers; NaN becomes None."""
        rows = zip(self.damping, self.linear, self.points, strict=True)
        return plain(
            {
                "where": self.where,
                "points": [{"damping": b, "linear_limit": k, **vars(point)} for b, k, point in rows],
                "conditions": {c.key: c.value for c in self.conditions},
            }
        )


def three_digits(value: float) -> str:
    """Format a stiffness with three digits, rounded down."""
    if value < 100.0:
        return compact(value, 3)
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{step * math.floor(value / step):,.0f}"


COLUMNS = (
    Column("b", lambda row: compact(row.damping), lambda row: row.damping, right=False, unit="N·s/m"),
    Column(
        "Stable up to", lambda row: three_digits(row.point.stiffness), lambda row: row.point.stiffness,
        unit="N/m",
    ),
    Column(
        "Partly stable up to", lambda row: row.point.band or "–", lambda row: row.point.last_held,
        unit="N/m",
    ),
)  # fmt: skip
_MORE_COLUMNS = (
    Column(
        "Exact boundary", lambda row: f"{row.linear:,.0f}" if math.isfinite(row.linear) else "–", unit="N/m"
    ),
    Column(
        "Above the limit",
        lambda row: ENDED[row.point.ended] + ", with the motor at its limit" * row.point.clamped,
        right=False,
    ),
)


def text(result: ZWidth) -> str:
    """Return the verdict, a line for each damping with the exact boundary, and the conditions, as text."""
    lines = text_lines((*COLUMNS, *_MORE_COLUMNS), result.rows)
    return "\n".join([result.sentence, "", *lines, "", f"Conditions: {result.caption}"])


# Largest number of samples of a hit, which limits the memory: a row takes 256 bytes. Smallest number of
# samples in the tail: fewer samples show no motion.
MOST_SAMPLES = 400_000
FEWEST_IN_TAIL = 5


@dataclass(frozen=True)
class Protocol:
    """The trial of a wall: the handle hits it at ``speed`` in m/s while the force ``push`` in N acts.

    The hit is simulated for ``seconds``, once for each sampling phase. A trial fails if the handle moves
    beyond ``travel`` in m, or by more than ``counts`` in the last ``tail`` s. The stiffness starts at
    ``softest`` in N/m. Where walls alternately pass and fail, ``apart`` is the relative step between two
    walls. ``max_force`` is the motor's limit in N, or inf. Raise ParameterError for an invalid value.
    """

    speed: float = SPEED.default
    push: float = PUSH.default
    phases: tuple[float, ...] = (1 / 6, 3 / 6, 5 / 6)
    seconds: float = 4.0
    tail: float = 0.5
    travel: float = 0.2
    counts: float = 2.0
    softest: float = 200.0
    raised: float = 1.3
    halvings: int = 14
    apart: float = 0.01
    max_force: float = math.inf

    def __post_init__(self) -> None:
        SPEED.check(self.speed)
        PUSH.check(self.push)
        if self.max_force == math.inf:
            return
        MAX_FORCE.check(self.max_force)
        if self.push >= self.max_force:
            raise ParameterError(
                f"The force limit must be above the push of {self.push:g} N; now it is {self.max_force:g} N."
            )


def samples_of(setting: LoopSettings, protocol: Protocol) -> int:
    """Return the number of samples of a hit; raise ParameterError if it is out of range."""
    seconds, rate = protocol.seconds, setting.rate
    count = round(seconds * rate)
    if count > MOST_SAMPLES or round(protocol.tail * rate) < FEWEST_IN_TAIL:
        least, most = FEWEST_IN_TAIL / protocol.tail, MOST_SAMPLES / seconds
        raise ParameterError(
            f"The rate must be between {least:,g} and {most:,g} Hz, not {rate:,g} Hz, because a trial takes "
            f"{seconds:g} s."
        )
    return count


def levels_of(damping: Sequence[float]) -> list[float]:
    """Return the virtual dampings in N·s/m, unique and sorted; raise ParameterError for invalid ones."""
    levels = sorted(set(checked_row(damping, DAMPING).tolist()))
    if not levels:
        raise ParameterError("Enter at least one value of damping for a Z-width, for example 0,1,2,5.")
    return levels


def loop_conditions(setting: LoopSettings, friction: bool = True) -> tuple[Condition, ...]:
    """Return the conditions of device and loop; ``friction`` is True if the friction is known."""
    known, rubs = (setting.coulomb, f"{setting.coulomb:g} N") if friction else (math.nan, "not known")
    given, estimator = estimator_texts(setting.estimator)
    controller = "on" if setting.controller else "off"
    return (
        Condition("rate_Hz", setting.rate, "Period", f"{1e3 * setting.period:g} ms", "T"),
        Condition("delay", setting.delay, "Delay", f"{compact(1e3 * setting.delay, 3)} ms"),
        Condition("mass", setting.mass, "Mass", f"{1e3 * setting.mass:g} g", "m"),
        Condition("viscous", setting.viscous, "Handle's damping", f"{setting.viscous:g} N·s/m", "b₀"),
        Condition("coulomb", known, "Friction", rubs),
        Condition("quantum", setting.quantum, "Sensor step", f"{compact(1e6 * setting.quantum, 3)} µm"),
        Condition("estimator", given, "Velocity filter", estimator),
        Condition("controller", controller, "Passivity controller", controller, "controller"),
    )


def conditions(setting: LoopSettings, protocol: Protocol) -> tuple[Condition, ...]:
    """Return all conditions of a simulated Z-width."""
    limit = protocol.max_force
    return (
        *loop_conditions(setting),
        Condition(
            "hand", setting.hand, "Hand", setting.hand if setting.grip else "none, only a constant push"
        ),
        Condition("speed", protocol.speed, "Impact speed", f"{protocol.speed:g} m/s", "v₀"),
        Condition("push", protocol.push, "Push", f"{protocol.push:g} N"),
        Condition("max_force", limit, "Force limit", f"{limit:g} N" if limit < math.inf else "none"),
        Condition("apart", protocol.apart, "Precision of the stiffness", f"{100.0 * protocol.apart:g} %"),
    )


@dataclass(frozen=True)
class TrialOutcome:
    """The outcome of a trial: why the wall failed, "" if it passed, and whether the motor saturated."""

    why: str
    clamped: bool = False


@dataclass(frozen=True)
class Point:
    """The stiffness in N/m up to which all walls passed, and the reason why the next wall failed.

    ``ended`` is one of ENDED. ``clamped`` is True if the motor limits the stiffness. ``first_failed`` is the
    softest wall that failed, inf if none failed, and ``last_held`` the stiffest wall that passed.
    """

    stiffness: float
    ended: str
    clamped: bool = False
    first_failed: float = math.inf
    last_held: float = 0.0

    @property
    def band(self) -> str:
        """Format the stiffest wall in N/m that passed above a failed wall; "" if the limit is sharp."""
        return three_digits(self.last_held) if self.first_failed < self.last_held else ""


def stiffest(
    held: Callable[[float], TrialOutcome], softest: float, raised: float, highest: float, halvings: int
) -> Point:
    """Increase the stiffness until a wall fails, then bisect; return the stiffest wall that passed, or 0.

    Walls stiffer than the first failed wall, or than ``highest``, are not tried.
    """
    low, high = Point(0.0, HIGHEST, False), softest
    while not (verdict := held(high)).why:
        low = Point(high, HIGHEST, verdict.clamped, last_held=high)
        if high >= highest:
            return low
        high = min(high * raised, highest)
    why = verdict.why
    for _ in range(halvings):
        middle = 0.5 * (low.stiffness + high)
        verdict = held(middle)
        if verdict.why:
            high, why = middle, verdict.why
        else:
            low = Point(middle, why, verdict.clamped)
    return Point(low.stiffness, why, low.clamped, high, low.stiffness)


# relative distance: the band ends where all walls within this distance pass (below) or fail (above)
_CLEAR = 0.1


def band_trials(apart: float) -> int:
    """Return the number of walls that are tried on either side of a sharp limit."""
    return round(_CLEAR / apart)


def with_band(
    held: Callable[[float], TrialOutcome], point: Point, apart: float, softest: float, highest: float
) -> Point:
    """Return the point at the lower end of the band in which walls alternately pass and fail.

    Walls with relative spacing ``apart`` are tried: from the limit down until all walls within 10 % pass,
    then from the limit up until all walls within 10 % fail. All tried walls are between ``softest``, which
    passed, and ``highest``.
    """
    if point.ended == HIGHEST or point.stiffness == 0.0:
        return point
    limit = point.stiffness
    for factor, holds in ((1.0 / (1.0 + apart), True), (1.0 + apart, False)):
        stiffness, alike = factor * limit, 0
        while alike < band_trials(apart) and softest <= stiffness <= highest:
            tried = held(stiffness)
            if failed := bool(tried.why):
                below = min(point.stiffness, max(factor * stiffness, softest))
                point = replace(point, stiffness=below, first_failed=min(point.first_failed, stiffness))
            else:
                clamped = tried.clamped if stiffness == point.stiffness else point.clamped
                point = replace(point, clamped=clamped, last_held=max(point.last_held, stiffness))
            alike = alike + 1 if failed != holds else 0
            stiffness *= factor
    return point
