"""Dialogs beside the work: keys, priority, about, markers, forms. None of them blocks the window."""

from collections.abc import Callable, Iterable, Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING

from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QDialog, QFormLayout, QLineEdit, QPushButton, QScrollArea, QWidget

from hapkit_studio.gui import banners, header
from hapkit_studio.gui.action_set import Action, matches, native
from hapkit_studio.gui.glossary import WORDS
from hapkit_studio.gui.widgets.parts import AnswerLine, across, down, label, primary
from hapkit_studio.gui.widgets.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.recording import Recording
    from hapkit_studio.haptics.priority import Priority

HAND_KEYS = (
    ("Hand 1 mm left, right", "← →"),
    ("Hand 0.1 mm left, right", "Shift+← →"),
    ("Hand lets go", "↓"),
    ("Slider, number: one step", "← → ↑ ↓"),
    ("Slider, number: ten steps", "Page Up, Page Down"),
    ("Slider, number: limits", "Home, End"),
    ("Time plots: zoom, move", "Wheel, drag"),
    ("Time plots: zoom into values", "Ctrl+wheel"),
    ("Code: the law language", "F1"),
)
_LINE = 20
_SHEET_WIDE, _SHEET_HIGH = 520, 440
_LONGEST = 40  # letters of a marker: what finds room beside its divider


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


class KeysDialog(TextDialog):
    """All keys, in groups as in the menus, and the window's words; a search leaves what has its words."""

    def __init__(self, actions: Iterable[Action], parent: QWidget | None = None):
        super().__init__("Keys", parent)
        self.field = QLineEdit(placeholderText="Find a key or a word")
        self.field.setAccessibleName("Find a key or a word")
        self.field.textChanged.connect(self.seek)
        self._body = QWidget()
        self._form = form = QFormLayout(self._body)
        form.setContentsMargins(0, 0, 12, 0)
        form.setHorizontalSpacing(28)
        form.setVerticalSpacing(4)
        self._groups: list[tuple[int, list[tuple[int, str]]]] = []
        keyed = [action for action in actions if action.keys]
        for menu in dict.fromkeys(action.menu.partition("/")[0] for action in keyed):
            own = (action for action in keyed if action.menu.partition("/")[0] == menu)
            self._add(menu, ((action.text, ", ".join(map(native, action.keys))) for action in own))
        self._add("Hand, sliders, numbers and plots", HAND_KEYS)
        self._add("Words", WORDS.items(), explained=True)
        self._arrange()

    def seek(self, words: str) -> None:
        """Leave only the lines that have the words, and the heads of their groups."""
        for head, lines in self._groups:
            found = [matches(words, text) for _, text in lines]
            for (row, _), shown in zip(lines, found, strict=True):
                self._form.setRowVisible(row, shown)
            self._form.setRowVisible(head, any(found))

    def _add(self, title: str, lines: Iterable[tuple[str, str]], explained: bool = False) -> None:
        """Add a group: keys stand beside what they do, an explanation below its word."""
        form, rows = self._form, []
        name = label(title, "section")
        name.setContentsMargins(0, 10, 0, 2)
        form.addRow(name)
        head = form.rowCount() - 1
        for words, more in lines:
            if explained:
                part = QWidget()
                down(label(words, "strong"), label(more, "axis"), into=part, margins=(0, 2, 0, 4))
                form.addRow(part)
            else:
                form.addRow(words, label(more, "axis", wrap=False))
            rows.append((form.rowCount() - 1, f"{title} {words} {more}"))
        self._groups.append((head, rows))

    def _arrange(self) -> None:
        scroll = QScrollArea()
        scroll.setWidgetResizable(True)
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        scroll.setWidget(self._body)
        scroll.setMinimumSize(theme.px(_SHEET_WIDE), theme.px(_SHEET_HIGH))
        self.column.addWidget(self.field)
        self.column.addWidget(scroll)
        self.column.addLayout(across(None, self.leave))


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


class WordsDialog(TextDialog):
    """Asks for at most ``most`` characters and passes them to ``take``; ``button`` names what that does."""

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
        self.column.addLayout(across(None, self.add, self.leave))

    def _add(self) -> None:
        self._take(self.text.text().strip())
        self.close()


class MarkerDialog(WordsDialog):
    """Notes the moment in which it was opened, however long the words take."""

    def __init__(self, recording: "Recording", live: "Live", parent: QWidget | None = None):
        super().__init__("Marker", "A few words, or none", _LONGEST, self._note, parent)
        self._recording, self._live, self._time = recording, live, live.history.now

    def _note(self, text: str) -> None:
        words = text or "Marker"
        self._live.history.divide(words, self._time)
        self._recording.mark(words, self._time)


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
