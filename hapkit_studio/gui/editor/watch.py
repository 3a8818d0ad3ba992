"""What happens to the open law without a key pressed: it faults in the loop, or others change its file."""

import re

import numpy as np
from PySide6.QtCore import QFileSystemWatcher, QObject, QTimer

from hapkit_studio.errors import LawError
from hapkit_studio.gui.editor.desk import Desk
from hapkit_studio.gui.studio import Studio
from hapkit_studio.haptics import rows
from hapkit_studio.workshop import folder

SETTLED_MS = 200
_LINE = re.compile(r"\bline (\d+)")


class Watch(QObject):
    """Tells the page of the law that is open."""

    def __init__(self, studio: Studio, desk: Desk, parent: QObject | None = None):
        super().__init__(parent)
        self._studio, self._desk = studio, desk
        self._fault = ""
        self._soon = QTimer(self, interval=SETTLED_MS, singleShot=True)
        self._soon.timeout.connect(self.look_at_files)
        self._files = QFileSystemWatcher(self)
        self._files.directoryChanged.connect(self._soon.start)
        self._files.fileChanged.connect(self._soon.start)
        desk.own.changed.connect(self._watch)
        self._watch()

    def look_at_files(self) -> None:
        """Notice what others did to the files; an open law follows, unless it was changed here too."""
        desk = self._desk
        desk.own.refresh()
        self._watch()
        if desk.path is None or desk.page.unsaved:
            return
        try:
            text = desk.own.seen(desk.path).text
        except LawError:
            return
        if text != desk.page.text:
            desk.page.open(desk.path, text)
            desk.strip.say("Changed outside the studio. Read it, then save it to run it.", "warn")

    def _watch(self) -> None:
        """Listen to the folder and its files; before there is a folder, to the nearest one above it."""
        wanted = {str(path) for path in (folder.existing(), *(file.path for file in self._desk.own.files))}
        heard = {*self._files.directories(), *self._files.files()}
        if heard - wanted:
            self._files.removePaths(sorted(heard - wanted))
        if wanted - heard:
            self._files.addPaths(sorted(wanted - heard))

    def look_at_row(self, row: np.ndarray, _clamped: bool) -> None:
        """Mark the line that a fault of this very law stands on, once."""
        if not int(row[rows.FLAGS]) & rows.FAULT:
            self._fault = ""
            return
        fault = self._studio.fault
        if fault is None or fault.text == self._fault:
            return
        self._fault = fault.text
        line = _LINE.search(fault.text)
        desk = self._desk
        if line is None or desk.path is None or desk.path != desk.own.in_force:
            return
        if not desk.page.unsaved:  # else its lines are not those of the law in the loop
            desk.page.code.mark([(int(line[1]), fault.text.removeprefix("Fault: "))])
        desk.strip.say(fault.text, "danger")
