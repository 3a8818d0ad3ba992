"""Dialogs beside the work: keys, real-time priority, about, and forms. None of them blocks the window."""

from collections.abc import Iterable, Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING

from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QKeySequence, QShowEvent
from PySide6.QtWidgets import QDialog, QFormLayout, QPushButton, QScrollArea, QWidget

from hapkit_studio.gui import banners, header
from hapkit_studio.gui.actions import Action
from hapkit_studio.gui.widgets.parts import AnswerLine, across, down, label, primary
from hapkit_studio.gui.widgets.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.haptics.priority import Priority

HAND_KEYS = (
    ("Hand 1 mm left, right", "← →"),
    ("Hand 0.1 mm left, right", "Shift+← →"),
    ("Hand lets go", "↓"),
    ("Slider, number: one step", "← → ↑ ↓"),
    ("Slider, number: ten steps", "Page Up, Page Down"),
    ("Slider, number: limits", "Home, End"),
)
_LINE = 20


class TextDialog(QDialog):
    """A window of words that stays beside the work; its motor goes on, so it never blocks.

    A second one of the same title takes the place of the first.
    """

    def __init__(self, title: str, parent: QWidget | None = None):
        super().__init__(parent)
        self.setWindowTitle(title)
        self.setModal(False)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        for old in parent.findChildren(TextDialog) if parent else ():
            if old is not self and old.isVisible() and old.windowTitle() == title:
                self.move(old.pos())
                old.close()
        self.column = down(label(title, "title", wrap=False), into=self, margins=(20, 16, 20, 16), gap=12)
        self.leave = QPushButton("Close")
        self.leave.clicked.connect(self.close)


def native(key: str) -> str:
    """Return a key as this system writes it."""
    return QKeySequence(key).toString(QKeySequence.SequenceFormat.NativeText)


def keys_dialog(actions: tuple[Action, ...], parent: QWidget | None = None) -> TextDialog:
    """Return the dialog of all keys, made from the action table."""
    dialog = TextDialog("Keys", parent)
    lines = [(a.text, ", ".join(native(k) for k in a.keys)) for a in actions if a.keys]
    body = QWidget()
    form = QFormLayout(body)
    form.setContentsMargins(0, 0, 12, 0)
    form.setHorizontalSpacing(28)
    form.setVerticalSpacing(4)
    for words, keys in [*lines, *HAND_KEYS]:
        form.addRow(words, label(keys, "axis", wrap=False))
    scroll = QScrollArea()
    scroll.setWidgetResizable(True)
    scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    scroll.setWidget(body)
    scroll.setMinimumWidth(body.sizeHint().width() + 16)
    scroll.setMinimumHeight(min(body.sizeHint().height() + 4, 420))
    dialog.column.addWidget(scroll)
    dialog.column.addLayout(across(None, dialog.leave))
    return dialog


def text_dialog(title: str, paragraphs: list[str], parent: QWidget | None = None) -> TextDialog:
    """Return a dialog of paragraphs that can be selected and copied."""
    dialog = TextDialog(title, parent)
    for paragraph in paragraphs:
        words = label(paragraph)
        words.setMinimumWidth(460)
        words.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        dialog.column.addWidget(words)
    dialog.column.addLayout(across(None, dialog.leave))
    return dialog


def priority_dialog(found: "Priority", parent: QWidget) -> TextDialog:
    """Return the dialog on what the loop has obtained from the system, and how to get more."""
    more = found.how or "This is the most this system gives."
    return text_dialog("Real-time priority", [f"The loop has obtained: {found.text}.", more], parent)


def about_dialog(parent: QWidget) -> TextDialog:
    """Return the dialog on the studio itself."""
    text = "Feel, tune and measure virtual environments on a Hapkit, real or simulated."
    return text_dialog("Hapkit Studio", [text, f"Version {version('hapkit-studio')}, BSD-3-Clause."], parent)


class FormDialog(TextDialog):
    """Parts are added from top to bottom; ``verdict`` is the answer line."""

    def __init__(self, title: str, about: str, parent: QWidget | None = None):
        super().__init__(title, parent)
        self.verdict = AnswerLine(margins=(0, 8, 0, 0))
        words = label(about)
        words.setMinimumWidth(520)
        self.column.addWidget(words)

    def showEvent(self, event: QShowEvent) -> None:
        """Open below the window's banners: a fault, and what clears it, stay in sight."""
        super().showEvent(event)
        parent = self.parentWidget()
        if parent is not None and not event.spontaneous():
            below = theme.px(header.HEIGHT + banners.MOST * banners.HEIGHT)
            top = parent.window().mapToGlobal(QPoint(0, below)).y()
            if self.y() < top:
                self.move(self.x(), top)

    def add_fields(self, fields: Iterable[tuple[str, QWidget, QWidget | None]]) -> None:
        """Add rows of a label, a widget, and what stands behind it."""
        form = QFormLayout()
        form.setHorizontalSpacing(12)
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.setLabelAlignment(Qt.AlignmentFlag.AlignVCenter)
        for words, widget, behind in fields:
            name = label(words, "axis", wrap=False)
            name.setBuddy(widget)
            widget.setAccessibleName(words)
            form.addRow(name, across((widget, 1), *([behind] if behind else [])))
        self.column.addLayout(form)

    def add_verdict(self, lines: int) -> None:
        """Add the answer line with room for so many lines, so that nothing moves when it comes."""
        self.verdict.setMinimumHeight(_LINE * lines + 4)
        self.column.addWidget(self.verdict)

    def add_buttons(self, main: QPushButton, left: Sequence[QPushButton] = ()) -> None:
        """Add the row of buttons, the one that does it and the closing one at the right."""
        self.column.addLayout(across(*left, None, primary(main), self.leave))
