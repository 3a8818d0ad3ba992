"""A table that shows the differences between two sets of settings."""

from collections.abc import Iterable

from PySide6.QtCore import Qt

from hapkit_studio.columns import Column
from hapkit_studio.dynamics.loop_settings import Difference
from hapkit_studio.gui.widgets.table import Table


class DifferenceTable(Table):
    """Shows one row per setting: its name with the unit, and both values."""

    def __init__(self, old: str, new: str):
        super().__init__("Settings that differ")
        # a click focuses the table for Ctrl+C (copy); the Tab key skips it, so that Enter presses a button
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self._columns = (
            Column("Setting", lambda row: ", ".join(filter(None, (row.name, row.unit))), right=False),
            Column(old, lambda row: row.old),
            Column(new, lambda row: row.new),
        )

    def show_differences(self, found: Iterable[Difference]) -> None:
        """Show these differences."""
        self.show_rows(self._columns, found)
