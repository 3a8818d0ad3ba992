"""A segmented control: two or three options side by side, of which one is selected."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QButtonGroup, QPushButton, QWidget

from hapkit_studio.gui.widgets.parts import hbox


class Segmented(QWidget):
    """Two or three options side by side; ``chosen`` is emitted with the index that the user selects.

    The arrow keys change the selected option.
    """

    chosen = Signal(int)

    def __init__(self, name: str, options: tuple[str, ...]):
        super().__init__()
        self._group = QButtonGroup(self)
        row = hbox(into=self, gap=0)
        places = ("first", *["middle"] * (len(options) - 2), "last")[: len(options)]
        for index, (option, place) in enumerate(zip(options, places, strict=True)):
            button = QPushButton(option)
            button.setCheckable(True)
            button.setAccessibleName(f"{name}: {option}")
            button.setCursor(Qt.CursorShape.PointingHandCursor)
            button.setProperty("segment", place)
            self._group.addButton(button, index)
            row.addWidget(button)
        self._group.idToggled.connect(self._toggled)

    @property
    def index(self) -> int:
        """Return the selected option's index."""
        return self._group.checkedId()

    @property
    def buttons(self) -> tuple[QWidget, ...]:
        """Return all buttons from left to right."""
        return tuple(self._group.buttons())

    def button(self, index: int) -> QPushButton:
        """Return one option's button."""
        return self._group.button(index)  # type: ignore[return-value]

    def show_index(self, index: int) -> None:
        """Select an option without emitting a signal."""
        blocked = self._group.blockSignals(True)
        self._group.button(index).setChecked(True)
        self._group.blockSignals(blocked)
        self._lead_tab()

    def _lead_tab(self) -> None:
        """Let the Tab key stop at the selected option only."""
        for button in self._group.buttons():
            policy = Qt.FocusPolicy.StrongFocus if button.isChecked() else Qt.FocusPolicy.ClickFocus
            button.setFocusPolicy(policy)

    def _toggled(self, index: int, on: bool) -> None:
        if on:
            self._lead_tab()
            self.chosen.emit(index)
