"""Non-modal dialogs for texts, one-line questions and forms."""

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QPoint, QSize, Qt
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QDialog, QFormLayout, QLineEdit, QPushButton, QWidget

from hapkit_studio.gui.widgets import breakpoints
from hapkit_studio.gui.widgets.parts import AnswerLine, hbox, label, primary, vbox
from hapkit_studio.gui.widgets.theme import theme

if TYPE_CHECKING:
    pass

_LINE = 20
# assumed size of the window manager's frame, which is unknown before the window is shown
FRAME = QSize(0, 40)


def on_screen(widget: QWidget, size: tuple[int, int]) -> QSize:
    """Return a new window's size in px, reduced so that the window and its frame fit on the screen."""
    return QSize(*size).boundedTo(widget.screen().availableSize() - FRAME)


class TextDialog(QDialog):
    """A dialog that replaces an open one with the same title; non-modal, because the motor keeps running."""

    def __init__(self, title: str, parent: QWidget | None = None):
        super().__init__(parent)
        self.setWindowTitle(title)
        self.setModal(False)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        for old in parent.findChildren(TextDialog) if parent else ():
            if old is not self and old.isVisible() and old.windowTitle() == title:
                self.move(old.pos())
                old.close()
        self.column = vbox(label(title, "title", wrap=False), into=self, margins=(20, 16, 20, 16), gap=12)
        self.leave = QPushButton("Close")
        self.leave.clicked.connect(self.close)


def text_dialog(title: str, paragraphs: list[str], parent: QWidget | None = None) -> TextDialog:
    """Return a dialog with paragraphs that the user can select and copy."""
    dialog = TextDialog(title, parent)
    for paragraph in paragraphs:
        part = label(paragraph)
        part.setMinimumWidth(460)
        part.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        dialog.column.addWidget(part)
    dialog.column.addLayout(hbox(None, dialog.leave))
    return dialog


class WordsDialog(TextDialog):
    """Asks for at most ``most`` characters and passes them to ``take``; the button's text is ``button``."""

    def __init__(
        self,
        title: str,
        about: str,
        most: int,
        take: Callable[[str], object],
        parent: QWidget | None,
        button: str = "Add",
        text: str = "",
    ):
        super().__init__(title, parent)
        self._take = take
        self.text = QLineEdit(text, maxLength=most, placeholderText=about)
        self.text.selectAll()
        self.text.setAccessibleName(f"Text of the {title.lower()}")
        self.text.setMinimumWidth(320)
        self.add = primary(QPushButton(button))
        self.add.setDefault(True)
        self.add.clicked.connect(self._add)
        self.column.addWidget(self.text)
        self.column.addLayout(hbox(None, self.add, self.leave))

    def _add(self) -> None:
        self._take(self.text.text().strip())
        self.close()


class FormDialog(TextDialog):
    """A dialog to which widgets are added from top to bottom; ``verdict`` is the line with the answer."""

    def __init__(self, title: str, about: str, parent: QWidget | None = None):
        super().__init__(title, parent)
        self.verdict = AnswerLine(margins=(0, 8, 0, 0))
        part = label(about)
        part.setMinimumWidth(520)
        self.column.addWidget(part)

    def showEvent(self, event: QShowEvent) -> None:
        """Open the dialog below the window's banners, so that a fault and its button stay visible.

        The dialog is at most as large as the window.
        """
        super().showEvent(event)
        parent = self.parentWidget()
        if parent is not None and not event.spontaneous():
            self.resize(self.size().boundedTo(parent.window().size()))
            below = theme.px(breakpoints.HEADER_HEIGHT + breakpoints.BANNERS * breakpoints.BANNER_HEIGHT)
            top = parent.window().mapToGlobal(QPoint(0, below)).y()
            if self.y() < top:
                self.move(self.x(), top)

    def add_fields(self, fields: Iterable[tuple[str, QWidget, QWidget | None]]) -> None:
        """Add rows that consist of a label, a widget, and an optional widget on the right."""
        form = QFormLayout()
        form.setHorizontalSpacing(12)
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.setLabelAlignment(Qt.AlignmentFlag.AlignVCenter)
        for text, widget, behind in fields:
            name = label(text, "axis", wrap=False)
            name.setBuddy(widget)
            widget.setAccessibleName(text)
            form.addRow(name, hbox((widget, 1), *([behind] if behind else [])))
        self.column.addLayout(form)

    def add_verdict(self, lines: int) -> None:
        """Add the answer line, with space for ``lines`` lines, so that nothing moves when it is filled."""
        self.verdict.setMinimumHeight(_LINE * lines + 4)
        self.column.addWidget(self.verdict)

    def add_buttons(self, main: QPushButton, left: Sequence[QPushButton] = ()) -> None:
        """Add the row of buttons, with the main and the closing button on the right."""
        self.column.addLayout(hbox(*left, None, primary(main), self.leave))
