"""The user's own environments: list of files, trial, loading and selection.

This process executes no code of a file before the same text has passed a trial in another process.
"""

import ast
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.errors import LawError
from hapkit_studio.gui.state.background import Job, Progress
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.laws.translate import parse
from hapkit_studio.workshop import folder, trial
from hapkit_studio.workshop.own import OwnEnvironment, built_in
from hapkit_studio.workshop.reading import calls, load_source, without_line
from hapkit_studio.workshop.source import Source, is_trusted, read
from hapkit_studio.workshop.trying import TrialResult, failed, remarks

_LONGEST = 60
BARE = "bare handle"
POLL_SECONDS = 0.02
_WAIT_MS = 10


@dataclass(frozen=True)
class OwnFile:
    """One file of the folder; its state is ready, checking, broken, or foreign (not trusted yet)."""

    path: Path
    title: str
    summary: str = ""
    scene: str = ""
    state: str = "ready"


def describe(path: Path, text: str, state: str) -> OwnFile:
    """Return a file with its declared title, summary and scene.

    A missing title is replaced by the file's name.
    """
    texts = declared_texts(text)
    title = texts.get("title") or path.stem.replace("_", " ").capitalize()
    return OwnFile(path, title[:_LONGEST], texts.get("summary", "")[:_LONGEST], texts.get("scene", ""), state)


