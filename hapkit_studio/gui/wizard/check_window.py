"""Test my Hapkit: every check with its verdict, and what to do; nothing is changed on the board."""

import math
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from hapkit_studio.analysis.calibrate.checks import CHECKS, Check, Report, run_all
from hapkit_studio.analysis.calibrate.result import FAIL, PASS, WARN, CheckResult
from hapkit_studio.gui.pages.measuring import PRIMARY
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.wizard.page import Seen
from hapkit_studio.gui.wizard.shell import Shell
from hapkit_studio.gui.wizard.verdict_box import LONG, VerdictBox

if TYPE_CHECKING:
    from hapkit_studio.devices.board_runner import BoardRunner
    from hapkit_studio.gui.studio import Studio

TITLE = "Test my Hapkit"
_FINE = 100
_SIGNS = {PASS: ("check", "ok"), WARN: ("triangle", "warn"), FAIL: ("triangle", "danger")}
_WAITING, _SAID = "QLabel { font-size: 14px; color: @ink3; }", "QLabel { font-size: 14px; color: @ink; }"
_BEGIN = "Handle in the middle, hands off, motor's supply on. Then press Test; it takes half a minute."


def itself(bench: "BoardRunner") -> "BoardRunner":
    """Return the bench: checks need nothing more."""
    return bench


class CheckWindow(Shell):
    """A row a check; one line for the whole."""

    _said = Signal(str, object)

    def __init__(self, studio: "Studio", parent: QWidget):
        super().__init__(TITLE, studio, itself, parent)
        self.resize(820, 600)
        self.setMinimumSize(640, 480)
        self.report: Report | None = None
        self._told = 0
        self.box, self.bar = VerdictBox(), QProgressBar()
        self.test, self.shut = QPushButton("Test"), QPushButton("Close")
        self.test.setProperty("tall", True)
        self.test.setAutoDefault(False)
        self.test.setEnabled(False)
        dress(self.test, PRIMARY + "QPushButton { font-size: 14px; }")
        self.rows: dict[str, tuple[QLabel, QLabel]] = {}
        body = self._body()
        self.column.addWidget(body, 1)
        self.test.clicked.connect(self.run)
        self.shut.clicked.connect(self.close)
        self._said.connect(self._show)
        self.desk.opened.connect(self._opened)
        self.desk.refused.connect(self._refused)
        self.desk.failed.connect(self._failed)
        self.box.say("Starting the board…", "", "circle", "accent")

    def run(self) -> None:
        """Run every check."""
        for check in CHECKS:
            sign, words = self.rows[check.key]
            sign.clear()
            dress(words, _WAITING)
            words.setText(check.about)

        def said(check: Check, verdict: CheckResult | None) -> None:
            self._said.emit(check.key, verdict)

        if self.desk.start(lambda bench: run_all(bench, said), self._finished):
            self.test.setEnabled(False)
            self._told = 0
            self.bar.setValue(0)
            self.box.say("Testing. Hands off…", "", "circle", "accent")

    def show_seen(self, _seen: Seen) -> None:
        """Show how far a check is that takes its time; one that begins again leaves the bar where it is."""
        bench = self.desk.bench
        passed, seconds = bench.progress if bench is not None and self.desk.busy else (0.0, 0.0)
        if LONG <= seconds < math.inf:
            within = round(_FINE * (self._told + passed / seconds))
            self.bar.setValue(max(self.bar.value(), min(within, _FINE * (self._told + 1))))

    def _opened(self, _bench: object) -> None:
        self.test.setEnabled(True)
        self.test.setFocus()
        self.box.say(_BEGIN)

    def _show(self, key: str, verdict: CheckResult | None) -> None:
        sign, words = self.rows[key]
        dress(words, _SAID)
        if verdict is None:
            sign.setPixmap(icons.pixmap("circle", 20, "accent", self.devicePixelRatioF()))
            words.setText(f"{words.text()} Under way…")
            return
        name, token = _SIGNS.get(verdict.level, ("circle", "ink3"))
        sign.setPixmap(icons.pixmap(name, 20, token, self.devicePixelRatioF()))
        words.setText(f"{verdict.words} {verdict.remedy}".strip())
        words.setAccessibleName(f"{key}: {verdict.level}. {words.text()}")
        self._told += 1
        self.bar.setValue(_FINE * self._told)

    def _finished(self, report: Report) -> None:
        self.report = report
        self.test.setEnabled(True)
        self.test.setText("Test again")
        level = PASS if report.good else FAIL if report.dangerous else WARN
        self.box.say(report.words, "", *_SIGNS[level])

    def _refused(self, words: str) -> None:
        self.test.setEnabled(True)
        self.box.say(words, "", "triangle", "warn")

    def _failed(self, words: str) -> None:
        self.test.setEnabled(False)
        self.box.say(words, "Close this window, connect the board again.", "unplugged", "warn")

    def _body(self) -> QWidget:
        body = QWidget()
        column, grid = QVBoxLayout(body), QGridLayout()
        column.setContentsMargins(24, 18, 24, 18)
        column.setSpacing(12)
        grid.setHorizontalSpacing(16)
        grid.setVerticalSpacing(12)
        grid.setColumnStretch(2, 1)
        self.bar.setRange(0, _FINE * len(CHECKS))
        for line, check in enumerate(CHECKS):
            sign, title, words = QLabel(), QLabel(check.title), QLabel(check.about)
            sign.setFixedWidth(22)
            words.setWordWrap(True)
            dress(title, "QLabel { font-size: 15px; font-weight: 600; }")
            dress(words, _WAITING)
            self.rows[check.key] = (sign, words)
            for place, part in enumerate((sign, title, words)):
                grid.addWidget(part, line, place, Qt.AlignmentFlag.AlignTop)
        column.addLayout(grid)
        column.addStretch(1)
        column.addWidget(self.bar)
        column.addWidget(self.box)
        self.shut.setProperty("tall", True)
        self.shut.setAutoDefault(False)
        row = QHBoxLayout()
        row.addWidget(self.test)
        row.addStretch(1)
        row.addWidget(self.shut)
        column.addLayout(row)
        return body
