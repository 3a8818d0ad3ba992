"""How far from instability: limits computed off the window's thread, the newest question wins."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import QObject, Signal

from hapkit_studio.analysis.stability.margin import Margin

if TYPE_CHECKING:
    from hapkit_studio.analysis.setting import Setting

POINTS = 25


@dataclass(frozen=True)
class Question:
    """A rendered stiffness (N/m) and damping (N·s/m) in a loop, and the map's width in N·s/m."""

    setting: "Setting"
    stiffness: float
    damping: float
    width: float


@dataclass(frozen=True)
class Answer:
    """The margin at the question's damping, and the boundary as (damping, limit) points.

    kept: whether the verdict before was stable, where this one only wanders about the limit; else None.
    """

    question: Question
    margin: Margin
    boundary: tuple[tuple[float, float], ...]
    kept: bool | None = None

    @property
    def stable(self) -> bool:
        """Say whether the rendered impedance is inside the limit; next to it, what was said before."""
        return self.margin.stable if self.kept is None else self.kept


@lru_cache(maxsize=256)
def boundary(setting: "Setting", width: float) -> tuple[tuple[float, float], ...]:
    """Return the exact boundary from no damping to a width in N·s/m, as points."""
    from hapkit_studio.analysis.stability import kb_plane  # off the first picture's way

    across = np.linspace(0.0, width, POINTS)
    return tuple(zip(across.tolist(), kb_plane.exact_boundary(setting, across).tolist(), strict=True))


def answer(question: Question) -> Answer:
    """Compute margin and boundary."""
    from hapkit_studio.analysis.stability import kb_plane

    q = question
    margin = Margin(q.stiffness, q.damping, kb_plane.limit(q.setting, q.damping), q.setting.hand)
    return Answer(q, margin, boundary(q.setting, q.width))


class MarginWorker(QObject):
    """Emits ``answered``; asking again before it did replaces the question.

    solve(question) returns an answer that has the very question as its ``question``.
    """

    answered = Signal(object)

    def __init__(self, solve: Callable[[Any], Any] = answer, parent: QObject | None = None):
        super().__init__(parent)
        self._solve = solve
        self._newest: Any = None
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="margin")

    def ask(self, question: Any) -> None:
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

    def _work(self, question: Any) -> Any:
        if question is not self._newest:
            return None
        return self._solve(question)

    def _deliver(self, job: "Future[Any]") -> None:
        if job.cancelled():
            return
        result = job.result()
        if result is not None and result.question is self._newest:
            self.answered.emit(result)
