"""What happens to the open law without a key pressed: it faults in the loop, or others change its file."""

import re

import numpy as np
from PySide6.QtCore import QObject

from hapkit_studio.errors import LawError
from hapkit_studio.gui.editor.desk import Desk
from hapkit_studio.gui.studio import Studio
from hapkit_studio.haptics import rows
from hapkit_studio.workshop.reading import text_of

_LINE = re.compile(r"\bline (\d+)")


class Watch(QObject):
    """Tells the page of the law that is open."""

    def __init__(self, studio: Studio, desk: Desk, parent: QObject | None = None):
        super().__init__(parent)
        self._studio, self._desk = studio, desk
        self._fault = ""

    def look_at_files(self) -> None:
        """Notice what others did to the files; an open law follows, unless it was changed here too."""
        desk = self._desk
        desk.own.refresh()
        if desk.path is None or desk.page.unsaved:
            return
        try:
            text = text_of(desk.path)
        except LawError:
            return
        if text != desk.page.text:
            desk.page.open(desk.path, text)
            desk.strip.say("Changed outside the studio. Read it, then save it to run it.", "warn")

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
