"""Folders and locales of all operating systems; substitutes behave as the systems' documentation says.

Folders: Known Folders (Microsoft) and the File System Programming Guide (Apple), as platformdirs reads them.
Ports, priority and clocks: tests/devices/test_ports.py, tests/haptics/test_priority.py and test_clock.py.
"""

import errno
import json
import locale
import ntpath
import os
import shutil
import subprocess
import sys
import tempfile
from io import BytesIO, TextIOWrapper
from pathlib import Path

import platformdirs
import pytest
from platformdirs import macos, windows
from PySide6.QtCore import QLocale

from hapkit_studio import api, cli, environments, lab
from hapkit_studio.commands import integrate, where
from hapkit_studio.errors import StudioError
from hapkit_studio.gui.state import prepare
from hapkit_studio.gui.widgets.numbers import NumberBox
from hapkit_studio.laws import native
from hapkit_studio.lessons import library
from hapkit_studio.parameters import Parameter
from hapkit_studio.quantity import Quantity
from hapkit_studio.sessions import folder as sessions
from hapkit_studio.workshop import folder as workshop
from hapkit_studio.workshop import sketch

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


@pytest.mark.parametrize("name", ["en_US", "de_DE", "de_CH", "fr_FR", "ar_EG", "hi_IN", "C", "xx_YY"])
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


# --- errors of folders
def one_line(capsys, *args):
    """Run a command that fails, and return its one line."""
    assert cli.main(args) == cli.FAILED
    (line,) = capsys.readouterr().err.splitlines()
    return line


@pytest.mark.parametrize(
    "system", [pytest.param("posix", marks=pytest.mark.skipif(os.name == "nt", reason="no pwd")), "nt"]
)
def test_an_unknown_home_directory_gives_one_line(monkeypatch, capsys, system):
    def unknown(_user):  # pwd.getpwuid() raises this error for a user without an entry, as in a container
        raise KeyError("uid not found")

    for name in ("HOME", "USERPROFILE", "HOMEPATH", "XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME"):
        monkeypatch.delenv(name, raising=False)
    if system == "nt":
        monkeypatch.setattr(os.path, "expanduser", ntpath.expanduser)
    else:
        monkeypatch.setattr("pwd.getpwuid", unknown)
    assert "Set HOME (on Windows USERPROFILE)" in one_line(capsys, "where")


@pytest.mark.parametrize("missing", KNOWN)
def test_a_folder_that_windows_cannot_find_gives_one_line(on_windows, monkeypatch, capsys, missing):
    def find(name):  # SHGetKnownFolderPath fails, for example for documents on a share that is away
        if name == missing:
            raise ValueError(f"SHGetKnownFolderPath failed for {name}")
        return KNOWN[name]

    monkeypatch.setattr(windows, "get_win_folder", find)
    assert str(lab.path()).replace("/", "\\") == r"C:\ProgramData\hapkit-studio\lab.toml"
    if missing in ("CSIDL_APPDATA", "CSIDL_COMMON_APPDATA"):  # a user's own files are in neither of them
        assert where.places()
    else:
        assert "Set HOME (on Windows USERPROFILE)" in one_line(capsys, "where")


def test_folders_on_windows_do_not_need_environment_variables(on_windows, monkeypatch):
    expected = places()
    for name in ("APPDATA", "LOCALAPPDATA", "PROGRAMDATA", "USERPROFILE"):
        monkeypatch.delenv(name, raising=False)
    assert places() == expected


