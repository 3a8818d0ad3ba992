"""What a view is: its name, and a page that measures and shows."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QVBoxLayout, QWidget

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.studio import Studio


def filled(*parts: QWidget) -> QFrame:
    """Return a card with parts below one another; the last one takes the room."""
    frame = QFrame()
    frame.setProperty("card", True)
    column = QVBoxLayout(frame)
    column.setContentsMargins(1, 1, 1, 1)
    column.setSpacing(0)
    for part in parts:
        column.addWidget(part, int(part is parts[-1]))
    return frame


class Page(QWidget):
    """A tab's page, below the scene; ``column`` holds its parts.

    side, if any, stands in the place of the parameter panel while the page is in sight. ``marked(words)``: it
    acts on the scene, and how; "" for not any more. Its tab says so in every view.
    """

    marked = Signal(str)

    side: QWidget | None = None

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.column = QVBoxLayout(self)
        self.column.setContentsMargins(0, 0, 0, 0)
        self.column.setSpacing(0)

    def set_shown(self, on: bool) -> None:
        """Come into sight, or leave it: what costs time while nobody looks stops here."""

    def set_room(self, width: int, height: int) -> None:
        """Lay out for the room there is."""

    def end(self) -> None:
        """End what still runs; the window is about to close."""


@dataclass(frozen=True)
class View:
    """A view of the header; scene: whether the scene stays in sight above its page as a strip."""

    key: str
    title: str
    order: int
    build: "Callable[[Studio, Live], Page]"
    scene: bool = True
