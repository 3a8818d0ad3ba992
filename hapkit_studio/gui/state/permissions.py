"""What may be changed: the instructor's lock, hidden values, and changes that are taken back."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from PySide6.QtCore import QObject, Signal

from hapkit_studio.gui.state.lock import Lock

LOCKED = "Locked by the instructor"
BLIND, QUIZ = "Hidden during the blind comparison", "Hidden during the quiz"
"""Why values are hidden: BLIND hides scene and plots as well, QUIZ shows them."""


class Permissions(QObject):
    """Answers why a setting cannot be changed now.

    hidden: why other values are rendered than the window shows, "" if they are the same; hidden_values: the
    values that are rendered then. temporary: a measurement changes settings and takes them back.
    """

    lock_changed = Signal()
    hidden_changed = Signal()

    def __init__(self, parent: QObject):
        super().__init__(parent)
        self.lock = Lock()
        self.hidden = ""
        self.hidden_values: dict[str, float] | None = None
        self.temporary = False

    def set_lock(self, lock: Lock) -> None:
        """Replace the lock."""
        self.lock = lock
        self.lock_changed.emit()

    @contextmanager
    def temporarily(self) -> Iterator[None]:
        """Allow every change, which is not a person's and is not undone."""
        before, self.temporary = self.temporary, True
        try:
            yield
        finally:
            self.temporary = before

    def why_fixed(self, *place: str) -> str:
        """Return why the setting at a place cannot be changed now, "" if it can."""
        if self.temporary:
            return ""
        return self.hidden or (LOCKED if self.lock.holds(place) else "")

    def hide(self, values: Mapping[str, float] | None, why: str) -> bool:
        """Hide the values that are rendered, None to show them again; return whether they differ now."""
        before, self.hidden_values = self.hidden_values, None if values is None else dict(values)
        self.hidden = "" if values is None else why
        return before != self.hidden_values
