"""The environments that can be chosen, the values of each, and which are compiled already."""

from collections.abc import Collection, Mapping, Sequence
from subprocess import Popen
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.environments import discover
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import LawError, ParameterError
from hapkit_studio.parameters import Choice

if TYPE_CHECKING:
    from hapkit_studio.haptics.engine import Engine

LOOK_MS = 100
# What a row says instead of its summary.
WORDS = {
    "preparing": "Preparing…",
    "next": "Preparing, comes next…",
    "broken": "Its law cannot be compiled",
}
_FIRST = "wall"


class Shelf:
    """Environments and their values by key; values are SI."""

    def __init__(self, library: Mapping[str, Environment]):
        self.environments = dict(library)
        self.values = {key: environment.values() for key, environment in library.items()}

    def put(self, environment: Environment) -> None:
        """Take an environment in; one of the same key leaves it its values."""
        key = environment.key
        kept = carried(self.environments[key], self.values[key], environment) if key in self.values else {}
        try:
            self.values[key] = environment.values(kept)
        except ParameterError:  # the old values do not go together any more
            self.values[key] = environment.values()
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
        if was is None or type(was) is not type(parameter) or values[was.key] == was.default:
            continue
        value = was.text(values[was.key]) if isinstance(was, Choice) else values[was.key]
        try:
            kept[parameter.key] = parameter.check(value)
        except ParameterError:
            continue
    return kept


class Readiness(QObject):
    """Knows each environment's state: "ready", "preparing", "next" (it is wished for) or "broken".

    Nothing is looked at once everything is ready. Where the programs that compile have ended, or died, and a
    law is not there, it is compiled in the window when it is chosen: late rather than never.
    ``changed``: a state; ``arrived(key)``: the newest wish can be had.
    """

    changed = Signal()
    arrived = Signal(str)

    def __init__(self, parent: QObject | None = None):
        super().__init__(parent)
        self._waiting: dict[str, Environment] = {}
        self._late: dict[str, Environment] = {}
        self._broken: set[str] = set()
        self._programs: Sequence[Popen] | None = None
        self.wish: str | None = None
        self._watch = QTimer(self, interval=LOOK_MS)
        self._watch.timeout.connect(self.look)

    @property
    def waiting(self) -> tuple[str, ...]:
        """Return the keys of what is still being compiled."""
        return tuple(self._waiting)

    def state(self, key: str) -> str:
        """Return how an environment stands."""
        if key in self._broken:
            return "broken"
        if key in self._waiting:
            return "next" if key == self.wish else "preparing"
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
        self.look()

    def ask(self, key: str) -> bool:
        """Return whether an environment can be had now; if not, it is the wish instead of an older one."""
        if key in self._late:
            self._compile_here(key)
        ready = self.state(key) == "ready"
        if not ready or self.wish is not None:
            self.wish = key if key in self._waiting else None
            self.changed.emit()
        return ready

    def forget(self) -> None:
        """Forget the wish: something else was put in force."""
        if self.wish is not None:
            self.wish = None
            self.changed.emit()

    def end(self) -> None:
        """Wait for nothing any more."""
        self._watch.stop()

    def look(self) -> None:
        """Look what has been compiled; hand over the wish if it has."""
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
        if self.wish is not None and self.wish not in self._waiting:
            self.arrived.emit(self.wish)

    def _compile_here(self, key: str) -> None:
        environment = self._late.pop(key)
        try:
            environment.force.compiled()
        except LawError:
            self._broken.add(key)


class Chosen(QObject):
    """Keeps every environment's values; passes what is chosen on to the engine, if there is one."""

    environment_changed = Signal()
    values_changed = Signal()

    def __init__(self, parent: QObject | None = None):
        super().__init__(parent)
        self.engine: Engine | None = None
        self._shelf = Shelf(discover())
        self.environments = self._shelf.environments
        self.environment = self.environments[
            _FIRST if _FIRST in self.environments else next(iter(self.environments))
        ]
        self.readiness = Readiness(self)
        self.readiness.arrived.connect(self.choose)

    @property
    def values(self) -> dict[str, float]:
        """Return the values in force of the environment in force."""
        return self._shelf.values[self.environment.key]

    def choose(self, key: str) -> None:
        """Switch the environment, or as soon as it is ready; its values are those it was left with."""
        if self.readiness.ask(key) and key != self.environment.key:
            self._force(self.environments[key])

    def adopt(self, environment: "Environment") -> None:
        """Take an environment in, or a newer version of it, and put it in force; it is compiled already."""
        self._shelf.put(environment)
        self.readiness.forget()
        self._force(environment)

    def drop(self, key: str) -> None:
        """Forget an environment; raise KeyError if it is in force."""
        if key == self.environment.key:
            raise KeyError(key)
        self._shelf.drop(key)

    def _force(self, environment: "Environment") -> None:
        self.environment = environment
        if self.engine is not None:
            self.engine.set_environment(environment, self.values)
        self.environment_changed.emit()
        self.values_changed.emit()

    def set_value(self, key: str, value: float) -> None:
        """Change one parameter; raise ParameterError and keep the last good values if it is bad."""
        self.set_values({key: value})

    def set_values(self, given: Mapping[str, float]) -> None:
        """Change several parameters at once; raise ParameterError and keep all as they are if one is bad."""
        self._set_values({**self.values, **given})

    def values_of(self, key: str) -> dict[str, float]:
        """Return the values an environment has, or would be played with."""
        return dict(self._shelf.values[key])

    def lay_out(self, key: str, given: Mapping[str, float]) -> None:
        """Change several parameters of any environment, in force or not; raise ParameterError."""
        if key == self.environment.key:
            self.set_values(given)
        else:
            numbers = self.environments[key].values({**self._shelf.values[key], **given})
            self._shelf.values[key].update(numbers)

    def reset_values(self) -> None:
        """Put every parameter of the environment back to its default, all at once."""
        self._set_values({})

    def _set_values(self, given: dict[str, float]) -> None:
        numbers = self.environment.values(given)
        if self.engine is not None:
            self.engine.set_environment(self.environment, numbers)
        self.values.update(numbers)
        self.values_changed.emit()
