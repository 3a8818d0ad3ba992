"""The switch between computer and board, and what each of the two ways comes to, side by side."""

from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.choice_row import ChoiceRow
from hapkit_studio.gui.margin import MarginWorker
from hapkit_studio.gui.rich import plain
from hapkit_studio.gui.segmented import Segmented
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.where_columns import NAMES, Facts, Lines
from hapkit_studio.gui.where_facts import (
    BOARD,
    WAYS,
    Found,
    Limits,
    cells,
    short,
    solve,
    ways,
    wish,
)
from hapkit_studio.parameters import Choice

if TYPE_CHECKING:
    from hapkit_studio.analysis.cheaper import Answer, Cheaper, Question
    from hapkit_studio.gui.where_facts import Way
    from hapkit_studio.haptics.engine import Engine
    from hapkit_studio.haptics.health import Health

TIP = (
    "Who computes the force. The computer: a sample goes up, a force comes down, with the delay of the USB "
    "line. The board: parameters go down once, its own processor runs the same law."
)
RATE = Choice(
    "board_rate", "Board's rate", ("fastest", "4000", "2000", "1000", "500"), "fastest",
    "How often the board computes the force. A law that takes long allows no more than its own fastest rate.",
    labels=("fastest", "4,000 Hz", "2,000 Hz", "1,000 Hz", "500 Hz"),
)  # fmt: skip


def _find(question: "Question") -> "Answer":
    from hapkit_studio.analysis import cheaper  # off the first picture's way

    return cheaper.find(question)


