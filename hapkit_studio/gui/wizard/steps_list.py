"""The steps at the left: which one is in sight, what became of the others."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from hapkit_studio.analysis.calibrate.result import FAIL, PASS, WARN, CheckResult
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.style import dress, mark
from hapkit_studio.gui.widgets.theme import theme

_SHEET = """
#steps { background: @side; border-right: 1px solid @line; }
#steps QPushButton { text-align: left; border: none; border-left: 3px solid transparent; border-radius: 0;
  background: transparent; min-height: 44px; padding: 0; }
#steps QPushButton:hover { background: @accentsoft; }
#steps QPushButton[current="true"] { background: @accentsoft; border-left: 3px solid @accent; }
#steps QPushButton:focus { border: 2px solid @accent; }
"""
_SIGNS = {PASS: ("check", "ok"), WARN: ("triangle", "warn"), FAIL: ("triangle", "danger")}


class _Row(QPushButton):
    def __init__(self, number: int, words: str):
        super().__init__()
        self.words = words
        self.setAutoDefault(False)
        self.sign, self.label = QLabel(), QLabel(f"{number}   {words}")
        row = QHBoxLayout(self)
        row.setContentsMargins(16, 0, 12, 0)
        row.addWidget(self.label, 1)
        row.addWidget(self.sign)
        for part in (self.sign, self.label):
            part.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        dress(self.label, "QLabel { font-size: 14px; }")


class StepsList(QWidget):
    """Emits ``chosen(index)``."""

    chosen = Signal(int)

    def __init__(self, names: tuple[str, ...], parent: QWidget | None = None):
        super().__init__(parent)
        self.setObjectName("steps")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setFixedWidth(200)
        self.rows = [_Row(number, words) for number, words in enumerate(names)]
        self._verdicts: list[CheckResult | None] = [None] * len(names)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 12, 0, 12)
        column.setSpacing(0)
        for index, row in enumerate(self.rows):
            row.clicked.connect(lambda _on=False, index=index: self.chosen.emit(index))
            column.addWidget(row)
        column.addStretch(1)
        dress(self, _SHEET)
        theme.changed.connect(self._dress)

    def show_current(self, index: int) -> None:
        """Mark the step in sight."""
        for at, row in enumerate(self.rows):
            mark(row, "current", at == index)

    def show_verdict(self, index: int, verdict: CheckResult | None) -> None:
        """Show what became of a step."""
        self._verdicts[index] = verdict
        self._dress()

    def _dress(self) -> None:
        for row, verdict in zip(self.rows, self._verdicts, strict=True):
            state = "not done yet"
            if verdict is None:
                row.sign.clear()
            else:
                sign, token = _SIGNS.get(verdict.level, ("circle", "ink3"))
                row.sign.setPixmap(icons.pixmap(sign, 18, token, self.devicePixelRatioF()))
                state = verdict.words
            row.setAccessibleName(f"{row.words}: {state}")
            row.setToolTip(state)
