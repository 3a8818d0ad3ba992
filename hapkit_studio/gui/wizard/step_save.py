"""The step Save: it asks for the kit's name, and saves the changed settings on the board and on disk."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QGridLayout, QLabel, QLineEdit

from hapkit_studio.analysis.calibrate.result import passed
from hapkit_studio.devices import calibration_file, profiles
from hapkit_studio.devices.calibration_file import MEASURED, setting_label, setting_text
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.widgets.parts import hbox, label
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.step_page import StepPage
from hapkit_studio.protocol.messages import Sensor

if TYPE_CHECKING:
    from hapkit_studio.analysis.calibrate.calibration import Calibration

Notes = dict[str, tuple[bool, str]]
"""For each step's name: whether the step is done, and its result or assumption."""
_NEAR_KIT = 0.2
"""A scale needs no confirmation if its relative deviation from a known kit's scale is at most this."""
_UNSAVED = "These settings are not saved yet: the board will lose them at its next start."


class SaveStep(StepPage):
    """This step is complete once the board has stored its settings.

    ``undone`` is emitted when the old settings are restored.
    """

    undone = Signal()
    name = "Save"
    heading = "Save: on the board, and in a file"
    if_skipped = "Nothing is saved, and the board loses the settings at its next start."

    def __init__(self, board: BoardThread, notes: Callable[[], Notes]) -> None:
        super().__init__(board)
        self._notes = notes
        grid = QGridLayout()
        grid.setHorizontalSpacing(28)
        grid.setVerticalSpacing(2)
        grid.setColumnStretch(3, 1)
        self.column.addLayout(grid)
        for column, head in enumerate(("before", "now"), 1):
            grid.addWidget(label(head, "axis", wrap=False), 0, column)
        self._cells: dict[str, tuple[QLabel, QLabel]] = {}
        for row, name in enumerate(MEASURED, 1):
            had, has = self._cells[name] = label(role="axis", wrap=False), label(wrap=False)
            for column, cell in enumerate((label(setting_label(name), "axis", wrap=False), had, has)):
                grid.addWidget(cell, row, column)
        self.assumptions = self.add_text()
        self.assumptions.setProperty("ink", "ink2")
        self.confirm = QCheckBox("I have checked the radii and the marks: the scale is right")
        self.confirm.toggled.connect(self._confirm_scale)
        self._confirmed = math.nan
        self.column.addStretch(1)
        self.label = QLineEdit(maxLength=12)
        self.label.setAccessibleName("Name of the kit")
        self.label.setMaximumWidth(180)
        self.first = self.save = self.button(
            "Save the settings",
            self.store,
            primary=True,
            ready=lambda: self._scale_plausible() or self._scale_confirmed(),
        )
        self.undo = self.button("Undo all changes…", self.ask)
        self.undo_all = self.job_button(
            "Undo all changes",
            "Restoring the settings…",
            lambda work: work.undo(),
            lambda _none: self.undone.emit(),
        )
        self.keep = self.button("Keep the changes", self.keep_everything)
        self.foot.insertWidget(
            0, self.confirm
        )  # The check box is outside the scroll area, so that it is visible even if the table is long.
        buttons = self.save, self.undo, self.undo_all, self.keep
        self.foot.insertLayout(1, hbox(QLabel("Name of the kit"), self.label, *buttons, None, gap=10))
        self.file = self.add_text()
        self.file.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.file.hide()
        self.keep_everything()

    def enter(self) -> None:
        """Show the board's old and new settings."""
        self.keep_everything()
        if self.calibration is None:
            return
        if not self.label.text():
            self.label.setText(self.calibration.board.label)
        self._fill_table()
        self.confirm.setVisible(not self._scale_plausible())
        self.confirm.setChecked(self._scale_confirmed())
        skipped = [f"{name}: {text}" for name, (done, text) in self._notes().items() if not done]
        self.assumptions.setText("Skipped steps: " + " ".join(skipped) if skipped else "")

    def reset(self) -> None:
        super().reset()
        self.label.clear()
        self.file.hide()

    # confirming the scale

    def _scale_plausible(self) -> bool:
        """Return True if the scale is near that of a known kit."""
        _, ratio = profiles.nearest_kit(self.calibration.board)
        return abs(ratio - 1.0) <= _NEAR_KIT

    def _scale_confirmed(self) -> bool:
        return self.calibration.board.quantum == self._confirmed

    def _confirm_scale(self, on: bool) -> None:
        """Confirm the current scale; a different scale must be confirmed again."""
        self._confirmed = self.calibration.board.quantum if on else math.nan
        self.keep_everything()
        self.enable_buttons()

    # methods that save the settings

    def store(self) -> None:
        """Store the settings on the board and write the file."""
        try:
            label = calibration_file.checked_label(self.label.text())
        except ParameterError as error:
            self.show_refusal(str(error))
            return
        notes = {name: text if done else f"skipped: {text}" for name, (done, text) in self._notes().items()}

        def job(work: "Calibration") -> str:
            work.store(label)
            return str(calibration_file.write(profiles.of_settings(work.runner.settings), notes))

        self.run_job("Saving the settings…", job, self._stored)

    def _stored(self, path: str) -> None:
        self._fill_table()
        self.file.setText(f"Saved file: {path}")
        self.file.show()
        self.finish(
            passed(
                f"The settings were saved on the board and in the file {Path(path).name}. "
                f"{self._next_start()}"
            )
        )

    def _next_start(self) -> str:
        """Describe where the handle must be when the board is switched on, for a correct zero."""
        board = self.calibration.board
        if board.sensor == Sensor.QUADRATURE:
            return (
                "Always switch the board on with the handle in the middle: its encoder takes the starting "
                "position as zero."
            )
        reach = 0.4e3 * board.counts_per_flip * board.quantum
        text = f"Switch the board on with the handle within {reach:.0f}\N{NO-BREAK SPACE}mm of the middle"
        return f"{text}: the board finds its zero from there."

    # methods that undo the set-up

    def ask(self) -> None:
        """Ask the user before all results are discarded."""
        self._show_question(True)
        self.box.show_warning(
            "Restore the settings that the board had when this window opened?",
            "All results of the steps will be lost. A saved file will not be deleted.",
        )
        self.keep.setFocus()

    def keep_everything(self) -> None:
        """Cancel the undo and keep all results."""
        self._show_question(False)
        if self.result is not None:
            self.box.show_result(self.result)
        elif self.calibration is not None and not (self._scale_plausible() or self._scale_confirmed()):
            kit, ratio = profiles.nearest_kit(self.calibration.board)
            self.box.show_warning(
                f"Per sensor count, the handle moves {ratio:.2f} × as far as with the most similar kit, "
                f"{kit.title}. The usual ratio is 0.8 to 1.2.",
                "Take the marks again in the step Zero and scale, or confirm the scale above. Then save.",
            )
        else:
            self.box.show_text(_UNSAVED)

    def _show_question(self, asked: bool) -> None:
        self.undo.setVisible(not asked)
        self.undo_all.setVisible(asked)
        self.keep.setVisible(asked)

    def _fill_table(self) -> None:
        before, now = self.calibration.original, self.calibration.board
        for name, (had, has) in self._cells.items():
            old, new = setting_text(before, name), setting_text(now, name)
            had.setText(old)
            has.setText("unchanged" if new == old else new)
            mark(has, "role", "axis" if new == old else "headline")
