"""The instructor's dialog that locks settings with a code, or unlocks them."""

from collections.abc import Iterator

from PySide6.QtCore import QSettings, QSize, Qt
from PySide6.QtWidgets import QLineEdit, QListWidget, QListWidgetItem, QPushButton, QWidget

from hapkit_studio.environments import discover
from hapkit_studio.gui.state.lock import DEVICE, ENTRY, LOOP, Lock, Place
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.dialogs import FormDialog
from hapkit_studio.gui.widgets.theme import theme

_LOCK = (
    "Tick the settings to be locked. Nobody can change them until the code is entered. The E-stop, faults, "
    "the choice of device and students' own laws are never locked."
)
_UNLOCK = "Enter the code to unlock all settings."
_LOW, _ROW = 110, 24  # px: minimum height of the list, and height of a row


class LockDialog(FormDialog):
    """Locks the ticked settings with a code that is entered twice, or unlocks all with the right code."""

    def __init__(self, studio: Studio, settings: QSettings, parent: QWidget):
        self._open = not studio.permissions.lock.places
        super().__init__(
            "Lock settings" if self._open else "Unlock settings", _LOCK if self._open else _UNLOCK, parent
        )
        self._studio, self._settings = studio, settings
        self.places = QListWidget()
        self.places.setAccessibleName("Settings to be locked")
        self.places.setProperty("field", True)
        self.places.setMinimumHeight(theme.px(_LOW))
        self.code, self.again = (QLineEdit(echoMode=QLineEdit.EchoMode.Password) for _ in range(2))
        self.others = QPushButton("Tick all “Environment” lines")
        self.confirm = QPushButton("Lock" if self._open else "Unlock")
        if self._open:
            for place, text in self._choices():
                row = QListWidgetItem(text, self.places)
                row.setData(_PLACE, place)
                row.setSizeHint(QSize(0, theme.px(_ROW)))
                row.setCheckState(Qt.CheckState.Unchecked)
            self.column.addWidget(self.places)
        fields = [("Code", self.code, None), ("Repeat the code", self.again, None)]
        self.add_fields(fields if self._open else fields[:1])
        self.add_verdict(1)
        self.add_buttons(self.confirm, left=[self.others] if self._open else [])
        self.confirm.setDefault(True)
        self.others.clicked.connect(self._tick_others)
        self.confirm.clicked.connect(self._lock if self._open else self._unlock)
        for changed in (self.code.textChanged, self.again.textChanged, self.places.itemChanged):
            changed.connect(self._judge)
        studio.environment_changed.connect(self.close)
        self._judge()

    @property
    def ticked(self) -> list[Place]:
        """Return the settings to be locked."""
        rows = map(self.places.item, range(self.places.count()))
        return [row.data(_PLACE) for row in rows if row.checkState() == Qt.CheckState.Checked]

    def _choices(self) -> Iterator[tuple[Place, str]]:
        here = self._studio.environment
        for parameter in here.parameters:
            yield ("value", here.key, parameter.key), f"{here.title}: {parameter.label}"
        yield LOOP, "Loop and grip"
        yield DEVICE, "Set-up, zero and direction of a Hapkit"
        for key, environment in discover().items():
            if key != here.key:
                yield ("environment", key), f"Environment “{environment.title}”"

    def _tick_others(self) -> None:
        for row in map(self.places.item, range(self.places.count())):
            if row.data(_PLACE)[0] == "environment":
                row.setCheckState(Qt.CheckState.Checked)

    def _judge(self) -> None:
        text = ""
        if self._open and not self.ticked:
            text = "Tick at least one setting."
        elif not self.code.text():
            text = "Enter a code first."
        elif self._open and self.code.text() != self.again.text():
            text = "The two codes differ: enter the same code twice."
        self.confirm.setEnabled(not text)
        self.verdict.show_text(text)

    def _lock(self) -> None:
        self._put(Lock.closed(self.ticked, self.code.text()))

    def _unlock(self) -> None:
        if self._studio.permissions.lock.opens(self.code.text()):
            self._put(Lock())
        else:
            self.verdict.show_text(
                "The code is wrong. Enter the code that was used to lock the settings.", "triangle", "warn"
            )

    def _put(self, lock: Lock) -> None:
        self._settings.setValue(ENTRY, lock.text())
        self._studio.permissions.set_lock(lock)
        self.close()


_PLACE = Qt.ItemDataRole.UserRole
