"""What a view is: its name, a page that measures and shows, and the panel at its side."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QGridLayout, QLabel, QWidget

from hapkit_studio.gui.state.background import end_all
from hapkit_studio.gui.widgets.parts import ScrollColumn, hint, label, rule, vbox

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.state.studio import Studio


class Page(QWidget):
    """A view's page, below the scene; ``column`` holds its parts.

    side, if any, stands in the place of the parameter panel while the page is in sight. ``marked(words)``: it
    acts on the scene, and how; "" for not any more. Its tab says so in every view. ``changed``: actions that
    depend on the page may be enabled or disabled now.
    """

    marked = Signal(str)
    changed = Signal()

    side: QWidget | None = None

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.column = vbox(into=self)

    def set_shown(self, on: bool) -> None:
        """React to being shown or hidden: work that only a visible page needs stops when hidden."""

    def end(self) -> None:
        """End timers and background work before the window closes."""
        end_all(self)


@dataclass(frozen=True)
class View:
    """A view of the header; scene: whether the scene stays in sight above its page as a strip."""

    key: str
    title: str
    order: int
    build: "Callable[[Studio, Live], Page]"
    scene: bool = True


class Pairs(QWidget):
    """Names at the left, values at the right; ``show_pairs`` replaces all of them.

    above: what names them, shown only while there are any.
    """

    def __init__(self, above: tuple[QWidget, ...] = ()) -> None:
        super().__init__()
        self.pairs: list[tuple[str, str]] = []
        self._above = above
        self.setProperty("form", True)
        self._rows = QGridLayout(self)  # a QFormLayout gives a value on several lines too little height
        self._rows.setContentsMargins(0, 0, 0, 0)
        self._rows.setVerticalSpacing(6)
        self._rows.setColumnStretch(1, 1)
        self.show_pairs([])

    def show_pairs(self, pairs: list[tuple[str, str]]) -> None:
        """Show these pairs from top to bottom."""
        self.pairs = pairs
        for old in self.findChildren(QLabel):
            old.setParent(None)  # deletes it
        for row, (name, value) in enumerate(pairs):
            right = label(value)
            right.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignTop)
            self._rows.addWidget(label(name, "axis", wrap=False), row, 0, Qt.AlignmentFlag.AlignTop)
            self._rows.addWidget(right, row, 1)
        for part in self._above:
            part.setVisible(bool(pairs))


class SidePanel(ScrollColumn):
    """A scrolling column in the parameter panel's place; parts are added from top to bottom."""

    def __init__(self, title: str = "", words: str = ""):
        super().__init__()
        self.heading, self.words = label(title, "title"), hint(words)
        self.add(self.heading, self.words)

    def section(self, name: str) -> tuple[QFrame, QLabel]:
        """Add a rule and a section's name; return both."""
        begun = rule(), label(name, "section")
        self.add(*begun)
        return begun
