"""The command that lists the data that the studio stores for this user; uninstalling keeps these data."""

import argparse
import os
import sys

import platformdirs

from hapkit_studio.commands.base import Command, Result
from hapkit_studio.commands.integrate import installed
from hapkit_studio.devices import calibration_file
from hapkit_studio.sessions import folder as sessions
from hapkit_studio.workshop.folder import own_folder_path

NAME = "hapkit-studio"


def settings_place(system: str = sys.platform) -> str:
    """Return the place in which Qt stores the window's settings (QSettings, native format)."""
    if system == "win32":
        return rf"HKEY_CURRENT_USER\Software\{NAME}\{NAME}"
    if system == "darwin":
        return os.path.expanduser(f"~/Library/Preferences/com.{NAME}.{NAME}.plist")
    root = os.environ.get("XDG_CONFIG_HOME", "")
    if not os.path.isabs(root):  # Qt ignores a relative path
        root = os.path.expanduser("~/.config")
    return os.path.join(root, NAME, f"{NAME}.conf")


def places() -> list[tuple[str, str]]:
    """Return (content, path) of everything that the studio stores; some of the paths may not exist."""
    return [
        ("settings of the window", settings_place()),
        ("recording folder, if changed", str(sessions.choice_file())),
        ("calibrations", str(calibration_file.folder())),
        ("recordings", str(sessions.folder())),
        ("own environments", str(own_folder_path())),
        ("files trusted by you", platformdirs.user_data_dir(NAME, appauthor=False)),
        ("machine code", platformdirs.user_cache_dir(NAME, appauthor=False)),
        ("fonts, found by matplotlib", _matplotlib_cache()),
        *(("desktop entry, icon, file type", str(path)) for path in installed()),
    ]


def _matplotlib_cache() -> str:
    """Return matplotlib's cache folder without importing matplotlib."""
    own = os.environ.get("MPLCONFIGDIR")
    linux = sys.platform.startswith(("linux", "freebsd"))
    return own or (
        platformdirs.user_cache_dir("matplotlib") if linux else os.path.expanduser("~/.matplotlib")
    )


def run(_options: argparse.Namespace) -> Result:
    """List the places, and mark those that do not exist."""
    found = [(what, path, os.path.exists(path)) for what, path in places()]
    width = max(len(what) for what, *_ in found)
    lines = [
        f"{what:<{width}}  {path}{'' if exists else '  (nothing there)'}" for what, path, exists in found
    ]
    as_json = [{"content": what, "path": path, "exists": exists} for what, path, exists in found]
    return Result("\n".join(lines), {"places": as_json})


COMMAND = Command("where", "list your files, which remain after uninstalling", run, order=97)
