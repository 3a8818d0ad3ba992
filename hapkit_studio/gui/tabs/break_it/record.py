"""What is known of one failure: its conditions, where its knob stands, what was tried and measured."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hapkit_studio.gui.widgets.numbers import Quantity
from hapkit_studio.parameters import Parameter

if TYPE_CHECKING:
    from hapkit_studio.analysis.failures import Chart, Evidence, Failure, Live

BELOW, ABOVE, CHART, LIMIT, HERE = "below", "above", "chart", "limit", "here"
_SAME = 1e-9


@dataclass(frozen=True)
class Try:
    """What one value of the knob showed, and how the window would show it."""

    value: float
    evidence: "Evidence"
    live: "Live | None" = None


@dataclass(frozen=True)
class Part:
    """A piece of a result as it arrives: limit in the knob's unit, a try or a chart, of some conditions."""

    key: str
    case: dict[str, float]
    limit: float | None = None
    tried: Try | None = None
    chart: "Chart | None" = None


class Record:
    """One failure with its results; what belongs to other conditions is kept, marked as old."""

    def __init__(self, failure: "Failure"):
        self.failure = failure
        self.case = failure.case()
        self.share = 1.0 - failure.margin
        self.limit: float | None = None
        self.here: Try | None = None
        self.below: Try | None = None
        self.above: Try | None = None
        self.chart: Chart | None = None
        self.old: set[str] = set()
        self.wrong = ""
        self.stopped = False

    @property
    def value(self) -> float | None:
        """Return where the knob stands, in its own unit."""
        if self.limit is None:
            return None
        knob = self.failure.knob
        return min(max(self.share * self.limit, knob.low), knob.high)

    @property
    def ready(self) -> bool:
        """Say whether the knob can be turned: the limit is known, and for these conditions."""
        return self.limit is not None and LIMIT not in self.old

    @property
    def complete(self) -> bool:
        """Say whether all of it was measured under the present conditions."""
        return self.chart is not None and self.limit is not None and not self.old - {HERE}

    @property
    def signs(self) -> tuple[bool | None, bool | None]:
        """Return whether it held below the limit and above it; None where it was not tried."""
        if self.wrong:
            return None, None
        return (
            self.below.evidence.holds if self.below else None,
            self.above.evidence.holds if self.above else None,
        )

    def set_condition(self, key: str, value: float) -> None:
        """Change a condition; what was found until now is old."""
        if self.case[key] != value:
            self.case = {**self.case, key: value}
            self.wrong, self.stopped = "", False
            self.old = {BELOW, ABOVE, CHART, LIMIT, HERE}

    def turn(self, share: float) -> None:
        """Turn the knob; what it showed before is old."""
        self.share, self.wrong = share, ""
        self.old.add(HERE)

    def take(self, part: Part) -> None:
        """Keep what arrived, unless the conditions have changed since."""
        if part.key != self.failure.key or part.case != self.case:
            return
        if part.limit is not None:
            self.limit, self.wrong = part.limit, ""
            self.old.discard(LIMIT)
        if part.tried is not None:
            self._keep(part.tried)
        if part.chart is not None:
            self.chart = part.chart
            self.old &= {HERE}

    def _keep(self, tried: Try) -> None:
        assert self.limit is not None
        side = BELOW if tried.value < self.limit else ABOVE
        setattr(self, side, tried)
        self.old.discard(side)
        value = self.value
        if value is not None and abs(tried.value - value) <= _SAME * abs(value):
            self.here = tried
            self.old.discard(HERE)


def reading(value: float, parameter: Parameter) -> str:
    """Write a value of a knob in the unit on the screen, three figures or whole numbers."""
    quantity = Quantity.of(parameter)
    return f"{figures(value * quantity.factor)} {quantity.unit}".rstrip()


def figures(value: float) -> str:
    """Write a number in three figures; from a hundred on as a whole number."""
    text = f"{value:.0f}" if 100.0 <= abs(value) < 1e7 else f"{value:.3g}"
    return text.replace("-", "−")


def sentence(words: str) -> str:
    """Write words with a capital at their beginning."""
    return words[:1].upper() + words[1:]
