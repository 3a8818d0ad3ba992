"""The switch that selects computer or board to compute the force, and a table that compares the two."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QGridLayout, QLabel, QPushButton, QWidget

from hapkit_studio.dynamics.loop_settings import BOARD, BOARD_RATE, RENDERERS, LoopSettings
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.panel.limits import steady_delay
from hapkit_studio.gui.panel.rows import ChoiceRow
from hapkit_studio.gui.state.background import LatestResult
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.parts import hbox, hint, label, vbox
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.theme import number

if TYPE_CHECKING:
    from hapkit_studio.analysis.board_alternative import Alternative, AlternativeResult, RefusedRequest
    from hapkit_studio.devices.delays import MeasuredDelay
    from hapkit_studio.haptics.engine import Engine
    from hapkit_studio.haptics.health import Health

ROWS = {
    "Delay, ms": "Delay from a sample of the sensor to its force at the motor, measured by the board: mean ± "
    "standard deviation over the last seconds",
    "Rate, Hz": "How many times per second the force is computed",
    "Stiffness limit, N/m": "The greatest stiffness at which a released handle is stable, at this delay, "
    "rate and velocity filter, with the damping of the scene",
    "Forces too late": "How many forces were not ready in time. From the computer: they arrived too late. "
    "On the board: the processor had no time to compute them",
    "Processor load, %": "How busy the board's processor usually is. At most 80 % is allowed",
}
"""The table's rows with their tooltips."""
_FIRST_ROWS = "Delay, ms", "Stiffness limit, N/m"
UNKNOWN = "–"
NAMES = "Computer", "Board"
TIP = (
    "Computer or board: who computes the force? Computer: each sample travels over USB to the computer "
    "and the force travels back, which takes time. Board: it receives the parameters once and computes "
    "the force itself."
)


@dataclass(frozen=True)
class RendererFacts:
    """Facts about computer or board as a renderer; a fact is None while it is unknown.

    ``rate`` is in Hz, ``share`` is the processor load, ``setting`` is for computing the stiffness limit.
    """

    delay: "MeasuredDelay | None"
    rate: float | None
    missed: int
    setting: "LoopSettings | None"
    share: float | None

    def texts(self, limit: float | None) -> tuple[str, ...]:
        """Return the texts of the renderer's column in the order of ROWS; ``limit`` is in N/m."""
        delay, share = self.delay, self.share
        return (
            f"{number(1e3 * delay.mean, 2)} ± {number(1e3 * delay.spread, 2)}" if delay else UNKNOWN,
            UNKNOWN if self.rate is None else number(self.rate, 0),
            UNKNOWN if limit is None or self.setting is None else number(limit, 0),
            number(self.missed, 0),
            UNKNOWN if share is None else number(100.0 * share, 0),
        )


def solve(question: tuple[list["LoopSettings | None"], float]) -> list[float | None]:
    """Return each setting's exact stiffness limit in N/m at a damping in N·s/m; None for no setting."""
    from hapkit_studio.analysis.stability import kb_plane  # imported late to keep start-up fast

    settings, damping = question
    return [None if s is None else kb_plane.limit(s, damping) for s in settings]


def renderers(studio: "Studio") -> list[RendererFacts]:
    """Return the facts of computer and board for the current device and loop."""
    engine = studio.engine
    assert engine is not None
    plan, found = engine.decision().plan, []
    for where in RENDERERS:
        delay, steady = engine.delay_of(where), steady_delay(engine, where)
        if delay is not None and steady is not None:
            delay = delay._replace(mean=steady)  # use the same delay as the rest of the window
        loop = engine.loop_of(where, steady or 0.0)
        setting = loop if delay is not None and loop is not None and loop.linear else None
        rate, share = loop.rate if loop is not None else None, None
        if where == BOARD and plan is not None:
            share = plan.share
        found.append(RendererFacts(delay, rate, engine.missed_of(where), setting, share))
    return found


