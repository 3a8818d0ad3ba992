"""The page a new environment begins on: which template, and what it is called."""

from collections.abc import Iterable, Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QButtonGroup,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from hapkit_studio.gui.editor.strip import Strip
from hapkit_studio.gui.gallery_row import GalleryRow, icon_name
from hapkit_studio.gui.own_file import declared_words
from hapkit_studio.gui.parameter_panel import rule
from hapkit_studio.gui.theme import theme
from hapkit_studio.workshop import folder
from hapkit_studio.workshop.templates import Template

_SIDE = 16
_ICONS = {"two_walls": "wall", "mass_on_a_spring": "mass_spring_damper"}


class Chooser(QWidget):
    """Emits ``made(template, title)`` or ``left``."""

    made = Signal(object, str)
    left = Signal()

    def __init__(self, templates: Sequence[Template], parent: QWidget | None = None):
        super().__init__(parent)
        self._templates, self._taken = tuple(templates), tuple[str, ...]()
        self.heading = QLabel("New environment")
        self.title = QLineEdit()
        self.title.setAccessibleName("Title of the new environment")
        self.title.setMaxLength(40)
        self.make, self.leave = (
            QPushButton("Create", autoDefault=True),
            QPushButton("Cancel", autoDefault=True),
        )
        self.strip = Strip()
        self.group = QButtonGroup(self)
        for index, template in enumerate(self._templates):
            said = declared_words(template.text)
            icon = icon_name(said.get("scene") or _ICONS.get(template.key, template.key))
            row = GalleryRow(icon, template.title.capitalize(), said.get("summary", ""))
            row.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            self.group.addButton(row, index)
        self._arrange()
        self.group.idClicked.connect(self._propose)
        self.title.returnPressed.connect(self._make)
        self.make.clicked.connect(self._make)
        self.leave.clicked.connect(self.left)
        theme.changed.connect(self._show_look)
        self._show_look()
        self.begin()

    def begin(self, taken: Iterable[str] = ()) -> None:
        """Begin anew, with the first template; none of the titles taken is proposed."""
        self._taken = tuple(taken)
        self.group.button(0).setChecked(True)
        self.title.setModified(False)
        self._propose(0)
        self.strip.say("It becomes a Python file of your own, which you can change while you feel it.")
        self.title.setFocus()
        self.title.selectAll()

    def _propose(self, index: int) -> None:
        """Name it after the template until a person has named it."""
        if not self.title.isModified():
            self.title.setText(folder.free_title(f"My {self._templates[index].title.lower()}", self._taken))

    def _make(self) -> None:
        title = self.title.text().strip()
        if title:
            self.made.emit(self._templates[self.group.checkedId()], title)
        else:
            self.strip.say("An environment has a title.", "warn")
            self.title.setFocus()

    def _show_look(self) -> None:
        self.heading.setFont(theme.font("title"))

    def _arrange(self) -> None:
        choices = QGridLayout()
        choices.setSpacing(8)
        for index, row in enumerate(self.group.buttons()):
            choices.addWidget(row, index // 2, index % 2)
        called = QLabel("Title")
        called.setBuddy(self.title)
        line = QHBoxLayout()
        line.setSpacing(8)
        line.addWidget(called)
        line.addWidget(self.title, 1)
        line.addWidget(self.leave)
        line.addWidget(self.make)
        inside = QVBoxLayout()
        inside.setContentsMargins(_SIDE, _SIDE, _SIDE, _SIDE)
        inside.setSpacing(12)
        inside.addWidget(self.heading)
        inside.addLayout(choices)
        inside.addLayout(line)
        inside.addStretch(1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(inside, 1)
        column.addWidget(rule())
        column.addWidget(self.strip)
