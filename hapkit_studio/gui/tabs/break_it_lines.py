"""How the lines of a failure's chart look, and their key above it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QFontMetrics, QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.tabs import marks
from hapkit_studio.gui.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.analysis.failures import Line

_SAMPLE, _GAP, _BETWEEN, _ROW = 26, 6, 14, 19


@dataclass(frozen=True)
class Look:
    """Token, dash and marker of one line; no dash and a marker: points alone."""

    token: str
    dash: list[float] | None
    marker: str = ""
    width: float = 2.0


_LOOKS = {
    "theory": (
        Look("ink", [3.2, 2.0], width=2.2),
        Look("asked", [5.0, 2.0]),
        Look("energy", [5.0, 2, 1.2, 2]),
    ),
    "measured": (
        Look("position", None, "circle"),
        Look("velocity", None, "square"),
        Look("applied", None, "up"),
    ),
    "other": (Look("hold", [1.4, 2.2]), Look("energy", [5.0, 2.0, 1.2, 2.0]), Look("asked", [1.4, 2.2])),
}


_LEVEL = Look("ink3", None, width=1.2)


def looks(lines: "Sequence[Line]") -> list[Look]:
    """Return how each line is drawn: by its role, the second of a role unlike the first."""
    seen: dict[str, int] = {}
    found = []
    for line in lines:
        choice = _LOOKS[line.role]
        found.append(choice[seen.get(line.role, 0) % len(choice)])
        seen[line.role] = seen.get(line.role, 0) + 1
    return found


class Key(QWidget):
    """What runs up, then samples of the lines with their names, in as many rows as the width needs."""

    def __init__(self) -> None:
        super().__init__()
        self._entries: list[tuple[Look | None, str]] = []
        theme.changed.connect(self.update)

    def show_lines(self, up: str, lines: "Sequence[Line]", level: str = "") -> None:
        """Show these names; level is the one of the line at which it begins to fail."""
        pairs = zip(looks(lines), (line.label for line in lines), strict=True)
        last = [(_LEVEL, level)] if level else []
        self._entries = [(None, up), *pairs, *last] if up else []
        self.setAccessibleName(", ".join(name for _, name in self._entries))
        self.update()

    def needed(self, width: int) -> int:
        """Return the height that its rows take."""
        places = self._places(width)
        return round(places[-1].bottom()) + 1 if places else _ROW

    def _places(self, width: int) -> list[QRectF]:
        x, y, found = 0.0, 0.0, []
        for look, name in self._entries:
            metrics = QFontMetrics(theme.font("hint" if look else "label"))
            wide = metrics.horizontalAdvance(name) + 2.0 + (_SAMPLE + _GAP if look else 0.0)
            if x > 0.0 and x + wide > width:
                x, y = 0.0, y + _ROW
            found.append(QRectF(x, y, wide, _ROW))
            x += wide + _BETWEEN
        return found

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for (look, name), box in zip(self._entries, self._places(self.width()), strict=True):
            if look:
                self._paint_sample(painter, look, box)
                box.setLeft(box.left() + _SAMPLE + _GAP)
            painter.setFont(theme.font("hint" if look else "label"))
            painter.setPen(theme.color("axis" if look else "ink"))
            words = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft
            painter.drawText(box.adjusted(0, 0, 4, 0), words, name)

    @staticmethod
    def _paint_sample(painter: QPainter, look: Look, box: QRectF) -> None:
        y = box.center().y()
        if look.marker:
            at = QPointF(box.left() + _SAMPLE / 2, y)
            marks.marker(painter, look.marker, at, look.token, 4.5, False)
        else:
            ends = [QPointF(box.left(), y), QPointF(box.left() + _SAMPLE, y)]
            marks.line(painter, ends, look.token, look.width, look.dash)
