"""An action of the window, and the set of all actions as QActions."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from PySide6.QtCore import QObject, Qt
from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QWidget

Window = TypeVar("Window", bound=QWidget)


@dataclass(frozen=True)
class Action(Generic[Window]):
    """A command of the window: an entry of a menu and of the command palette, and its shortcut.

    ``key`` has the form "menu.action". ``checked`` returns whether the entry has a check mark. ``extra`` are
    further shortcuts. ``current_text`` returns the entry's text if the text can change. The other fields are
    true in these cases: ``filtered`` if the window's event filter handles the shortcut, ``exclusive`` if
    exactly one entry of the submenu is checked, ``rule`` if a separator precedes the entry, ``on_plots`` if
    the entry is also in the plots' context menu.
    """

    key: str
    text: str
    run: Callable[[Window], object]
    shortcut: str = ""
    enabled: Callable[[Window], bool] = lambda _window: True
    checked: Callable[[Window], bool] | None = None
    filtered: bool = False
    extra: tuple[str, ...] = ()
    current_text: Callable[[Window], str] | None = None
    submenu: str = ""
    exclusive: bool = False
    rule: bool = False
    on_plots: bool = False

    @property
    def menu(self) -> str:
        """Return the menu's name as "Menu" or "Menu/Submenu"."""
        name = self.key.partition(".")[0].capitalize()
        return f"{name}/{self.submenu}" if self.submenu else name

    @property
    def keys(self) -> tuple[str, ...]:
        """Return all shortcuts in Qt's portable text format."""
        return tuple(k for k in (self.shortcut, *self.extra) if k)

    @property
    def single(self) -> bool:
        """Return whether one of the shortcuts is a key without modifiers.

        Such a shortcut is ignored in text fields, and the user can switch it off.
        """
        return not self.filtered and any(len(k) == 1 or k == "Space" for k in self.keys)


def native(key: str) -> str:
    """Return a shortcut in the operating system's notation."""
    return QKeySequence(key).toString(QKeySequence.SequenceFormat.NativeText)


def matches(sought: str, text: str) -> bool:
    """Return whether ``text`` matches every sought word.

    The text matches a sought word if it contains this word, or if one of its words contains the letters of
    the sought word in the same order.
    """
    return all(
        part in text.lower() or re.search(r"\b" + r"\w*?".join(map(re.escape, part)), text.lower())
        for part in sought.lower().split()
    )


class ActionSet(QObject, Generic[Window]):
    """All actions of one window as QActions."""

    def __init__(self, window: Window, entries: tuple[Action[Window], ...], single_keys: bool):
        super().__init__(window)
        self._window = window
        self.entries = entries
        self.qt: dict[str, QAction] = {}
        groups: dict[str, QActionGroup] = {}
        for entry in entries:
            action = self.qt[entry.key] = QAction(entry.text, window)
            action.triggered.connect(lambda _on=False, entry=entry: self.run(entry.key))
            action.setShortcutContext(Qt.ShortcutContext.WindowShortcut)
            if entry.checked is not None:
                action.setCheckable(True)
            if entry.exclusive:
                groups.setdefault(entry.menu, QActionGroup(self)).addAction(action)
            window.addAction(action)
        self.set_single_keys(single_keys)
        self.refresh()

    @property
    def on_plots(self) -> list[QAction]:
        """Return the actions that are in a plot's context menu."""
        return [self.qt[entry.key] for entry in self.entries if entry.on_plots]

    def run(self, key: str) -> None:
        """Run the action if it is enabled."""
        entry = next(e for e in self.entries if e.key == key)
        if entry.enabled(self._window):
            entry.run(self._window)
        self.refresh()

    def refresh(self) -> None:
        """Update text, check mark and enabled state of every action."""
        for entry in self.entries:
            action = self.qt[entry.key]
            action.setEnabled(entry.enabled(self._window))
            if entry.current_text is not None:
                action.setText(entry.current_text(self._window))
            if entry.checked is not None:
                action.setChecked(entry.checked(self._window))

    def set_single_keys(self, on: bool) -> None:
        """Enable or disable the shortcuts without modifiers."""
        for entry in self.entries:
            action = self.qt[entry.key]
            if entry.filtered:
                action.setText(f"{entry.text}\t{entry.shortcut}")
            elif on or not entry.single:
                action.setShortcuts([QKeySequence(k) for k in entry.keys])
            else:
                action.setShortcuts([QKeySequence(k) for k in entry.keys if len(k) > 1 and k != "Space"])
