"""What is known of one failure, and the runner that tries failures off the window's thread."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal

from hapkit_studio.analysis.failures import Chart, Evidence, Failure, Live, base
from hapkit_studio.errors import ParameterError, StudioError
from hapkit_studio.gui.background import Job, Progress
from hapkit_studio.gui.widgets.numbers import Quantity
from hapkit_studio.parameters import Parameter

BELOW, ABOVE, CHART, LIMIT, HERE = "below", "above", "chart", "limit", "here"
_SAME = 1e-9


@dataclass(frozen=True)
class Try:
    """What one value of the knob showed, and how the window would show it."""

    value: float
    evidence: Evidence
    live: Live | None = None


@dataclass(frozen=True)
class Part:
    """A piece of a result as it arrives: limit in the knob's unit, a try or a chart, of some conditions."""

    key: str
    case: dict[str, float]
    limit: float | None = None
    tried: Try | None = None
    chart: Chart | None = None


class Record:
    """One failure with its results; what belongs to other conditions is kept, marked as old."""

    def __init__(self, failure: Failure):
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

    def shown(self) -> base.Shown:
        """Return a copy of what was measured, for export."""
        assert self.limit is not None
        assert self.below is not None
        assert self.above is not None
        below, above = (base.Try(tried.value, tried.evidence) for tried in (self.below, self.above))
        return base.Shown(self.failure, dict(self.case), self.limit, below, above, self.chart)

    def _keep(self, tried: Try) -> None:
        assert self.limit is not None
        side = BELOW if tried.value < self.limit else ABOVE
        setattr(self, side, tried)
        self.old.discard(side)
        value = self.value
        if value is not None and abs(tried.value - value) <= _SAME * abs(value):
            self.here = tried
            self.old.discard(HERE)


def knob_text(value: float, parameter: Parameter) -> str:
    """Write a value of a knob in the unit on the screen, three figures or whole numbers."""
    quantity = Quantity(parameter)
    return f"{short_number(value * quantity.factor)} {quantity.unit}".rstrip()


def short_number(value: float) -> str:
    """Write a number in three figures; from a hundred on as a whole number."""
    text = f"{value:.0f}" if 100.0 <= abs(value) < 1e7 else f"{value:.3g}"
    return text.replace("-", "−")


Say = Callable[[Part], None]
_FINE = 1000


def try_value(failure: Failure, value: float, case: dict[str, float]) -> Try:
    """Return what one value of the knob shows."""
    return Try(value, failure.probe(value, case), failure.live(value, case) if failure.live else None)


def measure(failure: Failure, case: dict[str, float], share: float, progress: Progress, say: Say) -> None:
    """Find the limit, try just inside it, just outside and where the knob stands, then measure the curve."""

    def tell(**found) -> None:
        progress(0, _FINE)
        say(Part(failure.key, case, **found))

    limit = failure.limit(case)
    if not 0.0 < limit < math.inf:
        raise ParameterError(f"Nothing {'fails' if limit else 'holds'} under these conditions: change one.")
    tell(limit=limit)
    here = min(max(share * limit, failure.knob.low), failure.knob.high)
    beside = (1.0 - failure.margin) * limit, (1.0 + failure.margin) * limit
    for value in dict.fromkeys((*beside, here)):
        tell(tried=try_value(failure, value, case))
    tell(chart=failure.curve(case, progress))


class FailureRunner(QObject):
    """Emits ``arrived`` with every part of a result; ``wrong(key, text)`` where a failure cannot be tried.

    job does what takes long; what the knob asks for is done beside it.
    ``begun(key)``: a failure is being measured from now on; many: it is one of several.
    """

    arrived = Signal(object)
    wrong = Signal(str, str)
    begun = Signal(str)

    def __init__(self, job: Job, parent: QObject | None = None):
        super().__init__(parent)
        self.job = job
        self._quick = Job(self, needs="")  # a knob turns once its limit is known: all is compiled
        self._quick.finished.connect(self._deliver)
        self._quick.failed.connect(lambda text: self._deliver(text))
        self.many = False
        self._key = ""
        self._next: tuple[Record, float] | None = None

    def run(self, record: Record) -> None:
        """Try one failure and measure its curve; what was under way is cancelled."""
        self.many = False
        self._start([record])

    def run_all(self, records: Iterable[Record]) -> None:
        """Try these failures in turn; one that raises does not stop the others."""
        self.many = True
        self._start(list(records))

    def try_at(self, record: Record, value: float) -> None:
        """Try one value of a knob; of several asked for meanwhile only the newest."""
        self._next = (record, value)
        if not self._quick.running:
            self._go_on()

    def end(self) -> None:
        """Cancel everything and wait."""
        self._next = None
        self.job.end()
        self._quick.end()

    def _start(self, records: list[Record]) -> None:
        plans = [(record.failure, dict(record.case), record.share) for record in records]

        def work(progress: Progress) -> int:
            for number, (failure, case, share) in enumerate(plans):
                self._one(failure, case, share, _part_of(progress, number, len(plans)), alone=len(plans) == 1)
            return len(plans)

        self.job.start(work)

    def _one(self, failure: Failure, case: dict, share: float, progress: Progress, alone: bool) -> None:
        self.begun.emit(failure.key)
        try:
            measure(failure, case, share, progress, self.arrived.emit)
        except Exception as error:
            progress(0, _FINE)  # whatever it was: cancelled work says nothing
            self.wrong.emit(failure.key, _words(error))
            if alone:
                raise

    def _go_on(self) -> None:
        if self._next is None:
            return
        (record, value), self._next = self._next, None
        failure, case = record.failure, dict(record.case)
        self._key = failure.key
        self._quick.start(lambda _progress: Part(failure.key, case, tried=try_value(failure, value, case)))

    def _deliver(self, found: Part | str) -> None:
        if isinstance(found, Part):
            self.arrived.emit(found)
        else:
            self.wrong.emit(self._key, found)
        self._go_on()


def _part_of(progress: Progress, number: int, of: int) -> Progress:
    """Return the progress of one failure among several."""

    def say(done: int, whole: int) -> None:
        progress(round((number + done / max(whole, 1)) * _FINE), of * _FINE)

    return say


def _words(error: Exception) -> str:
    return str(error) if isinstance(error, StudioError) else f"This went wrong: {error}"
