"""Two settings of one environment, A and B, on one key; the panel's row says which is in force."""

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QPushButton, QWidget

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.panel.differences import DifferenceTable
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.state.undo import Difference, Settings, UndoHistory, differences, settings_of_scene
from hapkit_studio.gui.widgets.dialogs import FormDialog
from hapkit_studio.gui.widgets.parts import hbox, label

NAMES = "A", "B"


class TwoSettings(QObject):
    """Keeps values, loop and grip of each environment as A and B. ``changed``: others are kept or in force.

    Switching is no step of undo: the step before stays the one that Ctrl+Z takes back.
    """

    changed = Signal()

    def __init__(self, studio: Studio, history: UndoHistory, parent: QObject):
        super().__init__(parent)
        self._studio, self._history = studio, history
        self._kept: dict[str, list[Settings]] = {}
        self._last = 1
        studio.settings_changed.connect(self.changed)

    @property
    def kept(self) -> list[Settings]:
        """Return what is kept of the environment in force, A first."""
        return self._kept.get(self._studio.environment.key, [])

    @property
    def in_force(self) -> int | None:
        """Return which of them is in force, None for neither."""
        now = settings_of_scene(self._studio, with_loop=True)
        return self.kept.index(now) if now in self.kept else None

    @property
    def target(self) -> int:
        """Return which one comes next; from neither it is the one that was in force last."""
        now = self.in_force
        return self._last if now is None else 1 - now

    @property
    def differences(self) -> list[Difference]:
        """Return what differs between A and B, while both are kept."""
        return differences(self._studio, *self.kept) if len(self.kept) == len(NAMES) else []

    @property
    def comparable(self) -> bool:
        """Say whether A and B differ in values alone, as a loop shows in many a place; not in a replay."""
        if not self.differences or self._studio.temporary:
            return False
        a, b = self.kept
        return all(place[0] == "value" for place in a if a[place] != b[place])

    @property
    def next_words(self) -> str:
        """Say what ``step`` does next."""
        kept = len(self.kept)
        return f"Switch to {NAMES[self.target]}" if kept == len(NAMES) else f"Keep as {NAMES[kept]}"

    def step(self) -> None:
        """Keep what is set as A, then something else as B, then switch between them."""
        kept = self._kept.setdefault(self._studio.environment.key, [])
        if len(kept) == len(NAMES):
            target = self.target
            try:
                self._history.apply(kept[target])
                self._last = target
            except ParameterError as error:
                self._studio.refused.emit(str(error))
        elif self.in_force is None:
            kept.append(settings_of_scene(self._studio, with_loop=True))
            self._last = len(kept) - 1
        self.changed.emit()

    def forget(self) -> None:
        """Keep neither of the environment in force any more."""
        self._kept.pop(self._studio.environment.key, None)
        self.changed.emit()


class TwoSettingsRow(QWidget):
    """Says which of A and B is in force, from when A is kept; its button does what the key does."""

    def __init__(self, two: TwoSettings):
        super().__init__()
        self._two = two
        self.words, self.button = label(), QPushButton()
        hbox((self.words, 1), self.button, into=self, margins=(0, 3, 0, 3), gap=6)
        self.button.clicked.connect(two.step)
        self.button.setToolTip("Press X to keep or switch settings")
        two.changed.connect(self.show_state)
        self.show_state()

    def show_state(self) -> None:
        """Show what is in force."""
        two, now = self._two, self._two.in_force
        self.setVisible(bool(two.kept))
        self.words.setText("No settings kept as A or B" if now is None else f"{NAMES[now]} is active")
        self.button.setText(two.next_words)
        self.button.setEnabled(len(two.kept) == len(NAMES) or now is None)


class TwoSettingsDialog(FormDialog):
    """Shows in what A and B differ. ``blind``: compare them without names."""

    blind = Signal()

    def __init__(self, two: TwoSettings, parent: QWidget):
        about = (
            "Press X to keep the present settings as A. Change them and press X again to keep them as "
            "B. From then on, X switches between A and B."
        )
        super().__init__("A and B", about, parent)
        self._two, self.table = two, DifferenceTable(*NAMES)
        self.begin, self.drop = QPushButton("Compare blind"), QPushButton("Forget A and B")
        self.column.addWidget(self.table)
        self.add_verdict(1)
        self.add_buttons(self.begin, left=[self.drop])
        self.drop.clicked.connect(two.forget)
        self.begin.clicked.connect(self._begin)
        two.changed.connect(self.show_state)
        self.show_state()

    def show_state(self) -> None:
        """Show what differs, or what is to be kept next."""
        two = self._two
        self.table.show_differences(two.differences)
        self.begin.setEnabled(two.comparable)
        self.drop.setEnabled(bool(two.kept))
        words = "" if two.comparable else "Blind needs A and B with the same loop and grip."
        if not two.differences:
            words = f"Next, key X will: {two.next_words}."
        self.verdict.say(words)
        self.verdict.setVisible(bool(words))

    def _begin(self) -> None:
        self.close()
        self.blind.emit()
