"""The results of one failure, and the runner that tries failures in a thread."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from PySide6.QtCore import QObject, Signal

from hapkit_studio.analysis.failures import Failure
from hapkit_studio.analysis.failures.base import Shown, Try
from hapkit_studio.errors import StudioError
from hapkit_studio.gui.state.background import Job, Progress

_SAME = 1e-9


class Part(NamedTuple):
    """A partial result for one set of conditions; its kind is "limit", "chart", "plane" or "try"."""

    key: str
    case: dict[str, float]
    name: str
    found: object


class Record(Shown):
    """One failure with its results and its knob.

    ``old`` contains the names of the results that were measured under other conditions.

    ``share`` is the knob's value as a fraction of the limit; ``here`` is the result at that value.
    """

    def __init__(self, failure: Failure):
        super().__init__(failure, failure.case())
        self.share = 1.0 - failure.margin
        self.here: Try | None = None
        self.wrong = ""
        self.stopped = False

    @property
    def value(self) -> float | None:
        """Return the knob's value in its own unit."""
        return None if self.limit is None else knob_value(self.failure, self.share * self.limit)

    @property
    def ready(self) -> bool:
        """Return whether the knob can be turned, that is, whether the limit is known for these conditions."""
        return self.limit is not None and "limit" not in self.old

    @property
    def complete(self) -> bool:
        """Return whether everything was measured under the current conditions."""
        missing = self.failure.plane is not None and self.plane is None
        return self.chart is not None and self.limit is not None and not missing and not self.old - {"here"}

    @property
    def signs(self) -> tuple[bool | None, ...]:
        """Return whether the method worked inside and outside the limit.

        The value is None for a side that was not tried.
        """
        tried = (None, None) if self.wrong else (self.inside, self.outside)
        return tuple(one.evidence.holds if one else None for one in tried)

    def set_condition(self, key: str, value: float) -> None:
        """Change a condition; all results so far are then out of date."""
        if self.case[key] != value:
            self.case = {**self.case, key: value}
            self.wrong, self.stopped = "", False
            self.old = {"inside", "outside", "chart", "limit", "here"}
            self.old |= {"plane"} if self.failure.plane else set()

    def turn(self, share: float) -> None:
        """Turn the knob; the result at its previous value is then out of date."""
        self.share, self.wrong = share, ""
        self.old.add("here")

    def take(self, part: Part) -> None:
        """Store a partial result, unless the conditions have changed."""
        if part.case != self.case:
            return
        names = [part.name]
        self.wrong = "" if part.name == "limit" else self.wrong
        if isinstance(part.found, Try):
            assert self.limit is not None
            assert self.value is not None
            names = ["inside" if part.found.value < self.limit else "outside"]
            names += ["here"] if math.isclose(part.found.value, self.value, rel_tol=_SAME) else []
        for name in names:
            setattr(self, name, part.found)
        self.old.difference_update(names)


def knob_value(failure: Failure, value: float) -> float:
    """Clamp a value to the range of a failure's knob."""
    return min(max(value, failure.knob.low), failure.knob.high)


_FINE = 1000  # progress steps per failure


def try_value(failure: Failure, value: float, case: dict[str, float]) -> Part:
    """Try a failure at one value of its knob."""
    live = failure.live(value, case) if failure.live else None
    return Part(failure.key, case, "try", Try(value, failure.probe(value, case), live))


def measure(failure: Failure, case: dict[str, float], share: float, progress: Progress) -> Iterator[Part]:
    """Find the limit, try both sides and the knob's value, then measure the curve and the plane."""
    limit = failure.bound(case)
    yield Part(failure.key, case, "limit", limit)
    beside = (1.0 - failure.margin) * limit, (1.0 + failure.margin) * limit
    for value in dict.fromkeys((*beside, knob_value(failure, share * limit))):
        yield try_value(failure, value, case)
    yield Part(failure.key, case, "chart", failure.curve(case, progress))
    if failure.plane:
        yield Part(failure.key, case, "plane", failure.plane(case))


class FailureRunner(QObject):
    """Measures failures, the limits of methods, in a thread; emits ``arrived`` with each partial result.

    ``begun(key)`` is emitted when the measurement of a failure starts, and ``wrong(key, text)`` if the
    measurement ends with an error. ``many`` is True if several failures are measured one after the other.
    Measurements run in ``job``. At the same time, a second job simulates single values of the knob.
    """

    arrived = Signal(object)
    wrong = Signal(str, str)
    begun = Signal(str)

    def __init__(self, job: Job, parent: QObject | None = None):
        super().__init__(parent)
        self.job = job
        # this job needs no compilation: a knob can be turned only after ``job`` has compiled the code and
        # found the limit
        self._quick = Job(self, needs="")
        self._quick.finished.connect(self._deliver)
        self._quick.failed.connect(lambda text: self._deliver(text))
        self.many = False
        self._key = ""
        self._next: tuple[Record, float] | None = None

    def run(self, records: list[Record]) -> None:
        """Measure failures one after the other; this cancels earlier work.

        If one failure cannot be measured, the others are measured nevertheless.
        """
        plans = [(record.failure, dict(record.case), record.share) for record in records]
        self.many = many = len(plans) > 1

        def work(progress: Progress) -> int:
            for number, (failure, case, share) in enumerate(plans):

                def report(done: int, of: int, before: int = number) -> None:
                    progress(round((before + done / max(of, 1)) * _FINE), len(plans) * _FINE)

                self.begun.emit(failure.key)
                try:
                    for part in measure(failure, case, share, report):
                        report(0, _FINE)
                        self.arrived.emit(part)
                except Exception as error:
                    # if the job was cancelled, this call raises, so that the error below is not reported
                    report(0, _FINE)
                    text = (
                        str(error)
                        if isinstance(error, StudioError)
                        else f"An error occurred during the trial: {error}"
                    )
                    self.wrong.emit(failure.key, text)
                    if not many:
                        raise
            return len(plans)

        self.job.start(work)

    def try_at(self, record: Record, value: float) -> None:
        """Try one value of a knob; if an earlier value still waits for its trial, drop the earlier value."""
        self._next = (record, value)
        if not self._quick.running:
            self._go_on()

    def _go_on(self) -> None:
        if self._next is None:
            return
        (record, value), self._next = self._next, None
        failure, case = record.failure, dict(record.case)
        self._key = failure.key
        self._quick.start(lambda _progress: try_value(failure, value, case))

    def _deliver(self, found: Part | str) -> None:
        if isinstance(found, Part):
            self.arrived.emit(found)
        else:
            self.wrong.emit(self._key, found)
        self._go_on()
