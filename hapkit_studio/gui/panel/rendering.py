"""Where the force is computed, computer or board: the switch, and the figures of both, side by side."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.background import LatestAnswer
from hapkit_studio.gui.panel.limits import steady_delay
from hapkit_studio.gui.panel.rows import ChoiceRow
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.text import plain
from hapkit_studio.gui.widgets.theme import number
from hapkit_studio.parameters import Choice

if TYPE_CHECKING:
    from hapkit_studio.analysis.board_alternative import Alternative, Answer, RefusedRequest
    from hapkit_studio.analysis.setting import Setting
    from hapkit_studio.haptics.board_plan import PlanRequest
    from hapkit_studio.haptics.engine import Engine
    from hapkit_studio.haptics.health import Health
    from hapkit_studio.haptics.link import MeasuredDelay

RENDERERS = COMPUTER, BOARD = "computer", "board"
ROWS = "Delay, ms", "Rate, Hz", "Limit, N/m", "Missed", "Processor, %"
HINTS = (
    "From a sample to its force in the motor's register, as the board measured it: mean and standard "
    "deviation of the last seconds",
    "How often the force is computed anew",
    "Stiffness limit: the exact boundary for a released handle at this delay, rate and velocity estimator, "
    "with the scene's own damping",
    "Ticks missed. Computer: answers that came too late. Board: ticks it had no time for, by its own count",
    "Share of the board's processor that law, rest of the tick and telemetry take as a rule; up to 80",
)
_FIRST_ROWS = "Delay, ms", "Limit, N/m"
UNKNOWN = "–"
NAMES = "Computer", "Board"
TIP = (
    "Who computes the force. The computer: a sample goes up, a force comes down, with the delay of the USB "
    "line. The board: parameters go down once, its own processor runs the same law."
)
RATE = Choice(
    "board_rate", "Board's rate", ("fastest", "4000", "2000", "1000", "500"), "fastest",
    "How often the board computes the force. A law that takes long allows no more than its own fastest rate.",
    labels=("fastest", "4,000 Hz", "2,000 Hz", "1,000 Hz", "500 Hz"),
)  # fmt: skip


@dataclass(frozen=True)
class RendererFacts:
    """Delay, rate in Hz and processor share of computer or board, where known; what its limit depends on."""

    delay: "MeasuredDelay | None"
    rate: float | None
    missed: int
    setting: "Setting | None"
    share: float | None = None


@dataclass(frozen=True)
class LimitsQuestion:
    """A question: the settings of both, None where nothing is known, and the scene's damping in N·s/m."""

    settings: tuple["Setting | None", "Setting | None"]
    damping: float


@dataclass(frozen=True)
class LimitsAnswer:
    """The answer: the exact stiffness limit in N/m of each renderer, None where there is none."""

    question: LimitsQuestion
    limits: tuple[float | None, float | None]


def solve(question: LimitsQuestion) -> LimitsAnswer:
    """Compute both limits."""
    from hapkit_studio.analysis.stability import kb_plane  # late: keeps start-up fast

    limits = [None if s is None else kb_plane.limit(s, question.damping) for s in question.settings]
    return LimitsAnswer(question, (limits[0], limits[1]))


def renderers(studio: "Studio") -> tuple[RendererFacts, RendererFacts]:
    """Return both renderers of the device and loop in force."""
    from hapkit_studio.analysis.setting import Setting
    from hapkit_studio.haptics import board_plan

    engine = studio.engine
    assert engine is not None
    device = engine.device
    setting = Setting(device.mass, device.viscous, quantum=device.quantum)
    offered = engine.possible_plan
    rates = engine.loop.rate, None if offered is None else float(offered.rate)
    shares = None, None if offered is None else offered.share
    specs = studio.loop.spec, board_plan.spec_on_board(studio.loop.spec)
    found = []
    for where, rate, spec, share in zip(RENDERERS, rates, specs, shares, strict=True):
        delay, own = _steady(engine, where), None
        if delay is not None and rate is not None:
            own = _limit_setting(setting, rate, delay.mean, spec)
        found.append(RendererFacts(delay, rate, engine.missed_of(where), own, share))
    return found[0], found[1]


def plan_request(studio: "Studio") -> "PlanRequest":
    """Return what the board is asked for, in the words of its offer."""
    from hapkit_studio.haptics import board_plan

    engine = studio.engine
    assert engine is not None
    quantum, rate = engine.device.quantum, studio.loop.board_rate
    return board_plan.PlanRequest(
        engine.environment, dict(engine.values), engine.loop.estimator, quantum, rate
    )


def _steady(engine: "Engine", where: str) -> "MeasuredDelay | None":
    """Return the delay of one renderer as everything in the window shows it and takes it."""
    found, steady = engine.delay_of(where), steady_delay(engine, where)
    return None if found is None or steady is None else found._replace(mean=steady)


