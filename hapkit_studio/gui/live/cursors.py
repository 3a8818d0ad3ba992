"""Cursors A and B in the live plots, with the two samples and the statistics between them."""

import math
from operator import itemgetter

import numpy as np
from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtWidgets import QWidget

from hapkit_studio.analysis.statistics import Line, line, statistics
from hapkit_studio.columns import Column
from hapkit_studio.formatting import interval, with_unit
from hapkit_studio.gui.live.history import History
from hapkit_studio.gui.live.time_view import TimeView
from hapkit_studio.gui.widgets.parts import hbox, label, vbox
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.widgets.table import Table
from hapkit_studio.gui.widgets.theme import number
from hapkit_studio.haptics.signals import BY_NAME

NAMES = "A", "B"
_EACH_MS = 200  # ms: update interval of the statistics while a cursor is dragged
# initial positions of A and B before the newest sample, as fractions of the time window
_FIRST = 2 / 3, 1 / 3
_FADE = 0.05  # s: duration of a settings change, because numbers and forces fade for 30 ms
# N: the motor's force equals the requested force within this tolerance, which exceeds a motor step
_FOLLOWED = 0.05
_BENT = 0.05  # a line is straight if its maximum residual is below this fraction of the force's RMS


_LISTED = tuple(
    (BY_NAME[name], f"{symbol}, {BY_NAME[name].shown_unit}", decimals)
    for name, symbol, decimals in (("position", "x", 2), ("velocity", "v", 1), ("applied_force", "F", 3))
)
"""The rows of the table: signal, heading and decimals."""


Row = tuple[str, ...]
"""A row of the table consists of its heading and its cells."""


class Cursors(QObject):
    """The positions of A and B as times in s of the history's samples; None while the cursors are off."""

    changed = Signal()

    def __init__(self, view: TimeView, parent: QObject | None = None):
        super().__init__(parent)
        self.view = view
        self.times: tuple[float, float] | None = None
        self.max_force = math.inf
        """The force limit in N."""

    @property
    def _history(self) -> History:
        return self.view.history

    @property
    def on(self) -> bool:
        """Return whether the cursors are shown."""
        return self.times is not None

    def show(self, on: bool) -> None:
        """Show both cursors in the visible part of the history, or hide them."""
        stop, span = self.view.stretch[1], self.view.span
        if not on or math.isnan(stop):
            self.times = None
        elif self.times is None:
            self.times = (self._snapped(stop - _FIRST[0] * span), self._snapped(stop - _FIRST[1] * span))
        self.changed.emit()

    def move(self, index: int, time: float) -> None:
        """Move cursor ``index`` (0: A, 1: B) to the last sample up to a time in s."""
        if self.times is not None:
            times = list(self.times)
            times[index] = self._snapped(time)
            self.times = (times[0], times[1])
            self.changed.emit()

    def _snapped(self, time: float) -> float:
        before = self._history.before(time)
        return self._history.start if math.isnan(before) else before

    def forget_lost(self) -> None:
        """Hide the cursors once the history has dropped their samples."""
        if self.times is not None and min(self.times) < self._history.start:
            self.show(False)

    @property
    def settings_differ(self) -> bool:
        """Return whether settings changed between the cursors, or less than _FADE s before the first one."""
        first, last = sorted(self.times or (math.nan, math.nan))
        return any(first - _FADE < time <= last for time in self._history.changes)

    def between(self) -> dict[str, np.ndarray]:
        """Return the time and the channels (n,) of all samples from A to B inclusive, n > 1; otherwise {}."""
        first, last = sorted(self.times or (math.nan, math.nan))
        window = self._history.between(first, math.nextafter(last, math.inf)).known()
        return {"time": window.x, **window.y} if len(window.x) > 1 else {}

    def at(self) -> tuple[dict[str, float] | None, ...]:
        """Return all channels at A and B."""
        return tuple(self._history.at(time) for time in self.times or ())


def points(cursors: Cursors) -> list[Row]:
    """Return the rows for the time (relative to the plots' zero) and for each signal: A, B and B − A."""
    at_a, at_b = cursors.at()
    if cursors.times is None or at_a is None or at_b is None:
        return []
    rows = [_row("t, s", 1.0, 3, *(time - cursors.view.zero for time in cursors.times))]
    for signal, head, decimals in _LISTED:
        rows.append(_row(head, signal.scale, decimals, at_a[signal.name], at_b[signal.name]))
    return rows


def _row(head: str, scale: float, decimals: int, a: float, b: float) -> Row:
    cells = number(scale * a, decimals), number(scale * b, decimals)
    return head, *cells, number(scale * (b - a), decimals, sign=True)


def ranges(samples: dict[str, np.ndarray]) -> list[Row]:
    """Return a row of statistics for each signal from A to B."""
    rows = []
    for signal, head, decimals in _LISTED if samples else ():
        found = statistics(samples["time"], samples[signal.name])
        values = (found.minimum, found.maximum, found.mean, found.rms)
        often = "–" if math.isnan(found.frequency) else with_unit(found.frequency, "", 3)
        rows.append((head, *(number(signal.scale * value, decimals) for value in values), often))
    return rows


