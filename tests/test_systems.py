"""Folders of Windows and macOS, and other locales, with substitutes that follow the systems' documentation.

Folders: Known Folders (Microsoft) and the File System Programming Guide (Apple), as platformdirs reads them.
Ports, priority and clocks: tests/devices/test_ports.py, tests/haptics/test_priority.py and test_clock.py.
"""

from pathlib import Path

import platformdirs
import pytest
from platformdirs import macos, windows
from PySide6.QtCore import QLocale

from hapkit_studio import lab
from hapkit_studio.commands import where
from hapkit_studio.gui.state import prepare
from hapkit_studio.gui.widgets.numbers import NumberBox
from hapkit_studio.parameters import Parameter
from hapkit_studio.quantity import Quantity

KNOWN = {
    "CSIDL_LOCAL_APPDATA": r"C:\Users\Zoë B\AppData\Local",
    "CSIDL_APPDATA": r"C:\Users\Zoë B\AppData\Roaming",
    "CSIDL_COMMON_APPDATA": r"C:\ProgramData",
    "CSIDL_PERSONAL": r"D:\Zoë B\Documents",  # the user has moved this folder, as OneDrive does
}


@pytest.fixture
def on_windows(monkeypatch):
    monkeypatch.delenv("HAPKIT_STUDIO_FOLDER", raising=False)
    monkeypatch.setattr(windows, "get_win_folder", KNOWN.__getitem__)
    monkeypatch.setattr(platformdirs, "PlatformDirs", windows.Windows)


@pytest.fixture
def on_macos(monkeypatch):
    monkeypatch.delenv("HAPKIT_STUDIO_FOLDER", raising=False)
    for name in ("XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME", "XDG_CONFIG_DIRS"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", "/Users/zoe")
    monkeypatch.setattr(platformdirs, "PlatformDirs", macos.MacOS)


def places():
    return {what: path.replace("/", "\\") for what, path in where.places()}


def test_folders_on_windows(on_windows):
    found = places()
    local = KNOWN["CSIDL_LOCAL_APPDATA"] + r"\hapkit-studio"
    assert found["calibrations"].startswith(local)
    assert found["machine code"].startswith(local)
    assert found["recordings"] == r"D:\Zoë B\Documents\Hapkit sessions"
    assert found["own environments"] == r"D:\Zoë B\Documents\Hapkit Studio\environments"
    assert str(lab.path()).replace("/", "\\") == r"C:\ProgramData\hapkit-studio\lab.toml"
    assert str(prepare.stamp("loop").parent).replace("/", "\\") == found["machine code"]


def test_folders_on_macos(on_macos):
    found = dict(where.places())
    assert found["calibrations"] == "/Users/zoe/Library/Application Support/hapkit-studio/calibrations"
    assert found["machine code"] == "/Users/zoe/Library/Caches/hapkit-studio"
    assert found["recordings"] == "/Users/zoe/Documents/Hapkit sessions"
    assert lab.path() == Path("/Library/Application Support/hapkit-studio/lab.toml")


@pytest.mark.parametrize("name", ["en_US", "de_DE", "de_CH", "fr_FR", "ar_EG", "hi_IN"])
def test_numbers_are_shown_and_read_alike_in_every_locale(qtbot, name):
    before = QLocale()
    QLocale.setDefault(QLocale(name))
    try:
        box = NumberBox(Quantity(Parameter("stiffness", "Stiffness", "N/m", 0.0, 0.0, 5000.0)))
        qtbot.addWidget(box)
        box.show_value(1234.5)
        assert box.text().startswith("1,23")
        assert box.valueFromText("1234.5") == box.valueFromText("1234,5") == 1234.5
    finally:
        QLocale.setDefault(before)
