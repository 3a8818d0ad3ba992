"""The gallery's rows below the library: a person's own environments, and the way to a new one."""

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QContextMenuEvent, QPainter, QPen, QResizeEvent
from PySide6.QtWidgets import QMenu, QToolButton, QWidget

from hapkit_studio.gui import icons
from hapkit_studio.gui.gallery_row import LEAST_ROW, GalleryRow, icon_name
from hapkit_studio.gui.own_file import OwnFile
from hapkit_studio.gui.rich import plain_tip
from hapkit_studio.gui.theme import theme

# state: the icon that says it, the line that says it
_SIGNS = {"foreign": "lock", "broken": "triangle"}
_LINES = {"foreign": "From someone else", "broken": "Does not run yet", "checking": "Checking line by line…"}
_PENCIL, _RING, _LEAST = 30, 28, 120


def initials(title: str) -> str:
    """Return up to two letters that tell one title from another: "My two walls" is MW."""
    words = [word for word in title.split() if word[0].isalnum()]
    return "".join(word[0] for word in (words[:1] + words[1:][-1:])).upper()


class OwnRow(GalleryRow):
    """One own environment; the pencil, or the menu, leads to its law."""

    edit_pressed = Signal(object)
    reveal_pressed = Signal(object)
    delete_pressed = Signal(object)

    def __init__(self, file: OwnFile, parent: QWidget | None = None):
        self.file = file
        super().__init__("circle", file.title, "", parent=parent)
        self.pencil = QToolButton(self)
        self.pencil.setFixedSize(_PENCIL, _PENCIL)
        self.pencil.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # keys have the menu
        self.setAccessibleDescription("The menu key edits, shows or deletes its file.")
        self.pencil.clicked.connect(lambda: self.edit_pressed.emit(self.file.path))
        icons.bind(self.pencil, "pencil", "ink2", 18)
        self.show_file(file)

    def show_file(self, file: OwnFile) -> None:
        """Show how the file stands."""
        self.file = file
        self.set_words(
            _SIGNS.get(file.state, icon_name(file.scene)), file.title, _LINES.get(file.state, file.summary)
        )
        self.pencil.setToolTip(plain_tip(f"Edit {file.path.name}"))
        self.pencil.setAccessibleName(f"Edit {file.title}")

    def set_rail(self, rail: bool, height: int) -> None:
        super().set_rail(rail, height)
        if not rail:
            self.setToolTip(plain_tip(f"{self.title}\n{self.summary}\n{self.file.path.name}"))
        if hasattr(self, "pencil"):
            self.pencil.setVisible(not rail and self.file.state != "foreign")

    def sizeHint(self) -> QSize:
        """Take what the gallery gives: words of a stranger's length are cut, the tooltip has them whole."""
        return super().sizeHint().boundedTo(QSize(_LEAST, LEAST_ROW))

    def _paint_icon(self, painter: QPainter, color: str) -> None:
        """Draw a ring with initials where the file names no scene: a rail has no room for more."""
        if self.picture != "circle":
            super()._paint_icon(painter, color)
            return
        ring = QRectF(10 if self.rail else 8, (self.height() - _RING) / 2, _RING, _RING)
        painter.setPen(QPen(theme.color(color), 1.75))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawEllipse(ring)
        painter.setFont(theme.font("label"))
        painter.drawText(ring, Qt.AlignmentFlag.AlignCenter, initials(self.title))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.pencil.move(self.width() - _PENCIL - 8, (self.height() - _PENCIL) // 2)

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        self.menu().popup(event.globalPos())

    def menu(self) -> QMenu:
        """Return what can be done with the file."""
        menu = QMenu(self)
        entries: list[tuple[str, Callable[[object], None]]] = [
            ("Show in folder", self.reveal_pressed.emit),
            ("Delete…", self.delete_pressed.emit),
        ]
        if self.file.state != "foreign":
            entries.insert(0, ("Edit", self.edit_pressed.emit))
        for words, tell in entries:
            menu.addAction(words, partial(tell, self.file.path))
        return menu


class NewRow(GalleryRow):
    """The last line: it makes a new environment."""

    color = "accent"

    def __init__(self, parent: QWidget | None = None):
        super().__init__("plus", "New environment…", "", parent=parent)
        self.setCheckable(False)
