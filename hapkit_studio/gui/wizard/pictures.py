"""What the steps show: the kit, the handle on its rail, and a value over the last ten seconds."""

import re
from functools import cache
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QByteArray, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QMouseEvent, QPainter, QPaintEvent, QPen, QResizeEvent
from PySide6.QtSvgWidgets import QSvgWidget
from PySide6.QtWidgets import QPushButton, QSizePolicy, QWidget

from hapkit_studio import resources
from hapkit_studio.formatting import number
from hapkit_studio.gui.scenes import base, force_arrow
from hapkit_studio.gui.scenes.stage import Stage
from hapkit_studio.gui.widgets.theme import theme

_PARTS = ("upright", "plugged", "unplugged", "scale", "side_down", "empty", "weight")


@cache
def _kit() -> str:
    return resources.path("kit.svg").read_text(encoding="utf-8")


class KitDrawing(QSvgWidget):
    """Draws the kit, USB plugged in; supply: whether the motor's supply is to be plugged in too."""

    def __init__(self, supply: bool) -> None:
        super().__init__()
        self._plug = "plugged" if supply else "unplugged"
        self.shown, self.grams = {"upright", self._plug}, ""
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Preferred)
        self.setMinimumSize(250, 150)
        self.setObjectName("kitDrawing")
        self.setAccessibleName("Drawing of the kit")
        theme.changed.connect(self._load)
        self._load()

    def show_weight(self, grams: str) -> None:
        """Lay the kit on its side, with so many grams at its handle; "0" for none."""
        self.shown, self.grams = {"side_down", "empty" if grams == "0" else "weight"}, grams
        self._load()

    def show_scale(self) -> None:
        """Stand the kit up, with a kitchen scale at the right of its handle."""
        self.shown, self.grams = {"upright", self._plug, "scale"}, ""
        self._load()

    def sizeHint(self) -> QSize:
        return self.minimumSize()

    def _load(self) -> None:
        words = {part: "inline" if part in self.shown else "none" for part in _PARTS}
        words |= {"grams": self.grams} | theme.tokens
        text = re.sub(r"@(\w+)", lambda match: words.get(match[1], ""), _kit())
        self.load(QByteArray(text.encode()))
        self.renderer().setAspectRatioMode(Qt.AspectRatioMode.KeepAspectRatio)


REACH = 0.050
"""m that the virtual hand goes to either side."""
_LOWEST, _TALLEST = 150, 236
_PER_NEWTON = 90.0  # px
_BESIDE = 8  # px that the button keeps from the edges


class HandleView(QWidget):
    """Draws position in m, force in N (None: not shown), marks in m with whether each is taken.

    ``hand_moved(place)``: a person drags the hand of a board that has one, in m; None lets go, by a button.
    """

    hand_moved = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.position: float | None = None
        self.force: float | None = None
        self.hand: float | None = None
        self.hand_enabled = False
        self.marks: tuple[tuple[float, bool], ...] = ()
        self.let_go = QPushButton("Let go", self)
        self.let_go.setAutoDefault(False)
        self.let_go.setProperty("always_enabled", True)  # the motor carries what the hand held
        self.let_go.clicked.connect(lambda: self.move_hand(None))
        self.let_go.hide()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self.setMinimumSize(280, _LOWEST)
        self.setMaximumHeight(_TALLEST)
        self.setAccessibleName("Handle on its rail")

    def show_handle(self, position: float, force: float | None = None) -> None:
        """Show where the handle is in m, and what pushes it in N."""
        self.position, self.force = position, force
        self.update()

    def show_marks(self, marks: tuple[tuple[float, bool], ...]) -> None:
        """Show places in m, and whether they are taken."""
        self.marks = marks
        self.update()

    def set_hand_enabled(self, enabled: bool) -> None:
        """Say whether the board has a hand that can be dragged here."""
        self.hand_enabled = enabled
        self.setCursor(Qt.CursorShape.PointingHandCursor if enabled else Qt.CursorShape.ArrowCursor)

    def move_hand(self, place: float | None) -> None:
        """Hold the hand at a place in m; None lets go."""
        self.show_hand(None if place is None else min(max(place, -REACH), REACH))
        self.hand_moved.emit(self.hand)

    def show_hand(self, place: float | None) -> None:
        """Show where the hand holds, without moving it."""
        self.hand = place
        self.let_go.setVisible(place is not None)
        self._place_button()
        self.update()

    def hand_rect(self) -> QRectF | None:
        """Return where the hand's ring is in pixels; None for no hand."""
        if self.hand is None:
            return None
        stage = self._stage()
        x, y, radius = base.ring_place(stage, 1e3 * self.hand), stage.knob_middle, base.RING * stage.u
        return QRectF(x - radius, y - radius, 2 * radius, 2 * radius)

    def sizeHint(self) -> QSize:
        return QSize(520, _LOWEST)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._place_button()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self.mouseMoveEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self.hand_enabled and event.buttons() & Qt.MouseButton.LeftButton:
            self.move_hand(1e-3 * self._stage().mm(event.position().x()))

    def paintEvent(self, event: QPaintEvent) -> None:
        painter, stage = QPainter(self), self._stage()
        stage.begin(painter)
        painter.setPen(QPen(theme.color("line"), 1))
        painter.setBrush(theme.color("scene"))
        painter.drawRoundedRect(QRectF(0.5, 0.5, self.width() - 1, self.height() - 1), 8, 8)
        for place, taken in self.marks:
            x = stage.x(1e3 * place)
            pen = stage.pen("ok", 2) if taken else stage.pen("accent", 2, (4, 4))
            stage.line(x, 8 * stage.u, x, stage.rail, pen)
        stage.axis()
        self._draw_handle(stage)
        for place, taken in self.marks:
            x, y = stage.x(1e3 * place), 20 * stage.u
            words = f"{number(1e3 * place, 0)}{' ✓' if taken else ''}"
            places = [(x + side * 6, y, side) for side in (1, -1)]
            stage.say(words, places, "ok" if taken else "accent", 13, 600, must=True)
        if self.hand_enabled:
            y = stage.rail - 8 * stage.u
            stage.say("Drag: virtual hand", [(10, y, 1), (self.width() - 10, y, -1)], "accent")

    def _draw_handle(self, stage: Stage) -> None:
        """Draw handle, force and hand, as far as they are known, and keep words off them."""
        if self.position is None:
            return
        hand = None if self.hand is None else 1e3 * self.hand
        motion = base.Motion(position=1e3 * self.position, hand=hand, force=self.force or 0.0)
        motion.position_text, motion.force_text = motion.position, force_arrow.force_words(motion.force)
        if base.beyond(stage, motion):
            return
        x = stage.x(motion.position)
        stage.taken.append(QRectF(QPointF(x - 6, 0.0), QPointF(x + 6, stage.rail)))
        stage.taken.append(base.knob(stage, motion.position))
        base.handle(stage, motion.position)
        base.hand_ring(stage, motion)
        if self.force is not None:
            force_arrow.force(stage, motion, _PER_NEWTON)

    def _stage(self) -> Stage:
        return Stage(self.width(), self.height(), self.devicePixelRatioF())

    def _place_button(self) -> None:
        """Put the button on the side where the hand is not, below the knob and its force."""
        size = self.let_go.sizeHint()
        left = _BESIDE if (self.hand or 0.0) > 0.0 else self.width() - size.width() - _BESIDE
        self.let_go.setGeometry(left, round(self._stage().top), size.width(), size.height())


