"""Set against found: a row a term, its interval below its name, told apart by words where nothing is told."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.analysis.identify import Estimate, Part

_ROW, _HEAD = 46, 22


def whole(text: str) -> str:
    """Keep numbers and their units on one line."""
    return text.replace(" N", "\u00a0N").replace("/m", "/\u2060m").replace(" %", "\u00a0%")


class EstimateTable(QWidget):
    """Names at the left; what was set and, below it, what was found at the right."""

    def __init__(self) -> None:
        super().__init__()
        self._estimates: tuple[Estimate, ...] = ()
        self._heads = ("Set", "Rendered")
        self.setAccessibleName("What was set and what was found")
        theme.changed.connect(self.update)

    def show_part(self, part: "Part | None") -> None:
        """List a part's estimates, None for nothing."""
        self._estimates = part.estimates if part else ()
        handle = part is not None and part.key == "handle"
        self._heads = ("Has", "Identified") if handle else ("Set", "Rendered")
        self.setFixedHeight(_HEAD + _ROW * len(self._estimates) if self._estimates else 0)
        self.setAccessibleDescription("; ".join(self.words(e) for e in self._estimates))
        self.update()

    def words(self, estimate: "Estimate") -> str:
        """Return a row as one line."""
        return f"{estimate.term.label}: {self._heads[0]} {self._asked(estimate)}, {self._found(estimate)}"

    def _asked(self, estimate: "Estimate") -> str:
        from hapkit_studio.analysis.identify import words

        asked = words.plain(estimate.asked, estimate)
        return asked if estimate.asked is None else f"{asked} {words.unit_of(estimate)}"

    def _found(self, estimate: "Estimate") -> str:
        from hapkit_studio.analysis.identify import words

        if not estimate.told:
            return "cannot tell"
        return f"{words.measured(estimate)} {words.unit_of(estimate)}"

    def paintEvent(self, event: QPaintEvent) -> None:
        if not self._estimates:
            return
        painter = QPainter(self)
        painter.setFont(theme.font("hint"))
        self._line(painter, 0.0, _HEAD, ("", f"{self._heads[0]} / {self._heads[1].lower()}"), "ink3")
        for index, estimate in enumerate(self._estimates):
            self._entry(painter, _HEAD + index * _ROW, estimate)

    def _entry(self, painter: QPainter, top: float, estimate: "Estimate") -> None:
        painter.setPen(theme.color("line"))
        painter.drawLine(0, int(top), self.width(), int(top))
        painter.setFont(theme.font("body"))
        upper, lower = top + 3.0, top + _ROW / 2.0
        self._line(painter, upper, 20.0, (estimate.term.label, self._asked(estimate)), "ink2")
        painter.setFont(theme.font("strong"))
        token = "ink" if estimate.told else "warn"
        self._line(painter, lower, 20.0, ("", self._found(estimate)), token)

    def _line(self, painter: QPainter, top: float, height: float, texts: tuple[str, str], token: str) -> None:
        painter.setPen(theme.color(token))
        box = QRectF(0.0, top, float(self.width()), height)
        for text, side in zip(texts, (Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignRight), strict=True):
            painter.drawText(box, side | Qt.AlignmentFlag.AlignVCenter, text)
