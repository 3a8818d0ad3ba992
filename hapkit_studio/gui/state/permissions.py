"""Determines which settings may be changed. A lock, a lesson or hidden values can prevent a change."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager

from PySide6.QtCore import QObject, Signal

from hapkit_studio.gui.state.lock import Lock, Place

LOCKED, BY_LESSON = "Locked by the instructor", "Locked by the lesson"
BY_LAB = "Locked by the administrator of this computer"
HIDDEN_BY_LESSON = "Hidden by the lesson"
BLIND, QUIZ = "Values are hidden during the blind comparison", "Values are hidden during the quiz"
POINTING, THRESHOLD = (
    "Values are hidden during the pointing experiment",
    "Values are hidden during the threshold experiment",
)
"""The reasons for hiding values during experiments."""
BARE_SCENE = (BLIND, POINTING, THRESHOLD)
"""With these reasons for hiding values, the scene shows only the handle."""


class Permissions(QObject):
    """Determines why a setting cannot be changed now.

    ``hidden`` is the reason why the rendered values differ from the shown ones, or "" if they are equal.
    ``hidden_values`` are the rendered values while they are hidden.
    ``temporary`` is True while a measurement has changed settings that it will restore.
    ``lesson`` are the settings that the open step of a lesson locks.
    ``left_out`` are the parts of the window that this step hides, from ``lessons.parse.HIDDEN``. ``lab`` are
    the settings that the computer's administrator has locked permanently.
    """

    lock_changed = Signal()
    hidden_changed = Signal()

    def __init__(self, parent: QObject):
        super().__init__(parent)
        self.lock = Lock()
        self.hidden = ""
        self.hidden_values: dict[str, float] | None = None
        self.temporary = False
        self.lesson, self.lab = Lock(), Lock()
        self.left_out: frozenset[str] = frozenset()

    def set_lock(self, lock: Lock) -> None:
        """Replace the lock."""
        self.lock = lock
        self.lock_changed.emit()

    def set_lesson(self, places: Iterable[Place] = (), left_out: Iterable[str] = ()) -> None:
        """Lock settings and hide parts for a step of a lesson; without arguments, unlock and show all."""
        self.lesson, self.left_out = Lock(frozenset(places)), frozenset(left_out)
        self.lock_changed.emit()

    def lasting_locks(self) -> tuple[tuple[Lock, str], ...]:
        """Return the locks that do not end with a lesson, each with its reason."""
        return (self.lock, LOCKED), (self.lab, BY_LAB)

    @contextmanager
    def temporarily(self) -> Iterator[None]:
        """Allow every change within the context; such a change is not the user's and has no undo step."""
        before, self.temporary = self.temporary, True
        try:
            yield
        finally:
            self.temporary = before

    def why_fixed(self, *place: str) -> str:
        """Return why a setting cannot be changed now; "" if it can be changed."""
        if self.temporary:
            return ""
        if self.hidden or self.lock.covers(place):
            return self.hidden or LOCKED
        if self.lab.covers(place):
            return BY_LAB
        return BY_LESSON if self.lesson.covers(place) else ""

    def hide(self, values: Mapping[str, float] | None, why: str) -> bool:
        """Hide the rendered values; None shows them again. Return whether the hidden values have changed."""
        before, self.hidden_values = self.hidden_values, None if values is None else dict(values)
        self.hidden = "" if values is None else why
        return before != self.hidden_values
