"""The view Break it: it tries each method just inside and outside its limit."""

from collections.abc import Callable
from copy import copy
from typing import TYPE_CHECKING

from PySide6.QtCore import QTimer
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QPushButton, QWidget

from hapkit_studio.analysis import failures
from hapkit_studio.analysis.failures import base
from hapkit_studio.charts.failures import failure_figure
from hapkit_studio.charts.plane import plane_figure
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.pages.break_it.detail import Detail
from hapkit_studio.gui.pages.break_it.feel import Feel
from hapkit_studio.gui.pages.break_it.lists import NARROW, WIDE, FailureList, FailureSide
from hapkit_studio.gui.pages.break_it.record import FailureRunner, Part, Record
from hapkit_studio.gui.pages.measuring import MeasuringPage
from hapkit_studio.gui.widgets.parts import hbox
from hapkit_studio.gui.widgets.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.state.studio import Studio


_SETTLE_MS = 200
_WIDE_LIST_FROM = 840


class BreakItPage(MeasuringPage):
    """Shows the list of failures, and the chosen failure with knob, verdict, two traces and the curve.

    ``felt`` is the title of the failure in the scene, "" for none; ``marked`` is emitted with this title.
    """

    file = "break-it"
    title = "Where methods fail"
    drawn = "Motion below and above the limit, and the result for each value of the setting"
    buttons = ("Run this failure", "Run again")
    side: FailureSide

    def __init__(self, studio: "Studio", live: "Live"):
        super().__init__(studio, live)
        self.records = {key: Record(failure) for key, failure in failures.failures().items()}
        self.record = next(iter(self.records.values()))
        self.runner, self.feel = FailureRunner(self.job, self), Feel(studio, self)
        self.all = QPushButton("Run all failures", autoDefault=True)
        self.list = FailureList(self.records.values())
        self.detail, self.side = Detail(self.record, self.chart), FailureSide()
        self.knob, self.verdict = self.detail.knob, self.detail.verdict
        self._busy = ""
        self._settle = QTimer(self, interval=_SETTLE_MS, singleShot=True)
        self._settle.timeout.connect(self.run)
        self.bar.add(self.all)
        body = QWidget()
        hbox(self.list, (self.detail, 1), into=body, gap=0)
        self.build(body)
        self._join()
        self.list.choose(self.record.failure.key)

    @property
    def felt(self) -> str:
        """Return the title of the failure that is in the scene; "" for none."""
        return self.records[self.feel.felt].failure.title if self.feel.felt else ""

    # actions of the user

    def choose(self, key: str) -> None:
        """Show a failure; if it has not been measured yet, measure it after a short pause."""
        self.record = self.records[key]
        self._show_all()
        self._soon()

    def run(self) -> None:
        """Try the chosen failure and measure its curve."""
        self._settle.stop()
        self.record.stopped = False
        self.runner.run([self.record])

    def run_all(self) -> None:
        """Try every failure that has not been measured yet; if all were measured, try all of them again."""
        left = [record for record in self.records.values() if not record.complete]
        self._settle.stop()
        self.runner.run(left or list(self.records.values()))

    def turn(self, share: float) -> None:
        """Turn the knob to a fraction of the limit and try the failure there."""
        self.record.turn(share)
        value = self.record.value
        if value is not None and self.record.ready:
            self.runner.try_at(self.record, value)
        self.knob.show_value()
        self._show_results()

    def set_condition(self, key: str, value: float) -> None:
        """Change a condition of the chosen failure and measure it again after a pause."""
        self.record.set_condition(key, value)
        self._show_all()
        self._settle.start()

    def feel_it(self) -> None:
        """Put the failure at the knob's value into the scene."""
        here = self.record.here
        if here is None or here.live is None or "here" in self.record.old or not self._harmless:
            return
        try:
            self.feel.put(self.record.failure.key, here.live)
        except ParameterError as error:
            self.bar.show_text(str(error), danger=True)

    def exports(self) -> tuple[Callable[[str], object], Callable[[], dict]]:
        shown = copy(self.record)
        shown.old = set(shown.old)
        figure = plane_figure if self.detail.shows_plane else failure_figure
        return lambda path: figure(shown, path), lambda: base.as_json(shown, traces=True)

    # reactions to being shown, hidden, resized and closed

    def set_shown(self, on: bool) -> None:
        super().set_shown(on)
        if on:
            self._soon()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        wide = event.size().width() >= theme.px(_WIDE_LIST_FROM)
        self.list.setFixedWidth(theme.px(WIDE if wide else NARROW))

    def end(self) -> None:
        self._settle.stop()
        super().end()

    def _soon(self) -> None:
        """Measure the chosen failure once the selection has not changed for a while."""
        key, job = self.record.failure.key, self.job
        under_way = job.running and (self.runner.many or self._busy == key)
        if self._seen and not (self.record.complete or self.record.wrong or self.record.stopped or under_way):
            self._settle.start()
        else:
            self._settle.stop()

    # results

    def _take(self, part: Part) -> None:
        record = self.records[part.key]
        record.take(part)
        self.list.show_record(record, busy=self._busy == part.key)
        if record is not self.record:
            return
        if part.name == "limit":
            self.knob.show_record(record)
        self._show_results()
        if self.feel.felt == part.key and record.here is not None:
            self.feel_it()

    def show_result(self, _count: object) -> None:
        self._show_results()
        self._soon()

    def _begin(self, key: str) -> None:
        before, self._busy = self._busy, key
        for name in filter(None, (before, key)):
            self.list.show_record(self.records[name], busy=name == self._busy)

    def _stop(self, running: bool) -> None:
        self.all.setEnabled(not running)
        if not running:
            for record in filter(None, (self.records.get(self._busy), self.record)):
                record.stopped = not record.complete  # a cancelled measurement starts again only on request
            self._begin("")

    def _fail(self, key: str, text: str) -> None:
        self.records[key].wrong = text
        self.list.show_record(self.records[key])
        self._show_results()

    # methods that show the state

    def _show_all(self) -> None:
        self.side.show_record(self.record)
        self.knob.show_record(self.record)
        self._show_results()
        self.list.show_record(self.record, busy=self._busy == self.record.failure.key)

    def _show_results(self) -> None:
        self.detail.show_results(self.record)
        self._show_verdict()
        self.bar.export.setEnabled(self.record.complete)

    @property
    def _harmless(self) -> bool:
        """Return whether a failure may be put into the scene: only on a device without a motor."""
        return self._studio.opened is not None and not self._studio.opened.motor

    def _show_verdict(self) -> None:
        ours = self.feel.on and self.feel.key == self.record.failure.key
        felt = ours and bool(self.feel.felt)
        self.verdict.show_record(self.record, self._harmless, felt, self.feel.on, ours and not felt)

    # connections

    def _join(self) -> None:
        self.all.clicked.connect(self.run_all)
        self.list.chosen.connect(self.choose)
        self.knob.turned.connect(self.turn)
        self.detail.picked.connect(self.turn)
        self.side.changed.connect(self.set_condition)
        self.runner.arrived.connect(self._take)
        self.runner.begun.connect(self._begin)
        self.runner.wrong.connect(self._fail)
        self.job.running_changed.connect(self._stop)
        self.job.failed.connect(
            lambda _text: self.bar.show_text("The failure could not be tried", danger=True)
        )
        self.verdict.feel.clicked.connect(self.feel_it)
        self.verdict.back.clicked.connect(self.feel.take_back)
        self.feel.changed.connect(self._show_verdict)
        self.feel.changed.connect(
            lambda: self.marked.emit(f"The scene shows: {self.felt}" if self.felt else "")
        )
        self.feel.refused.connect(lambda text: self.bar.show_text(text, danger=True))
        self._studio.engine_changed.connect(self._show_verdict)
