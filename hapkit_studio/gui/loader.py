"""Loads in the window what a trial has compiled elsewhere, in pieces, so that no frame waits long."""

from collections.abc import Callable, Iterator
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.errors import LawError
from hapkit_studio.gui.own_scene import fitting
from hapkit_studio.workshop.reading import load_source
from hapkit_studio.workshop.source import Source
from hapkit_studio.workshop.verdict import Verdict, failed
from hapkit_studio.workshop.words import plain

Holder = Callable[[str, Path], str]
_WAIT_MS = 10


class Loader(QObject):
    """Emits ``loaded(environment, verdict)``, or ``failed(source, verdict)`` with what was in the way."""

    loaded = Signal(object, object)
    failed = Signal(object, object)

    def __init__(self, holder: Holder, parent: QObject | None = None):
        """holder names who else has a key, "" for nobody."""
        super().__init__(parent)
        self._holder = holder
        self._latest: dict[Path, Source] = {}

    def begin(self, source: Source, verdict: Verdict) -> None:
        """Load the very text whose trial went well; an older one of its file is not wanted any more."""
        self._latest[source.path] = source
        self._go_on(self._pieces(source, verdict))

    def _go_on(self, pieces: Iterator[int]) -> None:
        wait = next(pieces, None)
        if wait is not None:
            QTimer.singleShot(wait, self, lambda: self._go_on(pieces))

    def _pieces(self, source: Source, verdict: Verdict) -> Iterator[int]:
        try:
            environment = fitting(load_source(source))
            functions = environment.functions
            if functions:
                functions.begin()
            yield 0
            environment.force.compiled()
            yield 0
        except LawError as error:
            self.failed.emit(source, failed(plain(error), error.line))
            return
        other = self._holder(environment.key, source.path)
        if other:
            words = f'the key "{environment.key}" is that of {other} too: choose another one'
            self.failed.emit(source, failed(words))
            return
        while functions and not functions.ready:
            yield _WAIT_MS
        if self._latest[source.path] is source:
            self.loaded.emit(environment, verdict)
