"""Pictures of the steps: the kit, the handle on its rail, and a plot of the last ten seconds."""

import re
from collections.abc import Mapping

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QByteArray, QRectF, QSize, Qt
from PySide6.QtGui import QMouseEvent, QPen, QResizeEvent, QWheelEvent
from PySide6.QtSvgWidgets import QSvgWidget
from PySide6.QtWidgets import QPushButton, QSizePolicy

from hapkit_studio import resources
from hapkit_studio.formatting import number
from hapkit_studio.gui.scenes import base, force_arrow
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.scenes.view import SceneView
from hapkit_studio.gui.widgets.theme import theme

_PARTS = ("upright", "plugged", "unplugged", "scale", "spring", "side_down", "empty", "weight")


class KitDrawing(QSvgWidget):
    """A drawing of the kit with USB plugged in; with ``supply``, the motor's supply is plugged in as well."""

    def __init__(self, supply: bool) -> None:
        super().__init__()
        self._source = resources.path("kit.svg").read_text(encoding="utf-8")
        self._plug = "plugged" if supply else "unplugged"
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Preferred)
        self.setMinimumSize(250, 150)
        self.setObjectName("kitDrawing")
        self.setAccessibleName("Drawing of the kit")
        theme.changed.connect(self._load)
        self._show(self._plug, "upright")

    def show_weight(self, grams: str) -> None:
        """Show the kit on its side, with a weight in grams at its handle; "0" means no weight."""
        self._show("side_down", "empty" if grams == "0" else "weight", grams=grams)

    def show_scale(self) -> None:
        """Show the kit upright, with a kitchen scale to the right of its handle."""
        self._show("upright", self._plug, "scale")

    def show_spring(self) -> None:
        """Show the kit upright, with a spring between its handle and a post on the left."""
        self._show("upright", self._plug, "spring")

    def sizeHint(self) -> QSize:
        return self.minimumSize()

    def _show(self, *parts: str, grams: str = "") -> None:
        self.shown, self.grams = set(parts), grams
        self._load()

    def _load(self) -> None:
        values = {part: "inline" if part in self.shown else "none" for part in _PARTS}
        values |= {"grams": self.grams} | theme.tokens
        self.load(QByteArray(re.sub(r"@(\w+)", lambda name: values.get(name[1], ""), self._source).encode()))
        self.renderer().setAspectRatioMode(Qt.AspectRatioMode.KeepAspectRatio)


_PER_NEWTON = 90.0  # px: length of the force's arrow per newton
_BESIDE = 8  # px: distance between the button and the edges


class HandleView(SceneView):
    """Draws the handle on its rail, marks and, optionally, the motor's force.

    ``marks`` maps the position of each mark in m to True if the mark was taken. After dragging, a simulated
    hand holds the handle in place, so that the user can press a button. The button *Let go* releases the
    handle.
    """

    def __init__(self, with_force: bool) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # during a job the keyboard focus stays on the E-stop
        self.marks: Mapping[float, bool] = {}
        self._with_force, self._known = with_force, False
        self.let_go = QPushButton("Let go", self)
        self.let_go.hide()
        self._button_left = False
        self.let_go.clicked.connect(self.release)
        self.setMinimumSize(280, 150)
        self.setMaximumHeight(236)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self.setAccessibleName("Picture of the handle's position")
        self.set_hand_enabled(False)
        self._place_button()

    def show_handle(self, position: float, force: float) -> None:
        """Show the handle's position in m, and the motor's force in N."""
        self._known = True
        self.update_state(position, force, force, self._target, False, False, np.empty(0))

    def sizeHint(self) -> QSize:
        return QSize(520, 150)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._place_button()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self._dragging = False
        self.set_hand_enabled(self._hand_enabled)  # this shows the pointer as an open hand again

    def wheelEvent(self, event: QWheelEvent) -> None:
        event.ignore()  # the page scrolls with this event

    def _move_hand(self, target: float) -> None:
        super()._move_hand(target)
        self._place_button()

    def release(self) -> None:
        super().release()
        self._place_button()

    def _place_button(self) -> None:
        """Place the button below the knob, on the side on which it does not cover the hand."""
        size, stage = self.let_go.sizeHint(), self._layout()
        ends = self.width() - size.width() - _BESIDE, _BESIDE
        hand = stage.x(1e3 * (self._target or 0.0))
        reach = size.width() / 2 + base.RING * stage.u + 2
        if abs(ends[self._button_left] + size.width() / 2 - hand) <= reach:
            self._button_left = not self._button_left
        left = ends[self._button_left]
        self.let_go.setGeometry(left, round(self._layout().top), size.width(), size.height())
        self.let_go.setVisible(self._target is not None)

    def _play(self, stage: Stage) -> None:
        stage.p.setPen(QPen(theme.color("line"), 1))
        stage.p.setBrush(Qt.BrushStyle.NoBrush)
        stage.p.drawRoundedRect(QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5), 8, 8)
        for place, taken in self.marks.items():
            x = stage.x(1e3 * place)
            pen = stage.pen("ok", 2) if taken else stage.pen("accent", 2, (4, 4))
            stage.line(x, 8 * stage.u, x, stage.rail, pen)
        if self._known:
            self._play_handle(stage)
        for place, taken in self.marks.items():
            x, y = stage.x(1e3 * place), 20 * stage.u
            places = [(x + side * 6, y, side) for side in (1, -1)]
            text = f"{number(1e3 * place, 0)}{' ✓' if taken else ''}"
            stage.write(text, places, "ok" if taken else "accent", 13, 600, must=True)
        if self._hand_enabled:
            y = stage.rail - 8 * stage.u
            stage.write("Drag to move the virtual hand", [(10, y, 1), (self.width() - 10, y, -1)], "accent")

    def _play_handle(self, stage: Stage) -> None:
        """Draw the handle, the hand and the force. Place the labels so that they do not cover the drawing."""
        motion = self._motion
        if base.beyond(stage, motion):
            return
        x = stage.x(motion.position)
        stage.occupied += [QRectF(x - 6, 0.0, 12, stage.rail), base.knob(stage, motion.position)]
        base.handle(stage, motion.position)
        base.hand_ring(stage, motion)
        if self._with_force:
            force_arrow.force(stage, motion, _PER_NEWTON)


