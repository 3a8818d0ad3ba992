"""Unusable stored settings are replaced by their defaults, and one message names them once."""

from pathlib import Path

import pytest
from PySide6.QtCore import QSettings

from hapkit_studio.devices.hapkit import PACKET
from hapkit_studio.dynamics.loop_settings import USUAL_LOOP
from hapkit_studio.gui.state.stored import StoredSettings
from hapkit_studio.gui.widgets.theme import MODES
from tests.environments.calling import LIBRARY
from tests.wide import wide

DEEP = "[" * 5000


def write(text):
    """Write a settings file as another program or another version of the studio would write it."""
    path = Path(QSettings("hapkit-studio", "hapkit-studio").fileName())
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("[General]\n" + text)
    return path


GEOMETRY = "The stored size of the window (geometry) is damaged."
WRONG = {
    "theme=purple": "theme is 'purple'; it must be one of system, light, dark, contrast.",
    "theme=dark, light": "theme is ['dark', 'light']; it must be one of system, light, dark, contrast.",
    "geometry=5": GEOMETRY,
    "geometry=@ByteArray(\\x1\\xd9\\xd0\\xcb\\xff\\xff)": GEOMETRY,
    "grid=perhaps": "grid is 'perhaps'; it must be one of false, true.",
    "padding=7": f"padding is '7'; it must be one of 0, {PACKET}.",
    "panel_width=nan": "panel_width is nan; it must be a number from 0 to 10,000 px.",
    "panel_width=1e308": "panel_width is 1e+308; it must be a number from 0 to 10,000 px.",
    f'values="{DEEP}"': "values, line 1: brackets are nested deeper than 32.",
    'values="[1]"': "values is [1]; it must be a table.",
    'values="{\\"wall\\": 5}"': "values.wall: it must be a table of names and values.",
    'values="{\\"wall\\": {\\"damping\\": 51}}"': "values.wall: Damping must be between 0 and 50 N·s/m, not",
    f'loop="{DEEP}"': "loop, line 1: brackets are nested deeper than 32.",
    'loop="{\\"board_rate\\": 3}"': "loop: Board's rate must be one of fastest, 4000, ",
    f'presets="{DEEP}"': "presets, line 1: brackets are nested deeper than 32.",
    f'trigger="{DEEP}"': "trigger, line 1: brackets are nested deeper than 32.",
    'trigger="{\\"before\\": true}"': "trigger: Time shown before the event must be a number in %, not True.",
    f'lock="{DEEP}"': "lock, line 1: brackets are nested deeper than 32.",
    "view=moon": "view is 'moon'; it must be one of ",
}


@pytest.fixture
def settings():
    """Return a function that creates settings from a file's text."""

    def make(text):
        write(text)
        return StoredSettings()

    return make


def test_values_of_every_type_are_read(settings):
    stored = settings("theme=dark\ngrid=false\npadding=62\npanel_width=260.5\nvalues={}\n")
    assert stored.choice("theme", "system", MODES) == "dark"
    assert stored.flag("grid", True) is False
    assert stored.choice("padding", 0, (0, PACKET)) == PACKET == 62
    assert stored.pixels("panel_width", 100.0) == 260.5
    assert stored.table("values") == stored.table("loop") == {}
    assert stored.flag("single_keys", True) is True
    assert not stored.rejected


@pytest.mark.slow
@pytest.mark.parametrize("line", wide(WRONG, lambda line: line in list(WRONG)[::3]))
def test_a_wrong_setting_is_replaced_by_its_default_and_named(start_window, line):
    """The settings were written by hand or by a newer version, or contain values that overflow a parser."""
    write(line)
    window = start_window()
    notice = window.banners.get("settings")
    assert notice.title == "Some stored settings cannot be used. Their default values are used instead."
    assert notice.text.startswith(WRONG[line])
    assert "\n" not in notice.text
    assert (window.studio.values, window.studio.loop) == (LIBRARY["wall"].values(), USUAL_LOOP)
    assert not window.studio.permissions.lock.places


@pytest.mark.slow
def test_many_wrong_settings_give_one_message_that_is_not_repeated(start_window):
    write("theme=purple\ngeometry=5\ngrid=perhaps\nvalues=5")
    first = start_window()
    assert (
        first.banners.get("settings").text
        == "These settings are invalid and not used: theme, grid, values, geometry."
    )
    first.settings.sync()
    assert start_window().banners.get("settings") is None


@pytest.mark.slow
def test_a_setting_of_a_newer_version_stays_in_the_file(start_window):
    path = write("theme=purple")
    window = start_window()
    window.close()
    window.settings.sync()
    assert "theme=purple" in path.read_text()
