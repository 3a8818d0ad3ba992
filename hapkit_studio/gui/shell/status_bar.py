"""The status bar: the loop's timing with details on a click, clamp light, stability, and recording."""

import math
import time

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QFrame, QPushButton, QWidget

from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.parts import Sign, hbox, label, vbox
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.theme import number, theme
from hapkit_studio.haptics.health import WINDOW_SECONDS

CLAMP_SHOWN_S = 0.5
_MARGIN, _SPACING = 14, 12
_RATE_OFF = 0.02
_MOST_MISSED = 1e-3  # the user does not feel missed ticks if they are below this fraction of recent ticks
_JUMPS = "How many times the clock of the board jumped or stopped since the device was connected"
_MISSED = (
    "How many times a force came too late or not at all, or USB data were lost, since the device was "
    "connected"
)
_LATE, _IN_TIME = "Loop late", "Loop on time"
_CLAMP_WORDS = "Force cut to 8.8 N", "Force below limit of 8.8 N", "Force +8.8 N, limit 8.8 N"
_ENERGY_WORDS = ("The scene gave you 0.88 mJ of extra energy",)
_PRIORITY_WORDS = ("Normal priority, forces up to 88.8 ms late.",)


class Field(QWidget):
    """Shows a sign and a text, and a vertical line to their left unless ``edged`` is False.

    The field is as wide as its text, and at least as wide as the texts ``longest``, so that a link to the
    right of the text does not move.
    """

    def __init__(self, name: str, edged: bool = True, longest: tuple[str, ...] = ()):
        super().__init__()
        self._name, self._longest = name, longest
        self.sign, self.label = Sign(16), label("…", "status", wrap=False)
        self.link = QPushButton(autoDefault=True)  # Enter presses this button, because Space pauses the plots
        self.link.setProperty("link", True)
        self.link.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.link.hide()
        parts = hbox(self.sign, self.label, self.link, into=self, gap=6)
        if edged:
            edge = QFrame()
            edge.setFixedSize(1, 16)
            edge.setProperty("rule", True)
            parts.insertWidget(0, edge)
            parts.insertSpacing(1, 6)
        self.show_text("…")
        if longest:
            theme.changed.connect(self._reserve)
            self._reserve()

    def _reserve(self) -> None:
        """Reserve the width of the longest text in the current font."""
        metrics = QFontMetricsF(theme.font("label"))  # "label" is the widest style of the text
        self.label.setMinimumWidth(math.ceil(max(map(metrics.horizontalAdvance, self._longest))))

    def show_text(self, text: str, sign: str = "", token: str = "ink2") -> None:
        """Show a text after a sign, both in a token's colour."""
        if text != self.label.text():
            self.label.setText(text)
            self.label.setVisible(bool(text))
            self.setAccessibleName(f"{self._name}: {text}")
        mark(self.label, "ink", token)
        if (sign, token) != (self.sign.name, self.sign.token):
            self.sign.show_sign(sign, token)
        self.sign.setVisible(bool(sign))


def late(microseconds: float) -> str:
    """Format a lateness, given in µs, in ms: with two decimals below 10 ms, otherwise with one."""
    value = microseconds / 1000.0
    return f"{number(value, 2 if value < 9.95 else 1)} ms"


def _is_off(rate: float, nominal: float | None) -> bool:
    """Return whether a rate in Hz differs from the nominal rate; a rate of 0 means unknown."""
    return bool(rate) and nominal is not None and abs(rate - nominal) > _RATE_OFF * nominal


def rate_text(rate: float, nominal: float | None, on_board: bool) -> str:
    """Format a measured rate in Hz; if it differs from the nominal rate, the text contains both."""
    measured = f"{rate:,.0f} Hz" if rate else "– Hz"
    if nominal is None:
        return measured
    if on_board:
        return f"Force at {nominal:,.0f} Hz, data at {f'{rate:,.0f}' if rate else '–'} Hz"
    if _is_off(rate, nominal):
        return f"{rate:,.0f} of {nominal:,.0f} Hz"
    return measured


