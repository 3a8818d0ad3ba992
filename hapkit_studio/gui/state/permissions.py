"""Which settings may be changed: the instructor's lock, hidden values, and temporary changes."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from PySide6.QtCore import QObject, Signal

from hapkit_studio.gui.state.lock import Lock

LOCKED = "Locked by the instructor"
BLIND, QUIZ = "Hidden during the blind comparison", "Hidden during the quiz"
"""Reasons for hidden values: BLIND also hides scene and plots, QUIZ shows them."""


class Permissions(QObject):
    """Determines why a setting cannot be changed now.

    hidden: the reason why the rendered values differ from those shown, "" if they do not; hidden_values: the
    rendered values in that case. temporary: a measurement has changed settings and will restore them.
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
        """Allow every change within the context; it is no user change and has no undo step."""
        before, self.temporary = self.temporary, True
        try:
            yield
        finally:
            self.temporary = before

    def why_fixed(self, *place: str) -> str:
        """Return why a setting cannot be changed now, "" if it can."""
        if self.temporary:
            return ""
        return self.hidden or (LOCKED if self.lock.covers(place) else "")

    def hide(self, values: Mapping[str, float] | None, why: str) -> bool:
        """Hide the rendered values, or (None) show them again; return whether they have changed."""
        before, self.hidden_values = self.hidden_values, None if values is None else dict(values)
        self.hidden = "" if values is None else why
        return before != self.hidden_values
