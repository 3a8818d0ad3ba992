"""Keeps Space from pressing whatever button happens to have the focus while the motor may push."""

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QAbstractButton, QWidget

_KEYS = (QEvent.Type.KeyPress, QEvent.Type.KeyRelease)


class KeyGuard(QObject):
    """Application-wide event filter; swallows Space on buttons of one window, whose shortcut came first."""

    def __init__(self, window: QWidget, parent: QObject | None = None):
        super().__init__(parent)
        self._window = window

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() not in _KEYS or not isinstance(event, QKeyEvent) or event.key() != Qt.Key.Key_Space:
            return False
        return isinstance(watched, QAbstractButton) and watched.window() is self._window
