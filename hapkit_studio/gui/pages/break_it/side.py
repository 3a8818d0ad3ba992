"""Why it fails: title, what it is, the formula, the reason, and the conditions that can be changed."""

import html
import re

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from hapkit_studio.gui.pages.base import SidePanel, hint
from hapkit_studio.gui.pages.break_it.record import Record
from hapkit_studio.gui.panel.rows import ChoiceRow, ParameterRow
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.parameters import Choice

_ROOM_FOR_SLIDERS = 760
_NARROW = 290
_WHOSE = "Limit and curves are of the device and loop named here, not of the one that is connected."


def subscripts(text: str) -> str:
    """Return a text as HTML, what follows an underscore set lower."""
    return re.sub(r"_(\w)", r"<sub>\1</sub>", html.escape(text))


class FailureSide(SidePanel):
    """Emits ``changed(key, value)`` when a person changes a condition."""

    changed = Signal(str, float)

    def __init__(self) -> None:
        super().__init__("", "")
        self.formula, self.why = QLabel(), QLabel()
        for label in (self.formula, self.why):
            label.setWordWrap(True)
            label.setTextFormat(Qt.TextFormat.RichText)
            self.add(label)
        self.formula.setFont(theme.font("formula"))
        dress(self.why, "QLabel { color: @ink2; }")
        self.section("Conditions")
        self.add(hint(_WHOSE))
        self.rows: dict[str, ParameterRow | ChoiceRow] = {}
        self._holder = QWidget()
        self._rows = QVBoxLayout(self._holder)
        self._rows.setContentsMargins(0, 0, 0, 0)
        self._rows.setSpacing(0)
        self.add(self._holder)
        self._key = ""
        self._room = (False, True)

    def show_record(self, record: Record) -> None:
        """Show a failure and the conditions it is tried under."""
        failure = record.failure
        if self._key != failure.key:
            self._key = failure.key
            self.heading.setText(failure.title)
            self.words.setText(f"{failure.summary}.")
            self.formula.setText(subscripts(failure.formula))
            self.why.setText(subscripts(failure.explanation))
            self._make_rows(record)
            self.verticalScrollBar().setValue(0)
        for key, row in self.rows.items():
            if row.value != record.case[key]:
                row.show_value(record.case[key])

    def set_room(self, width: int, height: int) -> None:
        """Leave sliders out where the window is low."""
        self._room = (width < _NARROW, height < _ROOM_FOR_SLIDERS)
        for row in self.rows.values():
            self._fit(row)

    def _make_rows(self, record: Record) -> None:
        for old in self.rows.values():
            self._rows.removeWidget(old)
            old.hide()
            old.deleteLater()
        self.rows = {}
        for option in record.failure.options:
            row = ChoiceRow(option) if isinstance(option, Choice) else ParameterRow(option)
            row.changed.connect(self.changed)
            self._rows.addWidget(row)
            self.rows[option.key] = row
            self._fit(row)

    def _fit(self, row: ParameterRow | ChoiceRow) -> None:
        if isinstance(row, ParameterRow):
            row.set_narrow(self._room[0])
            row.set_compact(self._room[1])
