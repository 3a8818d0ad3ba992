"""The stability card: how far the rendered stiffness is from the limit, in words and on a small map."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from PySide6.QtCore import QRectF, Qt, QTimer, Signal
from PySide6.QtGui import QBrush, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from hapkit_studio.analysis.stability.margin import hand_words, height, nice_width, short, verdict
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.gui.background import LatestAnswer
from hapkit_studio.gui.live import strokes
from hapkit_studio.gui.live.canvas import Canvas
from hapkit_studio.gui.panel.limits import Answer, LoopFacts, Question, answer
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.widgets.parts import AnswerLine, down, hint, label
from hapkit_studio.gui.widgets.style import mark
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


class StabilityMap(Canvas):
    """Paints one answer; the dot stays inside the frame. Beyond the boundary it is hatched as well."""

    paper, below = "side", 36

    def __init__(self) -> None:
        self._answer: Answer | None = None
        super().__init__(bottom=True, left_width=_LEFT)
        self.bottom.setLabel("N·s/m across, N/m upwards")
        self.setAccessibleName("Stability map, damping across, stiffness up")

    def recolor(self) -> None:
        """Take the theme's colours and fonts."""
        super().recolor()
        self.setFixedHeight(theme.px(_HEIGHT))
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


class Verdict(NamedTuple):
    """What card and status bar say: headline and words of the card, icon and token of both, the bar's words.

    Everything that is said of an answer is put together in ``judge``.
    """

    headline: str
    words: str
    sign: tuple[str, str]
    short: str


def judge(answer: Answer) -> Verdict:
    """Return the verdict on an answer, with hand, delay and limit below it.

    What a passivity controller may hold all the same is no more than a warning, without advice to lower it.
    """
    delay, limit = number(answer.question.setting.delay * 1e3, 2), answer.margin.limit
    controlled = answer.question.setting.controller
    words = f"{hand_words(answer.margin.hand).capitalize()}, {delay} ms from sensor to motor."
    words = words if limit <= 0.0 else f"{words} Stiffness limit {number(limit, 0)} N/m."
    words = f"{words} {_WITHOUT}" if controlled else words
    said = short(answer.margin)
    if answer.kept is not None:
        return Verdict(_NEXT, words, ("triangle", "warn"), _NEXT)
    if answer.stable:
        return Verdict(verdict(answer.margin), words, ("check", "ok"), said)
    if controlled:
        said = f"{said}, passivity controller on"
        return Verdict(said, words, ("triangle", "warn"), said)
    return Verdict(verdict(answer.margin), words, ("cross", "danger"), said)


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

    def __init__(self, studio: Studio):
        super().__init__()
        self._studio = studio
        self._worker = LatestAnswer(answer, self)
        self.facts = LoopFacts(studio, self)
        self._judged: Answer | None = None
        self.verdict, self.words, self.drives, self.map = AnswerLine(), hint(), hint(), StabilityMap()
        down(label("Stability", "section"), self.verdict, self.words, self.drives, self.map, into=self, gap=4)
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
        studio.environment_changed.connect(self._show_drives)
        self._show_drives()
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
        self._say(headline, "circle", "ink2")
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
        said = judge(answer)
        self.words.setText(f"{said.words} {self._why_late(answer)}".rstrip())
        self._say(said.headline, *said.sign)
        self.judged.emit(said.short, *said.sign)

    def wait(self) -> None:
        """Wait for the worker, for tests; the answer comes with the next events."""
        self._soon.stop()
        self._worker.wait()

    def close_worker(self) -> None:
        """End the worker's thread."""
        self._worker.close()

    def _why_late(self, answer: Answer) -> str:
        """Return why the measured delay is long, less what was added on purpose."""
        engine = self._studio.engine
        if engine is None:
            return ""
        self.words.setToolTip(engine.device.latency.words if latency_timer(engine.device) else "")
        return delay_reason(engine.device, answer.question.setting.delay - self._studio.loop.delay)

    def _why_not(self) -> tuple[str, str]:
        """Return headline and words where nothing can be asked."""
        if self._studio.engine is not None and self._studio.environment.impedance is None:
            return "No limit applies", "This environment renders no stiffness or damping of its own."
        if self._studio.engine is not None and not self.facts.linear:
            name = ESTIMATORS[self._studio.loop.estimator].label
            return "No exact limit", f"{name} is not linear: only a run can tell."
        return self.facts.why_unknown()

    def _show_drives(self) -> None:
        words = self._studio.environment.drives
        self.drives.setText(words)
        self.drives.setVisible(bool(words))

    def _ask_soon(self) -> None:
        if not self._soon.isActive():
            self._soon.start()

    def _say(self, words: str, sign: str, token: str) -> None:
        self.verdict.say(words, sign, token)
        mark(self.verdict.words, "ink", "danger" if token == "danger" else "ink")
