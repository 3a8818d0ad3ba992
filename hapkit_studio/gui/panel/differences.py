"""A table of what differs between two settings."""

from collections.abc import Iterable

from PySide6.QtCore import Qt

from hapkit_studio.columns import Column
from hapkit_studio.dynamics.loop_settings import Difference
from hapkit_studio.gui.widgets.table import Table


class DifferenceTable(Table):
    """A row a setting: its name with the unit, and both values under their heads."""

    def __init__(self, old: str, new: str):
        super().__init__("What differs")
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)  # Ctrl+C copies it; Enter is for the buttons
        self._columns = (
            Column("Setting", lambda row: ", ".join(filter(None, (row.name, row.unit))), right=False),
            Column(old, lambda row: row.old),
            Column(new, lambda row: row.new),
        )

    def show_differences(self, found: Iterable[Difference]) -> None:
        """Show these from top to bottom."""
        self.show_rows(self._columns, found)
