"""The strip on top of a page: what is chosen at the left, what is being measured at the right."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from hapkit_studio.gui.tabs.job import Job
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.style import dress

PRIMARY = """
QPushButton { background: @accent; color: @onaccent; border-color: @accent; font-weight: 600; }
QPushButton:hover { background: @accent; }
QPushButton:disabled { background: @grid; color: @ink3; border-color: @line; }
QPushButton:focus { border: 2px solid @ink; }
"""
# more letters than that find no room beside the buttons; where the words stand among them
_BESIDE, _STATUS = 26, 2
_PLAIN = "QPushButton { font-weight: 600; }"


class RunBar(QWidget):
    """Emits ``run_pressed`` and ``export_pressed``; while its job runs, the same button cancels."""

    run_pressed = Signal()
    export_pressed = Signal()

    def __init__(self, job: Job, words: str = "Measure", again: str = "Measure again"):
        super().__init__()
        self._job, self._words, self._again = job, words, again
        self._fresh = True
        self.status = QLabel()
        self.status.setProperty("role", "hint")
        self.run = QPushButton(words)
        self.run.setAutoDefault(True)  # Enter presses it; Space is Pause
        self.run.clicked.connect(self._press)
        self.export = QPushButton("Export")
        self.export.setAutoDefault(True)
        self.export.setProperty("flat", True)
        self.export.setEnabled(False)
        self.export.clicked.connect(self.export_pressed)
        icons.bind(self.export, "export", "ink2", 18)
        self.progress = QProgressBar()
        self.progress.setFixedHeight(4)
        self.progress.setTextVisible(False)
        self.progress.setAccessibleName("Progress")
        self._arrange()
        self._join()
        self._look()

    def add(self, widget: QWidget) -> None:
        """Put a widget to the right of those added before; it keeps the width that its words need."""
        widget.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        for button in (widget, *widget.findChildren(QPushButton)):
            if isinstance(button, QPushButton):
                button.setAutoDefault(True)
        self._left.addWidget(widget)

    def say(self, text: str, danger: bool = False) -> None:
        """Show words beside the button, or on a line of their own where they are many."""
        self._give_room(len(text) > _BESIDE)
        self.status.setText(text)
        dress(self.status, f"QLabel {{ color: @{'danger' if danger else 'ink3'}; font-size: 12px; }}")

    def _give_room(self, below: bool) -> None:
        """Put the words below the row, or back into it."""
        if below == self._below.isEmpty():
            self._below.removeWidget(self.status)
            self._row.removeWidget(self.status)
            self.status.setWordWrap(below)
            if below:
                self._below.addWidget(self.status)
            else:
                self._row.insertWidget(_STATUS, self.status)
        self._below.setContentsMargins(14, 0, 14, 6 if below else 0)

    def _join(self) -> None:
        job = self._job
        job.running_changed.connect(self._look)
        job.preparing.connect(lambda: self.say("Preparing, once only: up to a minute"))
        job.progressed.connect(self._follow)
        job.failed.connect(lambda text: self.say(text, danger=True))
        job.finished.connect(self._finish)

    def _press(self) -> None:
        if self._job.running:
            self._job.cancel()
            self.say("Cancelled")
        else:
            self.run_pressed.emit()

    def _finish(self) -> None:
        self._fresh = False
        self.export.setEnabled(True)
        self.say("")
        self._look()

    def _follow(self, done: int, of: int) -> None:
        if not self._job.running:  # a last word of work that was cancelled
            return
        self.progress.setRange(0, of)
        self.progress.setValue(done)
        self.say(f"{100 * done // max(of, 1)} %")

    def _look(self) -> None:
        running = self._job.running
        self.run.setText("Cancel" if running else self._words if self._fresh else self._again)
        dress(self.run, _PLAIN if running else PRIMARY)
        self.progress.setRange(0, 0 if running else 1)
        self.progress.setValue(0)
        self.progress.setVisible(running)
        self._line.setVisible(not running)

    def _arrange(self) -> None:
        row = self._row = QHBoxLayout()
        self._below = QHBoxLayout()
        self._below.setContentsMargins(0, 0, 0, 0)
        row.setContentsMargins(12, 7, 8, 7)
        row.setSpacing(10)
        self._left = QHBoxLayout()
        self._left.setSpacing(10)
        row.addLayout(self._left)
        row.addStretch(1)
        row.addWidget(self.status)
        row.addWidget(self.run)
        row.addWidget(self.export)
        self._line = QFrame()
        self._line.setProperty("rule", True)
        self._line.setFixedHeight(4)
        dress(self._line, "QFrame { background: transparent; border: none; border-bottom: 1px solid @line; }")
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(row)
        column.addLayout(self._below)
        column.addWidget(self.progress)
        column.addWidget(self._line)
