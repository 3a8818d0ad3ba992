"""Two settings of an environment, A and B. One key switches between them; the panel shows the active one."""

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QPushButton, QWidget

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.panel.differences import DifferenceTable
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.state.undo import Difference, Snapshot, UndoHistory, differences, settings_of_scene
from hapkit_studio.gui.widgets.dialogs import FormDialog
from hapkit_studio.gui.widgets.parts import hbox, label

NAMES = "A", "B"


class TwoSettings(QObject):
    """Stores each environment's values, loop and grip as A and B.

    ``changed`` is emitted when a stored setting or the active one changes. Switching between A and B
    does not create an undo step: Ctrl+Z undoes the last change before the switch.
    """

    changed = Signal()

    def __init__(self, studio: Studio, history: UndoHistory, parent: QObject):
        super().__init__(parent)
        self._studio, self._history = studio, history
        self._stored: dict[str, list[Snapshot]] = {}
        self._last = 1
        studio.settings_changed.connect(self.changed)

    @property
    def stored(self) -> list[Snapshot]:
        """Return the stored settings of the current environment, A first."""
        return self._stored.get(self._studio.environment.key, [])

    @property
    def active(self) -> int | None:
        """Return the index of the active setting; None if neither is active."""
        now = settings_of_scene(self._studio, with_loop=True)
        return self.stored.index(now) if now in self.stored else None

    @property
    def target(self) -> int:
        """Return the index of the setting to switch to.

        If neither setting is active, return the index of the setting that was active last.
        """
        now = self.active
        return self._last if now is None else 1 - now

    @property
    def differences(self) -> list[Difference]:
        """Return the differences between A and B; the list is empty until both are stored."""
        return differences(self._studio, *self.stored) if len(self.stored) == len(NAMES) else []

    @property
    def comparable(self) -> bool:
        """Return whether A and B differ only in values, which a blind comparison requires."""
        if not self.differences or self._studio.temporary:
            return False
        a, b = self.stored
        return all(place[0] == "value" for place in a if a[place] != b[place])

    @property
    def next_text(self) -> str:
        """Describe what ``step`` would do."""
        count = len(self.stored)
        return (
            f"Switch to settings {NAMES[self.target]}"
            if count == len(NAMES)
            else f"Store settings as {NAMES[count]}"
        )

    def step(self) -> None:
        """Store the current settings as A; in the next call, store them as B if they differ from A.

        Later calls switch between both.
        """
        stored = self._stored.setdefault(self._studio.environment.key, [])
        if len(stored) == len(NAMES):
            target = self.target
            try:
                self._history.apply(stored[target])
                self._last = target
            except ParameterError as error:
                self._studio.refused.emit(str(error))
        elif self.active is None:
            stored.append(settings_of_scene(self._studio, with_loop=True))
            self._last = len(stored) - 1
        self.changed.emit()

    def forget(self) -> None:
        """Delete A and B of the current environment."""
        self._stored.pop(self._studio.environment.key, None)
        self.changed.emit()


class TwoSettingsRow(QWidget):
    """Shows whether A or B is active, with a button that switches. The row is visible once A is stored."""

    def __init__(self, two: TwoSettings):
        super().__init__()
        self._two = two
        self.label, self.button = label(), QPushButton()
        hbox((self.label, 1), self.button, into=self, margins=(0, 3, 0, 3), gap=6)
        self.button.clicked.connect(two.step)
        self.button.setToolTip(
            "Press X to store the present settings as A or B, or to switch between A and B"
        )
        two.changed.connect(self.show_state)
        self.show_state()

    def show_state(self) -> None:
        """Show which setting is active."""
        two, now = self._two, self._two.active
        self.setVisible(bool(two.stored))
        self.label.setText(
            "These settings are neither A nor B" if now is None else f"Settings {NAMES[now]} are active"
        )
        self.button.setText(two.next_text)
        self.button.setEnabled(len(two.stored) == len(NAMES) or now is None)


class TwoSettingsDialog(FormDialog):
    """Shows the differences between A and B; ``blind`` is emitted to start a blind comparison."""

    blind = Signal()

    def __init__(self, two: TwoSettings, parent: QWidget):
        about = (
            "Press X to store the present settings as A. Change them and press X again to store them as "
            "B. From then on, X switches between A and B."
        )
        super().__init__("Settings A and B", about, parent)
        self._two, self.table = two, DifferenceTable(*NAMES)
        self.begin, self.drop = QPushButton("Compare A and B blind"), QPushButton("Delete settings A and B")
        self.column.addWidget(self.table)
        self.add_verdict(1)
        self.add_buttons(self.begin, left=[self.drop])
        self.drop.clicked.connect(two.forget)
        self.begin.clicked.connect(self._begin)
        two.changed.connect(self.show_state)
        self.show_state()

    def show_state(self) -> None:
        """Show the differences between A and B, or which of them is stored next."""
        two = self._two
        self.table.show_differences(two.differences)
        self.begin.setEnabled(two.comparable)
        self.drop.setEnabled(bool(two.stored))
        text = "" if two.comparable else "For a blind comparison, A and B must have the same loop and grip."
        if not two.differences:
            text = f"The next press of X does this: {two.next_text}."
        self.verdict.show_text(text)
        self.verdict.setVisible(bool(text))

    def _begin(self) -> None:
        self.close()
        self.blind.emit()
