"""What a view is: its name, a page that measures and shows, and the panel at its side."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QGridLayout, QLabel, QScrollArea, QVBoxLayout, QWidget

from hapkit_studio.gui.panel.parameter_panel import rule
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.text import plain

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
    """A view's page, below the scene; ``column`` holds its parts.

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
        """React to being shown or hidden: work that only a visible page needs stops when hidden."""

    def set_room(self, width: int, height: int) -> None:
        """Adapt the layout to the page's size in px."""

    def end(self) -> None:
        """Cancel running work before the window closes."""


@dataclass(frozen=True)
class View:
    """A view of the header; scene: whether the scene stays in sight above its page as a strip."""

    key: str
    title: str
    order: int
    build: "Callable[[Studio, Live], Page]"
    scene: bool = True


_EDGE, _TOP = 16, 12


def hint(text: str = "") -> QLabel:
    """Return a label for a hint, its text wrapped."""
    label = plain(QLabel(text))
    label.setWordWrap(True)
    label.setProperty("role", "hint")
    return label


class Pairs(QWidget):
    """Names at the left, values at the right; ``show_pairs`` replaces all of them."""

    def __init__(self) -> None:
        super().__init__()
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setVerticalSpacing(6)
        self._grid.setColumnStretch(1, 1)
        self._labels: list[tuple[QLabel, QLabel]] = []
        self._above: tuple[QWidget, ...] = ()

    def stand_under(self, above: tuple[QWidget, ...]) -> None:
        """Show a section's rule and name only while there are pairs below them; there are none yet."""
        self._above = above
        self.show_pairs([])

    def show_pairs(self, pairs: list[tuple[str, str]]) -> None:
        """Show these pairs from top to bottom."""
        while len(self._labels) < len(pairs):
            self._append()
        for row, labels in enumerate(self._labels):
            for column, label in enumerate(labels):
                label.setVisible(row < len(pairs))
                label.setText(pairs[row][column] if row < len(pairs) else "")
        for part in self._above:
            part.setVisible(bool(pairs))

    def _append(self) -> None:
        row, name, value = len(self._labels), plain(QLabel()), plain(QLabel())
        dress(name, "QLabel { color: @ink2; }")
        value.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignTop)
        value.setWordWrap(True)
        self._grid.addWidget(name, row, 0, Qt.AlignmentFlag.AlignTop)
        self._grid.addWidget(value, row, 1)
        self._labels.append((name, value))


class SidePanel(QScrollArea):
    """A scrolling column in the parameter panel's place; parts are added from top to bottom."""

    def __init__(self, title: str, words: str = ""):
        super().__init__()
        self.setObjectName("panel")
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.heading, self.words = QLabel(title), hint(words)
        self.heading.setWordWrap(True)
        dress(self.heading, "QLabel { font-size: 18px; font-weight: 650; }")
        body = QWidget()
        body.setObjectName("panelBody")
        self._column = QVBoxLayout(body)
        self._column.setContentsMargins(_EDGE, _TOP, _EDGE, _TOP)
        self._column.setSpacing(8)
        self._column.addWidget(self.heading)
        self._column.addWidget(self.words)
        self._column.addStretch(1)
        self.setWidget(body)

    def add(self, widget: QWidget) -> None:
        """Add a part at the bottom."""
        self._column.insertWidget(self._column.count() - 1, widget)

    def section(self, name: str) -> tuple[QWidget, ...]:
        """Add a rule and a section's name; return both."""
        heading = QLabel(name)
        heading.setProperty("role", "section")
        begun = rule(), heading
        for part in begun:
            self.add(part)
        return begun
