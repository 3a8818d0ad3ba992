"""The live time plots: position, velocity and force over one time axis."""

import math
from collections.abc import Mapping

import numpy as np
from PySide6.QtCore import QElapsedTimer, Signal
from PySide6.QtWidgets import QVBoxLayout, QWidget

from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.history import History, Window
from hapkit_studio.gui.plots.beginning import Beginning
from hapkit_studio.gui.plots.declared import TimePlot, time_plots
from hapkit_studio.gui.plots.gaps import gaps
from hapkit_studio.gui.plots.header import HEIGHT, Header
from hapkit_studio.gui.plots.held import Held
from hapkit_studio.gui.plots.trace_canvas import Shown, TraceCanvas
from hapkit_studio.gui.reel import Reel

SPANS = (1.0, 60.0)
_READOUT_MS = 100
_AXIS = 22
_FOLD_BELOW = 3 * HEIGHT + _AXIS + 160


class TimePlots(QWidget):
    """Linked plots of a history's last seconds; frozen and free to pan and zoom while paused."""

    span_changed = Signal(float)
    paused_changed = Signal(bool)
    pointed = Signal(object)

    def __init__(self, parent: QWidget | None = None, plots: list[TimePlot] | None = None):
        super().__init__(parent)
        self.plots = time_plots() if plots is None else plots
        self.span, self.paused = 10.0, False
        self.shown = Shown()
        self._history = self._seen = History(seconds=1.0, rate=1.0)
        self._reel, self._shades = Reel(), False
        self._environment: Environment | None = None
        self._begin, self._narrow = Beginning(), False
        self._watch = QElapsedTimer()
        self._watch.start()
        column = self._column = QVBoxLayout(self)
        column.setContentsMargins(14, 2, 0, 6)
        column.setSpacing(0)
        self.headers = [Header(plot) for plot in self.plots]
        last = len(self.plots) - 1
        self.canvases = [
            TraceCanvas(plot, self.shown, index == last, index == 0) for index, plot in enumerate(self.plots)
        ]
        for header, canvas in zip(self.headers, self.canvases, strict=True):
            column.addWidget(header)
            column.addWidget(canvas)
            canvas.fit_wanted.connect(self.fit)
            canvas.pointed.connect(self._point)
            canvas.view.setLimits(xMin=-SPANS[1], xMax=0.0, minXRange=0.005)
        for canvas in self.canvases[:-1]:
            canvas.view.setXLink(self.canvases[-1].view)
        self.canvases[-1].view.sigXRangeChanged.connect(self._moved)
        self._show_span()

    # what is shown ------------------------------------------------------------------------------

    def set_history(self, history: History) -> None:
        """Plot another history."""
        self._history, self._reel, self._begin = history, Reel(), Beginning()
        self._seen = history.copy() if self.paused else history

    def set_environment(self, environment, values: Mapping[str, float], max_force: float) -> None:
        """Take over what is drawn besides data: contact shading, the wall's line, the force limit in N.

        For another environment the value axes open anew, once the view is live.
        """
        if environment is not self._environment and self._environment is not None:
            self._begin.put(self._history)
            self._narrow = True
        self._environment = environment
        self._shades = bool(environment.shades)
        self.shown.surface = values.get("position") if self._shades else None
        self.shown.max_force = max_force
        for header in self.headers:
            header.show_surface("" if self.shown.surface is None else environment.title.lower())

    def set_held(self, held: Held | None) -> None:
        """Show a past stretch under the traces, or none any more."""
        self.shown.held = held
        for header in self.headers:
            header.show_held("" if held is None else held.words)

    def set_span(self, seconds: float) -> None:
        """Show the last 1 to 60 seconds; raise ParameterError outside."""
        if not SPANS[0] <= seconds <= SPANS[1]:
            raise ParameterError(f"The time window goes from 1 to 60 s, not {seconds:g}.")
        self.span = float(seconds)
        self._show_span()
        self.span_changed.emit(self.span)

    def set_paused(self, paused: bool) -> None:
        """Freeze the view; the history goes on filling."""
        if paused == self.paused:
            return
        self.paused = self.shown.paused = paused
        self._seen = self._history.copy() if paused else self._history
        self._reel = Reel()
        for canvas in self.canvases:
            canvas.view.setMouseEnabled(paused, False)
        if not paused:
            self._show_span()
        self.paused_changed.emit(paused)

    def set_stale(self, stale: bool) -> None:
        """Paint paler while the device is gone; no frame comes then that would repaint."""
        self.shown.stale = stale
        for canvas in self.canvases:
            canvas.viewport().update()

    def fit(self) -> None:
        """Narrow the value axes to what is shown."""
        for canvas in self.canvases:
            canvas.fit()
        self.refresh()

    def refresh(self) -> None:
        """Draw the newest data; call once per frame."""
        self.take()
        if self.shown.pointed is not None:
            self.pointed.emit(self.shown.zero + (self.shown.pointer or 0.0))
        for canvas in self.canvases:
            if canvas.isVisible():
                canvas.viewport().update()
        if self._watch.elapsed() >= _READOUT_MS and len(self._history):
            self._watch.restart()
            for header in self.headers:
                header.show_value(self._history.last(header.plot.traces[-1].channel))

    def take(self) -> None:
        """Read the window from the history and widen the value axes where needed."""
        shown, canvas = self.shown, self.canvases[-1]
        left, right = canvas.view.viewRange()[0]
        columns = max(round(canvas.frame().width() * self.devicePixelRatioF()), 2)
        width = (right - left) / columns
        now = self._seen.now
        if math.isnan(now):
            shown.window, shown.contact, shown.gaps = Window(np.empty(0), {}, False), [], []
            shown.now = None
            return
        # columns at whole multiples of their width: their samples stay the same, so peaks do not dance
        last = math.ceil(now / width)
        shown.zero = last * width
        first = last + math.floor(left / width + 1e-6)
        shown.window = self._reel.window(self._seen, first, columns + 1, width)
        shown.now = None if self.paused else self._seen.latest()
        shown.contact = self._contact() if self._shades else []
        before = self._seen.before(first * width)
        shown.gaps = [(a - shown.zero, b - shown.zero) for a, b in gaps(shown.window.x, before)]
        shown.begin = -math.inf if self.paused else self._begin.within(self._seen)
        shown.pointed = None if shown.pointer is None else self._seen.at(shown.zero + shown.pointer)
        for canvas in self.canvases:
            if self._narrow and not self.paused:
                canvas.open()
            canvas.widen()
        self._narrow &= self.paused

    def _contact(self) -> list[tuple[float, float]]:
        """Return the stretches (start, stop) in s, relative to zero, in which a force was asked for."""
        window = self.shown.window
        touching = np.nan_to_num(window.y["asked"]) != 0.0
        if window.dense and not np.isnan(window.x).any():
            touching = np.repeat(touching.reshape(-1, 2).any(axis=1), 2)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], touching, [False]]).astype(np.int8)))
        x = window.x - self.shown.zero
        return [(float(x[a]), float(x[b - 1])) for a, b in edges.reshape(-1, 2)]

    # view ---------------------------------------------------------------------------------------

    def _show_span(self) -> None:
        self.canvases[-1].view.setXRange(-self.span, 0.0, padding=0)

    def _moved(self) -> None:
        if self.paused:
            self.refresh()

    def _point(self, time: float | None) -> None:
        self.shown.pointer = time
        self.refresh()
        if time is None:
            self.pointed.emit(None)

    def resizeEvent(self, event) -> None:
        """Share out the height; fold what may be folded when there is little."""
        super().resizeEvent(event)
        margins = self._column.contentsMargins()
        room = self.height() - margins.top() - margins.bottom()
        folded = [plot.folds and room < _FOLD_BELOW for plot in self.plots]
        free = room - HEIGHT * folded.count(False) - _AXIS
        whole = sum(p.share for p, away in zip(self.plots, folded, strict=True) if not away)
        for header, away in zip(self.headers, folded, strict=True):
            header.setVisible(not away)
        for plot, canvas, away in zip(self.plots, self.canvases, folded, strict=True):
            canvas.setVisible(not away)
            axis = _AXIS if canvas is self.canvases[-1] else 0
            self._column.setStretchFactor(canvas, max(int(free * plot.share / whole), 1) + axis)
