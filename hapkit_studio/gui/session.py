"""What the next start finds as it was left: environment, values, presets, loop, hand, view and trigger."""

import json
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from hapkit_studio.devices.simulated import MODELS
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.gui import pages
from hapkit_studio.gui.environment_library import checked, usable
from hapkit_studio.gui.live import trigger
from hapkit_studio.gui.panel.loop import DELAY, ESTIMATOR, GRIP, RATE
from hapkit_studio.gui.panel.rendering import RATE as BOARD_RATE
from hapkit_studio.gui.panel.rendering import RENDERERS
from hapkit_studio.parameters import AnyParameter, Choice

if TYPE_CHECKING:
    from PySide6.QtCore import QSettings

    from hapkit_studio.gui.studio import Studio
    from hapkit_studio.gui.window import MainWindow

_ENVIRONMENT, _VALUES, _LOOP, _VIEW, _PRESETS = "environment", "values", "loop", "view", "presets"
_TRIGGER = "trigger"
_OF_LOOP = (
    RATE, DELAY, ESTIMATOR, GRIP, Choice("model", "Model", MODELS), Choice("where", "Rendered by", RENDERERS)
)  # fmt: skip
_BOARD_RATES = [None, *map(float, BOARD_RATE.options[1:])]


def save(window: "MainWindow") -> None:
    """Remember what is in force, choices by their names, and what is in sight."""
    studio, settings = window.studio, window.settings
    values = {
        key: _by_name(environment.parameters, studio.values_of(key))
        for key, environment in studio.environments.items()
    }
    loop = {**vars(studio.loop), "options": dict(studio.loop.options), "grip": studio.grip}
    settings.setValue(_ENVIRONMENT, studio.environment.key)
    settings.setValue(_VALUES, json.dumps(values))
    settings.setValue(_LOOP, json.dumps(loop))
    settings.setValue(_VIEW, window.views.key)
    settings.setValue(_PRESETS, json.dumps(window.presets.names))
    settings.setValue(_TRIGGER, json.dumps(_by_name(trigger.PARAMETERS, window.centre.trigger.values)))


def restore(window: "MainWindow") -> None:
    """Put what was remembered in force, as far as it still is there and valid; a motor waits for "Render".

    Also what is locked: it was left so.
    """
    with window.studio.temporarily():
        _restore(window)


def _restore(window: "MainWindow") -> None:
    studio, settings = window.studio, window.settings
    key, view = (str(settings.value(name, "")) for name in (_ENVIRONMENT, _VIEW))
    if view in pages.discover():
        window.views.show(view)
    values = _remembered(settings, _VALUES)
    for known in values.keys() & studio.environments.keys():
        studio.set_values_of(known, usable(studio.environments[known], _mapping(values[known])))
    _restore_loop(studio, _remembered(settings, _LOOP))
    for name, value in checked(trigger.PARAMETERS, _remembered(settings, _TRIGGER)).items():
        window.centre.trigger.set_value(name, value)
    window.presets.remember(_remembered(settings, _PRESETS))
    if key in studio.environments:
        studio.choose(key)
    studio.restored = bool(key)


def _restore_loop(studio: "Studio", given: Mapping[str, Any]) -> None:
    loop = loop_from(given, studio.loop.estimator)
    studio.set_grip(loop.pop(GRIP.key, studio.grip))
    rate = given.get("board_rate")
    studio.set_loop(**loop, board_rate=rate if rate in _BOARD_RATES else None)


def loop_from(given: Mapping[str, Any], estimator: str) -> dict[str, Any]:
    """Return what is valid of a loop and a hand ("grip") that were written down, by the studio's names.

    estimator: the one whose options they are where none is named.
    """
    loop = _by_name(_OF_LOOP, checked(_OF_LOOP, given))
    method = ESTIMATORS[loop.get(ESTIMATOR.key, estimator)]
    options = checked(method.parameters, _mapping(given.get("options")))
    return {**loop, "options": tuple(options.items()), "controller": given.get("controller") is True}


def _by_name(parameters: Iterable[AnyParameter], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of parameters, choices by the names of their options."""
    known = [p for p in parameters if p.key in values]
    return {p.key: p.text(values[p.key]) if isinstance(p, Choice) else values[p.key] for p in known}


def _remembered(settings: "QSettings", name: str) -> Mapping[str, Any]:
    """Return what was written under a name; nothing where it cannot be read."""
    try:
        return _mapping(json.loads(str(settings.value(name, ""))))
    except ValueError:
        return {}


def _mapping(given: object) -> Mapping[str, Any]:
    return given if isinstance(given, dict) else {}
