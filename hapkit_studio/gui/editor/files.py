"""What is done to own files outside of their text: opened from elsewhere, shown in their folder, deleted."""

from pathlib import Path

from PySide6.QtCore import QFile, QObject, QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QFileDialog, QHBoxLayout, QLabel, QPushButton, QWidget

from hapkit_studio.gui.editor.desk import Desk
from hapkit_studio.gui.help_dialog import Sheet
from hapkit_studio.gui.rich import plain


class Files(QObject):
    """Its dialogs stand beside the window; none of them blocks it while the motor is on."""

    def __init__(self, desk: Desk, window: QWidget):
        super().__init__(window)
        self._desk, self._window = desk, window

    def open(self) -> None:
        """Let a file be chosen from anywhere; its source is shown before anything else."""
        dialog = QFileDialog(self._window, "Open an environment", str(Path.home()), "Python files (*.py)")
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        dialog.setModal(False)
        dialog.fileSelected.connect(lambda name: self._desk.bring(Path(name)))
        dialog.finished.connect(dialog.deleteLater)
        dialog.show()

    def reveal(self, path: Path) -> None:
        """Open the folder a file is in."""
        QDesktopServices.openUrl(QUrl.fromLocalFile(str(path.parent)))

    def delete(self, path: Path) -> None:
        """Ask, then move a file to the system's bin."""
        DeleteSheet(path, self._desk, self._window).show()


class DeleteSheet(Sheet):
    """Asks whether a file may go; the safe answer has the focus."""

    def __init__(self, path: Path, desk: Desk, parent: QWidget):
        super().__init__(f"Delete {path.name}?", parent)
        self._path, self._desk = path, desk
        self.words = plain(QLabel("It goes to the bin, from where it can be fetched back."))
        self.words.setWordWrap(True)
        self.words.setMinimumWidth(360)
        self.keep, self.delete = QPushButton("Keep it"), QPushButton("Move to bin")
        self.keep.clicked.connect(self.close)
        self.delete.clicked.connect(self._delete)
        row = QHBoxLayout()
        row.addStretch(1)
        row.addWidget(self.keep)
        row.addWidget(self.delete)
        self.column.addWidget(self.words)
        self.column.addLayout(row)
        self.keep.setFocus()

    def _delete(self) -> None:
        if QFile.moveToTrash(str(self._path)):
            self._desk.forget(self._path)
            self.close()
        else:
            self.words.setText(f"There is no bin for {self._path.parent}. Delete the file there by hand.")
            self.delete.hide()