def slope(cursors: Cursors, samples: dict[str, np.ndarray]) -> tuple[Line | None, str]:
    """Return the fitted line of force over position and its slope as text; or None and the reason.

    The fit uses only samples in which the law requested a force and the motor applied this force. The free
    space in front of a wall therefore does not bias the slope.
    """
    if not samples:
        return None, "–"
    if cursors.settings_differ:
        return None, "no slope: settings changed"
    position, applied, asked = (samples[name] for name in ("position", "applied_force", "force"))
    given = (np.abs(asked) < cursors.max_force) & (np.abs(applied - asked) <= _FOLLOWED)
    acts = given & (asked * applied > 0.0)
    if not acts.any():
        return None, "no slope: no force there"
    found = line(position, applied, acts)
    if found is None:
        return None, "no slope: too little motion"
    if found.left > _BENT:
        return None, "no slope: not a straight line"
    digits = 0 if found.half >= 10.0 else 1
    return found, f"{interval(found.slope, found.half, digits)} N/m"


_FOLDED, _BOTH = 0, 1  # indices of the switch's segments
_HEADS = (), ("A", "B", "B − A"), ("minimum", "maximum", "mean", "RMS", "Hz")
_SLOPE_HELP = (
    "Slope of force over position between A and B, with its 95 % interval. Only samples with a "
    "force below the force limit are used. There is no slope if a setting changed or the samples do "
    "not lie on a straight line"
)


def _columns(heads: tuple[str, ...]) -> tuple[Column, ...]:
    values = (Column(head, itemgetter(index)) for index, head in enumerate(heads, 1))
    return (Column("", itemgetter(0), right=False), *values)


class CursorCard(QWidget):
    """Shows the slope and a table with both samples, or with the statistics between the cursors.

    Emits ``fitted`` with the line of force over position (None: no line), and ``unfolded`` when the table
    appears or disappears.
    """

    fitted = Signal(object)
    unfolded = Signal()

    def __init__(self, cursors: Cursors, parent: QWidget | None = None):
        super().__init__(parent)
        self._cursors, self._read = cursors, False
        self._samples: dict[str, np.ndarray] = {}
        self._low = False
        # selected segment when there is enough height for plot and table, and when there is not
        self._chosen = [_BOTH, _FOLDED]
        self.switch = Segmented("Table of the cursors", ("No table", "A and B", "Statistics"))
        self.switch.show_index(_BOTH)
        self.table = Table("Values at the cursors")
        self.slope = label(role="strong", wrap=False)
        self.slope.setToolTip(_SLOPE_HELP)
        self.period = label(role="hint", wrap=False)
        head = hbox(label("Slope from A to B", wrap=False), None, self.slope)
        vbox(
            head, hbox(self.period, None, self.switch), 4, self.table, None,
            into=self, margins=(14, 4, 16, 8), gap=2,
        )  # fmt: skip
        self._each = QTimer(self, interval=_EACH_MS)
        self._each.timeout.connect(self.refresh)
        self.switch.chosen.connect(self._choose)
        cursors.changed.connect(self._follow)
        self.hide()

    @property
    def covers(self) -> bool:
        """Return whether the table is shown in place of the plot above it."""
        return self._low and self._cursors.on and self.switch.index != _FOLDED

    def set_low(self, low: bool) -> None:
        """Set whether the height is too low to show both the table and the plot above it."""
        if low != self._low:
            self._low = low
            self.switch.show_index(self._chosen[low])
            self.refresh()
            self.unfolded.emit()

    def _choose(self, index: int) -> None:
        self._chosen[self._low] = index
        self.refresh()
        self.unfolded.emit()

    def _follow(self) -> None:
        self._read = False
        if self._cursors.on == self.isHidden():
            self.setVisible(self._cursors.on)
            self.unfolded.emit()
        if self._cursors.on:
            self._each.start()
        else:
            self._each.stop()
            self.fitted.emit(None)

    def refresh(self) -> None:
        """Update the slope; if a cursor moved or samples were dropped, update the table, too."""
        self._cursors.forget_lost()
        times = self._cursors.times
        if times is None:
            return
        if not self._read:
            self._read, self._samples = True, self._cursors.between()
            found, text = slope(self._cursors, self._samples)
            self.slope.setText(text)
            self.fitted.emit(found)
            apart = abs(times[1] - times[0])
            self.period.setText(f"1/Δt  {with_unit(1.0 / apart, 'Hz')}" if apart > 0.0 else "")
        index = self.switch.index
        rows: list[Row] = []
        if index != _FOLDED:
            rows = points(self._cursors) if index == _BOTH else ranges(self._samples)
        self.table.show_rows(_columns(_HEADS[index]), rows)