class StatusBar(QWidget):
    """Shows fields from left to right; in a narrow window, less important fields are hidden.

    ``figures`` is a card above the bar; a click on the loop's field shows or hides it.
    """

    how_to_fix = Signal()
    show_sessions = Signal()

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.setObjectName("status")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.loop, self.clamp = Field("Loop", edged=False), Field("Force limit", longest=_CLAMP_WORDS)
        self.margin, self.energy = Field("Stability"), Field("Energy", longest=_ENERGY_WORDS)
        self.record = Field("Record", edged=False)
        self.energy.link.setText("Switch controller on")
        self.energy.link.setToolTip("Switch on the passivity controller, which adds damping as needed")
        names = "Servo rate", "Lateness", "Missed ticks", "Board's clock", "Computing time", "Priority"
        lines = self.rate, self.late, self.missed, self.jumps, self.compute, self.priority = [
            Field(name, edged=False, longest=_PRIORITY_WORDS * (name == "Priority")) for name in names
        ]
        self.figures = QFrame(parent or self)
        self.figures.setProperty("card", True)
        vbox(*(hbox(line, None) for line in lines), into=self.figures, margins=(14, 10, 14, 10), gap=6)
        self.figures.hide()
        self.loop.link.setToolTip(
            "Show servo rate, lateness, missed ticks, computing time and priority of the loop"
        )
        self.loop.link.setLayoutDirection(Qt.LayoutDirection.RightToLeft)
        icons.bind(self.loop.link, "chevron_up", "ink2", 14)
        self.loop.link.clicked.connect(lambda: self.show_figures(self.figures.isHidden()))
        self.priority.link.setText("How to fix this")
        self.priority.link.clicked.connect(self.how_to_fix)
        self.record.link.setText("Show")
        self.record.link.setToolTip("Show the recorded sessions")
        self.record.link.clicked.connect(self.show_sessions)
        self.missed.setToolTip(_MISSED)
        self.jumps.setToolTip(_JUMPS)
        self._clamped_until = 0.0
        fields = self.loop, self.clamp, self.energy, self.margin
        hbox(*fields, None, self.record, into=self, margins=(_MARGIN, 0, _MARGIN, 0), gap=_SPACING)
        theme.changed.connect(self._reserve_loop)
        self._reserve_loop()
        self.show_energy("")
        self.show_nothing("Preparing the loop. This happens only once.")

    def _reserve_loop(self) -> None:
        """Reserve the width of the loop's longest text, so that the clamp light does not move."""
        link, metrics = self.loop.link, QFontMetricsF(theme.font("strong"))
        # width of the chevron and its gap, and of the button's padding and border
        beside = theme.px(14) + 4 + 2 * theme.px(5)
        link.setMinimumWidth(math.ceil(max(map(metrics.horizontalAdvance, (_LATE, _IN_TIME)))) + beside)

    def show_nothing(self, text: str) -> None:
        """Show that no loop is running."""
        self.loop.show_text(text)
        self.loop.link.hide()
        self.show_figures(False)
        self.clamp.show_text("No force", "circle")
        self._hide_least_important()

    def show_figures(self, on: bool) -> None:
        """Show or hide the card with the loop's figures."""
        self.figures.setVisible(on)
        QWidget.setTabOrder(self.loop.link, self.priority.link)
        self._place_figures()

    def show_health(
        self, health, nominal: float | None = None, on_board: bool = False, compute: float = math.nan
    ) -> None:
        """Show the loop's health.

        ``nominal`` is the nominal rate in Hz; if ``on_board`` is True, it is the board's own rate.
        ``compute`` is the time in s that the newest tick needed for its computation.
        """
        us = health.lateness_us
        self.rate.show_text(rate_text(health.rate, nominal, on_board), "", "ink")
        self.late.show_text(
            f"Lateness: below {late(us['p99'])} for 99 % of the ticks, at most {late(us['max'])}"
        )
        lost = health.missed + health.link.lost_frames
        lately = health.missed_lately > 0
        often = health.missed_lately > _MOST_MISSED * WINDOW_SECONDS * (nominal or health.rate)
        late_now = often or (not on_board and _is_off(health.rate, nominal))
        word, *sign = (_LATE, "triangle", "warn") if late_now else (_IN_TIME, "check", "ok")
        self.loop.show_text("", *sign)
        self.loop.link.setText(word)
        mark(self.loop.link, "ink", sign[1])
        self.loop.link.show()
        self.compute.setHidden(on_board or math.isnan(compute))
        self.compute.show_text(f"Computing the force took {number(1e6 * compute, 1)} µs")
        self.missed.show_text(
            f"Missed ticks: {lost:,}", "triangle" if lately else "", "warn" if lately else "ink2"
        )
        jumps = health.link.clock_jumps
        self.jumps.show_text(f"The board's clock jumped {jumps:,} times (corrected)", "triangle", "warn")
        self.jumps.setVisible(jumps > 0)
        priority = health.priority
        text = f"{priority.text}, forces up to {late(us['max'])} late."
        shown = (priority.text, "check", "ok") if priority.realtime else (text, "triangle", "warn")
        self.priority.show_text(*shown)
        self.priority.link.setVisible(not priority.realtime)
        self.priority.setToolTip(priority.how)
        self._place_figures()
        self._hide_least_important()

    def show_clamp(self, clamped: bool, limit: float, acting: float | None = None) -> None:
        """Show the clamp light; it stays lit for half a second so that it can be seen.

        ``acting`` is the current force in N; it is given only while no other widget shows this force.
        """
        now = time.monotonic()
        if clamped:
            self._clamped_until = now + CLAMP_SHOWN_S
        if now < self._clamped_until:
            self.clamp.show_text(f"Force cut to {number(limit, 1)} N", "triangle", "warn")
        else:
            text = f"Force below limit of {number(limit, 1)} N"
            if acting is not None:
                text = f"Force {number(acting, 1, sign=True)} N, limit {number(limit, 1)} N"
            self.clamp.show_text(text, "circle")

    def show_margin(self, text: str, sign: str, token: str) -> None:
        """Show the verdict on stability with a colour token and a sign, which may be ""."""
        self.margin.show_text(text, sign, token)
        self._hide_least_important()

    def show_energy(self, text: str, tip: str = "", token: str = "ink2", remedy: bool = False) -> None:
        """Show a message about excess energy; "" removes it.

        If ``remedy`` is True, a link offers to switch the passivity controller on.
        """
        self.energy.show_text(text, "triangle" if token == "warn" else "circle", token)
        self.energy.setToolTip(tip)
        self.energy.link.setVisible(remedy)
        self.energy.setVisible(bool(text))
        self._hide_least_important()

    def show_record(self, text: str, sign: str = "", token: str = "ink2", written: bool = False) -> None:
        """Show the state of the recording, or the length of the stored samples.

        If ``written`` is True, a session was written, and a link offers to show the sessions.
        """
        self.record.show_text(text, sign, token)
        self.record.link.setVisible(written)
        self._hide_least_important()

    def resizeEvent(self, event) -> None:
        super().resizeEvent(event)
        self._hide_least_important()
        self._place_figures()

    def _place_figures(self) -> None:
        """Place the card with the loop's figures above the bar, in its natural size."""
        self.figures.resize(self.figures.sizeHint())
        self.figures.move(_MARGIN, self.y() - self.figures.height() - 4)
        self.figures.raise_()

    def _hide_least_important(self) -> None:
        """Hide the least important fields until the other fields fit."""
        fields = (
            self.loop,
            self.clamp,
            self.margin,
            self.record,
            *(() if self.energy.isHidden() else (self.energy,)),
        )
        needed = 2 * _MARGIN + sum(field.sizeHint().width() + _SPACING for field in fields)
        for field in (self.record, self.margin):
            field.setVisible(needed <= self.width())
            needed -= 0 if needed <= self.width() else field.sizeHint().width() + _SPACING
