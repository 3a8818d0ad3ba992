"""The page on which a law is edited: name, text, draft, and a message line below."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from PySide6.QtCore import QEvent, Qt, QTimer, Signal
from PySide6.QtGui import QKeyEvent, QTextCursor
from PySide6.QtWidgets import QProgressBar, QPushButton, QToolButton, QWidget

from hapkit_studio.errors import FileError
from hapkit_studio.files import read_text
from hapkit_studio.gui.editor.code_edit import CodeEdit
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.parts import Sign, hbox, label, rule, vbox
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.workshop.source import MOST_BYTES

Button = tuple[str, Callable[[], object]]

_HEIGHT = 40
# for each tone: the sign, and the colour token of sign and words
_TONES = {"": ("", "ink2"), "ok": ("check", "ok"), "warn": ("info", "warn"), "danger": ("cross", "danger")}
DRAFT_MS = 800
CYCLES, CYCLES_KEY = "Processor cycles", "Ctrl+Shift+C"
_CYCLES_TIP = (
    "The board's processor makes 16 million cycles per second. The number beside each line is the average "
    "number of cycles that the line takes in one call of the law, during a back-and-forth motion. For the "
    "whole law, two numbers are given: the most cycles of a call in that motion, and the cycles of the "
    "longest path through the law."
)


def draft_path(path: Path) -> Path:
    """Return the path of a file's draft, which contains the unsaved text."""
    return path.with_name(path.name + ".draft")


def load_draft(path: Path) -> str | None:
    """Return a file's draft; None if it has no draft."""
    try:
        return read_text(draft_path(path), MOST_BYTES)
    except FileError:
        return None


def delete_draft(path: Path) -> None:
    """Delete a file's draft."""
    with suppress(OSError):
        draft_path(path).unlink(missing_ok=True)


