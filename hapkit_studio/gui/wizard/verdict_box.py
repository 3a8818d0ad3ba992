"""One verdict: a sign, what was found, what to do; while something takes its time, how far it is."""

import math

from PySide6.QtCore import Qt
from PySide6.QtGui import QResizeEvent, QShowEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QVBoxLayout, QWidget

from hapkit_studio.analysis.calibrate.result import FAIL, PASS, WARN, CheckResult
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.theme import theme

LONG = 5.0
"""s from which on a run shows how far it is."""
_SIGNS = {PASS: ("check", "ok"), WARN: ("triangle", "warn"), FAIL: ("triangle", "danger")}
_NEUTRAL = ("circle", "ink2")
_GROUND = {"ok": "oksoft", "warn": "warnsoft", "danger": "dangersoft", "ink2": "side"}
_SIDE, _MARGIN, _GAP = 14, 9, 4
_BAR, _FINE = 5, 1000


class VerdictBox(QWidget):
    """A sign, what was found, and below it what to do; in the margin, how far something is."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.setObjectName("verdictBox")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.sign, self.words, self.remedy = QLabel(), QLabel(), QLabel()
        dress(self.words, "QLabel { font-size: 15px; font-weight: 650; }")
        dress(self.remedy, "QLabel { font-size: 14px; }")
        for label in (self.words, self.remedy):
            label.setWordWrap(True)
            label.setText("one line")
        self._two_lines = self.words.sizeHint().height() + self.remedy.sizeHint().height()
        column = QVBoxLayout()
        column.setSpacing(_GAP)
        column.addStretch(1)
        column.addWidget(self.words)
        column.addWidget(self.remedy)
        column.addStretch(1)
        self.bar = QProgressBar(self)  # in the margin below the words: its coming moves nothing
        self.bar.setRange(0, _FINE)
        self.bar.setTextVisible(False)
        self.bar.setFixedHeight(_BAR)
        self.bar.setAccessibleName("Progress")
        self.bar.hide()
        row = QHBoxLayout(self)
        row.setContentsMargins(_SIDE, _MARGIN, _SIDE, _MARGIN)
        row.setSpacing(12)
        row.addWidget(self.sign, 0, Qt.AlignmentFlag.AlignVCenter)
        row.addLayout(column, 1)
        self._look = _NEUTRAL
        theme.changed.connect(self._dress)
        self.say("")

    def say(self, words: str, remedy: str = "", sign: str = "circle", token: str = "ink2") -> None:
        """Show a sign, words and what to do."""
        self.words.setText(words)
        self.remedy.setText(remedy)
        self.remedy.setVisible(bool(remedy))
        self._look = (sign, token)
        self.setAccessibleName(f"{words} {remedy}".strip())
        self._dress()
        self._fit()

    def show_progress(self, passed: float, seconds: float) -> None:
        """Show how far a run is that takes so many s; nothing for none, a short one and one without end."""
        shown = LONG <= seconds < math.inf
        if shown:
            self.bar.setValue(round(_FINE * passed / seconds))
        self.bar.setVisible(shown)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._fit()

    def _fit(self) -> None:
        """Be as high as the words need at this width, at least two lines: most verdicts then move nothing."""
        self.bar.setGeometry(_SIDE, self.height() - _BAR - 3, self.width() - 2 * _SIDE, _BAR)
        wide = self.width() - 2 * _SIDE - 22 - 12
        high = sum(part.heightForWidth(wide) for part in (self.words, self.remedy) if part.text())
        self.setMinimumHeight(max(high, self._two_lines) + 2 * _MARGIN + _GAP)

    def show_verdict(self, verdict: CheckResult) -> None:
        """Show a verdict."""
        self.say(verdict.words, verdict.remedy, *_SIGNS.get(verdict.level, _NEUTRAL))

    def _dress(self) -> None:
        sign, token = self._look
        self.sign.setPixmap(icons.pixmap(sign, 22, token, self.devicePixelRatioF()))
        ground = f"background: @{_GROUND.get(token, 'side')}; border: 1px solid @line; border-radius: 8px;"
        dress(self, f"#verdictBox {{ {ground} }}")
