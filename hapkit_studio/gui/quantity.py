"""A number as a person sees it: its unit on the screen, its step, its scale along a slider."""

import math
from dataclasses import dataclass

from hapkit_studio.parameters import Parameter

_ON_SCREEN = {"m": ("mm", 1000.0), "s": ("ms", 1000.0)}


@dataclass(frozen=True)
class Quantity:
    """Limits, default and step of a parameter in the unit on the screen; factor turns SI into it.

    root: the slider runs with the square root, so that small values of a wide range can be met.
    """

    label: str
    unit: str
    factor: float
    low: float
    high: float
    default: float
    step: float
    root: bool

    @classmethod
    def of(cls, parameter: Parameter) -> "Quantity":
        """Derive the screen's view of a declared parameter."""
        unit, factor = _ON_SCREEN.get(parameter.unit, (parameter.unit, 1.0))
        low, high = parameter.low * factor, parameter.high * factor
        step = 10.0 ** math.floor(math.log10((high - low) / 200.0) + 1e-9)
        wide = low >= 0.0 and high > 10.0 * low
        return cls(parameter.label, unit, factor, low, high, parameter.default * factor, step, wide)

    @property
    def decimals(self) -> int:
        """Return how many decimals the step needs."""
        return max(0, -math.floor(math.log10(self.step) + 1e-9))

    @property
    def steps(self) -> int:
        """Return the number of whole steps between the limits."""
        return math.ceil((self.high - self.low) / self.step - 1e-9)

    def index(self, value: float) -> int:
        """Return the step nearest to a value."""
        return round((value - self.low) / self.step)

    def at(self, index: int) -> float:
        """Return the value at a step, free of binary dust, never beyond the limits."""
        return min(self.high, round(self.low + index * self.step, self.decimals + 4))

    def moved(self, value: float, steps: int) -> float:
        """Return a value some steps on, inside the limits."""
        return min(self.high, max(self.low, round(value + steps * self.step, self.decimals + 4)))

    def fraction(self, value: float) -> float:
        """Return where a value lies along the slider, 0 to 1."""
        part = min(1.0, max(0.0, (value - self.low) / (self.high - self.low)))
        return math.sqrt(part) if self.root else part

    def value(self, fraction: float) -> float:
        """Return the value, on a whole step, at a place along the slider."""
        part = min(1.0, max(0.0, fraction))
        part = part * part if self.root else part
        return self.at(self.index(self.low + part * (self.high - self.low)))

    def inside(self, value: float) -> bool:
        """Say whether a value lies within the limits, binary dust aside."""
        dust = 1e-9 * (self.high - self.low)
        return math.isfinite(value) and self.low - dust <= value <= self.high + dust

    def text(self, value: float) -> str:
        """Write a value: at least the step's decimals, more only where the value has them."""
        body = f"{value:.{self.decimals + 4}f}"
        kept = len(body) - 4 if self.decimals else len(body) - 5
        body = body[:kept] + body[kept:].rstrip("0").rstrip(".")
        return body.replace("-", "−") if float(body) else body.lstrip("-")

    def limits(self) -> str:
        """Say the limits in one sentence."""
        low, high = (f"{x:g}".replace("-", "−") for x in (self.low, self.high))
        return f"{self.label} goes from {low} to {high} {self.unit}".rstrip() + "."
