"""One choice of the panel: a segmented control for up to three short options, a list otherwise."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QWidget

from hapkit_studio.gui.rich import plain, tip
from hapkit_studio.gui.segmented import Segmented
from hapkit_studio.parameters import Choice

# more, or longer words, do not fit beside the label in a narrow panel
_MOST_SEGMENTS, _MOST_LETTERS = 3, 14


class ChoiceRow(QWidget):
    """Emits ``changed(key, index)`` when a person picks another option."""

    changed = Signal(str, float)

    def __init__(self, choice: Choice, formula: str = "", parent: QWidget | None = None):
        super().__init__(parent)
        self.parameter = choice
        words = choice.words
        self.label = plain(QLabel(choice.label))
        self.label.setWordWrap(True)
        self.picker: Segmented | QComboBox
        if len(words) <= _MOST_SEGMENTS and sum(map(len, words)) <= _MOST_LETTERS:
            self.picker = Segmented(choice.label, words)
            self.picker.chosen.connect(self._take)
        else:
            self.picker = QComboBox()
            self.picker.addItems(words)
            self.picker.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            self.picker.activated.connect(self._take)
        row = self._row = QHBoxLayout(self)
        row.setSpacing(6)
        row.addWidget(self.label, 1)
        row.addWidget(self.picker)
        self._formula = formula
        self.set_compact(False)
        self.set_locked("")
        self.show_value(choice.default)

    @property
    def value(self) -> float:
        """Return the chosen option's index."""
        picker = self.picker
        return float(picker.index if isinstance(picker, Segmented) else picker.currentIndex())

    def stops(self) -> tuple[QWidget, ...]:
        """Return what Tab stops at, in order."""
        return self.picker.buttons if isinstance(self.picker, Segmented) else (self.picker,)

    def show_value(self, value: float) -> None:
        """Show the option that is in force."""
        index = int(value)
        if isinstance(self.picker, Segmented):
            self.picker.show_index(index)
        else:
            self.picker.setCurrentIndex(index)
        self._name(value)

    def set_compact(self, compact: bool) -> None:
        """Stand closer to the rows above and below where the window is low."""
        margin = 1 if compact else 3
        self._row.setContentsMargins(0, margin, 0, margin)

    def set_locked(self, reason: str) -> None:
        """Leave the option readable but fixed, and say why; no reason unlocks it."""
        self.setEnabled(not reason)
        self.setToolTip(tip((reason, self.parameter.help), self._formula))

    def _name(self, value: float) -> None:
        self.picker.setAccessibleName(f"{self.parameter.label}, {self.parameter.word(value)}")

    def _take(self, index: int) -> None:
        self._name(index)
        self.changed.emit(self.parameter.key, float(index))
