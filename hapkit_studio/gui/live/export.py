"""Exports the live plots as tables and pictures: the visible range, the range between the cursors, or all."""

import json
import math
import time
from collections import deque
from collections.abc import Callable
from datetime import datetime, timedelta
from functools import partial
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QGuiApplication, QImage

from hapkit_studio.errors import ParameterError, StudioError
from hapkit_studio.gui.live.history import Window
from hapkit_studio.gui.live.live import HISTORY_SECONDS
from hapkit_studio.gui.live.plots.declared import OBJECT
from hapkit_studio.gui.live.recorded import Recorded
from hapkit_studio.gui.state.background import Job
from hapkit_studio.gui.widgets.parts import choose_file
from hapkit_studio.sessions import export, settings_events
from hapkit_studio.settings_log import Log

if TYPE_CHECKING:
    from hapkit_studio.api import Run
    from hapkit_studio.charts.run import KeptCurve
    from hapkit_studio.gui.live.centre import Centre
    from hapkit_studio.gui.state.studio import Studio

PICTURES = (".png", ".svg", ".pdf")
COMMA = "Table with decimal commas (*.csv)"
TABLES = f"Table (*.csv);;{COMMA};;Parquet (*.parquet);;MATLAB (*.mat)"
_KINDS = f"Picture (*.png);;Drawing (*.svg);;Page (*.pdf);;{TABLES}"
Figure = Callable[[str], object]
"""A function that draws to a path; it is called in a thread."""


def write(path: str | Path, figure: Callable[[str], object], numbers: Callable[[], dict]) -> str:
    """Write a picture with ``figure(path)``, or the numbers as one JSON object if the path ends in .json."""
    try:
        if Path(path).suffix.lower() == ".json":
            Path(path).write_text(json.dumps(numbers(), ensure_ascii=False, indent=2), encoding="utf-8")
        else:
            figure(str(path))
    except OSError as error:
        raise StudioError(f"The file {Path(path).name} cannot be written: {error.strerror}.") from error
    return str(path)


