"""Small dialogs of the window: keys and words, priority, about, marker."""

from collections.abc import Iterable
from importlib.metadata import version
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFormLayout, QLineEdit, QScrollArea, QWidget

from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.shell.action_set import Action, matches, native
from hapkit_studio.gui.state.recording import Recording
from hapkit_studio.gui.widgets.dialogs import TextDialog, WordsDialog, text_dialog
from hapkit_studio.gui.widgets.glossary import WORDS
from hapkit_studio.gui.widgets.parts import hbox, label, vbox
from hapkit_studio.gui.widgets.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.haptics.priority import Priority

HAND_KEYS = (
    ("Move the hand by 1 mm", "← →"),
    ("Move the hand by 0.1 mm", "Shift+← →"),
    ("Let go of the handle", "↓"),
    ("Change a slider or number by one step", "← → ↑ ↓"),
    ("Change a slider or number by ten steps", "Page Up, Page Down"),
    ("Set a slider or number to min or max", "Home, End"),
    ("Zoom and move the time plots", "Wheel, drag"),
    ("Zoom the time plots vertically", "Ctrl+wheel"),
    ("Explain the law language (code editor)", "F1"),
)
_SHEET_WIDE, _SHEET_HIGH = 520, 380
_LONGEST = 40  # maximum number of letters of a marker; the plots have no space for a longer text


class KeysDialog(TextDialog):
    """Shows all keys, grouped by menu, and the glossary; a search field filters the lines."""

    def __init__(self, actions: Iterable[Action], parent: QWidget | None = None):
        super().__init__("Keys and glossary", parent)
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

    def seek(self, sought: str) -> None:
        """Show only the lines that match the words, and the headings of their groups."""
        for head, lines in self._groups:
            found = [matches(sought, text) for _, text in lines]
            for (row, _), shown in zip(lines, found, strict=True):
                self._form.setRowVisible(row, shown)
            self._form.setRowVisible(head, any(found))

    def _add(self, title: str, lines: Iterable[tuple[str, str]], explained: bool = False) -> None:
        """Add a group of lines: keys and actions or, if ``explained``, terms and explanations."""
        form, rows = self._form, []
        name = label(title, "section")
        name.setContentsMargins(0, 10, 0, 2)
        form.addRow(name)
        head = form.rowCount() - 1
        for text, more in lines:
            if explained:
                part = QWidget()
                vbox(label(text, "strong"), label(more, "axis"), into=part, margins=(0, 2, 0, 4))
                form.addRow(part)
            else:
                form.addRow(text, label(more, "axis", wrap=False))
            rows.append((form.rowCount() - 1, f"{title} {text} {more}"))
        self._groups.append((head, rows))

    def _arrange(self) -> None:
        scroll = QScrollArea()
        scroll.setWidgetResizable(True)
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        scroll.setWidget(self._body)
        scroll.setMinimumSize(theme.px(_SHEET_WIDE), theme.px(_SHEET_HIGH))
        self.column.addWidget(self.field)
        self.column.addWidget(scroll)
        self.column.addLayout(hbox(None, self.leave))


def priority_dialog(found: "Priority", parent: QWidget) -> TextDialog:
    """Return the dialog that shows the loop's real-time priority and how to raise it."""
    more = found.how or "This system allows no higher priority."
    return text_dialog("Real-time priority", [f"The loop runs with: {found.text}.", more], parent)


def about_dialog(parent: QWidget) -> TextDialog:
    """Return the About dialog."""
    text = "Feel, tune and measure virtual environments on a Hapkit, real or simulated."
    return text_dialog(
        "Hapkit Studio", [text, f"Version {version('hapkit-studio')}. Licence: BSD-3-Clause."], parent
    )


class MarkerDialog(WordsDialog):
    """Adds a marker. The marker's time is the time at which the dialog was opened."""

    def __init__(self, recording: Recording, live: Live, parent: QWidget | None = None):
        super().__init__("Add a marker", "A few words (optional)", _LONGEST, self._note, parent)
        self._recording, self._live, self._time = recording, live, live.history.now

    def _note(self, text: str) -> None:
        note = text or "Marker"
        self._live.history.divide(note, self._time)
        self._recording.mark(note, self._time)
