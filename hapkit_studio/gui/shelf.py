"""Every environment that can be chosen, each with the values it was left with."""

from collections.abc import Mapping

from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import Choice


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
