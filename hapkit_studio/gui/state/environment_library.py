"""The environments that the user can choose, their values, and which of them are compiled."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from subprocess import Popen

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.dynamics.loop_settings import Reject, ignore
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import LawError, ParameterError
from hapkit_studio.parameters import AnyParameter, Choice

POLL_MS = 100
# the gallery shows these texts in place of the summary
WORDS = {"preparing": "Preparing…", "next": "Will be prepared next…", "broken": "The law cannot be compiled"}


class EnvironmentLibrary:
    """All available environments and their last values in SI, by key."""

    def __init__(self, library: Mapping[str, Environment]):
        self.environments = dict(library)
        self.values = {key: environment.values() for key, environment in library.items()}

    def put(self, environment: Environment) -> None:
        """Add an environment; it keeps the values of an older version with the same key."""
        key = environment.key
        kept = carried(self.environments[key], self.values[key], environment) if key in self.values else {}
        self.values[key] = usable(environment, kept)
        self.environments[key] = environment

    def drop(self, key: str) -> None:
        """Remove an environment and its values."""
        self.environments.pop(key, None)
        self.values.pop(key, None)


def carried(old: Environment, values: Mapping[str, float], new: Environment) -> dict[str, object]:
    """Return the values of an older version that are still valid, except those equal to their defaults."""
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
    """Return the valid values among those given, by key; pass the errors of the others to ``reject``."""
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
    """Return the given values that are valid, and the environment's defaults for the other parameters.

    If these values are invalid in combination, return only defaults.
    """
    try:
        return environment.values(checked(environment.parameters, given, reject))
    except ParameterError as error:
        reject(error)
        return environment.values()


class Readiness(QObject):
    """Tracks each environment's state: "ready", "preparing", "next" (requested) or "broken".

    Polling stops once all environments are ready. If the compiling programs have ended and a law is still
    missing, the law is compiled in the window when the user chooses it. ``changed`` is emitted when a state
    has changed, ``request_ready(key)`` when the requested environment is compiled.
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
        """Return the keys of the environments that are still being compiled."""
        return tuple(self._waiting)

    def state(self, key: str) -> str:
        """Return an environment's state."""
        if key in self._broken:
            return "broken"
        if key in self._waiting:
            return "next" if key == self.requested else "preparing"
        return "ready"

    def expect(self, library: Mapping[str, Environment], soon: Collection[str]) -> None:
        """Start waiting for all environments that are not compiled.

        The environments in ``soon`` are excluded, because they are compiled together with the loop.
        """
        self._waiting = {k: e for k, e in library.items() if k not in soon and not e.force.is_compiled()}
        if self._waiting:
            self._watch.start()
            self.changed.emit()

    def follow(self, programs: Sequence[Popen]) -> None:
        """Stop waiting once these programs, which compile the expected environments, have ended."""
        self._programs = programs
        self.refresh()

    def request(self, key: str) -> bool:
        """Return whether an environment is ready; if not, request it in place of an earlier request."""
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
        """Discard the request, because the user has selected another environment."""
        if self.requested is not None:
            self.requested = None
            self.changed.emit()

    def stop(self) -> None:
        """Stop polling."""
        self._watch.stop()

    def refresh(self) -> None:
        """Update the states; if the requested environment is compiled, emit ``request_ready``."""
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
