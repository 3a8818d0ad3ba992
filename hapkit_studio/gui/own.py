"""A person's own environments: which files there are, trying them out, bringing them in force."""

from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.errors import LawError
from hapkit_studio.gui.editor.trial_runner import TrialRunner
from hapkit_studio.gui.loader import Loader
from hapkit_studio.gui.own_file import OwnFile, described
from hapkit_studio.gui.studio import Studio
from hapkit_studio.workshop import folder, tried, trust
from hapkit_studio.workshop.own import OwnEnvironment
from hapkit_studio.workshop.source import Source, read
from hapkit_studio.workshop.verdict import Verdict, failed
from hapkit_studio.workshop.words import plain


class OwnEnvironments(QObject):
    """Nothing of a file is executed here before a trial of the very same text went well elsewhere.

    ``asked(source)``: it was chosen, but nobody agreed to its text. ``chosen``: one that may run
    was, or one of the library. ``began(path)``, then ``judged(path, verdict)``: a trial. ``changed``: other
    files, or one that stands differently.
    """

    changed = Signal()
    asked = Signal(object)
    chosen = Signal()
    began = Signal(object)
    judged = Signal(object, object)

    def __init__(self, studio: Studio, parent: QObject | None = None):
        super().__init__(parent)
        self._studio = studio
        self._loaded: dict[Path, OwnEnvironment] = {}
        self._broken: dict[Path, str] = {}
        self._seen: dict[Path, tuple[tuple[int, ...], Source]] = {}
        self.files: list[OwnFile] = []
        self.runner = TrialRunner(self)
        self.runner.finished.connect(self._judge)
        self._loader = Loader(self._holder, self)
        self._loader.loaded.connect(self._take_in)
        self._loader.failed.connect(self._refuse)
        self.refresh()

    # what there is

    def refresh(self) -> None:
        """Look at the folder again: files come, go, and are changed by others."""
        found = [self._look(path) for path in folder.own_files()]
        for path in [p for p in self._loaded if p not in {file.path for file in found}]:
            self._forget(path)
        if found != self.files:
            self.files = found
            self.changed.emit()

    def seen(self, path: Path) -> Source:
        """Return a file as it was when it last changed, read once; raise LawError."""
        stamp = _stamp(path)
        if path not in self._seen or self._seen[path][0] != stamp:
            self._seen[path] = stamp, read(path)
        return self._seen[path][1]

    def path_of(self, key: str) -> Path | None:
        """Return the file of an environment, None for one of the library."""
        return next((path for path, e in self._loaded.items() if e.key == key), None)

    def loaded(self, path: Path) -> OwnEnvironment | None:
        """Return the environment of a file as it was loaded last, None where it never was."""
        return self._loaded.get(path)

    @property
    def in_force(self) -> Path | None:
        """Return the file of the environment in force, None for one of the library."""
        return self.path_of(self._studio.environment.key)

    # bringing them in force

    def choose(self, path: Path) -> None:
        """Switch to a file's environment: at once if it is loaded, after a trial, or after asking."""
        try:
            source = read(path)
        except LawError as error:
            self.judged.emit(path, failed(plain(error)))
            self.refresh()
            return
        if not trust.is_trusted(source):
            self.refresh()
            self.asked.emit(source)
            return
        self.chosen.emit()
        loaded = self._loaded.get(path)
        if loaded is not None and loaded.source == source:
            self._studio.choose(loaded.key)
        elif tried.has_passed(source):
            self._loader.begin(source, Verdict())
        else:
            self.run(source)

    def choose_built_in(self, key: str) -> None:
        """Switch to an environment of the library, even where it is in force already."""
        self.chosen.emit()
        self._studio.choose(key)

    def run(self, source: Source) -> None:
        """Try out a text that may run, in a program of its own; the law in force goes on meanwhile."""
        self._seen[source.path] = _stamp(source.path), source
        self.runner.begin(source)
        self.refresh()
        self.began.emit(source.path)

    def close(self) -> None:
        """End a trial that is under way."""
        self.runner.close()

    def _judge(self, source: Source, verdict: Verdict) -> None:
        tried.note(source, verdict.ok)
        if verdict.ok:
            self._loader.begin(source, verdict)
        else:
            self._refuse(source, verdict)

    def _refuse(self, source: Source, verdict: Verdict) -> None:
        self._broken[source.path] = source.digest
        self._tell(source.path, verdict)

    def _tell(self, path: Path, verdict: Verdict) -> None:
        self.refresh()
        self.judged.emit(path, verdict)

    def _take_in(self, environment: OwnEnvironment, verdict: Verdict) -> None:
        """Put a loaded environment in force, in the place of its older version."""
        path = environment.source.path
        old = self._loaded.get(path)
        self._loaded[path] = environment
        self._broken.pop(path, None)
        self._studio.adopt(environment)
        if old is not None and old.key != environment.key:
            self._studio.drop(old.key)
        QTimer.singleShot(0, self, lambda: self._tell(path, verdict))  # a frame may come in between

    def _holder(self, key: str, path: Path) -> str:
        """Return who else has a key, "" for nobody."""
        if key not in self._studio.environments:
            return ""
        holder = self.path_of(key)
        if holder == path:
            return ""
        return holder.name if holder else self._studio.environments[key].title

    def _look(self, path: Path) -> OwnFile:
        try:
            source = self.seen(path)
        except LawError:
            return described(path, "", "broken")
        return described(path, source.text, self._state(source))

    def _state(self, source: Source) -> str:
        if self.runner.path == source.path:
            return "checking"
        if not trust.is_trusted(source):
            return "foreign"
        broken = self._broken.get(source.path) == source.digest or tried.has_failed(source)
        return "broken" if broken else "ready"

    def _forget(self, path: Path) -> None:
        environment = self._loaded.pop(path)
        if self._studio.environment.key == environment.key:
            self._studio.choose("free")
        self._studio.drop(environment.key)


def _stamp(path: Path) -> tuple[int, ...]:
    """Return what changes with a file, () where there is none."""
    try:
        found = path.stat()
    except OSError:
        return ()
    return found.st_mtime_ns, found.st_size, found.st_ino
