"""What the next start finds as it was left: the environment, its values and the view."""

import json
from typing import TYPE_CHECKING

from hapkit_studio.gui import pages
from hapkit_studio.gui.environment_library import usable
from hapkit_studio.parameters import Choice

if TYPE_CHECKING:
    from hapkit_studio.gui.window import MainWindow

_ENVIRONMENT, _VALUES, _VIEW = "environment", "values", "view"


def save(window: "MainWindow") -> None:
    """Remember what is in force, choices by their names, and what is in sight."""
    environment, values = window.studio.environment, window.studio.values
    named = {
        p.key: p.text(values[p.key]) if isinstance(p, Choice) else values[p.key]
        for p in environment.parameters
    }
    window.settings.setValue(_ENVIRONMENT, environment.key)
    window.settings.setValue(_VALUES, json.dumps(named))
    window.settings.setValue(_VIEW, window.views.key)


def restore(window: "MainWindow") -> None:
    """Put what was remembered in force, as far as it still is there and valid; a motor waits for "Render"."""
    studio = window.studio
    key, values, view = (str(window.settings.value(name, "")) for name in (_ENVIRONMENT, _VALUES, _VIEW))
    if view in pages.discover():
        window.views.show(view)
    if key not in studio.environments:
        return
    try:
        given = json.loads(values)
    except ValueError:
        given = None
    known = usable(studio.environments[key], given if isinstance(given, dict) else {})
    studio.set_values_of(key, known)
    studio.choose(key)
    studio.restored = True
