"""The axes of a picture of speed against accuracy: how far they go, their units, and where zero is drawn."""

import math
from typing import TYPE_CHECKING, Any

from hapkit_studio.charts.style import Colors, dress

if TYPE_CHECKING:
    from hapkit_studio.analysis.accuracy import Point, Sheet

# An error below this is none: no sensor shows it, and rounding made it.
_NOTHING = {"": 1e-17, "m/s": 1e-9}
_NS = 1e-3
_MOST, _INSIDE = 1e6, 0.97
# So far do errors go that only powers of ten tell them; so little do costs that 2 and 5 have ticks.
_WIDE, _NARROW = 1e8, 300.0


class Frame:
    """Error in % or mm/s or µm/s over cost in µs; errors of nothing stand on a row of their own, named 0."""

    def __init__(self, sheet: "Sheet"):
        self._sheet = sheet
        scene = sheet.scene
        self._nothing = _NOTHING[scene.unit]
        small = scene.unit == "m/s" and scene.tolerance < 1e-4
        self.factor = (1e6 if small else 1e3) if scene.unit == "m/s" else 1.0
        self.unit = (", µm/s" if small else ", mm/s") if scene.unit == "m/s" else ""
        errors = [p.error for p in sheet.points if self._nothing < p.error < _MOST] + [scene.tolerance]
        low, high = math.log10(min(errors) * self.factor), math.log10(max(errors) * self.factor)
        air = 0.08 * (high - low) + 0.12
        self.has_zero = any(p.error <= self._nothing for p in sheet.points)
        self._zero = 10.0 ** (low - 2.0 * air)
        self.bottom = 10.0 ** (low - (3.2 * air if self.has_zero else air))
        self.top = 10.0 ** (high + air)
        costs = [p.ns_per_simulated_s * _NS for p in sheet.points]
        span = math.log10(max(costs) / min(costs))
        room = 0.05 if scene.step_s else 0.12
        self.left, self.right = (
            min(costs) / 10 ** (room * (1.0 + span)),
            max(costs) * 10 ** (0.12 + 0.34 * span),
        )

    def place(self, point: "Point") -> tuple[float, float]:
        """Return where a point is drawn: one whose error is lost in growth, at the upper edge."""
        edge = self.top**_INSIDE * self.bottom ** (1.0 - _INSIDE)
        error = self._zero if point.error <= self._nothing else min(point.error * self.factor, edge)
        return point.ns_per_simulated_s * _NS, error

    def dress(self, axes: Any, c: Colors) -> None:
        """Set ranges, ticks, grid and titles."""
        error = f"{self._sheet.scene.error}{self.unit} (less is better)"
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlim(self.left, self.right)
        axes.set_ylim(self.bottom, self.top)
        self._across(axes)
        self._up(axes)
        dress(axes, c, "computing time per simulated second (less is faster)", error)

    def _across(self, axes: Any) -> None:
        from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

        subs = (1, 2, 5) if self.right / self.left < _NARROW else (1,)
        ticks = [sub * 10.0**power for power in range(-2, 6) for sub in subs]
        axes.xaxis.set_major_locator(FixedLocator([t for t in ticks if self.left <= t <= self.right]))
        axes.xaxis.set_minor_locator(NullLocator())
        axes.xaxis.set_major_formatter(
            FuncFormatter(lambda t, _: f"{t / 1e3:g} ms" if t > 999.0 else f"{t:g} µs")
        )

    def _up(self, axes: Any) -> None:
        from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

        floor = self._zero * 1.5 if self.has_zero else self.bottom
        decades = math.log10(self.top / floor)
        every = 1 if self.top / self.bottom < _WIDE else 3
        subs = (1, 2, 5) if decades < 2.5 else (1,)
        powers = range(math.floor(math.log10(floor)), math.ceil(math.log10(self.top)) + 1)
        ticks = [sub * 10.0**power for power in powers if power % every == 0 for sub in subs]
        ticks = [t for t in ticks if floor <= t <= self.top] + ([self._zero] if self.has_zero else [])
        axes.yaxis.set_major_locator(FixedLocator(ticks))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter(FuncFormatter(lambda t, _: self._tick(t)))

    def _tick(self, value: float) -> str:
        if self.has_zero and math.isclose(value, self._zero):
            return "0"
        if not self.unit and 1e-3 <= value < 10.0 and self.top / self.bottom < _WIDE:
            return f"{100.0 * value:g} %"
        if 1e-3 <= value < 1e4 and (self.unit or value >= 1.0):
            return f"{value:g}"
        return f"$10^{{{round(math.log10(value))}}}$"
