"""How far from instability: limits computed off the window's thread, the newest question wins."""

import math
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache

from PySide6.QtCore import QObject, Signal

POINTS = 25


@dataclass(frozen=True)
class Loop:
    """What the limit depends on besides the rendered damping; delay is the measured one. SI units."""

    mass: float
    viscous: float
    rate: float
    delay: float
    estimator: str
    options: tuple[tuple[str, float], ...] = ()
    grip: str = "released"


@dataclass(frozen=True)
class Question:
    """A rendered stiffness (N/m) and damping (N·s/m) in a loop, and the map's width in N·s/m."""

    loop: Loop
    stiffness: float
    damping: float
    width: float


@dataclass(frozen=True)
class Answer:
    """The limit (N/m) at the question's damping, and the boundary as (damping, limit) points."""

    question: Question
    limit: float
    boundary: tuple[tuple[float, float], ...]

    @property
    def stable(self) -> bool:
        """Say whether the rendered impedance is inside the limit."""
        return self.limit > 0.0 and self.question.stiffness <= self.limit

    @property
    def ratio(self) -> float:
        """Return limit over stiffness; infinite without stiffness."""
        return self.limit / self.question.stiffness if self.question.stiffness > 0.0 else math.inf


@lru_cache(maxsize=2048)
def limit(loop: Loop, damping: float) -> float:
    """Return the largest stable stiffness in N/m, 0 where no stiffness is stable."""
    from hapkit_studio.analysis.stability import stiffness_limit  # scipy: off the first picture's way

    spec = (loop.estimator, dict(loop.options)) if loop.options else loop.estimator
    return stiffness_limit(
        loop.mass,
        loop.viscous,
        damping=damping,
        rate=loop.rate,
        delay=loop.delay,
        estimator=spec,
        hand=loop.grip,
    )


def answer(question: Question, wanted: Callable[[], bool] = lambda: True) -> Answer:
    """Compute limit and boundary; give up the boundary as soon as nobody wants it any more."""
    points = []
    for index in range(POINTS):
        if not wanted():
            break
        damping = question.width * index / (POINTS - 1)
        points.append((damping, limit(question.loop, damping)))
    return Answer(question, limit(question.loop, question.damping), tuple(points))


class MarginWorker(QObject):
    """Emits ``answered``; asking again before it did replaces the question."""

    answered = Signal(object)

    def __init__(self, solve: Callable[..., Answer] = answer, parent: QObject | None = None):
        super().__init__(parent)
        self._solve = solve
        self._newest: Question | None = None
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="margin")

    def ask(self, question: Question) -> None:
        """Ask, unless this very question was the last one."""
        if question == self._newest:
            return
        self._newest = question
        job = self._worker.submit(self._work, question)
        job.add_done_callback(self._deliver)

    def forget(self) -> None:
        """Want no answer any more."""
        self._newest = None

    def wait(self) -> None:
        """Wait until everything asked is answered."""
        self._worker.submit(int).result()

    def close(self) -> None:
        """Drop what is waiting and end the thread."""
        self._newest = None
        self._worker.shutdown(wait=True, cancel_futures=True)

    def _work(self, question: Question) -> Answer | None:
        if question is not self._newest:
            return None
        return self._solve(question, lambda: question is self._newest)

    def _deliver(self, job: "Future[Answer | None]") -> None:
        if job.cancelled():
            return
        result = job.result()
        if result is not None and result.question is self._newest:
            self.answered.emit(result)
