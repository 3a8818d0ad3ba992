"""The table of scenes and terms: painted, walked with the arrow keys."""

from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from hapkit_studio.devices.terms import TERMS
from hapkit_studio.environments import discover
from hapkit_studio.gui.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.analysis.fidelity import Effect, Fidelity

_HEAD, _NAMES = 40, 172
_HEAD_FLAGS = int(Qt.AlignmentFlag.AlignCenter) | int(Qt.TextFlag.TextWordWrap)
_STEPS = {
    Qt.Key.Key_Up: (-1, 0), Qt.Key.Key_Down: (1, 0), Qt.Key.Key_Left: (0, -1), Qt.Key.Key_Right: (0, 1)
}  # fmt: skip


class FidelityTable(QWidget):
    """Emits ``chosen(Effect)`` for the cell that is clicked or walked to."""

    chosen = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self._scenes = [(key, scene.title) for key, scene in discover().items()]
        self._results: dict[str, Fidelity] = {}
        self._at = (0, 0)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Scenes down, terms of the device across")
        self.setMinimumSize(560, 300)
        theme.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        return QSize(900, 620)

    def show_results(self, results: "list[Fidelity]") -> None:
        """Show what was found."""
        self._results = {result.scene: result for result in results}
        self.update()

    def choose(self, row: int, column: int) -> None:
        """Choose a cell, as near as there is one."""
        row = min(max(row, 0), len(self._scenes) - 1)
        column = min(max(column, 0), len(TERMS) - 1)
        self._at = (row, column)
        effect = self._effect(row, column)
        self.update()
        if effect is not None:
            self.setAccessibleDescription(f"{self._scenes[row][1]}, {list(TERMS.values())[column].word}")
            self.chosen.emit(effect)

    def _effect(self, row: int, column: int) -> "Effect | None":
        result = self._results.get(self._scenes[row][0])
        return result.effects[column] if result else None

    # painting

    def cell(self, row: int, column: int) -> QRectF:
        """Return a cell's place."""
        width = (self.width() - _NAMES - 12) / len(TERMS)
        height = (self.height() - _HEAD - 10) / len(self._scenes)
        return QRectF(_NAMES + column * width, _HEAD + row * height, width, height)

    def head(self, column: int) -> QRectF:
        """Return the place of a term's name, which may take two lines."""
        box = self.cell(0, column)
        return QRectF(box.left() + 2, 0, box.width() - 4, _HEAD)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self._heads(painter)
        for row in range(len(self._scenes)):
            for column in range(len(TERMS)):
                self._cell(painter, row, column)
        box = self.cell(*self._at).adjusted(1.5, 1.5, -1.5, -1.5)
        if self._results:
            painter.setPen(QPen(theme.color("accent"), 2.5 if self.hasFocus() else 1.5))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRect(box)

    def _heads(self, painter: QPainter) -> None:
        painter.setPen(theme.color("ink2"))
        painter.setFont(theme.font("label"))
        for column, term in enumerate(TERMS.values()):
            painter.drawText(self.head(column), _HEAD_FLAGS, term.word)
        painter.setFont(theme.font("body"))
        painter.setPen(theme.color("ink"))
        for row, (_, title) in enumerate(self._scenes):
            box = self.cell(row, 0)
            names = QRectF(14, box.top(), _NAMES - 20, box.height())
            painter.drawText(names, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, title)

    def _cell(self, painter: QPainter, row: int, column: int) -> None:
        from hapkit_studio.charts.fidelity import outcome_word, percent

        box, effect = self.cell(row, column), self._effect(row, column)
        needed = effect is not None and effect.needed
        painter.setPen(QPen(theme.color("line"), 1))
        painter.setBrush(theme.color("accentsoft" if needed else "surface"))
        painter.drawRect(box)
        if effect is None:
            return
        painter.setPen(theme.color("accent" if needed else "ink3"))
        painter.setFont(theme.font("strong" if needed else "body"))
        tall = box.height() >= 38 and box.width() >= 84 and needed
        upper = QRectF(box.left(), box.top() + 3, box.width(), box.height() / 2 - 2) if tall else box
        painter.drawText(upper, Qt.AlignmentFlag.AlignCenter, percent(effect.change))
        if tall:
            painter.setPen(theme.color("ink2"))
            painter.setFont(theme.font("tick"))
            lower = QRectF(box.left(), box.center().y() - 2, box.width(), box.height() / 2)
            painter.drawText(lower, Qt.AlignmentFlag.AlignCenter, outcome_word(effect.outcome))

    # mouse and keys

    def mousePressEvent(self, event: QMouseEvent) -> None:
        first = self.cell(0, 0)
        row = int((event.position().y() - first.top()) // first.height())
        column = int((event.position().x() - first.left()) // first.width())
        self.choose(row, column)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = _STEPS.get(Qt.Key(event.key()))
        if step is None:
            super().keyPressEvent(event)
        else:
            self.choose(self._at[0] + step[0], self._at[1] + step[1])
