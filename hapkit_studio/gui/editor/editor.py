"""The editor, which replaces the plots.

It has pages for a new law, for code, and for another person's file.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path

from PySide6 import QtWidgets
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QLabel, QPushButton, QWidget

from hapkit_studio.gui.editor.code_edit import CodeEdit
from hapkit_studio.gui.editor.code_page import CodePage, MessageLine
from hapkit_studio.gui.state.own_environments import declared_texts
from hapkit_studio.gui.widgets.gallery_row import GalleryRow, icon_name
from hapkit_studio.gui.widgets.parts import Sign, hbox, label, rule, vbox
from hapkit_studio.workshop import folder
from hapkit_studio.workshop.folder import Template
from hapkit_studio.workshop.source import Source

_ICONS = {"two_walls": "wall", "mass_on_a_spring": "mass_spring_damper"}
_ASK = (
    "This file is a program and can do anything that a program can do. Run it only if you know where "
    "it comes from."
)


class Chooser(QWidget):
    """The page with the templates; emits ``made(template, title)`` or ``left``."""

    made = Signal(object, str)
    left = Signal()

    def __init__(self, templates: Sequence[Template], parent: QWidget | None = None):
        super().__init__(parent)
        self._templates, self._taken = tuple(templates), tuple[str, ...]()
        self.title = QtWidgets.QLineEdit(maxLength=40)
        self.title.setAccessibleName("Title of the new environment")
        self.make = QPushButton("Create environment", autoDefault=True)
        self.leave = QPushButton("Cancel", autoDefault=True)
        self.message = MessageLine()
        self.group = QtWidgets.QButtonGroup(self)
        for index, template in enumerate(self._templates):
            declared = declared_texts(template.text)
            icon = icon_name(declared.get("scene") or _ICONS.get(template.key, template.key))
            row = GalleryRow(icon, template.title.capitalize(), declared.get("summary", ""))
            row.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            self.group.addButton(row, index)
        self._arrange()
        self.group.idClicked.connect(self._propose)
        self.title.returnPressed.connect(self._make)
        self.make.clicked.connect(self._make)
        self.leave.clicked.connect(self.left)
        self.begin()

    def begin(self, taken: Iterable[str] = ()) -> None:
        """Select the first template; do not propose a title in ``taken``."""
        self._taken = tuple(taken)
        self.group.button(0).setChecked(True)
        self.title.setModified(False)
        self._propose(0)
        self.message.show_text(
            "This creates a Python file of your own. You can edit the law while you feel its force."
        )
        self.title.setFocus()
        self.title.selectAll()

    def _propose(self, index: int) -> None:
        """Propose the template's name, unless the user has entered a name."""
        if not self.title.isModified():
            self.title.setText(folder.free_title(f"My {self._templates[index].title.lower()}", self._taken))

    def _make(self) -> None:
        title = self.title.text().strip()
        if title:
            self.made.emit(self._templates[self.group.checkedId()], title)
        else:
            self.message.show_text("Enter a title for the environment first.", "warn")
            self.title.setFocus()

    def _arrange(self) -> None:
        choices = QtWidgets.QGridLayout()
        choices.setSpacing(8)
        for index, row in enumerate(self.group.buttons()):
            choices.addWidget(row, index // 2, index % 2)
        called = QLabel("Title of the environment")
        called.setBuddy(self.title)
        line = hbox(called, (self.title, 1), self.leave, self.make)
        heading = label("New environment", "title")
        inside = vbox(heading, choices, line, None, margins=(16, 16, 16, 16), gap=12)
        vbox((inside, 1), rule(), self.message, into=self)


class SourcePage(QWidget):
    """The page with another person's file; emits ``run_pressed`` with the shown source, or ``left``."""

    run_pressed = Signal(object)
    left = Signal()

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.source = Source(Path(), "", "")
        self.title, self.ask = label(role="headline"), label(_ASK)
        self.code = CodeEdit()
        self.code.setReadOnly(True)
        self.run = QPushButton("Run this file", autoDefault=True)
        self.leave = QPushButton("Do not run this file", autoDefault=True)
        self.run.clicked.connect(lambda: self.run_pressed.emit(self.source))
        self.leave.clicked.connect(self.left)
        head = QWidget()
        head.setObjectName("foreign")
        column = vbox(self.title, self.ask, gap=2)
        row = (Sign(24, "lock", "warn"), (column, 1), self.leave, self.run)
        hbox(*row, into=head, margins=(12, 8, 12, 8), gap=12)
        vbox(head, rule(), (self.code, 1), into=self)

    def show_source(self, source: Source) -> None:
        """Show an untrusted file."""
        self.source, name = source, source.path.name
        self.title.setText(f"{name} was written by someone else, or was changed outside the studio.")
        self.code.setPlainText(source.text)
        self.code.setAccessibleName(f"Text of {name}, which cannot be edited here")


class Editor(QtWidgets.QStackedWidget):
    """Shows one of its pages at a time."""

    def __init__(self, templates: Sequence[Template], parent: QWidget | None = None):
        super().__init__(parent)
        self.setProperty("card", True)
        self.setContentsMargins(1, 1, 1, 1)
        self.chooser, self.page, self.source = Chooser(templates), CodePage(), SourcePage()
        for page in (self.chooser, self.page, self.source):
            self.addWidget(page)
