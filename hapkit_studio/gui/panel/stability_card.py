"""The stability card: how far the rendered stiffness is from the limit, in words and on a small map."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QRectF, Qt, QTimer, Signal
from PySide6.QtGui import QBrush, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QHBoxLayout, QLabel, QVBoxLayout, QWidget

from hapkit_studio.analysis.stability.margin import hand_words, height, nice_width, short, verdict
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.gui.background import LatestAnswer
from hapkit_studio.gui.live import strokes
from hapkit_studio.gui.live.canvas import Canvas
from hapkit_studio.gui.panel.limits import Answer, LoopFacts, Question, answer
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.text import plain
from hapkit_studio.gui.widgets.theme import number, theme

if TYPE_CHECKING:
    from hapkit_studio.haptics.health import Health

LONG = 2e-3
"""s from which on a delay is worth a word: two periods, on a good line it is half of one."""
_BOARD = "render on the board"
_FRAMES = "fill its frames (Device, USB frames)"
_HEIGHT, _LEFT = 146, 50.0
ASK_MS = 100
_LEAST_WIDTH = 4.0
_WANDERS = 0.05
"""Share of the limit by which the measured delay alone may move it without turning the verdict round."""
_NEXT = "At the limit"
_WITHOUT = "Without the passivity controller, which is on: with it, only a run can tell."


def delay_reason(device: Any, delay: float) -> str:
    """Return the likeliest reason and what helps; nothing where the delay in s is short."""
    if device.simulated or delay <= LONG:
        return ""
    if getattr(device, "hand", False):  # a virtual board has no USB chip, and frames filled do not help
        return f"The virtual board shares this computer's processors: {_BOARD}."
    what = _BOARD if getattr(device, "padding", 0) else f"{_FRAMES}, or {_BOARD}"
    timer = latency_timer(device)
    holds = f"The USB chip holds frames back, up to {timer} ms" if timer else "The line holds frames back"
    return f"{holds}: {what}."


def latency_timer(device: Any) -> str:
    """Return the USB chip's latency timer in ms, nothing where it is short or not known."""
    latency = getattr(device, "latency", None)
    return f"{1e3 * latency.timer:.0f}" if latency is not None and latency.long else ""


def delay_remedy(device: Any) -> str:
    """Return what shortens the timer itself, for a tooltip."""
    return device.latency.words if latency_timer(device) else ""


class StabilityMap(Canvas):
    """Paints one answer; the dot stays inside the frame. Beyond the boundary it is hatched as well."""

    paper = "side"

    def __init__(self) -> None:
        self._answer: Answer | None = None
        super().__init__(bottom=True, left_width=_LEFT)
        self.bottom.setHeight(36)
        self.bottom.setLabel("N·s/m across, N/m upwards")
        self.setFixedHeight(_HEIGHT)
        self.setAccessibleName("Stability map, damping across, stiffness up")

    def recolor(self) -> None:
        """Take the theme's colours and fonts."""
        super().recolor()
        self.bottom.label.setFont(theme.font("tick"))
        self.bottom.label.setDefaultTextColor(theme.color("ink3"))

    def show_answer(self, answer: Answer) -> None:
        """Show another answer: with room above dot and limit, the whole boundary if it is low."""
        self._answer = answer
        highest = max([k for _, k in answer.boundary if math.isfinite(k)], default=1.0)
        top = height(answer.question.stiffness, answer.margin.limit, highest)
        self.view.setRange(xRange=(0.0, answer.question.width), yRange=(0.0, top), padding=0)
        self.viewport().update()

    def paint_under(self, painter: QPainter, box: QRectF) -> None:
        """Paint the regions beyond and below the boundary."""
        if self._answer is None or len(self._answer.boundary) < 2:
            return
        curve = [self.pixel(b, min(k, 1e7)) for b, k in self._answer.boundary]
        painter.fillRect(box, theme.color("unstable"))
        painter.fillRect(box, QBrush(theme.color("danger", 0.25), Qt.BrushStyle.BDiagPattern))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(theme.color("stable"))
        painter.drawPolygon(QPolygonF([*curve, box.bottomRight(), box.bottomLeft()]))
        painter.setPen(QPen(theme.color("ink"), 2))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.drawPolyline(QPolygonF(curve))

    def paint_marks(self, painter: QPainter, box: QRectF) -> None:
        """Paint the dot and the dotted way to the boundary."""
        if self._answer is None:
            return
        question, (_, top) = self._answer.question, self.view.viewRange()[1]
        across = min(question.damping, question.width)
        dot, edge = (self.pixel(across, min(k, top)) for k in (question.stiffness, self._answer.margin.limit))
        token = "accent" if self._answer.stable else "danger"
        painter.setPen(QPen(theme.color(token), 1.6, Qt.PenStyle.DotLine))
        painter.drawLine(dot, edge)
        strokes.mark(painter, dot, "accent", 6.0)
        if not self._answer.stable:
            painter.setPen(QPen(theme.color("danger"), 2))
            painter.drawEllipse(dot, 9, 9)


