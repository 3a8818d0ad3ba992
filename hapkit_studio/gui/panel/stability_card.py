"""The stability card: how far the rendered stiffness is from the limit, in words and on a small map."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QPointF, QRectF, QSize, QSizeF, Qt, QTimer, Signal
from PySide6.QtGui import QBrush, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QHBoxLayout, QLabel, QVBoxLayout, QWidget

from hapkit_studio.analysis.stability.axes import height, nice_width
from hapkit_studio.analysis.stability.margin import hand_words, short, verdict
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.gui.background import LatestAnswer
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
_HEIGHT = 146
_LEFT, _TOP, _RIGHT, _BOTTOM = 56, 8, 10, 36
_DOT_ROOM = 13  # px: as far as the ring round a dot on the frame stands out
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


class StabilityMap(QWidget):
    """Paints one answer; the dot stays inside the frame and says so by an open ring where it is beyond."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self._answer: Answer | None = None
        self.setFixedHeight(_HEIGHT)
        self.setAccessibleName("Stability map, damping across, stiffness up")
        theme.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        return QSize(220, _HEIGHT)

    def show_answer(self, answer: Answer) -> None:
        """Show another answer."""
        self._answer = answer
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        if self._answer is None or len(self._answer.boundary) < 2:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(theme.font("tick"))
        frame = QRectF(_LEFT, _TOP, self.width() - _LEFT - _RIGHT, self.height() - _TOP - _BOTTOM)
        right = self._answer.question.width
        top = self._top()
        self._regions(painter, frame, right, top)
        self._axes(painter, frame, right, top)
        self._dot(painter, frame, right, top)

    def _top(self) -> float:
        """Return the stiffness at the upper edge: room above dot and limit, the whole curve if it is low."""
        assert self._answer is not None
        highest = max([k for _, k in self._answer.boundary if math.isfinite(k)], default=1.0)
        return height(self._answer.question.stiffness, self._answer.margin.limit, highest)

    def _regions(self, painter: QPainter, frame: QRectF, right: float, top: float) -> None:
        assert self._answer is not None
        beyond = 10.0 * top
        curve = [_at(frame, b / right, min(k, beyond) / top) for b, k in self._answer.boundary]
        painter.save()
        painter.setClipRect(frame)
        painter.fillRect(frame, theme.color("unstable"))
        painter.fillRect(frame, QBrush(theme.color("danger", 0.25), Qt.BrushStyle.BDiagPattern))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(theme.color("stable"))
        painter.drawPolygon(QPolygonF([*curve, frame.bottomRight(), frame.bottomLeft()]))
        painter.setPen(QPen(theme.color("ink"), 2))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawPolyline(QPolygonF(curve))
        painter.restore()
        dot = self._place(frame, right, top)
        painter.setFont(theme.font("label"))
        for word, token, above in (("grows", "danger", True), ("stable", "ok", False)):
            box = _room_for_name(frame, curve, dot, above)
            if box is not None:
                painter.setPen(theme.color(token))
                painter.drawText(box, Qt.AlignmentFlag.AlignCenter, word)

    def _axes(self, painter: QPainter, frame: QRectF, right: float, top: float) -> None:
        painter.setFont(theme.font("tick"))
        painter.setPen(theme.color("ink2"))
        for part in (0.0, 0.5, 1.0):
            place = _at(frame, part, part)
            x = min(place.x() - 30, self.width() - 60)
            bottom = QRectF(x, frame.bottom() + 5, 60, 16)
            flag = Qt.AlignmentFlag.AlignRight if part == 1.0 else Qt.AlignmentFlag.AlignHCenter
            painter.drawText(bottom, flag, f"{part * right:g}")
            left = QRectF(0, place.y() - 8, _LEFT - _DOT_ROOM, 16)
            painter.drawText(
                left, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter, f"{part * top:,g}"
            )
        painter.setPen(theme.color("ink3"))
        below = QRectF(frame.left(), frame.bottom() + 18, frame.width(), 18)
        painter.drawText(below, Qt.AlignmentFlag.AlignHCenter, "damping, N·s/m")

    def _place(self, frame: QRectF, right: float, top: float) -> QPointF:
        assert self._answer is not None
        question = self._answer.question
        return _at(frame, min(1.0, question.damping / right), min(1.0, question.stiffness / top))

    def _dot(self, painter: QPainter, frame: QRectF, right: float, top: float) -> None:
        assert self._answer is not None
        question, dot = self._answer.question, self._place(frame, right, top)
        edge = _at(frame, min(1.0, question.damping / right), min(top, self._answer.margin.limit) / top)
        token = "accent" if self._answer.stable else "danger"
        painter.setPen(QPen(theme.color(token), 1.6, Qt.PenStyle.DotLine))
        painter.drawLine(dot, edge)
        painter.setPen(QPen(theme.color("surface"), 2))
        painter.setBrush(theme.color("accent"))
        painter.drawEllipse(dot, 6, 6)
        if not self._answer.stable:
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(theme.color("danger"), 2))
            painter.drawEllipse(dot, 9, 9)