class Facts(QWidget):
    """Shows one row per fact, with a column for the computer and one for the board.

    The column of the active renderer is coloured.
    """

    def __init__(self) -> None:
        super().__init__()
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 2, 0, 2)
        grid.setHorizontalSpacing(10)
        grid.setVerticalSpacing(2)
        grid.setColumnStretch(0, 1)
        self.columns = [[label(text, "fact", wrap=False) for text in (name, *ROWS)] for name in NAMES]
        for column, labels in enumerate(self.columns, start=1):
            for row, part in enumerate(labels):
                part.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
                grid.addWidget(part, row, column)
        self._details: list[QLabel] = []
        for row, (name, meaning) in enumerate(ROWS.items(), start=1):
            head = label(name, "fact", wrap=False)
            head.setToolTip(meaning)
            grid.addWidget(head, row, 0)
            if name not in _FIRST_ROWS:
                self._details += [head, *(labels[row] for labels in self.columns)]

    def set_folded(self, folded: bool) -> None:
        """Show only the first facts, or all facts."""
        for part in self._details:
            part.setHidden(folded)

    def show_renderer(self, column: int, texts: tuple[str, ...], on: bool) -> None:
        """Show one renderer's texts in the order of ROWS; ``on`` is True for the active renderer."""
        labels = self.columns[column]
        for part, text in zip(labels[1:], texts, strict=True):
            part.setText(text)
        for part in labels:
            mark(part, "on", on)


def _find(question: "RefusedRequest") -> "AlternativeResult":
    from hapkit_studio.analysis import board_alternative  # imported late to keep start-up fast

    return board_alternative.find(question)


