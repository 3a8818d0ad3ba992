"""A parameter in display units, with its limits, steps and text."""

import math

from hapkit_studio.formatting import compact
from hapkit_studio.parameters import Parameter

_ON_SCREEN = {"m": ("mm", 1000.0), "s": ("ms", 1000.0)}


class Quantity:
    """A parameter's limits, default and step in display units; ``factor`` converts SI to these units.

    If ``root`` is True, the slider follows the square root of the value, so that the user can select small
    values in a wide range.
    """

    def __init__(self, parameter: Parameter):
        self.parameter = parameter
        self.unit, self.factor = _ON_SCREEN.get(parameter.unit, (parameter.unit, 1.0))
        self.low, self.high = parameter.low * self.factor, parameter.high * self.factor
        self.default = parameter.default * self.factor
        power = 0 if parameter.whole else math.floor(math.log10((self.high - self.low) / 200.0) + 1e-9)
        self.step, self.decimals = 10.0**power, max(0, -power)
        self.root = self.low >= 0.0 and self.high > 10.0 * self.low

    def si(self, value: float) -> float:
        """Return a value in SI, clipped exactly to the parameter's limits."""
        return min(self.parameter.high, max(self.parameter.low, value / self.factor))

    def index(self, value: float) -> int:
        """Return the index of the step that is nearest to a value."""
        return round((value - self.low) / self.step)

    def moved(self, value: float, steps: int) -> float:
        """Return a value moved by some steps; it is within the limits and has no binary rounding errors."""
        return min(self.high, max(self.low, round(value + steps * self.step, self.decimals + 4)))

    def fraction(self, value: float) -> float:
        """Return a value's position on the slider, 0 to 1."""
        part = min(1.0, max(0.0, (value - self.low) / (self.high - self.low)))
        return math.sqrt(part) if self.root else part

    def value(self, fraction: float) -> float:
        """Return the value at a position on the slider; it is a multiple of the step."""
        part = min(1.0, max(0.0, fraction))
        part = part * part if self.root else part
        return self.on_step(self.low + part * (self.high - self.low))

    def on_step(self, value: float) -> float:
        """Return the multiple of the step that is nearest to a value."""
        return self.moved(self.low, self.index(value))

    def inside(self, value: float) -> bool:
        """Return True if a value is within the limits, apart from binary rounding errors."""
        dust = 1e-9 * (self.high - self.low)
        return math.isfinite(value) and self.low - dust <= value <= self.high + dust

    def text(self, value: float) -> str:
        """Format a value with the decimals of the step, or with more decimals if they are needed."""
        body = f"{value:,.{self.decimals + 4}f}"
        kept = len(body) - 4 if self.decimals else len(body) - 5
        body = body[:kept] + body[kept:].rstrip("0").rstrip(".")
        return body.replace("-", "−") if body.strip("-0.") else body.lstrip("-")

    def limits(self) -> str:
        """Return a sentence with the limits."""
        low, high = compact(self.low), compact(self.high)
        return f"{self.parameter.label} must be between {low} and {high} {self.unit}".rstrip() + "."