class LiveExport(QObject):
    """Saves and copies a range of the plotted samples, with the settings and their changes.

    ``succeeded`` is emitted with a sentence that reports success, ``failed`` with the reason for a failure.
    """

    succeeded = Signal(str)
    failed = Signal(str)

    def __init__(self, studio: "Studio", centre: "Centre"):
        super().__init__(centre)
        self._studio, self._centre = studio, centre
        self._settings: deque[tuple[float, dict[str, Any]]] = deque()
        self._saving, self._copying = (Job(self, needs="", must_finish=True) for _ in range(2))
        self._saving.finished.connect(
            lambda path: self.succeeded.emit(f"The file {Path(path).name} was saved")
        )
        self._copying.finished.connect(self._put)
        for job in (self._saving, self._copying):
            job.failed.connect(self.failed)
        for changed in (studio.settings_changed, studio.hidden_changed, studio.engine_changed):
            changed.connect(self._note_settings)

    @property
    def visible(self) -> tuple[float, float]:
        """Return begin and end in s of the visible range."""
        begin, end = self._centre.view.stretch
        return begin, math.nextafter(end, math.inf)

    @property
    def selected(self) -> tuple[float, float]:
        """Return begin and end in s of the range between the cursors, inclusive; NaN without cursors."""
        times = self._centre.time.cursors.times or (math.nan, math.nan)
        return min(times), math.nextafter(max(times), math.inf)

    def ask(self, stretch: tuple[float, float] = (-math.inf, math.inf)) -> None:
        """Ask for a file name in a non-modal dialog, then write the samples from begin to end in s."""
        made = self._made(stretch)
        if made is None:
            return
        run, table, figure = made

        def save(path: str) -> None:
            decimal = "," if dialog.selectedNameFilter() == COMMA else "."
            made = partial(_save, run=table, figure=figure, decimal=decimal)
            self._saving.start(lambda _progress: write(path, made, dict))

        name = f"{run.settings.get('environment', 'export')}.png"
        dialog = choose_file(self._centre, "Export", _KINDS, save, save_as=name)

    def copy(self) -> None:
        """Put a picture of the visible range on the clipboard."""
        made = self._made(self.visible)
        if made is not None:
            self.copy_picture(made[2])

    def copy_picture(self, figure: Figure) -> None:
        """Put a figure on the clipboard as a picture in light colours."""
        self._copying.start(lambda _progress: _picture(figure))

    def _put(self, picture: QImage) -> None:
        QGuiApplication.clipboard().setImage(picture)
        self.succeeded.emit("The picture was copied")

    def _note_settings(self) -> None:
        """Store the current settings with their time; discard settings that only apply to dropped samples."""
        now = time.perf_counter()
        self._settings.append((now, self._in_force()))
        while len(self._settings) > 1 and self._settings[1][0] < now - HISTORY_SECONDS:
            self._settings.popleft()

    def _log(self, begin: float, end: float) -> Log:
        """Return the settings at ``begin`` and each change until ``end``, both in s.

        The times in the result are in s after ``begin``.
        """
        known = [was for when, was in self._settings if when <= begin]
        changes = [(when - begin, now) for when, now in self._settings if begin < when <= end]
        first = known[-1] if known else changes[0][1] if changes else self._in_force()
        log = [(0.0, first), *changes]
        return [log[0], *(new for old, new in pairwise(log) if new[1] != old[1])]

    def _in_force(self) -> dict[str, Any]:
        studio, engine = self._studio, self._studio.engine
        if engine is None:
            return settings_events.of_scene(studio.environment, studio.values)
        return settings_events.about_device(engine) | settings_events.in_force(engine)

    def _made(self, stretch: tuple[float, float]) -> "tuple[Run, Run, Figure] | None":
        """Return a range with gaps, the same range without gaps, and its figure; None if it is too short."""
        from hapkit_studio.charts.run import run_figure  # imported late to keep start-up fast

        history = self._centre.view.history
        window = history.between(*stretch)
        table = window.known()
        if len(table.x) < 2:
            many = history.exceeds(*stretch)
            too_many = (
                "This range has too many samples to be exported here. Export them in the view Sessions."
            )
            self.failed.emit(too_many if many else "There are no samples in this range.")
            return None
        begin, end = float(table.x[0]), float(table.x[-1])
        log = history.log(begin, end) if isinstance(history, Recorded) else self._log(begin, end)
        marks = [(when - begin, text) for when, text in history.dividers if begin <= when <= end]
        if isinstance(history, Recorded):
            date = history.session.date
        else:
            began = datetime.now() - timedelta(seconds=time.perf_counter() - begin)
            date = began.isoformat(" ", "minutes")
        run, clean = (self._run(part, begin, log, date) for part in (window, table))
        kept_curves, known, phase = (
            self._kept_curves(begin),
            dict(self._studio.environments),
            self._centre.phase,
        )
        over = phase.canvas.plot_of.channel if phase.pane is None else ""
        return run, clean, lambda path: run_figure(run, path, marks, kept_curves, known, over)

    def _run(self, window: Window, zero: float, log: Log, date: str) -> "Run":
        """Return a window's samples as a Run; signals that the history does not store are NaN."""
        from hapkit_studio.api import Run

        y, unknown, last = window.y, np.full(len(window.x), np.nan), dict(log[-1][1])
        rendered = (self._studio.environments.get(settings.get("environment", "")) for _, settings in log)
        names = {environment.moves.name for environment in rendered if environment and environment.moves}
        name = names.pop() if len(names) == 1 else OBJECT
        return Run(
            time=window.x - zero,
            position=y["position"],
            velocity=y["velocity"],
            true_position=unknown,
            true_velocity=unknown,
            force=y["force"],
            applied_force=y["applied_force"],
            hand_force=unknown,
            energy=y["energy"],
            flags=unknown,
            state=np.empty((len(unknown), 0)),
            state_names=(),
            faults=(),
            settings=last,
            settings_log=log,
            moves={name: y[OBJECT]} if np.isfinite(y[OBJECT]).any() else {},
            date=date,
        )

    def _kept_curves(self, begin: float) -> "list[KeptCurve]":
        """Return the kept curves as the plots show them."""
        from hapkit_studio.charts.run import KeptCurve

        shown = self._centre.time.shown
        return [
            KeptCurve(
                curve.name,
                curve.time - begin + (shown.zero if curve.pinned else 0.0),
                curve.values["position"],
                curve.values["velocity"],
                curve.values["applied_force"],
                curve.style.token,
                [length / 2.0 for length in curve.style.dash],
            )
            for curve in shown.kept_curves
        ]


def _save(path: str, run: "Run", figure: Figure, decimal: str) -> None:
    """Write a table or a picture depending on the file extension; raise ParameterError for an unknown one."""
    ending = Path(path).suffix.lower()
    if ending in export.WRITERS:
        run.save(path, decimal)
    elif ending in PICTURES:
        figure(path)
    else:
        known = ", ".join((*PICTURES, *export.WRITERS))
        raise ParameterError(f"The file name must end in {known}, not in {ending or 'nothing'!r}.")


def _picture(figure: Figure) -> QImage:
    with TemporaryDirectory() as folder:
        path = f"{folder}/picture.png"
        figure(path)
        return QImage(path)
