"""Shared parts of the experiments with the user: the recorded trials and the dialog with the results."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QWidget

from hapkit_studio.columns import Column
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.pages.drawing import Drawing
from hapkit_studio.gui.pages.views import Views
from hapkit_studio.gui.state.recording import Recording
from hapkit_studio.gui.state.studio import Studio
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


class Experiment(QObject):
    """Shows an experiment's page in place of the views, and its results at the end."""

    def __init__(self, studio: Studio, views: Views, window: QWidget):
        super().__init__(window)
        self._studio, self._views, self._window = studio, views, window
        self.page: Any = None

    @property
    def possible(self) -> bool:
        """Return True if an experiment can be started."""
        studio = self._studio
        return self.page is None and studio.engine is not None and not studio.hidden and not studio.temporary

    def show_results(self, page: Any, name: str) -> None:
        """Show the results of a page's trials; ``name`` is the name of the recording, or ""."""
        raise NotImplementedError

    def end(self) -> None:
        """End a running experiment."""
        if self.page is not None:
            self.page.finish()

    def _start(self, page: Any, scene: bool = False) -> None:
        """Start a page's experiment, unless settings are locked; with ``scene``, keep the scene visible."""
        try:
            page.begin()
        except ParameterError as error:
            page.end()
            page.deleteLater()
            self._studio.refused.emit(str(error))
            return
        self.page = page
        page.ended.connect(self._end)
        self._views.cover(page.side, page, scene=scene)

    def _end(self) -> None:
        page, self.page = self.page, None
        if page is None or page.side is None or page.trials is None:
            return
        name = page.trials.end()
        self._views.cover(None)
        page.side.deleteLater()
        page.deleteLater()
        self.show_results(page, name)


class ResultDialog(TextDialog):
    """Shows the results of an experiment as sentences, a chart and a table."""

    def __init__(
        self,
        title: str,
        texts: Sequence[str],
        paint: "Paint",
        columns: Sequence[Column] = (),
        rows: Sequence[Any] = (),
        parent: QWidget | None = None,
    ):
        super().__init__(title, parent)
        self.labels = [label(line) for line in texts]
        for line in self.labels:
            self.column.addWidget(line)
        self.chart = Drawing(title, _CHART)
        self.chart.show_drawing(paint)
        self.column.addWidget(self.chart, 1)
        self.table = Table(f"{title}: results")
        if rows:
            self.table.show_rows(columns, rows)
            self.column.addWidget(self.table)
        self.column.addLayout(hbox(None, self.leave))
