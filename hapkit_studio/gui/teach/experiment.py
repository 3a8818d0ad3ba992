"""Shared parts of the experiments with the user: the recorded trials and the dialog with the results."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from PySide6.QtWidgets import QWidget

from hapkit_studio.columns import Column
from hapkit_studio.gui.pages.drawing import Drawing
from hapkit_studio.gui.state.recording import Recording
from hapkit_studio.gui.widgets.dialogs import TextDialog
from hapkit_studio.gui.widgets.parts import hbox, label
from hapkit_studio.gui.widgets.table import Table

if TYPE_CHECKING:
    from hapkit_studio.charts.style import Paint

_CHART = (620, 300)  # px: size of the chart


class RecordedTrials:
    """Records an experiment. It starts a recording unless one is running, and ends only its own recording."""

    def __init__(self, recording: Recording):
        self._recording = recording
        self._started = recording.progress is None
        if self._started:
            recording.toggle()

    def note(self, kind: str, what: dict[str, Any], when: float | None = None) -> None:
        """Add a trial to the recording."""
        self._recording.note(kind, what, when)

    def end(self) -> str:
        """End the recording if it was started here.

        Return the file's name, or "" if there was no recording.
        """
        progress = self._recording.progress
        if self._started:
            self._recording.end()
        return progress.path.name if progress is not None else ""


class ResultDialog(TextDialog):
    """Shows the results of an experiment as sentences, a chart and a table."""

    def __init__(
        self,
        title: str,
        words: Sequence[str],
        paint: "Paint",
        columns: Sequence[Column] = (),
        rows: Sequence[Any] = (),
        parent: QWidget | None = None,
    ):
        super().__init__(title, parent)
        self.words = [label(line) for line in words]
        for line in self.words:
            self.column.addWidget(line)
        self.chart = Drawing(title, _CHART)
        self.chart.show_drawing(paint)
        self.column.addWidget(self.chart, 1)
        self.table = Table(f"{title}: results")
        if rows:
            self.table.show_rows(columns, rows)
            self.column.addWidget(self.table)
        self.column.addLayout(hbox(None, self.leave))