class MessageLine(QWidget):
    """Shows one message at a time; ``show_text`` replaces the message."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.setObjectName("messageLine")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setMinimumHeight(_HEIGHT)
        self.tone = ""
        self.sign, self.label, self.busy = Sign(20), label(), QProgressBar()
        self.label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.busy.setRange(0, 0)
        self.busy.setFixedWidth(72)
        self.busy.setAccessibleName("Working")
        self.buttons: list[QPushButton] = []
        self._row = hbox(self.sign, self.busy, (self.label, 1), into=self, margins=(12, 4, 8, 4))
        self.show_text("")

    def show_text(
        self, text: str, tone: str = "", buttons: Sequence[Button] = (), busy: bool = False
    ) -> None:
        """Show a message in a tone ("", ok, warn, danger) with buttons, or a progress bar if ``busy``."""
        self.tone = tone
        self.label.setText(text)
        self.busy.setVisible(busy)
        for old in self.buttons:
            self._row.removeWidget(old)
            old.hide()
            old.deleteLater()
        self.buttons = [self._button(*button) for button in buttons]
        sign, color = _TONES[tone]
        self.sign.show_sign(sign, color)
        mark(self, "tone", tone)
        mark(self.label, "ink", color)

    def _button(self, text: str, run: Callable[[], object]) -> QPushButton:
        # let Enter press this button, because Space pauses the plots
        button = QPushButton(text, autoDefault=True)
        button.clicked.connect(lambda: run())
        self._row.addWidget(button)
        button.show()
        return button


class CodePage(QWidget):
    """Shows the text of one law.

    ``save_pressed`` and ``close_pressed`` are emitted by its buttons, ``unsaved_changed`` when the mark for
    unsaved text changes, and ``opened`` when another text is shown or the page is empty. The check box
    ``count`` shows cycles. ``help_pressed(word)`` requests the page on the law language, at the word under
    the cursor.
    """

    opened = Signal()
    save_pressed = Signal()
    close_pressed = Signal()
    unsaved_changed = Signal()
    help_pressed = Signal(str)

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.path: Path | None = None
        self.code, self.message = CodeEdit(), MessageLine()
        self.name, self.marker = label(role="headline"), label("● Law not saved", "hint", wrap=False)
        self.marker.hide()
        self.save = QPushButton("Save law and run", autoDefault=True)
        self.save.setToolTip("Save the file, test the law and use it (Ctrl+S)")
        self.count = QPushButton("Count cycles", autoDefault=True)
        self.count.setCheckable(True)
        self.count.setToolTip(f"Show how many processor cycles the board needs for each line ({CYCLES_KEY})")
        self.cycles = label(role="hint")
        self.cycles.setContentsMargins(12, 5, 12, 5)
        self.cycles.setToolTip(_CYCLES_TIP)
        self.cycles.hide()
        self.close_law = QToolButton()
        self.close_law.setToolTip("Back to the plots (Ctrl+W)")
        self.close_law.setAccessibleName("Close the law")
        self.language = QToolButton()
        self.language.setToolTip("Explain the language of laws (F1)")
        self.language.setAccessibleName("Explain the language of laws")
        icons.bind(self.save, "play", "accent", 18)
        icons.bind(self.language, "help", "ink2", 18)
        icons.bind(self.close_law, "close", "ink2", 18)
        parts = self.marker, self.count, self.save, self.language, self.close_law
        head = hbox((self.name, 1), *parts, margins=(12, 5, 8, 5), gap=10)
        vbox(head, rule(), self.cycles, (self.code, 1), rule(), self.message, into=self)
        self._draft = QTimer(self, interval=DRAFT_MS, singleShot=True)
        self._draft.timeout.connect(self.keep_draft)
        self.save.clicked.connect(self.save_pressed)
        self.language.clicked.connect(lambda: self.help_pressed.emit(""))
        self.close_law.clicked.connect(self.close_pressed)
        self.code.document().modificationChanged.connect(self._show_marker)
        self.code.textChanged.connect(self._note_typing)

    @property
    def text(self) -> str:
        """Return the current text."""
        return self.code.toPlainText()

    @property
    def counting(self) -> bool:
        """Return True if cycles are shown beside the lines."""
        return self.count.isChecked()

    def show_cycles(self, by_line: Mapping[int, float] | None, text: str) -> None:
        """Show each line's cycles beside it, and a message about the whole law; None removes the cycles."""
        self.code.count(by_line)
        self.show_cycle_text(text)

    def show_cycle_text(self, text: str) -> None:
        """Replace the message about the whole law; the cycles beside the lines do not change."""
        self.cycles.setText(text)
        self.cycles.setVisible(bool(text))

    @property
    def unsaved(self) -> bool:
        """Return True if the text differs from that of the file."""
        return self.path is not None and self.code.document().isModified()

    def open(self, path: Path, text: str) -> None:
        """Show a file's text; if there is a draft, show the draft and mark it as unsaved."""
        self.keep_draft()
        draft = load_draft(path)
        self.path = path
        self.code.setPlainText(text)
        self.code.mark(())
        self.code.count({} if self.counting else None)
        self.name.setText(path.name)
        self.code.setAccessibleName(f"Law, {path.name}")
        if draft is not None and draft != text:
            self.code.selectAll()
            self.code.insertPlainText(draft)  # one undo step returns to the file's text
            message = "Unsaved changes from last time were restored. Ctrl+Z returns to the saved file."
            self.message.show_text(message, "warn")
        else:
            delete_draft(path)
            self.message.show_text("")
        # go to the first line inside the law, because users change it most often
        heads = (n for n, line in enumerate(self.text.splitlines(), 1) if line.startswith("def force("))
        self.code.go_to(next(heads, 0) + 1)
        self.opened.emit()

    def leave(self) -> None:
        """Clear the page; a draft is kept."""
        self.keep_draft()
        self.path = None
        self.code.setPlainText("")
        self.code.mark(())
        self.opened.emit()

    def note_saved(self) -> None:
        """Clear the mark for unsaved text, after the text was saved or discarded."""
        self.code.document().setModified(False)

    def keep_draft(self) -> None:
        """Write unsaved text to the draft immediately."""
        self._draft.stop()
        if self.path is not None and self.unsaved:
            with suppress(OSError):  # on a full or read-only disk there is no draft
                draft_path(self.path).write_text(self.text, encoding="utf-8")

    def event(self, event: QEvent) -> bool:
        """Handle F1 here; otherwise the window would explain its own keys."""
        if isinstance(event, QKeyEvent) and event.key() == Qt.Key.Key_F1:
            if event.type() == QEvent.Type.KeyPress:
                cursor = self.code.textCursor()
                cursor.select(QTextCursor.SelectionType.WordUnderCursor)
                self.help_pressed.emit(cursor.selectedText())
            event.accept()
            return True
        return super().event(event)

    def _note_typing(self) -> None:
        if self.unsaved:
            self._draft.start()

    def _show_marker(self, modified: bool) -> None:
        if not modified and self.path is not None:
            self._draft.stop()
            delete_draft(self.path)
        if modified and self.message.tone in ("", "ok"):
            self.message.show_text("Your changes are not running yet. Ctrl+S saves and runs them.")
        self.marker.setVisible(modified)
        self.unsaved_changed.emit()
