"""Base classes of a view: its declaration, its page and its side panel."""

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

    side: optional widget that replaces the parameter panel while the page is visible. ``marked(text)``: the
    page acts on the scene, described by the text, or no longer ("" ); the view's tab shows it. ``changed``:
    actions that depend on the page may have to be enabled or disabled. ``view_wanted(key)``: show a view.
    ``plot_wanted(channel)``: show the plot of force over a channel.
    beside: the page replaces the gallery, beside the live plots. stays: it does so in every view.
    """

    marked = Signal(str)
    changed = Signal()
    view_wanted = Signal(str)
    plot_wanted = Signal(str)

    side: QWidget | None = None
    beside = stays = False

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.column = vbox(into=self)

    def set_shown(self, on: bool) -> None:
        """React to being shown or hidden: work that only a visible page needs stops when hidden."""

    def end(self) -> None:
        """Stop timers and background work before the window closes."""
        end_all(self)


@dataclass(frozen=True)
class View:
    """A view in the header; scene: the scene stays visible as a strip above its page."""

    key: str
    title: str
    order: int
    build: "Callable[[Studio, Live], Page]"
    scene: bool = True


class Pairs(QWidget):
    """Names on the left, values on the right; ``show_pairs`` replaces all of them.

    above: heading widgets, visible only while there are pairs.
    """

    def __init__(self, above: tuple[QWidget, ...] = ()) -> None:
        super().__init__()
        self.pairs: list[tuple[str, str]] = []
        self._above = above
        self.setProperty("form", True)
        self._rows = QGridLayout(self)  # in a QFormLayout a value of several lines gets too little height
        self._rows.setContentsMargins(0, 0, 0, 0)
        self._rows.setVerticalSpacing(6)
        self._rows.setColumnStretch(1, 1)
        self.show_pairs([])

    def show_pairs(self, pairs: list[tuple[str, str]]) -> None:
        """Show these pairs."""
        self.pairs = pairs
        for old in self.findChildren(QLabel):
            old.setParent(None)  # removing the parent deletes the label
        for row, (name, value) in enumerate(pairs):
            right = label(value)
            right.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignTop)
            self._rows.addWidget(label(name, "axis", wrap=False), row, 0, Qt.AlignmentFlag.AlignTop)
            self._rows.addWidget(right, row, 1)
        for part in self._above:
            part.setVisible(bool(pairs))


class SidePanel(ScrollColumn):
    """A scrolling column that replaces the parameter panel."""

    def __init__(self, title: str = "", words: str = ""):
        super().__init__()
        self.heading, self.words = label(title, "title"), hint(words)
        self.add(self.heading, self.words)

    def section(self, name: str) -> tuple[QFrame, QLabel]:
        """Add a rule and a section heading; return both."""
        begun = rule(), label(name, "section")
        self.add(*begun)
        return begun
