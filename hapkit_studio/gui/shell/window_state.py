"""Saves the window's state when it closes and restores it at the next start."""

import json
from collections.abc import Iterable, Mapping
from typing import Any

from hapkit_studio.dynamics.loop_settings import Reject, from_table, to_table
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui import pages
from hapkit_studio.gui.live import trigger
from hapkit_studio.gui.live.trigger import Trigger
from hapkit_studio.gui.pages.views import LAW, LIVE, Views
from hapkit_studio.gui.panel.preset_row import Presets
from hapkit_studio.gui.state.environment_library import checked, usable
from hapkit_studio.gui.state.stored import StoredSettings
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.parameters import AnyParameter, Choice

_ENVIRONMENT, _VALUES, _LOOP, _VIEW, _PRESETS = "environment", "values", "loop", "view", "presets"
_FORMER_VIEWS = {"chain": "accuracy", "fidelity": "accuracy"}  # views that were merged into another view
_TRIGGER = "trigger"


class WindowState:
    """Saves and restores environment, values, presets, loop, hand, view and trigger."""

    def __init__(
        self, studio: Studio, settings: StoredSettings, views: Views, presets: Presets, trigger: Trigger
    ):
        self._studio, self._settings, self._views = studio, settings, views
        self._presets, self._trigger = presets, trigger

    def save(self) -> None:
        """Store the state; a choice is stored as the name of its option."""
        studio, settings = self._studio, self._settings
        values = {
            key: _by_name(environment.parameters, studio.values_of(key))
            for key, environment in studio.environments.items()
        }
        settings.setValue(_ENVIRONMENT, studio.environment.key)
        settings.setValue(_VALUES, json.dumps(values))
        settings.setValue(_LOOP, json.dumps(to_table(studio.loop)))
        settings.setValue(_VIEW, self._views.key)
        settings.setValue(_PRESETS, json.dumps(self._presets.names))
        settings.setValue(_TRIGGER, json.dumps(_by_name(trigger.PARAMETERS, self._trigger.values)))

    def restore(self) -> None:
        """Restore all valid stored settings, including locked ones.

        Afterwards, a motor stays off until the user presses *Render*.
        """
        with self._studio.temporarily():
            self._restore()

    def _restore(self) -> None:
        studio, settings = self._studio, self._settings
        key = str(settings.value(_ENVIRONMENT, ""))
        if (former := str(settings.value(_VIEW, ""))) in _FORMER_VIEWS:
            settings.setValue(_VIEW, _FORMER_VIEWS[former])
        known = pages.discover()
        view = settings.choice(_VIEW, LIVE, (LIVE, LAW, *known))
        if view in known:
            self._views.show(view)
        values = settings.table(_VALUES)
        for scene in values.keys() & studio.environments.keys():
            reject = _rejection(settings, _VALUES, f"{_VALUES}.{scene}")
            studio.set_values_of(
                scene, usable(studio.environments[scene], _table(values[scene], reject), reject)
            )
        loop = settings.table(_LOOP)
        studio.set_loop(**from_table(loop, studio.loop, _rejection(settings, _LOOP)))
        given = settings.table(_TRIGGER)
        for name, value in checked(trigger.PARAMETERS, given, _rejection(settings, _TRIGGER)).items():
            self._trigger.set_value(name, value)
        self._presets.remember(settings.table(_PRESETS))
        if key in studio.environments:
            studio.choose(key)
        studio.stop_state.restored = bool(key)


def _by_name(parameters: Iterable[AnyParameter], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters' values; a choice is given by the name of its option."""
    known = [p for p in parameters if p.key in values]
    return {p.key: p.text(values[p.key]) if isinstance(p, Choice) else values[p.key] for p in known}


def _rejection(settings: StoredSettings, name: str, place: str = "") -> Reject:
    """Return a callback that reports why a part of a stored setting is not used."""
    return lambda error: settings.reject(name, f"{place or name}: {error}")


def _table(given: object, reject: Reject) -> Mapping[str, Any]:
    """Return a stored table; if the stored value is not a table, report this and return {}."""
    if isinstance(given, dict):
        return given
    reject(ParameterError("it must be a table of names and values."))
    return {}