@pytest.fixture
def home(tmp_path, monkeypatch):
    """Return a user's home directory whose path contains spaces and umlauts."""
    folder = tmp_path / "Zoë Müller ß"
    folder.mkdir()
    for name in ("XDG_CONFIG_HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME", "XDG_DOCUMENTS_DIR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.delenv(workshop.VARIABLE, raising=False)
    monkeypatch.setenv("HOME", str(folder))
    return folder


@pytest.fixture
def closed(home, monkeypatch):
    """Deny access to the home directory by replaced calls, because file permissions do not stop root."""
    stat, listed = os.stat, os.scandir

    def denied(path):
        if isinstance(path, str | os.PathLike) and Path(path).is_relative_to(home):
            raise PermissionError(errno.EACCES, "Permission denied", str(path))

    def checked_stat(path, *args, **options):
        denied(path)
        return stat(path, *args, **options)

    def checked_list(path="."):
        denied(path)
        return listed(path)

    def checked_mkdir(path, *_words, **_options):
        denied(path)

    monkeypatch.setattr(os, "stat", checked_stat)
    monkeypatch.setattr(os, "scandir", checked_list)
    monkeypatch.setattr(os, "mkdir", checked_mkdir)
    return home


def test_a_home_directory_without_access_counts_as_empty(closed):
    inside = [
        place for place in where.run(None).as_json["places"] if Path(place["path"]).is_relative_to(closed)
    ]
    assert len(inside) >= 5
    assert not any(place["exists"] for place in inside)
    assert sessions.folder().is_relative_to(closed)
    assert sessions.files() == workshop.own_files() == integrate.installed() == []
    assert not prepare.prepared("loop")
    assert workshop.existing().is_relative_to(closed.parent)
    with pytest.raises(StudioError, match="Permission denied"):
        sessions.new_path("wall")
    with pytest.raises(StudioError, match="Permission denied"):
        sessions.choose_folder(closed / "recordings")
    with pytest.raises(OSError, match="Permission denied"):
        workshop.own_folder()
    with pytest.raises(StudioError, match="There is no folder"):
        library(closed / "lessons")


def test_files_in_place_of_folders_are_named(home):
    for name in ("Documents", ".config", ".cache"):
        (home / name).write_text("a file", encoding="utf-8")
    assert sessions.files() == workshop.own_files() == []
    with pytest.raises(
        StudioError, match=r"Hapkit sessions cannot be created: (Not a directory|File exists)"
    ):
        sessions.new_path("wall")
    with pytest.raises(StudioError, match="cannot be chosen"):
        sessions.choose_folder(home / "Documents" / "recordings")
    with pytest.raises(OSError, match=r"Not a directory|File exists"):
        workshop.own_folder()
    assert not prepare.prepared("loop")


def test_recordings_and_tables_are_kept_in_a_folder_with_umlauts(home):
    made = api.simulate("wall", hand="press", seconds=0.05)
    path = sessions.new_path("wall")
    made.save(path)
    made.save(path.with_suffix(".csv"))
    assert sessions.files() == [path]
    assert path.is_relative_to(home)
    assert len(path.with_suffix(".csv").read_text(encoding="utf-8").splitlines()) > len(made.time)


def test_laws_are_compiled_in_a_temporary_folder_if_the_disk_is_full(home, monkeypatch):
    class Full(BytesIO):
        def write(self, _data):
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(native.numba.config, "CACHE_DIR", "")
    assert native._folder() == home / ".cache" / "hapkit-studio" / "laws"
    monkeypatch.setattr(tempfile, "TemporaryFile", lambda **_: Full())
    other = native._folder()
    try:
        assert not other.is_relative_to(home)
        assert other.is_dir()
    finally:
        other.rmdir()


# --- locales
@pytest.fixture
def comma(tmp_path):
    """Let the C library write decimal commas; Qt's application sets the user's locale, too."""
    before = locale.setlocale(locale.LC_ALL)
    made, name = tmp_path / "de_DE.UTF-8", "de_DE.UTF-8"
    with pytest.MonkeyPatch.context() as patch:
        if sys.platform == "linux":
            if shutil.which("localedef") is None:
                pytest.skip("no program that makes locales")
            subprocess.run(
                ["localedef", "-i", "de_DE", "-f", "UTF-8", made], check=False, capture_output=True
            )
            patch.setenv("LOCPATH", str(tmp_path))
        try:
            locale.setlocale(locale.LC_ALL, name)
        except locale.Error:
            pytest.skip("no German locale")
        yield
        locale.setlocale(locale.LC_ALL, before)


def written(folder):
    """Return the bytes of a run's table and of a sketch, which are written in the current locale."""
    folder.mkdir()
    made = api.simulate("wall", {"stiffness": "1234.5"}, hand="press", seconds=0.05)
    made.save(folder / "run.csv")
    return (folder / "run.csv").read_bytes(), sketch.text(environments.named("wall"), {"stiffness": 1234.5})


@pytest.mark.slow  # creating the locale takes some seconds
def test_files_have_decimal_points_in_a_locale_with_commas(tmp_path, request):
    expected = written(tmp_path / "point")
    request.getfixturevalue("comma")
    assert locale.localeconv()["decimal_point"] == ","
    assert f"{1.5:n}" == "1,5"
    table, text = written(tmp_path / "comma")
    assert (table, text) == expected
    assert b"1234.5" in table
    assert "1234.5f" in text


@pytest.mark.parametrize("encoding", ["cp437", "cp850", "cp1252", "cp932", "ascii", "utf-8"])
def test_json_is_complete_on_every_console(home, monkeypatch, encoding):
    folder = home / "Łódź Ω 触覚"
    folder.mkdir()
    monkeypatch.setenv(workshop.VARIABLE, str(folder))
    data = BytesIO()
    monkeypatch.setattr(sys, "stdout", TextIOWrapper(data, encoding=encoding))
    assert cli.main(["where", "--json"]) == 0
    found = {place["content"]: place for place in json.loads(data.getvalue().decode(encoding))["places"]}
    assert found["own environments"]["path"] == str(folder / "environments")


@pytest.mark.parametrize("encoding", ["cp437", "cp850", "cp1252", "ascii"])
def test_text_is_printed_on_a_console_with_few_characters(home, monkeypatch, encoding):
    data = BytesIO()
    monkeypatch.setattr(sys, "stdout", TextIOWrapper(data, encoding=encoding))
    assert cli.main(["environments"]) == 0
    text = data.getvalue().decode(encoding)
    assert "N·s/m".encode(encoding, "replace").decode(encoding) in text