SECONDS = 10.0
_MOST_POINTS = 1500
_JUMP = 64.0  # counts: a larger step is the sensor's wrap-around, a smaller step is motion


class RecentPlot(pg.PlotWidget):
    """Plots values (n,) over board times (n,) in s, the newest on the right, with dashed lines."""

    def __init__(self, title: str, lines: list[pg.InfiniteLine], token: str) -> None:
        super().__init__(enableMenu=False)
        self.values, self.lines = np.empty(0), lines
        self._title, self._token = title, token
        self.setMinimumSize(280, 150)
        self.setObjectName("recent")
        self.setAccessibleName(f"{title}, over the last {SECONDS:g} s")
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setMouseEnabled(False, False)
        self.hideButtons()
        self.curve = self.plot()
        for line in lines:
            self.addItem(line)
        self.setXRange(-SECONDS, 0.0, padding=0.01)
        self.getAxis("bottom").setStyle(showValues=False)
        # pyqtgraph ignores the frame and its padding, which hide 8 px at the right and at the bottom
        self.getPlotItem().layout.setContentsMargins(3, 3, 14, 12)
        self.getAxis("left").setWidth(52)
        theme.changed.connect(self._paint)
        self._paint()

    def sizeHint(self) -> QSize:
        return self.minimumSize()

    def set_scale(self, ticks: tuple[float, ...], margin: float = 0.0) -> None:
        """Show the range from the first to the last tick, with a margin."""
        self.setYRange(ticks[0] - margin, ticks[-1] + margin, padding=0.02)
        self.getAxis("left").setTicks([[(tick, number(tick, 0)) for tick in ticks]])

    def show_values(self, time: np.ndarray, values: np.ndarray) -> None:
        """Show values (n,) over board times (n,) in s.

        The line is interrupted at jumps over nearly the whole range.
        """
        self.values = values
        step = max(1, len(time) // _MOST_POINTS)
        shown = values[::step]
        jumps = np.abs(np.diff(shown, append=shown[-1:])) > 0.4 * max(float(np.ptp(shown)), _JUMP)
        self.curve.setData(time[::step] - time[-1], shown, connect=~jumps)

    def _paint(self) -> None:
        self.setBackground(theme.color("plot"))
        self.setTitle(self._title, color=theme.color("ink"), size="13px", bold=True, justify="left")
        self.curve.setPen(pg.mkPen(theme.color("position"), width=2))
        self.setLabel("bottom", f"time, last {SECONDS:g} s", color=theme.color("axis").name())
        for axis in (self.getAxis("left"), self.getAxis("bottom")):
            axis.setStyle(tickLength=0)
            axis.setPen(theme.color("grid"))
            axis.setTextPen(theme.color("axis"))
            axis.setTickFont(theme.font("tick"))
        for line in self.lines:
            line.setPen(pg.mkPen(theme.color(self._token), width=1.3, style=Qt.PenStyle.DashLine))
            if hasattr(line, "label"):
                line.label.setColor(theme.color("ink2"))
                line.label.fill = pg.mkBrush(theme.color("plot", 0.9))


class SensorPlot(RecentPlot):
    """Plots sensor readings with their lowest and highest value; a wrap-around appears as a sawtooth."""

    def __init__(self) -> None:
        place = [{"position": 0.1, "anchors": [(0, y), (0, y)]} for y in (0, 1)]
        lines = [pg.InfiniteLine(angle=0, label="", labelOpts=options) for options in place]
        super().__init__("Sensor reading, counts", lines, "hold")
        self.set_scale((0, 512, 1023))

    def show_readings(self, time: np.ndarray, raw: np.ndarray, bottom: int, top: int) -> None:
        """Show readings (n,) over board times (n,) in s.

        ``bottom`` and ``top`` are the limits of the vertical axis.
        """
        self.set_scale((bottom, round(0.5 * (bottom + top)), top))
        self.show_values(time, raw)
        for line, word, value in zip(self.lines, ("lowest", "highest"), (raw.min(), raw.max()), strict=True):
            line.setValue(float(value))
            line.label.setFormat(f"{word} {number(value, 0)}")


class PositionPlot(RecentPlot):
    """Plots positions relative to the handle's start, with lines at the limits of a sweep (± 25 mm)."""

    LIMIT = 25.0
    start: float | None = None
    """The reference position in m; None means that the next sample becomes the reference."""

    def __init__(self) -> None:
        lines = [pg.InfiniteLine(angle=0, pos=side * self.LIMIT) for side in (-1, 1)]
        super().__init__("Distance from start, mm", lines, "danger")
        self.set_scale((-self.LIMIT, 0.0, self.LIMIT), 0.2 * self.LIMIT)

    def show_positions(self, time: np.ndarray, position: np.ndarray) -> None:
        """Show positions (n,) in m over board times (n,) in s."""
        if self.start is None:
            self.start = float(position[-1])
        self.show_values(time, 1e3 * (position - self.start))
