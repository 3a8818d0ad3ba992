"""What a Z-width is: the stiffest wall at each virtual damping, the conditions, the words."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hapkit_studio.analysis.zwidth_limits import HIGHEST
from hapkit_studio.dynamics.estimators import Spec, parse

if TYPE_CHECKING:
    from hapkit_studio.analysis.zwidth_search import Point

# Why the search at one damping ended.
BUZZES, GROWS, LEAVES, FAST = "buzzes", "grows", "leaves", "fast"
ENDED = {
    BUZZES: "it buzzes",
    GROWS: "its buzz grows",
    LEAVES: "it throws the handle away",
    FAST: "it moves the handle too fast",
    HIGHEST: "no stiffer wall was tried",
}


@dataclass(frozen=True)
class Condition:
    """One thing the measurement depends on: key and SI value for programs, name and text for people.

    short: the name in a line of many, if it is another one.
    """

    key: str
    value: float | str
    name: str
    text: str
    short: str = ""

    @property
    def words(self) -> str:
        """Return name and text for a line of many."""
        return f"{self.short or self.name[0].lower() + self.name[1:]} {self.text}"


@dataclass(frozen=True)
class ZWidth:
    """The stiffest wall (n,) in N/m that is rendered without buzzing at each damping (n,) in N·s/m.

    ends: why nothing stiffer was found, one of ENDED; clamped: whether the motor's limit was reached, so that
    the stiffness is the motor's rather than the loop's. linear: the linear loop's limit (n,), nan where there
    is none; curve (2, m): the same finely, damping and limit. where: "simulation" or the device's title.
    """

    where: str
    damping: np.ndarray
    stiffness: np.ndarray
    ends: tuple[str, ...]
    clamped: tuple[bool, ...]
    linear: np.ndarray
    curve: np.ndarray
    conditions: tuple[Condition, ...]

    @classmethod
    def of(
        cls,
        where: str,
        damping: Sequence[float],
        points: "Sequence[Point]",
        linear: np.ndarray,
        curve: np.ndarray,
        conditions: tuple[Condition, ...],
    ) -> "ZWidth":
        """Put together what a search found at each damping."""
        return cls(
            where,
            np.array(damping[: len(points)]),
            np.array([p.stiffness for p in points]),
            tuple(p.ended for p in points),
            tuple(p.clamped for p in points),
            linear[: len(points)],
            curve,
            conditions,
        )

    @property
    def sentence(self) -> str:
        """Say the stiffest wall in one sentence."""
        if not len(self.damping) or not (self.stiffness > 0.0).any():
            return "No wall was rendered without buzzing."
        return f"{self.at(self.best)}{self.motor(self.best)}."

    @property
    def best(self) -> int:
        """Return the index of the stiffest wall."""
        return int(np.argmax(self.stiffness))

    def motor(self, index: int) -> str:
        """Say that a point is the motor's rather than the loop's, "" where it is not."""
        if not self.clamped[index]:
            return ""
        limit = next((c.text for c in self.conditions if c.key == "max_force"), "")
        return ", at the motor's limit" + (f" of {limit}" if limit not in ("", "none") else "")

    def at(self, index: int) -> str:
        """Say one point, without a full stop."""
        least = "at least " if self.ends[index] == HIGHEST else "up to "
        limit = least + newtons_per_metre(float(self.stiffness[index]))
        return f"At B = {self.damping[index]:g} N·s/m this Hapkit renders {limit}"

    @property
    def place(self) -> str:
        """Say where it was measured."""
        return self.where[:1].upper() + self.where[1:]

    @property
    def caption(self) -> str:
        """Say the conditions in one line."""
        return " · ".join(c.words for c in self.conditions)

    def as_json(self) -> dict:
        """Return one object of plain numbers; None where there is no number."""
        points = zip(self.damping, self.stiffness, self.linear, self.ends, self.clamped, strict=True)
        keys = "damping", "stiffness", "linear_limit", "ended", "clamped"
        numbers = ((float(b), float(k), _number(linear), *rest) for b, k, linear, *rest in points)
        return {
            "where": self.where,
            "points": [dict(zip(keys, row, strict=True)) for row in numbers],
            "conditions": {c.key: _number(c.value) for c in self.conditions},
        }


def newtons_per_metre(value: float) -> str:
    """Write a stiffness with three digits and its unit, never more than it is."""
    if value < 100.0:
        return f"{value:.3g} N/m"
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{step * math.floor(value / step):,.0f} N/m"


def estimator_words(spec: Spec) -> tuple[str, str]:
    """Write a velocity estimator with its options: for programs as the command line takes it, for people."""
    method, options = parse(spec)
    numbers = [f"{key}={value:g}" for key, value in options.items()]
    given = f"{method.key}:{','.join(numbers)}" if numbers else method.key
    words = [f"{p.label.lower()} {options[p.key]:g} {p.unit}".rstrip() for p in method.parameters]
    return given, ", ".join([method.label, *words])


def table(result: ZWidth) -> str:
    """Return a line a damping: what was rendered, the linear limit, why it ended."""
    lines = [f"{'B, N·s/m':>9}{'K, N/m':>11}{'linear limit':>14}   beyond"]
    for index, damping in enumerate(result.damping):
        linear = result.linear[index]
        limit = f"{linear:,.0f}" if math.isfinite(linear) else "–"
        motor = ", at the motor's limit" if result.clamped[index] else ""
        ended = ENDED[result.ends[index]] + motor
        lines.append(f"{damping:>9g}{result.stiffness[index]:>11,.0f}{limit:>14}   {ended}")
    return "\n".join(lines)


def text(result: ZWidth) -> str:
    """Return verdict, table and conditions for a person."""
    return f"{result.sentence}\n\n{table(result)}\n\nConditions: {result.caption}"


def _number(value: float | str) -> float | str | None:
    return value if isinstance(value, str) else float(value) if math.isfinite(value) else None
