"""The stability card: how far the rendered stiffness is from the limit, in words and on a small map."""

from dataclasses import replace
from typing import TYPE_CHECKING

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QVBoxLayout, QWidget

from hapkit_studio.analysis.stability.axes import nice_width
from hapkit_studio.analysis.stability.margin import hand_words, short, verdict
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.gui import icons
from hapkit_studio.gui.dress import dress
from hapkit_studio.gui.latency_hint import reason, remedy
from hapkit_studio.gui.loop_facts import LoopFacts
from hapkit_studio.gui.margin import Answer, MarginWorker, Question
from hapkit_studio.gui.rich import plain
from hapkit_studio.gui.stability_map import StabilityMap
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.theme import number, theme

if TYPE_CHECKING:
    from hapkit_studio.haptics.health import Health

ASK_MS = 100
_LEAST_WIDTH = 4.0
_WANDERS = 0.05
"""Share of the limit by which the measured delay alone may move it without turning the verdict round."""
_NEXT = "At the limit"
_WITHOUT = "Without the passivity controller, which is on: with it, only a run can tell."


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
    """Return the card's headline and the status bar's words; nobody need lower what the controller holds."""
    if answer.kept is not None:
        return _NEXT, _NEXT
    said = short(answer.margin)
    if answer.question.setting.controller and not answer.stable:
        return (f"{said}, passivity controller on",) * 2
    return verdict(answer.margin), said


def wanders(before: Answer, answer: Answer) -> bool:
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

    def __init__(self, studio: Studio, worker: MarginWorker | None = None, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self._worker = worker or MarginWorker(parent=self)
        self.facts = LoopFacts(studio, self)
        self._sign = ("check", "ok")
        self._judged: Answer | None = None
        self.heading = QLabel("Stability")
        self.heading.setProperty("role", "section")
        self.sign, self.headline, self.words = QLabel(), plain(QLabel()), plain(QLabel())
        self.headline.setWordWrap(True)
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
        studio.environment_changed.connect(self._tell_drives)
        self._tell_drives()
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
        if before is not None and wanders(before, answer):
            answer = replace(answer, kept=before.stable)
        else:
            self._judged = answer
        self.map.setVisible(True)
        self.map.show_answer(answer)
        self.words.setText(f"{conditions(answer)} {self._late_because(answer)}".rstrip())
        headline, words = headlines(answer)
        self._show(headline, *sign_of(answer))
        self.judged.emit(words, *sign_of(answer))
        self.crossed.emit(None if answer.stable else answer)

    def _late_because(self, answer: Answer) -> str:
        """Return why the measured delay is long, less what was added on purpose."""
        engine = self._studio.engine
        if engine is None:
            return ""
        self.words.setToolTip(remedy(engine.device))
        return reason(engine.device, answer.question.setting.delay - self._studio.loop.delay)

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

    def _tell_drives(self) -> None:
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
        ink = "danger" if token == "danger" else "ink"
        dress(self.headline, f"QLabel {{ color: @{ink}; font-size: 14px; font-weight: 650; }}")

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
