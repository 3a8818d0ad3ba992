"""Last: what changed, the kit's name, and keeping it: on the board and in a file."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QGridLayout, QLabel, QLineEdit, QWidget

from hapkit_studio.analysis.calibrate.result import passed
from hapkit_studio.devices import calibration_file, profiles
from hapkit_studio.devices.calibration_file import MEASURED, setting_label, setting_text
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.wizard.desk import Desk
from hapkit_studio.gui.wizard.page import StepPage
from hapkit_studio.protocol.messages import Sensor

Notes = dict[str, tuple[bool, str]]

if TYPE_CHECKING:
    from hapkit_studio.analysis.calibrate.calibration import Calibration

_UNSAVED = "Not saved yet: the board would forget it at its next start."


class SaveStep(StepPage):
    """Finished once the board has kept its settings. ``undone``: the old ones are back."""

    undone = Signal()
    title = "Save: on the board, and in a file"
    assumed = "nothing is kept: the board forgets at its next start"

    def __init__(self, desk: Desk, notes: Callable[[], Notes]):
        super().__init__(desk)
        self._notes = notes
        self.table = QWidget()
        self._grid = QGridLayout(self.table)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setHorizontalSpacing(28)
        self._grid.setVerticalSpacing(2)
        dress(self.table, "QLabel { font-size: 14px; }")
        self.column.addWidget(self.table)
        self.assumptions = QLabel()
        self.assumptions.setWordWrap(True)
        dress(self.assumptions, "QLabel { font-size: 14px; color: @ink2; }")
        self.column.addWidget(self.assumptions)
        self.column.addStretch(1)
        self.label = QLineEdit()
        self.label.setMaxLength(12)
        self.label.setAccessibleName("Name of the kit")
        dress(self.label, "QLineEdit { font-size: 14px; min-height: 32px; max-width: 180px; }")
        self.save = self.button("Save", self.keep, primary=True)
        self.undo = self.button("Undo everything…", self.ask)
        self.sure, self.stay = (
            self.button("Undo it all", self.put_back),
            self.button("Keep", self.ask_no_more),
        )
        row = self.row(QLabel("Name of the kit"), self.label, self.save)
        for button in (self.undo, self.sure, self.stay):
            row.addWidget(button)
        self.ask_no_more()
        self.file = QLabel()
        self.file.setWordWrap(True)
        self.file.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.file.hide()
        dress(self.file, "QLabel { font-size: 13px; color: @ink2; }")
        self.column.addWidget(self.file)
        self.column.addWidget(self.box)

    def enter(self) -> None:
        """Show what the board had, and what it has now."""
        self.ask_no_more()
        if self.desk.subject is None:
            return
        if not self.label.text():
            self.label.setText(self.subject.board.label)
        self._fill()
        skipped = [f"{title}: {words}" for title, (done, words) in self._notes().items() if not done]
        self.assumptions.setText("Assumed. " + "; ".join(skipped) + "." if skipped else "")

    def keep(self) -> None:
        """Keep the settings on the board and write the file."""
        try:
            label = calibration_file.checked_label(self.label.text())
        except ParameterError as error:
            self.show_refusal(str(error))
            return
        notes = {
            title: words if done else f"left out; assumed: {words}"
            for title, (done, words) in self._notes().items()
        }

        def job(work: "Calibration") -> str:
            work.store(label)
            return str(calibration_file.write(profiles.of_settings(work.runner.settings), notes))

        self.do("Saving…", job, self._kept)

    def ask(self) -> None:
        """Ask before everything that was found is dropped."""
        self._show_question(True)
        self.box.say(
            "Put back what the board had when this window opened?",
            "All that the steps found is forgotten. A saved file stays.",
            "triangle",
            "warn",
        )
        self.stay.setFocus()

    def ask_no_more(self) -> None:
        """Leave things as they are."""
        self._show_question(False)
        if self.verdict is not None:
            self.box.show_verdict(self.verdict)
        else:
            self.box.say(_UNSAVED)

    def _show_question(self, asked: bool) -> None:
        self.undo.setVisible(not asked)
        self.sure.setVisible(asked)
        self.stay.setVisible(asked)

    def withdraw(self) -> None:
        super().withdraw()
        self.label.clear()
        self.file.hide()

    def put_back(self) -> None:
        """Put back what the board had at the start."""
        self.do("Putting back…", lambda work: work.undo(), self._put_back)

    def _kept(self, path: str) -> None:
        self._fill()
        self.file.setText(f"File: {path}")
        self.file.show()
        self.show_verdict(passed(f"Saved on the board and in {Path(path).name}. {self._next_start()}"))

    def _next_start(self) -> str:
        """Say where the handle must be when the board is switched on, for its zero to be right."""
        board = self.subject.board
        if board.sensor == Sensor.QUADRATURE:
            return "Always switch on with the handle in the middle: an encoder's zero is where it starts."
        reach = 0.4e3 * board.counts_per_flip * board.quantum
        words = f"Switch on with the handle within {reach:.0f}\N{NO-BREAK SPACE}mm of the middle"
        return f"{words}: the board finds its zero from there."

    def _put_back(self, _none: object) -> None:
        self._fill()
        self.undone.emit()

    def _fill(self) -> None:
        while (item := self._grid.takeAt(0)) is not None:
            if (cell := item.widget()) is not None:
                cell.deleteLater()
        before, now = self.subject.original, self.subject.board
        for column, words in enumerate(("", "before", "now")):
            self._cell(0, column, words, "axis")
        for line, name in enumerate(MEASURED, 1):
            old, new = setting_text(before, name), setting_text(now, name)
            self._cell(line, 0, setting_label(name), "axis")
            self._cell(line, 1, old, "axis")
            self._cell(line, 2, new if new != old else "as before", "" if new != old else "axis")
        self._grid.setColumnStretch(3, 1)

    def _cell(self, line: int, column: int, words: str, role: str) -> None:
        label = QLabel(words)
        label.setProperty("role", role)
        if not role:
            dress(label, "QLabel { font-size: 14px; font-weight: 650; }")
        self._grid.addWidget(label, line, column)
