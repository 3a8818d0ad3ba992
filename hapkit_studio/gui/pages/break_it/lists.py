"""The list of failures, and the side panel: explanation and conditions of the chosen failure."""

import html
import re
from collections.abc import Iterable

from PySide6.QtCore import QRect, QSize, Qt, Signal
from PySide6.QtWidgets import QAbstractItemView, QListWidget, QListWidgetItem, QStyledItemDelegate, QWidget

from hapkit_studio.analysis.failures import Failure
from hapkit_studio.formatting import on_screen
from hapkit_studio.gui.pages.base import SidePanel
from hapkit_studio.gui.pages.break_it.record import Record
from hapkit_studio.gui.panel.rows import ChoiceRow, ParameterRow
from hapkit_studio.gui.widgets.parts import hint, label, vbox
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.parameters import Choice

WIDE, NARROW = 244, 204
_SHORT = 6  # if a symbol has more letters than this, the label is shown instead
_PADDING, _MARGIN = 16, 6  # px: vertical padding of a row, horizontal margin of its text
_SAID = {None: "was not tried", True: "works", False: "fails"}
_SIGNS = {None: "", True: "✓", False: "✕"}
_KEY = Qt.ItemDataRole.UserRole


class _Wrapped(QStyledItemDelegate):
    """Gives a row the height of its wrapped text; Qt's own estimate is one line too high."""

    def sizeHint(self, option, index) -> QSize:
        width = option.widget.viewport().width() - theme.px(_MARGIN)
        text = QRect(0, 0, width, 1000)
        box = option.fontMetrics.boundingRect(text, Qt.TextFlag.TextWordWrap, index.data())
        return QSize(width, box.height() + theme.px(_PADDING))


class FailureList(QListWidget):
    """Lists failures with their limits and whether the method worked on each side; emits ``chosen(key)``."""

    chosen = Signal(str)

    def __init__(self, records: Iterable[Record]):
        super().__init__()
        self._items: dict[str, QListWidgetItem] = {}
        self.setObjectName("failures")
        self.setAccessibleName("Where methods fail")
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setWordWrap(True)
        self.setResizeMode(QListWidget.ResizeMode.Adjust)
        self.setItemDelegate(_Wrapped(self))
        self.setFixedWidth(WIDE)
        for record in records:
            item = self._items[record.failure.key] = QListWidgetItem(self)
            item.setData(_KEY, record.failure.key)
            item.setToolTip(f"<p>{record.failure.summary}.</p>")
            self.show_record(record)
        self.currentItemChanged.connect(lambda item: self.chosen.emit(item.data(_KEY)))

    def choose(self, key: str) -> None:
        """Select a failure, as a click does."""
        self.setCurrentItem(self._items[key])

    def show_record(self, record: Record, busy: bool = False) -> None:
        """Update a failure's row."""
        item, (inside, outside) = self._items[record.failure.key], record.signs
        title, known = record.failure.title, known_text(record, busy)
        shown = spoken = known
        if (inside, outside) != (None, None):
            shown = f"{known}\ninside {_SIGNS[inside]}   outside {_SIGNS[outside]}"
            spoken = f"Inside the limit the method {_SAID[inside]}, outside the limit it {_SAID[outside]}"
        item.setText(f"{title}\n{shown}")
        item.setData(Qt.ItemDataRole.AccessibleTextRole, f"{title}. {spoken}")


def known_text(record: Record, busy: bool) -> str:
    """Describe a failure's state or limit in a few words."""
    if busy:
        return "Measuring…"
    if record.wrong:
        return "Could not be tried"
    if "limit" in record.old:
        return "Out of date: conditions changed"
    if record.limit is None:
        return "Not tried yet"
    knob = record.failure.knob
    name = "" if knob.unit else f"{knob.symbol if 0 < len(knob.symbol) <= _SHORT else knob.label.lower()} "
    return f"Limit {name}{on_screen(record.limit, knob.unit)}"


_WHOSE = "The limit and the curves are for the values named here, not for the connected device."


def subscripts(text: str) -> str:
    """Return HTML in which a character after an underscore is a subscript."""
    return re.sub(r"_(\w)", r"<sub>\1</sub>", html.escape(text))


class FailureSide(SidePanel):
    """The side panel of a failure; emits ``changed(key, value)`` when the user changes a condition."""

    changed = Signal(str, float)

    def __init__(self) -> None:
        super().__init__()
        self.formula, self.why = label(), label(role="axis")
        for part in (self.formula, self.why):
            part.setTextFormat(Qt.TextFormat.RichText)
            self.add(part)
        self.formula.setFont(theme.font("formula"))
        self.section("Conditions")
        self.rows: dict[str, ParameterRow | ChoiceRow] = {}
        holder = QWidget()
        self._rows = vbox(into=holder)
        self.add(hint(_WHOSE), holder)

    def show_record(self, record: Record) -> None:
        """Show a failure and its conditions."""
        failure = record.failure
        if self.heading.text() != failure.title:
            self.heading.setText(failure.title)
            self.label.setText(f"{failure.summary}.")
            self.formula.setText(subscripts(failure.formula))
            self.why.setText(subscripts(failure.explanation))
            self._make_rows(failure)
            self.verticalScrollBar().setValue(0)
        for key, row in self.rows.items():
            if row.value != record.case[key]:
                row.show_value(record.case[key])

    def _make_rows(self, failure: Failure) -> None:
        for old in self.rows.values():
            self._rows.removeWidget(old)
            old.hide()
            old.deleteLater()
        self.rows = {}
        for option in failure.options:
            row = ChoiceRow(option) if isinstance(option, Choice) else ParameterRow(option)
            row.changed.connect(self.changed)
            self._rows.addWidget(row)
            self.rows[option.key] = row
