"""Saving what a page shows: a picture or its numbers, by the file name's ending."""

import json
from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QDir
from PySide6.QtWidgets import QFileDialog, QWidget

from hapkit_studio.errors import StudioError
from hapkit_studio.gui.tabs.job import Job, Progress

_KINDS = "Picture (*.png);;Drawing (*.svg);;Page (*.pdf);;Numbers (*.json)"


def write(path: str | Path, figure: Callable[[str], object], numbers: Callable[[], dict]) -> str:
    """Write a picture by ``figure(path)``, or numbers as one JSON object where the name says so.

    Return the path. Raise OSError, ParameterError.
    """
    if Path(path).suffix.lower() == ".json":
        Path(path).write_text(json.dumps(numbers(), ensure_ascii=False, indent=2), encoding="utf-8")
    else:
        figure(str(path))
    return str(path)


class Export:
    """Asks for a file name, then writes in a thread; ``say(words, danger)`` tells what became of it."""

    def __init__(self, parent: QWidget, name: str, say: Callable[..., None]):
        self._parent, self._name, self._say = parent, name, say
        self.job = Job(parent, needs="")
        self.job.finished.connect(lambda path: say(f"Saved {Path(path).name}"))
        self.job.failed.connect(lambda text: say(text, danger=True))

    def ask(self, figure: Callable[[str], object], numbers: Callable[[], dict]) -> None:
        """Open the dialog beside the window: nothing waits for it, and the E-stop stays within reach."""
        dialog = QFileDialog(self._parent, "Export", QDir.homePath(), _KINDS)
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setDefaultSuffix("png")
        dialog.filterSelected.connect(lambda kind: dialog.setDefaultSuffix(kind.split("*.")[1][:-1]))
        dialog.selectFile(f"{self._name}.png")
        dialog.fileSelected.connect(lambda path: self.save(path, figure, numbers))
        dialog.setModal(False)
        dialog.finished.connect(dialog.deleteLater)
        dialog.show()

    def save(self, path: str, figure: Callable[[str], object], numbers: Callable[[], dict]) -> None:
        """Write to a path."""

        def work(_progress: Progress) -> str:
            try:
                return write(path, figure, numbers)
            except OSError as error:
                raise StudioError(f"{Path(path).name} cannot be written: {error.strerror}.") from error

        self.job.start(work)
