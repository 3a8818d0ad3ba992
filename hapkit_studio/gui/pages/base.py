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
    """A view's page, below the scene; ``column`` is the layout of its widgets.

    ``side`` is an optional widget that replaces the parameter panel while the page is visible. ``beside``:
    the page replaces the gallery and is shown next to the live plots. ``stays``: a page with ``beside`` also
    stays visible in the other views.
    ``marked(text)`` is emitted when the page starts to change the scene (the text describes the change) or
    stops (the text is empty). Until it stops, the view's tab shows a mark.
    ``changed`` is emitted when actions that depend on the page may have to be enabled or disabled.
    ``view_wanted(key)`` asks the window to show a view.
    ``plot_wanted(channel)`` asks the window to plot the force over a channel.
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
        """React to being shown or hidden; a hidden page stops the work that only a visible page needs."""

    def end(self) -> None:
        """Stop timers and background work before the window closes."""
        end_all(self)


@dataclass(frozen=True)
class View:
    """A view in the header. ``scene``: the scene stays visible as a strip above the view's page."""

    key: str
    title: str
    order: int
    build: "Callable[[Studio, Live], Page]"
    scene: bool = True


class Pairs(QWidget):
    """Shows names on the left and values on the right; ``show_pairs`` replaces all of them.

    ``above`` are heading widgets, which are visible only while there are pairs.
    """

    def __init__(self, above: tuple[QWidget, ...] = ()) -> None:
        super().__init__()
        self.pairs: list[tuple[str, str]] = []
        self._above = above
        self.setProperty("form", True)
        self._rows = QGridLayout(self)  # QFormLayout would give too little height to a value of several lines
        self._rows.setContentsMargins(0, 0, 0, 0)
        self._rows.setVerticalSpacing(6)
        self._rows.setColumnStretch(1, 1)
        self.show_pairs([])

    def show_pairs(self, pairs: list[tuple[str, str]]) -> None:
        """Show these pairs in place of the previous ones."""
        self.pairs = pairs
        for old in self.findChildren(QLabel):
            old.setParent(None)  # without a parent, the label is deleted
        for row, (name, value) in enumerate(pairs):
            right = label(value)
            right.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignTop)
            self._rows.addWidget(label(name, "axis", wrap=False), row, 0, Qt.AlignmentFlag.AlignTop)
            self._rows.addWidget(right, row, 1)
        for part in self._above:
            part.setVisible(bool(pairs))


class SidePanel(ScrollColumn):
    """A scrolling column that replaces the parameter panel."""

    def __init__(self, title: str = "", text: str = ""):
        super().__init__()
        self.heading, self.label = label(title, "title"), hint(text)
        self.add(self.heading, self.label)

    def section(self, name: str) -> tuple[QFrame, QLabel]:
        """Add a horizontal line and a section heading; return these two widgets."""
        begun = rule(), label(name, "section")
        self.add(*begun)
        return begun