SECONDS = 10.0
_MOST_POINTS = 1500
_JUMP = 64.0  # counts: a smaller step is motion, never the sensor's repeat


class RecentPlot(pg.PlotWidget):
    """Draws values (n,) over board times (n,) in s, the newest on the right; lines are dashed, by name."""

    line_token = "hold"

    def __init__(self, title: str) -> None:
        super().__init__(enableMenu=False)
        self.values = np.empty(0)
        self.lines: dict[str, pg.InfiniteLine] = {}
        self._title = title
        self.setMinimumSize(280, 150)
        self.setObjectName("recent")
        self.setAccessibleName(f"{title}, over the last {SECONDS:g} s")
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setMouseEnabled(False, False)
        self.hideButtons()
        self.curve = self.plot()
        self.setXRange(-SECONDS, 0.0, padding=0.01)
        self.getAxis("bottom").setStyle(showValues=False)
        self.getAxis("left").setWidth(52)
        theme.changed.connect(self._paint)
        self._paint()

    def sizeHint(self) -> QSize:
        return self.minimumSize()

    def set_scale(self, ticks: tuple[float, ...], margin: float = 0.0) -> None:
        """Show values from the first to the last tick, and a margin beyond them."""
        self.setYRange(ticks[0] - margin, ticks[-1] + margin, padding=0.02)
        self.getAxis("left").setTicks([[(tick, number(tick, 0)) for tick in ticks]])

    def add_line(self, name: str, **options: Any) -> None:
        """Add a dashed line across the plot."""
        self.lines[name] = pg.InfiniteLine(angle=0, **options)
        self.addItem(self.lines[name])
        self._paint()

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
        self.setLabel("bottom", f"last {SECONDS:g} s", color=theme.color("axis").name())
        for axis in (self.getAxis("left"), self.getAxis("bottom")):
            axis.setStyle(tickLength=0)
            axis.setPen(theme.color("grid"))
            axis.setTextPen(theme.color("axis"))
            axis.setTickFont(theme.font("tick"))
        for line in self.lines.values():
            line.setPen(pg.mkPen(theme.color(self.line_token), width=1.3, style=Qt.PenStyle.DashLine))
            if hasattr(line, "label"):
                line.label.setColor(theme.color("ink2"))
                line.label.fill = pg.mkBrush(theme.color("plot", 0.9))


class SensorPlot(RecentPlot):
    """Draws readings with their lowest and highest; the teeth of the saw are the sensor's repeats."""

    def __init__(self) -> None:
        super().__init__("Sensor reading, counts")
        for word, y in (("lowest", 0), ("highest", 1)):
            self.add_line(word, label="", labelOpts={"position": 0.1, "anchors": [(0, y), (0, y)]})
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
    line_token = "danger"
    start: float | None = None
    """m from which distances count; None: from the next sample on."""

    def __init__(self) -> None:
        super().__init__("Distance from start, mm")
        for side in (-1, 1):
            self.add_line(f"{side}", pos=side * self.LIMIT)
        self.set_scale((-self.LIMIT, 0.0, self.LIMIT), 0.2 * self.LIMIT)

    def show_positions(self, time: np.ndarray, position: np.ndarray) -> None:
        """Show positions (n,) in m over board times (n,) in s."""
        if self.start is None:
            self.start = float(position[-1])
        self.show_values(time, 1e3 * (position - self.start))

    def begin_here(self) -> None:
        """Count from where the handle is now: the limits of what follows are about that place."""
        self.start = None
