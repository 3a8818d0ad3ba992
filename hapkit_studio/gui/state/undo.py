"""Undo and redo of all settings. The changes during one press of a button or key are one step."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QUndoCommand, QUndoStack

from hapkit_studio.dynamics.loop_settings import FIELDS, WITH_SCENE, Difference, difference
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.state.studio import Studio

Snapshot = dict[tuple[str, ...], Any]
"""A key is ("environment",), ("loop", name in LoopSettings) or ("value", environment, parameter)."""
MOST = 200
"""Maximum number of steps."""
ENVIRONMENT, HAND = ("environment",), ("loop", "hand")


def settings_of(studio: Studio) -> Snapshot:
    """Return all settings that can be undone."""
    found: Snapshot = {ENVIRONMENT: studio.environment.key}
    for name in FIELDS:
        found["loop", name] = getattr(studio.loop, name)
    for key, values in studio.library.values.items():
        for name, value in values.items():
            found["value", key, name] = value
    return found


def settings_of_scene(studio: Studio, with_loop: bool) -> Snapshot:
    """Return the current environment's settings, and those loop settings that do not depend on the device."""
    key, now = studio.environment.key, settings_of(studio)
    values = {place: value for place, value in now.items() if place[:2] == ("value", key)}
    places = [("loop", name) for name in WITH_SCENE] if with_loop else []
    return {ENVIRONMENT: key, **values, **{place: now[place] for place in places}}


def differing(studio: Studio, settings: Snapshot) -> Snapshot:
    """Return the given settings that differ from the current ones."""
    now = settings_of(studio)
    return {place: value for place, value in settings.items() if now.get(place) != value}


def put(studio: Studio, settings: Snapshot) -> None:
    """Apply all settings; if one of them is refused, apply none and raise ParameterError."""
    loop = {names[0]: value for (kind, *names), value in settings.items() if kind == "loop"}
    values: dict[str, dict[str, float]] = defaultdict(dict)
    for (kind, *names), value in settings.items():
        if kind == "value":
            values[names[0]][names[1]] = value
    chosen, changed = settings.get(ENVIRONMENT, studio.environment.key), differing(studio, settings)
    studio.check_free((*place, chosen) if place == ENVIRONMENT else place for place in changed)
    for key in (*values, chosen):
        if key not in studio.environments:
            raise ParameterError(f"The environment {key} is no longer installed.")
    for key, changes in values.items():
        # this raises before any setting is changed
        studio.environments[key].values({**studio.values_of(key), **changes})
    if loop:
        studio.set_loop(**loop)
    for key, changes in values.items():
        studio.set_values_of(key, changes)
    studio.choose(chosen)


def change_text(studio: Studio, before: Snapshot, after: Snapshot) -> str:
    """Describe a change for a menu, for example "stiffness 300 → 500 N/m".

    If the velocity filter has changed, the text includes the options of the new filter.
    """
    if ENVIRONMENT in after:
        known = studio.environments
        keys = (settings[ENVIRONMENT] for settings in (before, after))
        # the file of an environment may have been deleted
        return " → ".join(known[key].title if key in known else key for key in keys)
    if len(after) == 1:
        ((where, new),) = after.items()
        return str(_difference(studio, where, before[where], new))
    return f"{len(after)} settings"


def joined(first: tuple[Snapshot, Snapshot], then: tuple[Snapshot, Snapshot]) -> tuple[Snapshot, Snapshot]:
    """Merge two consecutive changes (before, after).

    Omit settings whose value is the same at start and end.
    """
    before, after = then[0] | first[0], first[1] | then[1]
    changed = [where for where in after if before[where] != after[where]]
    return {where: before[where] for where in changed}, {where: after[where] for where in changed}


def differences(studio: Studio, before: Snapshot, after: Snapshot) -> list[Difference]:
    """Return the differences between two sets of settings.

    The environment, and settings that only one of the sets contains, are ignored.
    """
    return [
        _difference(studio, place, before[place], value)
        for place, value in after.items()
        if place != ENVIRONMENT and place in before and before[place] != value
    ]


