"""Esc stops, wherever the focus is: in the window, a text, a dialog, an open menu. Space presses nothing."""

from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QAbstractButton, QWidget

_PRESS, _OVERRIDE, _RELEASE = QEvent.Type.KeyPress, QEvent.Type.ShortcutOverride, QEvent.Type.KeyRelease


class StopFilter(QObject):
    """Application-wide event filter; it sees every event, so all others leave it after one comparison.

    Every Esc calls ``stop`` first and then does what it always does. Space on a button of the window is
    swallowed: it is the pause key, and must not press what happens to have the focus while the motor pushes.
    """

    def __init__(self, stop: Callable[[], None], window: QWidget):
        super().__init__(window)
        self._stop, self._window = stop, window

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        kind = event.type()
        if kind not in (_PRESS, _OVERRIDE, _RELEASE) or not isinstance(event, QKeyEvent):
            return False
        if event.key() == Qt.Key.Key_Escape and kind != _RELEASE:
            self._stop()
        elif event.key() == Qt.Key.Key_Space and kind != _OVERRIDE and isinstance(watched, QAbstractButton):
            return watched.window() is self._window
        return False