def conditions(answer: Answer) -> str:
    """Return hand, delay and limit in words."""
    delay, limit = number(answer.question.setting.delay * 1e3, 2), answer.margin.limit
    words = f"{hand_words(answer.margin.hand).capitalize()}, {delay} ms from sensor to motor."
    words = words if limit <= 0.0 else f"{words} Stiffness limit {number(limit, 0)} N/m."
    return f"{words} {_WITHOUT}" if answer.question.setting.controller else words


def sign_of(answer: Answer) -> tuple[str, str]:
    """Return icon and token: what a controller may hold all the same is no more than a warning."""
    if answer.kept is not None:
        return "triangle", "warn"
    if answer.stable:
        return "check", "ok"
    return ("triangle", "warn") if answer.question.setting.controller else ("cross", "danger")


def headlines(answer: Answer) -> tuple[str, str]:
    """Return the card's headline and the status bar's words; no advice to lower what the controller holds."""
    if answer.kept is not None:
        return _NEXT, _NEXT
    said = short(answer.margin)
    if answer.question.setting.controller and not answer.stable:
        return (f"{said}, passivity controller on",) * 2
    return verdict(answer.margin), said


def differs_by_noise_only(before: Answer, answer: Answer) -> bool:
    """Tell whether two verdicts differ only because the measured delay is never quite the same."""
    if before.stable == answer.stable:
        return False
    q = answer.question
    same = replace(q, setting=replace(q.setting, delay=before.question.setting.delay)) == before.question
    moved = abs(answer.margin.limit - before.margin.limit)
    return same and moved < _WANDERS * max(answer.margin.limit, before.margin.limit)


