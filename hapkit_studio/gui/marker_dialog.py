"""A marker: a moment that a person notes, with a few words; a divider in the plots, an event in a session."""

from PySide6.QtWidgets import QLineEdit, QPushButton, QWidget

from hapkit_studio.gui.dialogs import TextDialog
from hapkit_studio.gui.live.live import Live
from hapkit_studio.gui.recording import Recording
from hapkit_studio.gui.widgets.parts import across, primary

LONGEST = 40
"""Letters: what finds room beside its divider."""
_PLAIN = "Marker"


class MarkerDialog(TextDialog):
    """Notes the moment in which it was opened, however long the words take."""

    def __init__(self, recording: Recording, live: Live, parent: QWidget | None = None):
        super().__init__("Marker", parent)
        self._recording, self._live, self._time = recording, live, live.history.now
        self.text = QLineEdit(maxLength=LONGEST, placeholderText="A few words, or none")
        self.text.setAccessibleName("Text of the marker")
        self.text.setMinimumWidth(320)
        self.add = primary(QPushButton("Add"))
        self.add.setDefault(True)
        self.add.clicked.connect(self._add)
        self.column.addWidget(self.text)
        self.column.addLayout(across(None, self.add, self.leave))

    def _add(self) -> None:
        words = self.text.text().strip() or _PLAIN
        self._live.history.divide(words, self._time)
        self._recording.mark(words, self._time)
        self.close()
