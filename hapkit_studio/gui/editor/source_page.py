"""A file from someone else: its source, to be read before it may run. Nothing of it has run so far."""

from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from hapkit_studio.gui import icons
from hapkit_studio.gui.dress import dress
from hapkit_studio.gui.editor.code_edit import CodeEdit
from hapkit_studio.gui.parameter_panel import rule
from hapkit_studio.gui.rich import plain
from hapkit_studio.gui.theme import theme
from hapkit_studio.workshop.source import Source

_ASK = "It is a program and may do what any program may. Run it only if you know where it comes from."


class SourcePage(QWidget):
    """Emits ``run_pressed`` with the very source that was shown, or ``left``."""

    run_pressed = Signal(object)
    left = Signal()

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.source = Source(Path(), "", "")
        self.title, self.ask, self.sign = plain(QLabel()), QLabel(_ASK), QLabel()
        self.title.setWordWrap(True)
        self.ask.setWordWrap(True)
        self.code = CodeEdit()
        self.code.setReadOnly(True)
        self.run, self.leave = (
            QPushButton("Run it", autoDefault=True),
            QPushButton("Leave it", autoDefault=True),
        )
        self.run.clicked.connect(lambda: self.run_pressed.emit(self.source))
        self.leave.clicked.connect(self.left)
        self._arrange()
        theme.changed.connect(self._show_look)
        self._show_look()

    def show_source(self, source: Source) -> None:
        """Show a file that nobody has agreed to yet."""
        self.source, name = source, source.path.name
        self.title.setText(f"{name} is from someone else, or was changed outside the studio.")
        self.code.setPlainText(source.text)
        self.code.setAccessibleName(f"Source of {name}, to read")

    def _show_look(self) -> None:
        self.title.setFont(theme.font("banner"))
        self.sign.setPixmap(icons.pixmap("lock", 24, "warn", self.devicePixelRatioF()))

    def _arrange(self) -> None:
        words = QVBoxLayout()
        words.setSpacing(2)
        words.addWidget(self.title)
        words.addWidget(self.ask)
        head = QWidget()
        head.setObjectName("foreign")
        dress(head, "#foreign { background: @warnsoft; border-left: 5px solid @warn; }")
        row = QHBoxLayout(head)
        row.setContentsMargins(12, 8, 12, 8)
        row.setSpacing(12)
        row.addWidget(self.sign)
        row.addLayout(words, 1)
        row.addWidget(self.leave)
        row.addWidget(self.run)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(head)
        column.addWidget(rule())
        column.addWidget(self.code, 1)
