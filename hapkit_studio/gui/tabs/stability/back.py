"""One step back from a click on the map, or from a drag that began with it."""

from PySide6.QtCore import QObject, Qt
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.studio import Studio


class Back(QObject):
    """Keeps what was set before the last click; Ctrl+Z brings it back while the page is in sight."""

    def __init__(self, studio: Studio, page: QWidget):
        super().__init__(page)
        self._studio = studio
        self._key, self._before = "", dict[str, float]()
        self.shortcut = QShortcut(QKeySequence(QKeySequence.StandardKey.Undo), page)
        self.shortcut.setContext(Qt.ShortcutContext.WindowShortcut)
        self.shortcut.activated.connect(self.go)

    def remember(self) -> None:
        """Keep what is set now."""
        self._key, self._before = self._studio.environment.key, dict(self._studio.values)

    def go(self) -> None:
        """Set what was set before the last click, once; nothing in another environment."""
        if self._before and self._key == self._studio.environment.key:
            self._studio.set_values(self._before)
        self._before = {}