class StabilityCard(QWidget):
    """Emits ``judged(words, icon, token)`` to the status bar."""

    judged = Signal(str, str, str)

    def __init__(self, studio: Studio, worker: LatestAnswer | None = None, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self._worker = worker or LatestAnswer(answer, self)
        self.facts = LoopFacts(studio, self)
        self._sign = ("check", "ok")
        self._judged: Answer | None = None
        self.heading = QLabel("Stability")
        self.heading.setProperty("role", "section")
        self.sign, self.headline, self.words = QLabel(), plain(QLabel()), plain(QLabel())
        self.headline.setWordWrap(True)
        self.headline.setProperty("role", "headline")
        self.words.setWordWrap(True)
        self.words.setProperty("role", "hint")
        self.drives = plain(QLabel())
        self.drives.setWordWrap(True)
        self.drives.setProperty("role", "hint")
        self.map = StabilityMap()
        self._arrange()
        self._soon = QTimer(self, singleShot=True, interval=ASK_MS)
        self._soon.timeout.connect(self.ask)
        self._worker.answered.connect(self.show_answer)
        for signal in (
            studio.values_changed,
            studio.environment_changed,
            studio.engine_changed,
            studio.stop_changed,
            studio.link_changed,
            self.facts.changed,
        ):
            signal.connect(self._ask_soon)
        theme.changed.connect(self._look)
        studio.environment_changed.connect(self._show_drives)
        self._show_drives()
        self._look()
        self.ask()

    def note_health(self, health: "Health") -> None:
        """Take over the delay as measured."""
        self.facts.note_health(health)
        if self._judged is None:
            self._ask_soon()  # why there is no verdict may have changed: a fault came or was cleared

    def question(self) -> Question | None:
        """Return what to ask about the environment and loop in force; None where no limit applies."""
        setting, impedance = self.facts.setting(), self._studio.environment.impedance
        if setting is None or impedance is None or not self.facts.linear:
            return None
        stiffness, damping = impedance(self._studio.values)
        return Question(setting, stiffness, damping, nice_width(damping, least=_LEAST_WIDTH))

    def ask(self) -> None:
        """Ask the worker; say so at once where there is nothing to ask."""
        question = self.question()
        if question is not None:
            self._worker.ask(question)
            return
        self._worker.forget()
        self._judged = None
        self.map.hide()
        headline, words = self._why_not()
        self.words.setText(words)
        self._show(headline, "circle", "ink2")
        self.judged.emit(headline, "", "ink2")

    def show_answer(self, answer: Answer) -> None:
        """Show a verdict; one that only wanders about the limit takes neither side."""
        before = self._judged
        if before is not None and differs_by_noise_only(before, answer):
            answer = replace(answer, kept=before.stable)
        else:
            self._judged = answer
        self.map.setVisible(True)
        self.map.show_answer(answer)
        self.words.setText(f"{conditions(answer)} {self._why_late(answer)}".rstrip())
        headline, words = headlines(answer)
        self._show(headline, *sign_of(answer))
        self.judged.emit(words, *sign_of(answer))

    def _why_late(self, answer: Answer) -> str:
        """Return why the measured delay is long, less what was added on purpose."""
        engine = self._studio.engine
        if engine is None:
            return ""
        self.words.setToolTip(delay_remedy(engine.device))
        return delay_reason(engine.device, answer.question.setting.delay - self._studio.loop.delay)

    def wait(self) -> None:
        """Wait for the worker, for tests; the answer comes with the next events."""
        self._soon.stop()
        self._worker.wait()

    def close_worker(self) -> None:
        """End the worker's thread."""
        self._worker.close()

    def _why_not(self) -> tuple[str, str]:
        if self._studio.engine is None:
            link = self._studio.link
            return (
                "Not judged yet",
                f"{link.text}." if link.state == "idle" and link.text else "Needs a device.",
            )
        if self._studio.environment.impedance is None:
            return "No limit applies", "This environment renders no stiffness or damping of its own."
        if not self.facts.linear:
            name = ESTIMATORS[self._studio.loop.estimator].label
            return "No exact limit", f"{name} is not linear: only a run can tell."
        if self._studio.stopped or self._studio.engine.fault is not None:
            return "Not measured while stopped", "The motor must be on for the delay to be measured."
        if self._studio.engine.where == "board":
            return "Measuring the delay", "The board has not rendered yet."
        return "Measuring the delay", "Half a second at zero force, on connecting."

    def _show_drives(self) -> None:
        words = self._studio.environment.drives
        self.drives.setText(words)
        self.drives.setVisible(bool(words))

    def _ask_soon(self) -> None:
        if not self._soon.isActive():
            self._soon.start()

    def _show(self, words: str, sign: str, token: str) -> None:
        self.headline.setText(words)
        self._sign = (sign, token)
        self._look()

    def _look(self) -> None:
        name, token = self._sign
        self.sign.setPixmap(icons.pixmap(name, 18, token, self.devicePixelRatioF()))
        mark(self.headline, "ink", "danger" if token == "danger" else "ink")

    def _arrange(self) -> None:
        row = QHBoxLayout()
        row.setSpacing(6)
        row.addWidget(self.sign)
        row.addWidget(self.headline, 1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.heading)
        column.addLayout(row)
        column.addWidget(self.words)
        column.addWidget(self.drives)
        column.addWidget(self.map)
