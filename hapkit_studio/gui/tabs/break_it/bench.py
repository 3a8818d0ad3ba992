"""Tries failures off the window's thread: one with its curve, all of them, or one value of a knob."""

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from hapkit_studio.errors import ParameterError, StudioError
from hapkit_studio.gui.tabs.break_it.record import Part, Record, Try
from hapkit_studio.gui.tabs.job import Job, Progress

if TYPE_CHECKING:
    from hapkit_studio.analysis.failures import Failure

Say = Callable[[Part], None]
_FINE = 1000


def attempt(failure: "Failure", value: float, case: dict[str, float]) -> Try:
    """Return what one value of the knob shows."""
    return Try(value, failure.probe(value, case), failure.live(value, case) if failure.live else None)


def measure(failure: "Failure", case: dict[str, float], share: float, progress: Progress, say: Say) -> None:
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
        tell(tried=attempt(failure, value, case))
    tell(chart=failure.curve(case, progress))


class Bench(QObject):
    """Hands over every part as it arrives; ``wrong(key, text)`` where a failure could not be tried.

    ``begun(key)``: a failure is being measured from now on; many: it is one of several.
    """

    arrived = Signal(object)
    wrong = Signal(str, str)
    begun = Signal(str)

    def __init__(self, parent: QObject | None = None):
        super().__init__(parent)
        self.job = Job(self)
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
        """Try these failures, one after the other; one that cannot be keeps no other back."""
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

    def _one(self, failure: "Failure", case: dict, share: float, progress: Progress, alone: bool) -> None:
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
        self._quick.start(lambda _progress: Part(failure.key, case, tried=attempt(failure, value, case)))

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