def _difference(studio: Studio, where: tuple[str, ...], old: Any, new: Any) -> Difference:
    kind, *names = where
    if kind == "loop":
        return FIELDS[names[0]].difference(old, new)
    parameters = studio.environments[names[0]].parameters
    return difference(next(p for p in parameters if p.key == names[1]), old, new)


class Step(QUndoCommand):
    """The changes of one gesture.

    Only changed settings are stored, so that the others keep their current values.
    """

    def __init__(self, history: "UndoHistory", before: Snapshot, after: Snapshot, name: str):
        super().__init__()
        self._history, self.gesture, self.name = history, history.gesture, name
        self.before, self.after = before, after
        self._done = True
        self.setText(name or change_text(history.studio, before, after))

    def id(self) -> int:
        return 1

    def mergeWith(self, other: QUndoCommand) -> bool:
        """Merge a later change of the same gesture into this step; a step without effect is removed."""
        if not isinstance(other, Step) or other.gesture != self.gesture:
            return False
        self.before, self.after = joined((self.before, self.after), (other.before, other.after))
        self.name = self.name or other.name
        self.setObsolete(not self.after)
        if self.after:
            self.setText(self.name or change_text(self._history.studio, self.before, self.after))
        return True

    def undo(self) -> None:
        self._put(self.before)

    def redo(self) -> None:
        """Redo the step; the first call is a no-op, because QUndoStack makes it when the step is pushed."""
        if self._done:
            self._done = False
        else:
            self._put(self.after)

    def _put(self, settings: Snapshot) -> None:
        try:
            self._history.apply(settings)
        except ParameterError as error:
            self.setObsolete(True)
            self._history.refusal = str(error)


class UndoHistory(QObject):
    """Records changes of the studio's settings.

    ``changed`` is emitted when the next step to undo or redo changes, ``refused`` when undo has failed.
    ``gesture`` counts presses of buttons and keys: changes within one gesture are one step.
    """

    changed = Signal()
    refused = Signal(str)

    def __init__(self, studio: Studio, parent: QObject | None = None):
        super().__init__(parent)
        self.studio, self.gesture = studio, 0
        self.stack = QUndoStack(self)
        self.stack.setUndoLimit(MOST)
        self.stack.indexChanged.connect(self.changed)
        self._name, self._applying, self.refusal = "", False, ""
        self.forget()
        studio.settings_changed.connect(self._refresh)

    def undo(self) -> None:
        """Undo the last step; if this is not possible, emit the reason."""
        self._move(self.stack.undo)

    def redo(self) -> None:
        """Redo the next step."""
        self._move(self.stack.redo)

    def _move(self, move: Callable[[], None]) -> None:
        self.refusal = ""
        move()
        if self.refusal:
            self.refused.emit(self.refusal)

    def forget(self) -> None:
        """Clear the history; later steps start from the current settings."""
        self.stack.clear()
        self._snapshot()

    @contextmanager
    def named(self, name: str) -> Iterator[None]:
        """Give a name to the changes made within the context, and make them a single step."""
        self.gesture += 1
        self._name = name
        try:
            yield
        finally:
            self._name = ""

    def apply(self, settings: Snapshot) -> None:
        """Apply settings without a new step; raise ParameterError if one of them is refused."""
        self._applying = True
        try:
            put(self.studio, settings)
        finally:
            self._applying = False
            self._snapshot()

    def _snapshot(self) -> None:
        self._last, self._environments = settings_of(self.studio), dict(self.studio.environments)

    def _refresh(self) -> None:
        """Push an undo command if the user has changed settings; ignore the values of a reloaded law."""
        if self._applying:
            return
        last, environments = self._last, self._environments
        self._snapshot()
        if self.studio.temporary:
            return
        after = {
            where: value
            for where, value in self._last.items()
            if where in last and last[where] != value and self._same(where, environments)
        }
        if after:
            self.stack.push(Step(self, {where: last[where] for where in after}, after, self._name))

    def _same(self, where: tuple[str, ...], environments: Mapping[str, object]) -> bool:
        return where[0] != "value" or environments.get(where[1]) is self._environments.get(where[1])