@lru_cache(maxsize=64)
def declared_texts(text: str) -> Mapping[str, str]:
    """Return title, summary and scene from the text of ``Environment(…)`` without executing the text."""
    try:
        tree = parse(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return {}
    found: dict[str, str] = {}
    for given in (given for call in calls(tree, "Environment") for given in call.keywords):
        match given:
            case ast.keyword(arg="title" | "summary" | "scene" as name, value=ast.Constant(value=str(value))):
                found[name] = " ".join(value.split())
    return found


def with_fitting_scene(environment: OwnEnvironment) -> OwnEnvironment:
    """Return the environment with the scene that it names; if this scene does not fit, with the handle only.

    A scene reads parameters and state by name. The environment must therefore have the same state names, and
    the limits of its parameters must lie within those for which the scene was drawn.
    """
    theirs = built_in().get(environment.scene)
    if theirs is None:
        return environment
    mine = {p.key: p for p in environment.parameters}
    inside = all(
        type(mine[p.key]) is type(p) and p.low <= mine[p.key].low and mine[p.key].high <= p.high
        for p in theirs.parameters
        if p.key in mine
    )
    if inside and environment.state_names == theirs.state_names:
        return environment
    return replace(environment, scene=BARE)


def _tried(source: Source, progress: Progress) -> tuple[Source, TrialResult]:
    """Try a text in another process and return the result; a time-out or a cancel stops the process."""
    try:
        process = trial.begin(source)
    except OSError as error:
        return source, failed(f"the file cannot be tried out: {error.strerror}")
    end = time.monotonic() + trial.TIMEOUT
    try:
        while process.poll() is None and time.monotonic() < end:
            progress(0, 0)  # this call raises if the trial was cancelled
            time.sleep(POLL_SECONDS)
        return source, trial.result(process, 0.0)
    finally:
        if process.poll() is None:
            trial.stop(process)


class OwnEnvironments(QObject):
    """The user's own environments.

    This process executes a file only after the file has passed a trial in another process.

    ``asked(source)`` is emitted when the user has chosen an untrusted file, ``chosen`` when the user has
    chosen a trusted file or a built-in environment. ``began(path)`` and ``judged(path, verdict)`` are emitted
    at the start and the end of a trial, ``changed`` when the files or their states have changed.
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
        self.runner = Job(self, needs="")
        self.runner.finished.connect(lambda found: self._judge(*found))
        self.checking: Path | None = None
        self._latest: dict[Path, Source] = {}  # for each file, the newest text to be loaded
        self.refresh()

    # files

    def refresh(self) -> None:
        """Read the folder again, because other programs may add, remove or change files."""
        found = [self._describe(path) for path in folder.own_files()]
        for path in [p for p in self._loaded if p not in {file.path for file in found}]:
            self._forget(path)
        if found != self.files:
            self.files = found
            self.changed.emit()

    def seen(self, path: Path) -> Source:
        """Return a file's text, cached until the file changes; raise LawError if the file cannot be read."""
        stamp = _stamp(path)
        if path not in self._seen or self._seen[path][0] != stamp:
            self._seen[path] = stamp, read(path)
        return self._seen[path][1]

    def path_of(self, key: str) -> Path | None:
        """Return the file of an environment; None for a built-in one."""
        return next((path for path, e in self._loaded.items() if e.key == key), None)

    def loaded(self, path: Path) -> OwnEnvironment | None:
        """Return the environment that was loaded last from a file; None if the file was not loaded."""
        return self._loaded.get(path)

    @property
    def active(self) -> Path | None:
        """Return the file of the current environment; None for a built-in one."""
        return self.path_of(self._studio.environment.key)

    # selecting

    def choose(self, path: Path) -> None:
        """Select a file's environment, if necessary after a trial; for an untrusted file, emit ``asked``."""
        try:
            source = read(path)
        except LawError as error:
            self.judged.emit(path, failed(without_line(error)))
            self.refresh()
            return
        if not is_trusted(source):
            self.refresh()
            self.asked.emit(source)
            return
        self.chosen.emit()
        loaded = self._loaded.get(path)
        if loaded is not None and loaded.source == source:
            self._studio.choose(loaded.key)
        elif trial.has_passed(source):
            self._load(source, TrialResult())
        else:
            self.run(source)

    def choose_built_in(self, key: str) -> None:
        """Select a built-in environment; this also works if it is the current one."""
        self.chosen.emit()
        self._studio.choose(key)

    def run(self, source: Source) -> None:
        """Try a trusted text in another process; the current law keeps running."""
        self._seen[source.path] = _stamp(source.path), source
        self.checking = source.path
        self.runner.start(partial(_tried, source))
        self.refresh()
        self.began.emit(source.path)

    def _judge(self, source: Source, verdict: TrialResult) -> None:
        self.checking = None
        trial.remember(source, verdict.ok)
        if verdict.ok:
            self._load(source, verdict)
        else:
            self._refuse(source, verdict)

    def _load(self, source: Source, verdict: TrialResult) -> None:
        """Load the text that has passed its trial, unless there is a newer text of the same file."""
        self._latest[source.path] = source
        self._go_on(self._steps(source, verdict))

    def _go_on(self, steps: Iterator[int]) -> None:
        wait = next(steps, None)
        if wait is not None:
            QTimer.singleShot(wait, self, lambda: self._go_on(steps))

    def _steps(self, source: Source, verdict: TrialResult) -> Iterator[int]:
        """Load a text and select its environment, or refuse it; yield the time in ms until the next step."""
        try:
            environment = with_fitting_scene(load_source(source))
            functions = environment.functions
            if functions:
                functions.begin()
            yield 0
            environment.force.compiled()
            yield 0
        except LawError as error:
            self._refuse(source, failed(without_line(error), error.line))
            return
        if other := self._key_owner(environment.key, source.path):
            text = f'the key "{environment.key}" is already used by {other}: choose another one'
            self._refuse(source, failed(text))
            return
        while functions and not functions.ready:
            yield _WAIT_MS
        if self._latest[source.path] is source:
            self._activate(environment, verdict)

    def _refuse(self, source: Source, verdict: TrialResult) -> None:
        self._broken[source.path] = source.digest
        self._publish(source.path, verdict)

    def _publish(self, path: Path, verdict: TrialResult) -> None:
        self.refresh()
        self.judged.emit(path, verdict)

    def _activate(self, environment: OwnEnvironment, verdict: TrialResult) -> None:
        """Select a loaded environment in place of its older version."""
        path = environment.source.path
        if verdict == TrialResult():  # the result of an earlier trial has no remarks
            verdict = TrialResult(remarks=remarks(environment))
        old = self._loaded.get(path)
        self._loaded[path] = environment
        self._broken.pop(path, None)
        self._studio.adopt(environment)
        if old is not None and old.key != environment.key:
            self._studio.drop(old.key)
        QTimer.singleShot(0, self, lambda: self._publish(path, verdict))  # publish after the next frame

    def _key_owner(self, key: str, path: Path) -> str:
        """Return the name of another file or environment that uses a key; "" if the key is free."""
        if key not in self._studio.environments:
            return ""
        owner = self.path_of(key)
        if owner == path:
            return ""
        return owner.name if owner else self._studio.environments[key].title

    def _describe(self, path: Path) -> OwnFile:
        try:
            source = self.seen(path)
        except LawError:
            return describe(path, "", "broken")
        broken = self._broken.get(path) == source.digest or trial.has_failed(source)
        state = "checking" if self.checking == path else "foreign" if not is_trusted(source) else ""
        return describe(path, source.text, state or ("broken" if broken else "ready"))

    def _forget(self, path: Path) -> None:
        environment = self._loaded.pop(path)
        if self._studio.environment.key == environment.key:
            self._studio.choose("free")
        self._studio.drop(environment.key)


def _stamp(path: Path) -> tuple[int, ...]:
    """Return a value that changes with a file's content; () if the file does not exist."""
    try:
        found = path.stat()
    except OSError:
        return ()
    return found.st_mtime_ns, found.st_size, found.st_ino
