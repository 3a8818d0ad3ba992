"""Labelled dividers in the history: one for each change that the user makes to the settings."""

import math
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from hapkit_studio.gui.state.undo import ENVIRONMENT, Snapshot, UndoHistory, change_text, joined, settings_of

if TYPE_CHECKING:
    from hapkit_studio.gui.live.live import Live
    from hapkit_studio.gui.state.studio import Studio

_RESTED = 1.0  # s: changes within one gesture that are farther apart than this get separate dividers


class Dividers(QObject):
    """Adds a divider for changed values and loop settings at the time of a gesture's last change."""

    def __init__(self, studio: "Studio", live: "Live", undo: UndoHistory):
        super().__init__(live)
        self._studio, self._live, self._undo = studio, live, undo
        self._rebase()
        self._hidden_at = -math.inf
        studio.hidden_changed.connect(self._note_hidden)
        studio.environment_changed.connect(self._rebase)
        for changed in (studio.values_changed, studio.loop_changed):
            changed.connect(self._refresh)

    def _in_force(self) -> Snapshot:
        key, found = self._studio.environment.key, settings_of(self._studio)
        return {
            where: value
            for where, value in found.items()
            if where != ENVIRONMENT and (where[0] != "value" or where[1] == key)
        }

    def _rebase(self) -> None:
        """Compare later changes with the current settings. A new environment has its own divider."""
        self._last = self._in_force()
        self._gesture, self._at = -1, 0.0
        self._change: tuple[Snapshot, Snapshot] = {}, {}

    def _note_hidden(self) -> None:
        """Add a divider for a change of hidden values without showing the values."""
        again = self._live.history.now - self._hidden_at < _RESTED
        text = "Hidden values are active" if self._studio.hidden else "Your values are restored"
        self._hidden_at = self._live.note(text, self._hidden_at if again else None)

    def _refresh(self) -> None:
        last, self._last = self._last, self._in_force()
        after = {where: new for where, new in self._last.items() if last.get(where, new) != new}
        if not after or self._live.replaying:
            return
        change, instead = ({where: last[where] for where in after}, after), None
        if self._gesture == self._undo.gesture and self._live.history.now - self._at < _RESTED:
            change, instead = joined(self._change, change), self._at
        text = change_text(self._studio, *change) if change[1] else ""
        self._at = self._live.note(f"{text[:1].upper()}{text[1:]}", instead)
        self._gesture, self._change = self._undo.gesture, change