def _room_for_name(frame: QRectF, curve: list[QPointF], dot: QPointF, above: bool) -> QRectF | None:
    """Return where a region's name fits, clear of boundary and dot; None where the region is too small."""
    size = QSizeF(50, 18)
    y = frame.top() + 4 if above else frame.bottom() - size.height() - 4
    shares = (0.05, 0.3, 0.55, 0.95) if above else (0.95, 0.6, 0.3, 0.05)
    for share in shares:
        box = QRectF(QPointF(frame.left() + share * (frame.width() - size.width()), y), size)
        near = [p.y() for p in curve if box.left() - 12 <= p.x() <= box.right() + 12]
        clear = min(near) > box.bottom() if above else max(near) < box.top()
        if clear and not box.adjusted(-12, -12, 12, 12).contains(dot):
            return box
    return None


def _at(frame: QRectF, across: float, up: float) -> QPointF:
    return QPointF(frame.left() + across * frame.width(), frame.bottom() - up * frame.height())


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
    """Emits ``judged(words, icon, token)`` to the status bar, ``crossed(Answer or None)`` to the banner."""

    judged = Signal(str, str, str)
    crossed = Signal(object)

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
        self.crossed.emit(None)

    def show_answer(self, answer: Answer) -> None:
        """Show a verdict; one that only wanders about the limit has its own figures, but no other banner."""
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
        self.crossed.emit(None if answer.stable else answer)

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


def margin_notice(answer: Answer) -> tuple[str, str]:
    """Return title and line of the banner for an unstable answer."""
    question, limit = answer.question, answer.margin.limit
    rate, delay = number(question.setting.rate, 0), number(question.setting.delay * 1e3, 2)
    loop = f"At {rate} Hz and the measured delay of {delay} ms,"
    if answer.kept is not None:
        title = f"Stiffness {number(question.stiffness, 0)} N/m is at the limit of {number(limit, 0)} N/m."
        return title, f"{loop} contact without a hand hardly settles."
    if question.setting.controller:
        return _controlled_notice(answer, loop)
    if limit <= 0.0:
        return "Unstable at this damping.", f"{loop} no stiffness is stable. Lower damping."
    title = f"Stiffness {number(question.stiffness, 0)} N/m is above the limit of {number(limit, 0)} N/m."
    return title, f"{loop} contact without a hand grows instead of settling."


def _controlled_notice(answer: Answer, loop: str) -> tuple[str, str]:
    """Return the banner where the passivity controller is on: what is exact holds without it."""
    limit = answer.margin.limit
    held = "The passivity controller may hold contact all the same."
    if limit <= 0.0:
        return "Unstable at this damping without the controller.", f"{loop} no stiffness is stable. {held}"
    stiffness = number(answer.question.stiffness, 0)
    title = f"Stiffness {stiffness} N/m is above {number(limit, 0)} N/m, the limit without the controller."
    return title, f"{loop} contact would grow without it. {held}"