def _limit_setting(setting: "Setting", rate: float, delay: float, spec: Any) -> "Setting | None":
    """Return what the limit of one renderer depends on; None where there is no exact one."""
    own = replace(setting, rate=rate, delay=delay, estimator=spec, controller=False)
    return own if own.linear else None


def fact_texts(renderer: RendererFacts, limit: float | None) -> tuple[str, ...]:
    """Return what stands in a way's column, in the order of ROWS."""
    delay = UNKNOWN
    if renderer.delay is not None:
        delay = f"{number(1e3 * renderer.delay.mean, 2)} ± {number(1e3 * renderer.delay.spread, 2)}"
    stiffness = UNKNOWN if limit is None or renderer.setting is None else number(limit, 0)
    rate = UNKNOWN if renderer.rate is None else f"{renderer.rate:,.0f}"
    share = UNKNOWN if renderer.share is None else number(100.0 * renderer.share, 0)
    return delay, rate, stiffness, f"{renderer.missed:,d}", share


class Facts(QWidget):
    """A row for each fact, a column each for computer and board; the one in force in the accent colour."""

    def __init__(self) -> None:
        super().__init__()
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 2, 0, 2)
        grid.setHorizontalSpacing(12)
        grid.setVerticalSpacing(2)
        grid.setColumnStretch(0, 1)
        self.heads = [QLabel(name) for name in NAMES]
        self.values = [[QLabel(UNKNOWN) for _ in ROWS] for _ in NAMES]
        for column, (head, values) in enumerate(zip(self.heads, self.values, strict=True), start=1):
            for row, label in enumerate((head, *values)):
                label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
                label.setProperty("role", "fact")
                grid.addWidget(label, row, column)
        self._details: list[QLabel] = []
        for row, (name, hint) in enumerate(zip(ROWS, HINTS, strict=True), start=1):
            label = QLabel(name)
            label.setToolTip(hint)
            label.setProperty("role", "fact")
            grid.addWidget(label, row, 0)
            if name not in _FIRST_ROWS:
                self._details += [label, *(values[row - 1] for values in self.values)]

    def set_folded(self, folded: bool) -> None:
        """Leave out all but the first facts, or show all."""
        for label in self._details:
            label.setHidden(folded)

    def show_renderer(self, column: int, texts: tuple[str, ...], on: bool) -> None:
        """Show one renderer's texts in the order of ROWS; on: it renders now."""
        for label, text in zip(self.values[column], texts, strict=True):
            label.setText(text)
        for label in (self.heads[column], *self.values[column]):
            mark(label, "on", on)


def _find(question: "RefusedRequest") -> "Answer":
    from hapkit_studio.analysis import board_alternative  # late: keeps start-up fast

    return board_alternative.find(question)


