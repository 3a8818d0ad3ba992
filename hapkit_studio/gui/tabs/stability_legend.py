"""What each line of the map means: a sample, its name, one line of explanation."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRectF, QSize
from PySide6.QtGui import QPainter, QPaintEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from hapkit_studio.gui.tabs.marks import DASH_DOT, DOT, line, marker
from hapkit_studio.gui.tabs.side import hint
from hapkit_studio.gui.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.analysis.plane import Plane

_SAMPLE = QSize(26, 18)
# Lines: token, width, dash; the others are drawn as marks.
_DRAWN: dict[str, tuple[str, float, list[float] | None]] = {
    "exact": ("ink", 3.0, None),
    "hands": ("ink2", 1.6, None),
    "simple": ("asked", 2.0, DOT),
    "passive": ("velocity", 2.0, DASH_DOT),
    "coulomb": ("warn", 2.0, [6.0, 3.0]),
}
_FILLED = {"buzzes": "warnsoft"}


class Sample(QWidget):
    """A line or mark as the map draws it."""

    def __init__(self, key: str):
        super().__init__()
        self._key = key
        self.setFixedSize(_SAMPLE)
        theme.changed.connect(self.update)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = QPointF(0.5 * self.width(), 0.5 * self.height())
        if self._key in _DRAWN:
            token, width, dash = _DRAWN[self._key]
            line(painter, [QPointF(0.0, middle.y()), QPointF(self.width(), middle.y())], token, width, dash)
        elif self._key in _FILLED:
            painter.setPen(theme.color("edge"))
            painter.setBrush(theme.color(_FILLED[self._key]))
            painter.drawRect(QRectF(middle.x() - 7.0, middle.y() - 6.0, 14.0, 12.0))
        else:
            token = "applied" if self._key == "controlled" else "position"
            marker(painter, "circle", middle, token, 6.0, filled=False)


class Row(QWidget):
    """One line's sample, name and explanation; folded, the explanation is the tooltip."""

    def __init__(self, key: str):
        super().__init__()
        self.name, self.words = QLabel(), hint()
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Maximum)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(12)
        top = QVBoxLayout()
        top.addWidget(Sample(key))
        top.addStretch(1)
        row.addLayout(top)
        column = QVBoxLayout()
        column.setSpacing(0)
        column.addWidget(self.name)
        column.addWidget(self.words)
        row.addLayout(column, 1)
        self._parts = row, column

    def show_words(self, name: str, words: str) -> None:
        """Name the line and explain it."""
        self.name.setText(name)
        self.words.setText(words)
        self.setToolTip(words)

    def fold(self, on: bool) -> None:
        """Leave the explanation to the tooltip; the height is another at once."""
        self.words.setVisible(not on)
        for layout in self._parts:
            layout.invalidate()
        self.updateGeometry()


class Legend(QWidget):
    """The lines that there are, from top to bottom."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: dict[str, Row] = {}
        self._folded = False
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(8)
        for key in ("exact", "hands", "measured", "controlled", "buzzes", "simple", "passive", "coulomb"):
            self.rows[key] = Row(key)
            self._column.addWidget(self.rows[key])
        self.show_lines({})

    def show_lines(self, words: dict[str, tuple[str, str]]) -> None:
        """Show these lines, by key: name and explanation."""
        for key, row in self.rows.items():
            row.setVisible(key in words)
            if key in words:
                row.show_words(*words[key])

    def fold(self, on: bool) -> None:
        """Leave the explanations to the tooltips."""
        self._column.setSpacing(3 if on else 8)
        for row in self.rows.values():
            row.fold(on)
        self._column.invalidate()
        self.updateGeometry()


def legend_words(plane: "Plane", shown: dict[str, bool]) -> dict[str, tuple[str, str]]:
    """Return name and explanation of the lines that are seen; shown: what is measured, and every hand."""
    from hapkit_studio.analysis.plane_words import line

    wanted = {
        "exact": plane.setting.linear,
        "hands": shown["hands"],
        "measured": shown["measured"],
        "controlled": shown["controlled"],
        "buzzes": shown["buzzes"],
        "simple": True,
        "passive": bool(plane.edge.any()),
        "coulomb": plane.coulomb < plane.top,
    }
    seen = "Measured, controlled" if shown["controlled_seen"] else "Controlled: above this map"
    own = {
        "hands": ("Other hands", "light, medium and firm grip"),
        "controlled": (seen, "measured with the passivity controller"),
    }
    return {key: own[key] if key in own else line(plane, key) for key, on in wanted.items() if on}
