"""The environments that can be chosen, the values of each, and which are compiled already."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from subprocess import Popen

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.dynamics.loop_settings import Reject, ignore
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import LawError, ParameterError
from hapkit_studio.parameters import AnyParameter, Choice

POLL_MS = 100
# What a row says instead of its summary.
WORDS = {"preparing": "Preparing…", "next": "Preparing, comes next…", "broken": "Its law cannot be compiled"}


class EnvironmentLibrary:
    """Every environment that can be chosen and the values it was left with, by key; values are SI."""

    def __init__(self, library: Mapping[str, Environment]):
        self.environments = dict(library)
        self.values = {key: environment.values() for key, environment in library.items()}

    def put(self, environment: Environment) -> None:
        """Take an environment in; one of the same key leaves it its values."""
        key = environment.key
        kept = carried(self.environments[key], self.values[key], environment) if key in self.values else {}
        self.values[key] = usable(environment, kept)
        self.environments[key] = environment

    def drop(self, key: str) -> None:
        """Forget an environment and its values."""
        self.environments.pop(key, None)
        self.values.pop(key, None)


def carried(old: Environment, values: Mapping[str, float], new: Environment) -> dict[str, object]:
    """Return an older version's values that still mean something; one never moved follows its default."""
    before = {p.key: p for p in old.parameters}
    kept: dict[str, object] = {}
    for parameter in new.parameters:
        was = before.get(parameter.key)
        if was is not None and type(was) is type(parameter) and values[was.key] != was.default:
            kept[was.key] = was.text(values[was.key]) if isinstance(was, Choice) else values[was.key]
    return kept


def checked(
    parameters: Iterable[AnyParameter],
    given: Mapping[str, object],
    reject: Reject = ignore,
) -> dict[str, float]:
    """Return the valid ones of some values by key; ``reject`` gets the error of each of the others."""
    kept: dict[str, float] = {}
    for parameter in parameters:
        if parameter.key in given:
            try:
                kept[parameter.key] = parameter.check(given[parameter.key])
            except ParameterError as error:
                reject(error)
    return kept


def usable(
    environment: Environment,
    given: Mapping[str, object],
    reject: Reject = ignore,
) -> dict[str, float]:
    """Return an environment's values, with what it can use of others; with none where they do not agree."""
    try:
        return environment.values(checked(environment.parameters, given, reject))
    except ParameterError as error:
        reject(error)
        return environment.values()


class Readiness(QObject):
    """Knows each environment's state: "ready", "preparing", "next" (it is requested) or "broken".

    Nothing is looked at once everything is ready. Where the programs that compile have ended, or died, and a
    law is not there, it is compiled in the window when it is chosen: late rather than never.
    ``changed``: a state; ``request_ready(key)``: what was requested last is compiled now.
    """

    changed = Signal()
    request_ready = Signal(str)

    def __init__(self, parent: QObject | None = None):
        super().__init__(parent)
        self._waiting: dict[str, Environment] = {}
        self._late: dict[str, Environment] = {}
        self._broken: set[str] = set()
        self._programs: Sequence[Popen] | None = None
        self.requested: str | None = None
        self._watch = QTimer(self, interval=POLL_MS)
        self._watch.timeout.connect(self.refresh)

    @property
    def waiting(self) -> tuple[str, ...]:
        """Return the keys of what is still being compiled."""
        return tuple(self._waiting)

    def state(self, key: str) -> str:
        """Return how an environment stands."""
        if key in self._broken:
            return "broken"
        if key in self._waiting:
            return "next" if key == self.requested else "preparing"
        return "ready"

    def expect(self, library: Mapping[str, Environment], soon: Collection[str]) -> None:
        """Wait from now on for what is not compiled, but for those that the loop begins with."""
        self._waiting = {k: e for k, e in library.items() if k not in soon and not e.force.is_compiled()}
        if self._waiting:
            self._watch.start()
            self.changed.emit()

    def follow(self, programs: Sequence[Popen]) -> None:
        """Wait for these programs, which compile what is expected, and no longer."""
        self._programs = programs
        self.refresh()

    def request(self, key: str) -> bool:
        """Return whether an environment is ready; if not, it is requested, in place of an older request."""
        environment = self._late.pop(key, None)
        if environment is not None:
            try:
                environment.force.compiled()
            except LawError:
                self._broken.add(key)
        ready = self.state(key) == "ready"
        if not ready or self.requested is not None:
            self.requested = key if key in self._waiting else None
            self.changed.emit()
        return ready

    def drop_request(self) -> None:
        """Drop the request: something else was put in force."""
        if self.requested is not None:
            self.requested = None
            self.changed.emit()

    def stop(self) -> None:
        """Stop waiting."""
        self._watch.stop()

    def refresh(self) -> None:
        """See what has been compiled; announce the requested one if it has."""
        done = self._programs is not None and all(p.poll() is not None for p in self._programs)
        ready = [key for key, e in self._waiting.items() if e.force.is_compiled()]
        for key in ready:
            del self._waiting[key]
        if done:
            self._late, self._waiting = self._waiting, {}
        if not self._waiting:
            self._watch.stop()
        if ready or done:
            self.changed.emit()
        if self.requested is not None and self.requested not in self._waiting:
            self.request_ready.emit(self.requested)