class RenderingSwitch(QWidget):
    """Shown for devices with a board. ``compare``: a person wants both renderers, one after the other."""

    compare = Signal()

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self._worker = LatestAnswer(solve, self)
        self._worker.answered.connect(self._take)
        self._found: LimitsAnswer | None = None
        self._finder = LatestAnswer(_find, self)
        self._finder.answered.connect(self._take_cheaper)
        self._cheaper: Alternative | None = None
        self.label = QLabel("Rendered by")
        self.label.setToolTip(TIP)
        self.switch = Segmented("Rendered by", NAMES)
        self.switch.setToolTip(TIP)
        self.switch.chosen.connect(self._choose)
        self.facts, self.note = Facts(), plain(QLabel())
        self.rate = ChoiceRow(RATE)
        self.rate.changed.connect(lambda _key, index: self._set(board_rate=_rate(int(index))))
        self.button = QPushButton("Compare both")
        self.button.clicked.connect(self.compare)
        self.instead = QPushButton()
        self.instead.clicked.connect(self._use_cheaper)
        self.note.setProperty("role", "hint")
        self.note.setWordWrap(True)
        self._message = self._refusal = ""
        self._folded = False
        self._renderers: tuple[RendererFacts, RendererFacts] | None = None
        self._arrange()
        for signal in (studio.engine_changed, studio.loop_changed, studio.environment_changed):
            signal.connect(self.show_state)
        studio.values_changed.connect(self._refresh_facts)
        for signal in (studio.engine_changed, studio.environment_changed, studio.values_changed):
            signal.connect(self._clear_message)
        self.show_state()

    # what is shown

    def set_folded(self, folded: bool) -> None:
        """Say it in one line, or in all."""
        self._folded = folded
        self.facts.set_folded(folded)
        self.show_state()

    def note_health(self, _health: "Health") -> None:
        """Take over what was measured lately."""
        self._refresh_facts()
        engine = self._studio.engine
        if engine is not None and not self.isHidden():
            self._look_for_cheaper(engine)

    def set_busy(self, words: str) -> None:
        """Say what goes on while both renderers are compared; nothing ends it."""
        self.switch.setEnabled(not words)
        self.button.setText("Cancel" if words else "Compare both")
        self.show_message(words)

    def show_message(self, words: str) -> None:
        """Say what became of a comparison, until something else is chosen."""
        self._message = words
        self.show_state()

    def show_state(self) -> None:
        """Show who renders, and why the board cannot where it cannot; until that is known, as it was."""
        engine = self._studio.engine
        board = engine is not None and not engine.device.simulated
        self.setVisible(board)
        if engine is None or not board:
            self._refusal, self._cheaper, self._renderers = "", None, None
            return
        if self._studio.board_answered and engine.board_refusal() != self._refusal:
            self._refusal, self._cheaper = engine.board_refusal(), None
        refusal, cheaper = self._refusal, self._cheaper
        self.switch.show_index(0 if refusal else RENDERERS.index(engine.where))
        self.switch.button(1).setEnabled(not refusal)
        self.rate.show_value(_place(self._studio.loop.board_rate))
        instead = f"{refusal} {cheaper.words}" if cheaper is not None else refusal
        self.note.setText(instead or self._message or self._remark(engine))
        self.instead.setVisible(cheaper is not None)
        self.instead.setText(f"Use {cheaper.choice.word(cheaper.option)}" if cheaper is not None else "")
        able, compare = not refusal, self._studio.hand_is_ours
        self.facts.setVisible(able)
        self.rate.setVisible(able and not self._folded)
        self.button.setVisible(able and compare)
        self.note.setVisible(bool(self.note.text()))
        self._refresh_facts()
        self._look_for_cheaper(engine)

    def _remark(self, engine) -> str:
        """Return what of the loop the board does not do, and what it takes where no table says so."""
        from hapkit_studio.haptics import board_plan

        loop, parts = self._studio.loop, []
        if engine.where != BOARD:
            return ""
        if self._folded and engine.possible_plan is not None:
            parts.append(f"{100.0 * engine.possible_plan.share:.0f} % of the board's processor.")
        if board_plan.spec_on_board(loop.spec) != loop.spec:
            parts.append("The board has no such velocity filter and uses Kalman.")
        if loop.delay > 0.0:
            parts.append("The added delay applies on the computer only.")
        if loop.controller:
            parts.append("The passivity controller works on the computer only.")
        return " ".join(parts)

    def _refresh_facts(self) -> None:
        engine = self._studio.engine
        if engine is None or self.isHidden() or not engine.renders_on_boards:
            return
        if self._renderers is not None and not self._studio.board_answered:
            return
        self._renderers = renderers(self._studio)
        impedance = self._studio.environment.impedance
        if impedance is not None:
            damping = impedance(self._studio.values)[1]
            settings = tuple(renderer.setting for renderer in self._renderers)
            self._worker.ask(LimitsQuestion((settings[0], settings[1]), damping))
        else:
            self._found = None
        self._write()

    def _take(self, found: LimitsAnswer) -> None:
        self._found = found
        self._write()

    def _write(self) -> None:
        engine = self._studio.engine
        if engine is None or self._renderers is None:
            return
        limits = self._found.limits if self._found is not None else (None, None)
        for column, (renderer, limit, where) in enumerate(
            zip(self._renderers, limits, RENDERERS, strict=True)
        ):
            self.facts.show_renderer(column, fact_texts(renderer, limit), where == engine.where)

    def _look_for_cheaper(self, engine: "Engine") -> None:
        """Have something looked for that the board can render, where this law is too much for it."""
        offer = engine.driver.planner if engine.driver is not None else None
        if not self._refusal or offer is None:
            self._finder.forget()
        elif self._studio.board_answered and isinstance(offer.known(plan_request(self._studio)), str):
            from hapkit_studio.analysis.board_alternative import RefusedRequest

            self._finder.ask(RefusedRequest(offer, plan_request(self._studio)))

    def _take_cheaper(self, answer: "Answer") -> None:
        self._cheaper = answer.found
        self.show_state()

    def _clear_message(self) -> None:
        if self._message and self.switch.isEnabled():
            self.show_message("")

    def close_worker(self) -> None:
        """End the workers' threads."""
        self._worker.close()
        self._finder.close()

    # what a person does

    def _choose(self, index: int) -> None:
        self._message = ""
        self._set(where=RENDERERS[index])

    def _use_cheaper(self) -> None:
        if self._cheaper is not None:
            self._studio.set_value(self._cheaper.choice.key, float(self._cheaper.option))

    def _set(self, **change: object) -> None:
        try:
            self._studio.set_loop(**change)
        except ParameterError as error:
            self.show_state()
            self.note.setText(str(error))
            self.note.show()

    def _arrange(self) -> None:
        head = QHBoxLayout()
        head.addWidget(self.label, 1)
        head.addWidget(self.switch)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 4, 0, 4)
        column.setSpacing(4)
        column.addLayout(head)
        for part in (self.facts, self.rate, self.button, self.note, self.instead):
            column.addWidget(part)


def _rate(index: int) -> float | None:
    return float(RATE.options[index]) if index else None


def _place(rate: float | None) -> int:
    return 0 if rate is None else RATE.options.index(f"{rate:.0f}")