class RenderingSwitch(QWidget):
    """Switches between computer and board; ``compare`` is emitted when the user wants to compare both."""

    compare = Signal()

    def __init__(self, studio: Studio):
        super().__init__()
        self._studio = studio
        self._worker, self._finder = LatestResult(solve, self), LatestResult(_find, self)
        self._worker.answered.connect(self._show_limits)
        self._finder.answered.connect(self._show_cheaper)
        self._renderers: list[RendererFacts] | None = None
        self._limits: list[float | None] = [None, None]
        self._cheaper: dict[str, Alternative] = {}
        """Alternatives that the board can render, by the refusal for which they were found."""
        self._message = ""
        self._folded = False
        name = label("Rendered by", wrap=False)
        self.switch = Segmented("Rendered by", NAMES)
        for widget in (name, self.switch):
            widget.setToolTip(TIP)
        self.facts, self.rate, self.note = Facts(), ChoiceRow(BOARD_RATE), hint()
        self.button, self.instead = QPushButton("Compare computer and board"), QPushButton()
        head = hbox((name, 1), self.switch, gap=6)
        parts = (head, self.facts, self.rate, self.button, self.note, self.instead)
        vbox(*parts, into=self, margins=(0, 4, 0, 4), gap=4)
        self.switch.chosen.connect(self._choose)
        self.rate.changed.connect(self._choose_rate)
        self.button.clicked.connect(self.compare)
        self.instead.clicked.connect(self._use_cheaper)
        for signal in (studio.engine_changed, studio.loop_changed, studio.environment_changed):
            signal.connect(self.show_state)
        studio.values_changed.connect(self._refresh_facts)
        for signal in (studio.engine_changed, studio.environment_changed, studio.values_changed):
            signal.connect(self._clear_message)
        self.show_state()

    # methods that show the state

    def set_folded(self, folded: bool) -> None:
        """Show the short or the full form."""
        self._folded = folded
        self.facts.set_folded(folded)
        self.show_state()

    def note_health(self, _health: "Health") -> None:
        """Update the measured facts."""
        self._refresh_facts()
        engine = self._studio.engine
        if engine is not None and not self.isHidden():
            self._look_for_cheaper(engine)

    def set_busy(self, text: str) -> None:
        """Show the progress of a comparison; "" means that it has ended."""
        self.switch.setEnabled(not text)
        self.button.setText("Cancel" if text else "Compare computer and board")
        self.show_message(text)

    def show_message(self, text: str) -> None:
        """Show the result of a comparison until the settings change."""
        self._message = text
        self.show_state()

    def show_state(self) -> None:
        """Show whether computer or board renders, or the reason why the board cannot render the law."""
        engine = self._studio.engine
        board = engine is not None and engine.device.has_board
        self.setVisible(board)
        if engine is None or not board:
            self._renderers = None
            return
        decision = engine.decision()
        refusal, cheaper = decision.refusal, self._cheaper.get(decision.refusal)
        self.switch.show_index(RENDERERS.index(decision.where))
        self.switch.button(1).setEnabled(not refusal)
        rate = self._studio.loop.board_rate
        self.rate.show_value(0 if rate is None else BOARD_RATE.options.index(f"{rate:.0f}"))
        instead = f"{refusal} {cheaper.text}" if cheaper is not None else refusal
        self.note.setText(instead or self._message or self._remark(engine))
        self.instead.setVisible(cheaper is not None)
        self.instead.setText(
            f"Use {cheaper.choice.option_label(cheaper.option)}" if cheaper is not None else ""
        )
        able, compare = not refusal, self._studio.hand_is_ours
        self.facts.setVisible(able)
        self.rate.setVisible(able and not self._folded)
        self.button.setVisible(able and compare)
        self.note.setVisible(bool(self.note.text()))
        self._refresh_facts()
        self._look_for_cheaper(engine)

    def _remark(self, engine) -> str:
        """Return a remark on settings that the board ignores; while folded, also on the board's load."""
        from hapkit_studio.haptics import board_plan

        loop, parts, decision = self._studio.loop, [], engine.decision()
        if decision.where != BOARD:
            return ""
        if self._folded and decision.plan is not None:
            parts.append(f"The law uses {100.0 * decision.plan.share:.0f} % of the board's processor.")
        if board_plan.spec_on_board(loop.estimator) != loop.estimator:
            parts.append("The board does not have the chosen velocity filter and uses the Kalman filter.")
        if loop.delay > 0.0:
            parts.append("The board ignores the added delay.")
        if loop.controller:
            parts.append("The board has no passivity controller.")
        return " ".join(parts)

    def _refresh_facts(self) -> None:
        engine = self._studio.engine
        if engine is None or self.isHidden() or engine.driver is None or engine.driver.planner is None:
            return
        if self._renderers is not None and engine.decision().pending:
            return
        self._renderers = renderers(self._studio)
        impedance = self._studio.environment.impedance
        if impedance is not None:
            damping = impedance(self._studio.values)[1]
            self._worker.ask(([renderer.setting for renderer in self._renderers], damping))
        else:
            self._limits = [None, None]
        self._write()

    def _show_limits(self, limits: list[float | None]) -> None:
        self._limits = limits
        self._write()

    def _write(self) -> None:
        engine = self._studio.engine
        if engine is None or self._renderers is None:
            return
        for column, (renderer, limit) in enumerate(zip(self._renderers, self._limits, strict=True)):
            self.facts.show_renderer(column, renderer.texts(limit), RENDERERS[column] == engine.where)

    def _look_for_cheaper(self, engine: "Engine") -> None:
        """If the board refuses the law, search for an option of its choices that the board can render."""
        decision, offer = engine.decision(), engine.driver.planner if engine.driver is not None else None
        if not decision.refusal or offer is None:
            self._finder.forget()
        elif not decision.pending and isinstance(offer.known(engine.plan_request), str):
            from hapkit_studio.analysis.board_alternative import RefusedRequest

            self._finder.ask(RefusedRequest(offer, engine.plan_request))

    def _show_cheaper(self, answer: "AlternativeResult") -> None:
        refusal = answer.question.planner.known(answer.question.request)
        self._cheaper = {refusal: answer.found} if isinstance(refusal, str) and answer.found else {}
        self.show_state()

    def _clear_message(self) -> None:
        if self._message and self.switch.isEnabled():
            self.show_message("")

    # actions of the user

    def _choose(self, index: int) -> None:
        self._message = ""
        self._set(where=RENDERERS[index])

    def _choose_rate(self, _key: str, index: float) -> None:
        self._set(board_rate=float(BOARD_RATE.options[int(index)]) if index else None)

    def _use_cheaper(self) -> None:
        engine = self._studio.engine
        cheaper = None if engine is None else self._cheaper.get(engine.decision().refusal)
        if cheaper is not None:
            self._studio.set_value(cheaper.choice.key, float(cheaper.option))

    def _set(self, **change: object) -> None:
        try:
            self._studio.set_loop(**change)
        except ParameterError as error:
            self.show_state()
            self.note.setText(str(error))
            self.note.show()
