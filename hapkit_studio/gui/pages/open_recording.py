"""Opens a file that contains a recording: a session file or a table.

If the program does not know a table's columns, a dialog asks the user for their meaning.
"""

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QComboBox, QPushButton, QWidget

from hapkit_studio import tables
from hapkit_studio.gui.state.background import Job, Progress
from hapkit_studio.gui.widgets.dialogs import FormDialog
from hapkit_studio.gui.widgets.parts import choose_file
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.sessions.file import SUFFIX
from hapkit_studio.tables import NEEDED, UNITS, Table, TableColumn, TableColumns, UnknownColumnsError

_KINDS = f"Recordings (*.csv *.txt *.tsv *{SUFFIX});;All files (*)"
_ABOUT = (
    "The program does not know the columns of “{}”. Choose the column and the unit of each quantity. The "
    "force is the one that acts on the handle. Force and position must be positive to the right."
)
_UNIT_WIDTH = 84  # px: width of the list of units
_COMPUTED = "Computed from the position"


class RecordingOpener(QObject):
    """Reads a recording in a thread; emits ``opened(recording, path)``, or ``failed`` with the reason."""

    opened = Signal(object, object)
    failed = Signal(str)

    def __init__(self, parent: QWidget):
        super().__init__(parent)
        self._parent = parent
        # columns that the user chose for earlier files; the key is the tuple of the file's column names
        self._named: dict[tuple[str, ...], TableColumns] = {}
        self._job = Job(self, needs="")
        self._job.finished.connect(self._take)
        self._job.failed.connect(self.failed)

    def ask(self) -> None:
        """Ask for a file, then open it."""
        choose_file(self._parent, "Open a recording", _KINDS, self.open)

    def open(self, path: str, columns: TableColumns | None = None) -> None:
        """Open a file; without ``columns``, ask the user for them if the file has unknown column names."""

        def work(_progress: Progress) -> tuple[Path, object]:
            from hapkit_studio import api  # imported late to keep start-up fast

            try:
                return Path(path), api.open_recording(path, columns)
            except UnknownColumnsError as error:
                return Path(path), error.table

        self._job.start(work)

    def _take(self, result: tuple[Path, object]) -> None:
        path, found = result
        if isinstance(found, Table):
            self._ask_columns(path, found)
        else:
            self.opened.emit(found, path)

    def _ask_columns(self, path: Path, table: Table) -> None:
        def take(columns: TableColumns) -> None:
            self._named[table.names] = columns
            self.open(str(path), columns)

        known = self._named.get(table.names) or tables.guess(table.names)
        ColumnsDialog(table, known, take, self._parent.window()).show()


class ColumnsDialog(FormDialog):
    """Asks for the column and the unit of each quantity in a table; a guess is preselected."""

    def __init__(
        self,
        table: Table,
        guessed: TableColumns,
        then: Callable[[TableColumns], object],
        parent: QWidget | None,
    ):
        super().__init__("Columns of the recording", _ABOUT.format(table.file), parent)
        self._then = then
        self.names: dict[str, QComboBox] = {}
        self.units: dict[str, QComboBox] = {}
        samples = list(zip(*(row[: len(table.names)] for row in table.preview), strict=False))
        for quantity in (*NEEDED, "velocity"):
            names, units = self.names[quantity], self.units[quantity] = QComboBox(), QComboBox()
            names.addItem("Choose a column…" if quantity in NEEDED else _COMPUTED)
            for name, values in zip(table.names, samples, strict=False):
                names.addItem(f"{name}   ({'  '.join(values)} …)", name)
            units.addItems(list(UNITS[quantity]))
            if quantity in guessed:
                names.setCurrentIndex(names.findData(guessed[quantity].name))
                units.setCurrentText(guessed[quantity].unit)
            units.setAccessibleName(f"Unit of the {quantity}")
            units.setFixedWidth(theme.px(_UNIT_WIDTH))
            names.currentIndexChanged.connect(self._refresh)
        order = (*NEEDED, "velocity")
        self.add_fields((key.capitalize(), self.names[key], self.units[key]) for key in order)
        self.add_verdict(1)
        self.take = QPushButton("Open recording")
        self.take.clicked.connect(self._hand_over)
        self.leave.setText("Cancel")
        self.add_buttons(self.take)
        self._refresh()

    @property
    def columns(self) -> TableColumns:
        """Return the chosen columns by quantity."""
        chosen = {key: names.currentData() for key, names in self.names.items()}
        return {key: TableColumn(name, self.units[key].currentText()) for key, name in chosen.items() if name}

    def _refresh(self) -> None:
        """Show for which quantities the user must still choose a column."""
        chosen = self.columns
        missing = [quantity for quantity in NEEDED if quantity not in chosen]
        twice = len({column.name for column in chosen.values()}) < len(chosen)
        self.units["velocity"].setEnabled("velocity" in chosen)
        self.take.setEnabled(not (missing or twice))
        if missing:
            self.verdict.show_text(f"Choose the column of the {' and the '.join(missing)}.")
        elif twice:
            self.verdict.show_text(
                "Two quantities use the same column. Choose a different column for one of them.",
                "triangle",
                "warn",
            )
        else:
            self.verdict.show_text("Check the units, then press Open recording.")

    def _hand_over(self) -> None:
        self.close()
        self._then(self.columns)
