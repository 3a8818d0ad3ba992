"""The environment a person has chosen, and the values it is played with."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from hapkit_studio.environments import discover
from hapkit_studio.gui.readiness import Readiness
from hapkit_studio.gui.shelf import Shelf

if TYPE_CHECKING:
    from hapkit_studio.environments.base import Environment
    from hapkit_studio.haptics.engine import Engine

_FIRST = "wall"


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
