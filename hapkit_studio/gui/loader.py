"""Loads in the window what a trial has compiled elsewhere, in pieces, so that no frame waits long."""

from collections.abc import Callable, Iterator
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.errors import LawError
from hapkit_studio.gui.own_scene import fitting
from hapkit_studio.workshop import trust
from hapkit_studio.workshop.own import OwnEnvironment
from hapkit_studio.workshop.reading import load_text, text_of
from hapkit_studio.workshop.verdict import Problem, Verdict, failed
from hapkit_studio.workshop.words import plain

Holder = Callable[[str, Path], str]


class Loader(QObject):
    """Emits ``loaded(path, environment, verdict)``, or ``failed(path, verdict)`` with what was in the way."""

    loaded = Signal(object, object, object)
    failed = Signal(object, object)

    def __init__(self, holder: Holder, parent: QObject | None = None):
        """holder names who else has a key, "" for nobody."""
        super().__init__(parent)
        self._holder = holder

    def begin(self, path: Path, verdict: Verdict) -> None:
        """Load a file whose trial went well, if it still has the text that was tried."""
        self._go_on(self._pieces(path, verdict))

    def _go_on(self, pieces: Iterator[None]) -> None:
        if next(pieces, self) is None:
            QTimer.singleShot(0, self, lambda: self._go_on(pieces))

    def _pieces(self, path: Path, verdict: Verdict) -> Iterator[None]:
        try:
            environment = self._read(path, verdict.digest)
            yield
            environment.force.compiled()
            yield
        except LawError as error:
            self.failed.emit(path, Verdict((Problem(error.line, plain(error)),), digest=verdict.digest))
            return
        other = self._holder(environment.key, path)
        if other:
            words = f'the key "{environment.key}" is that of {other} too: choose another one'
            self.failed.emit(path, failed(words, digest=verdict.digest))
        else:
            self.loaded.emit(path, environment, verdict)

    @staticmethod
    def _read(path: Path, digest: str) -> OwnEnvironment:
        text = text_of(path)
        if trust.digest(text) != digest or not trust.is_trusted(text):
            raise LawError("the file was changed while it was checked")
        return fitting(load_text(text, path))