class WhereSwitch(QWidget):
    """Shown for devices with a board. ``compare``: a person wants both ways, one after the other."""

    compare = Signal()

    def __init__(self, studio: Studio, parent: QWidget | None = None):
        super().__init__(parent)
        self._studio = studio
        self._worker = MarginWorker(solve, self)
        self._worker.answered.connect(self._take)
        self._found: Found | None = None
        self._finder = MarginWorker(_find, self)
        self._finder.answered.connect(self._take_cheaper)
        self._cheaper: Cheaper | None = None
        self.label = QLabel("Rendered by")
        self.label.setToolTip(TIP)
        self.switch = Segmented("Rendered by", NAMES)
        self.switch.setToolTip(TIP)
        self.switch.chosen.connect(self._choose)
        self.facts, self.lines, self.note = Facts(), Lines(), plain(QLabel())
        self.rate = ChoiceRow(RATE)
        self.rate.changed.connect(lambda _key, index: self._set(board_rate=_rate(int(index))))
        self.button = QPushButton("Compare both")
        self.button.clicked.connect(self.compare)
        self.instead = QPushButton()
        self.instead.clicked.connect(self._use_cheaper)
        self.note.setProperty("role", "hint")
        self.note.setWordWrap(True)
        self._told = self._refusal = ""
        self._folded = False
        self._ways: tuple[Way, Way] | None = None
        self._arrange()
        for signal in (studio.engine_changed, studio.loop_changed, studio.environment_changed):
            signal.connect(self.show_state)
        studio.values_changed.connect(self._look)
        for signal in (studio.engine_changed, studio.environment_changed, studio.values_changed):
            signal.connect(self._untell)
        self.show_state()

    # what is shown

    def set_folded(self, folded: bool) -> None:
        """Say it in one line, or in all."""
        self._folded = folded
        self.show_state()

    def note_health(self, _health: "Health") -> None:
        """Take over what was measured lately."""
        self._look()
        engine = self._studio.engine
        if engine is not None and not self.isHidden():
            self._look_for_cheaper(engine)

    def set_busy(self, words: str) -> None:
        """Say what goes on while both ways are compared; nothing ends it."""
        self.switch.setEnabled(not words)
        self.button.setText("Cancel" if words else "Compare both")
        self.tell(words)

    def tell(self, words: str) -> None:
        """Say what became of a comparison, until something else is chosen."""
        self._told = words
        self.show_state()

    def show_state(self) -> None:
        """Show who renders, and why the board cannot where it cannot; until that is known, as it was."""
        engine = self._studio.engine
        board = engine is not None and not engine.device.simulated
        self.setVisible(board)
        if engine is None or not board:
            self._refusal, self._cheaper, self._ways = "", None, None
            return
        if self._studio.board_answered and engine.board_refusal() != self._refusal:
            self._refusal, self._cheaper = engine.board_refusal(), None
        refusal, cheaper = self._refusal, self._cheaper
        self.switch.show_index(0 if refusal else WAYS.index(engine.where))
        self.switch.button(1).setEnabled(not refusal)
        self.rate.show_value(_place(self._studio.loop.board_rate))
        instead = f"{refusal} {cheaper.words}" if cheaper is not None else refusal
        self.note.setText(instead or self._told or self._remark(engine))
        self.instead.setVisible(cheaper is not None)
        self.instead.setText(f"Use {cheaper.choice.word(cheaper.option)}" if cheaper is not None else "")
        able, compare = not refusal, self._studio.hand_is_ours
        self.facts.setVisible(able and not self._folded)
        self.lines.setVisible(able and self._folded)
        self.rate.setVisible(able and not self._folded)
        self.button.setVisible(able and compare)
        self.note.setVisible(bool(self.note.text()))
        self._look()
        self._look_for_cheaper(engine)

    def _remark(self, engine) -> str:
        """Return what of the loop the board does not do, and what it takes where no table says so."""
        from hapkit_studio.haptics import board_plan

        loop, parts = self._studio.loop, []
        if engine.where != BOARD:
            return ""
        if self._folded and engine.offered_way is not None:
            parts.append(f"{100.0 * engine.offered_way.share:.0f} % of the board's processor.")
        if board_plan.spec_on_board(loop.spec) != loop.spec:
            parts.append("The board has no such velocity filter: Kalman in its place.")
        if loop.delay > 0.0:
            parts.append("Added delay is the computer's alone.")
        if loop.controller:
            parts.append("The passivity controller is the computer's alone.")
        return " ".join(parts)

    def _look(self) -> None:
        engine = self._studio.engine
        if engine is None or self.isHidden() or not engine.renders_on_boards:
            return
        if self._ways is not None and not self._studio.board_answered:
            return
        self._ways = ways(self._studio)
        impedance = self._studio.environment.impedance
        if impedance is not None:
            damping = impedance(self._studio.values)[1]
            settings = tuple(way.setting for way in self._ways)
            self._worker.ask(Limits((settings[0], settings[1]), damping))
        else:
            self._found = None
        self._write()

    def _take(self, found: Found) -> None:
        self._found = found
        self._write()

    def _write(self) -> None:
        engine = self._studio.engine
        if engine is None or self._ways is None:
            return
        limits = self._found.limits if self._found is not None else (None, None)
        for column, (way, limit, where) in enumerate(zip(self._ways, limits, WAYS, strict=True)):
            self.facts.show_way(column, cells(way, limit), where == engine.where)
            self.lines.show_way(column, short(way, limit), where == engine.where)

    def _look_for_cheaper(self, engine: "Engine") -> None:
        """Have something looked for that the board can render, where this law is too much for it."""
        offer = engine.driver.offer if engine.driver is not None else None
        if not self._refusal or offer is None:
            self._finder.forget()
        elif self._studio.board_answered and isinstance(offer.known(wish(self._studio)), str):
            from hapkit_studio.analysis.cheaper import Question

            self._finder.ask(Question(offer, wish(self._studio)))

    def _take_cheaper(self, answer: "Answer") -> None:
        self._cheaper = answer.found
        self.show_state()

    def _untell(self) -> None:
        if self._told and self.switch.isEnabled():
            self.tell("")

    def close_worker(self) -> None:
        """End the workers' threads."""
        self._worker.close()
        self._finder.close()

    # what a person does

    def _choose(self, index: int) -> None:
        self._told = ""
        self._set(where=WAYS[index])

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
        for part in (self.facts, self.lines, self.rate, self.button, self.note, self.instead):
            column.addWidget(part)


def _rate(index: int) -> float | None:
    return float(RATE.options[index]) if index else None


def _place(rate: float | None) -> int:
    return 0 if rate is None else RATE.options.index(f"{rate:.0f}")
