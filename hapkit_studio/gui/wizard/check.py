"""The dialog *Test my Hapkit*. It runs all checks and shows results and remedies; it changes no setting."""

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QGridLayout, QLabel, QLayout, QPushButton, QWidget

from hapkit_studio.analysis.calibrate.checks import CHECKS, Report, run_all
from hapkit_studio.analysis.calibrate.result import FAIL, PASS, WARN, CheckResult
from hapkit_studio.gui.widgets.dialogs import on_screen
from hapkit_studio.gui.widgets.parts import Sign, hbox, label, primary, vbox
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.wizard.board_dialog import NEUTRAL, SIGNS, BoardDialog, Recent, ResultBox

if TYPE_CHECKING:
    from hapkit_studio.gui.state.studio import Studio

_ICON = 20
_BEGIN = (
    "Put the handle in the middle, take your hands off, switch the motor's supply on, then press "
    "Start test. The test takes half a minute."
)


class CheckDialog(BoardDialog):
    """Shows one row per check, and a line with the overall result."""

    title = "Test my Hapkit"

    def __init__(self, studio: "Studio", parent: QWidget) -> None:
        super().__init__(studio, parent)
        self.resize(on_screen(self, (820, 600)))
        self.setMinimumSize(640, 480)
        self.report: Report | None = None
        self.box = ResultBox()
        self.test = primary(QPushButton("Start test"))
        self.test.setEnabled(False)
        self.rows: dict[str, tuple[Sign, QLabel]] = {}
        self.column.addLayout(self._body(), 1)
        self.test.clicked.connect(self.run)
        self.board.progressed.connect(self._show_check)
        self.board.opened.connect(self._opened)
        self.board.refused.connect(lambda text: self._show_ready(text, sign=SIGNS[WARN]))
        self.board.failed.connect(self._failed)
        self.box.show_working("Starting the board…")

    def run(self) -> None:
        """Run all checks."""
        for check in CHECKS:
            sign, line = self.rows[check.key]
            sign.show_sign("", "ink2")
            mark(line, "role", "hint")
            line.setText(check.about)
        report = self.board.report_progress
        if self.board.run_job(
            lambda runner: run_all(runner, lambda check, result: report((check.key, result))), self._finished
        ):
            self.test.setEnabled(False)
            self.close_button.setText("Cancel")
            self.box.show_working("Testing. Keep your hands off the handle…")

    def show_recent(self, _recent: Recent) -> None:
        if self.board.runner is not None:
            self.box.show_progress(*self.board.runner.progress)

    def _opened(self, _runner: object) -> None:
        self._show_ready(_BEGIN, button="Start test")
        self.test.setFocus()

    def _show_check(self, progress: tuple[str, CheckResult | None]) -> None:
        key, result = progress
        sign, line = self.rows[key]
        mark(line, "role", "")
        sign.show_sign(*(("circle", "accent") if result is None else SIGNS[result.level]))
        if result is None:
            line.setText(f"{line.text()} Running…")
            return
        line.setText(f"{result.text} {result.remedy}".strip())
        line.setAccessibleName(f"{key}: {result.level}. {line.text()}")

    def _finished(self, report: Report) -> None:
        self.report = report
        self._show_ready(report.text, sign=SIGNS[PASS if report.good else FAIL if report.dangerous else WARN])

    def _failed(self, text: str) -> None:
        self._show_ready(
            text, "Close this window and connect the board again.", ("unplugged", "warn"), "Start test"
        )
        self.test.setEnabled(False)

    def _show_ready(
        self, text: str, remedy: str = "", sign: tuple[str, str] = NEUTRAL, button: str = "Test again"
    ) -> None:
        """Show a state, and enable the button that starts the test."""
        self.box.show_text(text, remedy, sign)
        self.test.setText(button)
        self.test.setEnabled(True)
        self.close_button.setText("Close")

    def _body(self) -> QLayout:
        grid = QGridLayout()
        grid.setSpacing(12)
        grid.setColumnStretch(2, 1)
        for line, check in enumerate(CHECKS):
            sign, readout = self.rows[check.key] = Sign(_ICON), label(check.about, "hint")
            sign.setFixedWidth(_ICON + 2)
            for place, part in enumerate((sign, label(check.title, "headline", wrap=False), readout)):
                grid.addWidget(part, line, place, Qt.AlignmentFlag.AlignTop)
        for button in (self.test, self.close_button):
            button.setProperty("tall", True)
            button.setAutoDefault(False)
        buttons = hbox(self.test, None, self.close_button)
        return vbox(grid, None, self.box, buttons, margins=(24, 18, 24, 18), gap=12)
