"""A value over the last ten seconds: the sensor's reading, or how far the handle is from its start."""

from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QSizePolicy

from hapkit_studio.formatting import number
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.theme import theme

SECONDS = 10.0
_MOST_POINTS = 1500
_JUMP = 64.0
"""Counts: a smaller step is motion, never the sensor's repeat."""


class RecentPlot(pg.PlotWidget):
    """Draws values (n,) over board times (n,) in s, the newest on the right."""

    def __init__(self, title: str, name: str) -> None:
        super().__init__(enableMenu=False)
        self.values = np.empty(0)
        self._title = title
        self._lines: list[tuple[pg.InfiniteLine, str]] = []
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(280, 150)
        dress(self, "RecentPlot { border: 1px solid @line; border-radius: 8px; }")
        self.setAccessibleName(name)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setMouseEnabled(False, False)
        self.hideButtons()
        self.curve = self.plot()
        self.setXRange(-SECONDS, 0.0, padding=0.01)
        self.getAxis("bottom").setStyle(showValues=False)
        self.getAxis("left").setWidth(52)
        self.getPlotItem().setContentsMargins(0, 4, 12, 8)
        theme.changed.connect(self._paint)
        self._paint()

    def sizeHint(self) -> QSize:
        return self.minimumSize()

    def set_scale(self, ticks: tuple[float, ...], margin: float = 0.0) -> None:
        """Show values from the first to the last tick, and a margin beyond them."""
        self.setYRange(ticks[0] - margin, ticks[-1] + margin, padding=0.02)
        self.getAxis("left").setTicks([[(tick, number(tick, 0)) for tick in ticks]])

    def add_line(self, color: str, **options: Any) -> pg.InfiniteLine:
        """Return a new dashed line across the plot, in the theme's colour of that name."""
        line = pg.InfiniteLine(angle=0, **options)
        self.addItem(line)
        self._lines.append((line, color))
        self._paint()
        return line

    def show_values(self, time: np.ndarray, values: np.ndarray) -> None:
        """Show values (n,) over board times (n,) in s; a jump of nearly the whole range is no line."""
        self.values = values
        step = max(1, len(time) // _MOST_POINTS)
        shown = values[::step]
        jumps = np.abs(np.diff(shown, append=shown[-1:])) > 0.4 * max(float(np.ptp(shown)), _JUMP)
        self.curve.setData(time[::step] - time[-1], shown, connect=~jumps)

    def _paint(self) -> None:
        self.setBackground(theme.color("plot"))
        self.setTitle(self._title, color=theme.color("ink"), size="13px", bold=True, justify="left")
        self.curve.setPen(pg.mkPen(theme.color("position"), width=2))
        self.setLabel(
            "bottom", f"last {SECONDS:g} s", color=theme.color("axis").name(), **{"font-size": "12px"}
        )
        for axis in (self.getAxis("left"), self.getAxis("bottom")):
            axis.setStyle(tickLength=0)
            axis.setPen(theme.color("grid"))
            axis.setTextPen(theme.color("axis"))
            axis.setTickFont(theme.font("tick"))
        for line, color in self._lines:
            line.setPen(pg.mkPen(theme.color(color), width=1.3, style=Qt.PenStyle.DashLine))
            if hasattr(line, "label"):
                line.label.setColor(theme.color("ink2"))
                line.label.fill = pg.mkBrush(theme.color("plot", 0.9))


class SensorPlot(RecentPlot):
    """Draws readings with their lowest and highest; the teeth of the saw are the sensor's repeats."""

    def __init__(self) -> None:
        super().__init__("Sensor reading, counts", "Sensor reading over time")
        self.lines = {
            word: self.add_line("hold", label="", labelOpts={"position": 0.1, "anchors": [(0, y), (0, y)]})
            for word, y in (("lowest", 0), ("highest", 1))
        }
        self.set_scale((0, 512, 1023))

    def show_readings(self, time: np.ndarray, raw: np.ndarray, bottom: int, top: int) -> None:
        """Show readings (n,) over board times (n,) in s, and the scale for them."""
        self.set_scale((bottom, round(0.5 * (bottom + top)), top))
        self.show_values(time, raw)
        for word, value in (("lowest", raw.min()), ("highest", raw.max())):
            self.lines[word].setValue(float(value))
            self.lines[word].label.setFormat(f"{word} {number(value, 0)}")


class PositionPlot(RecentPlot):
    """Draws positions about where the handle began, with the limits of a sweep, ± 25 mm."""

    LIMIT = 25.0
    start: float | None = None
    """m from which distances count; None: from the next sample on."""

    def __init__(self) -> None:
        super().__init__("Distance from start, mm", "Position over time")
        for side in (-1, 1):
            self.add_line("danger", pos=side * self.LIMIT)
        self.set_scale((-self.LIMIT, 0.0, self.LIMIT), 0.2 * self.LIMIT)

    def show_positions(self, time: np.ndarray, position: np.ndarray) -> None:
        """Show positions (n,) in m over board times (n,) in s."""
        if self.start is None:
            self.start = float(position[-1])
        self.show_values(time, 1e3 * (position - self.start))

    def begin_here(self) -> None:
        """Count from where the handle is now: the limits of what follows are about that place."""
        self.start = None
