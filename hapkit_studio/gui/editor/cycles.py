"""Counts a law's cycles on the board line by line, in the background while they are shown."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer

from hapkit_studio.errors import LawError
from hapkit_studio.gui.editor.code_page import CodePage
from hapkit_studio.gui.state.background import LatestResult
from hapkit_studio.gui.state.own_environments import OwnEnvironments
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.laws.machine import ARENA

if TYPE_CHECKING:
    from hapkit_studio.haptics.board_plan import BoardPlanner, PlanRequest

SOON_MS = 100
_NOT_YET = "The cycles are not counted yet. Save and run the law first."


@dataclass(frozen=True)
class CycleRequest:
    """A law with its values, the board's limits, and the text of its lines."""

    offer: "BoardPlanner"
    request: "PlanRequest"
    text: str


@dataclass(frozen=True)
class Count:
    """The cycles by line (from 1), and a sentence on cycles per call and the possible rate."""

    question: CycleRequest
    by_line: Mapping[int, float]
    text: str


def count(question: CycleRequest) -> Count:
    """Count a law's cycles, even if the board would reject the law."""
    from hapkit_studio.haptics import board_plan  # imported late because it takes a while
    from hapkit_studio.laws import board

    offer, request = question.offer, question.request
    found, period = offer.plan(request), 1.0 / board_plan.RATES[-1]
    try:
        if isinstance(found, str):
            program = board.compile(request.environment.force, request.values, period, offer.arena)
        else:
            program = found.program
    except LawError:
        return Count(question, {}, str(found))
    cost = (
        f"One call of the law takes about {program.usual:,.0f} cycles on the board, at most {program.most:,}."
    )
    if isinstance(found, str):
        text = f"{cost} {found}"
    else:
        share, most = 100.0 * found.share, board_plan.fastest(program)
        text = (
            f"{cost} At {found.rate:,.0f} Hz, the law uses {share:.0f} % of the board's processor. The "
            f"fastest possible rate is {most:,.0f} Hz."
        )
    return Count(question, program.cycles_by_line(), text)


class Cycles(QObject):
    """Counts the cycles of the open law as it was last loaded, with its current values."""

    def __init__(self, studio: Studio, own: OwnEnvironments, page: CodePage, parent: QObject | None = None):
        super().__init__(parent)
        self._studio, self._own, self._page = studio, own, page
        self._worker = LatestResult(count, self)
        self._worker.answered.connect(self._show)
        self._soon = QTimer(self, interval=SOON_MS, singleShot=True)
        self._soon.timeout.connect(self.refresh)
        page.count.toggled.connect(lambda _on: self.refresh())
        page.opened.connect(self.refresh)
        for changed in (studio.values_changed, studio.loop_changed, studio.engine_changed, own.changed):
            changed.connect(self._soon.start)
        own.judged.connect(lambda _path, _verdict: self._soon.start())

    def refresh(self) -> None:
        """Count the open law again if its cycles are shown; for an invalid law the previous counts stay."""
        self._worker.forget()  # count again even if the request is equal: the text may be newly opened
        if not self._page.counting:
            self._page.show_cycles(None, "")
            return
        question = self._question()
        if question is None:
            self._page.show_cycles({}, _NOT_YET)
        else:
            self._worker.ask(question)

    def _question(self) -> CycleRequest | None:
        from hapkit_studio.haptics import board_plan

        path, studio = self._page.path, self._studio
        environment = None if path is None else self._own.loaded(path)
        if environment is None:
            return None
        driver = studio.engine.driver if studio.engine is not None else None
        offer = (driver and driver.planner) or board_plan.BoardPlanner(ARENA)
        values = studio.values_of(environment.key)
        request = board_plan.PlanRequest(
            environment, values, studio.loop.estimator, rate=studio.loop.board_rate
        )
        return CycleRequest(offer, request, environment.source.text)

    def _show(self, found: Count) -> None:
        if not self._page.counting:
            return
        if found.question.text == self._page.text:
            self._page.show_cycles(found.by_line, found.text)
        else:
            self._page.show_cycle_text(
                f"These numbers are for the law that is running, without your changes. {found.text}"
            )
