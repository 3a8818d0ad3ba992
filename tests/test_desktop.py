"""`integrate` and `where`: a desktop understands the written files, and nothing is left at the end."""

import configparser
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from hapkit_studio import cli
from hapkit_studio.commands import integrate, where
from hapkit_studio.sessions.file import SUFFIX

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the desktop of Linux")


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    """Return a new home directory."""
    for name in (
        "XDG_DATA_HOME",
        "XDG_CONFIG_HOME",
        "XDG_CACHE_HOME",
        "HAPKIT_STUDIO_FOLDER",
        "MPLCONFIGDIR",
    ):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setattr(integrate.priority, "probe", lambda: integrate.priority.Priority("FIFO 80", True))
    return tmp_path


def answer(capsys, *args):
    assert cli.main([*args, "--json"]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)


def written(home):
    """Return the studio's files, without those that update-mime-database derives from mime/packages."""
    found = (path for path in home.rglob("*hapkit*") if path.is_file())
    return {path for path in found if path.parent.name != "application"}


def test_integrate_asks_before_it_writes(home, capsys, monkeypatch):
    monkeypatch.setattr(sys, "stdin", open(os.devnull))  # noqa: SIM115, closed with the test
    assert cli.main(["integrate"]) == 2
    assert "--yes" in capsys.readouterr().err
    assert not written(home)


def test_remove_undoes_all_that_integrate_wrote(home, capsys):
    paths = {Path(path) for path in answer(capsys, "integrate", "--yes")["written"]}
    assert written(home) == paths
    listed = {place["path"] for place in answer(capsys, "where")["places"] if place["exists"]}
    assert {str(path) for path in paths} <= listed
    assert {Path(path) for path in answer(capsys, "integrate", "--remove", "--yes")["removed"]} == paths
    assert not written(home)
    assert answer(capsys, "integrate", "--remove", "--yes")["removed"] == []


def test_relative_folders_in_the_environment_are_ignored(home, capsys, monkeypatch):
    monkeypatch.chdir(home)
    for name in ("XDG_DATA_HOME", "XDG_CONFIG_HOME"):
        monkeypatch.setenv(name, "relative")
    paths = [Path(path) for path in answer(capsys, "integrate", "--yes")["written"]]
    assert all(path.is_relative_to(home / ".local" / "share") for path in paths)
    assert not (home / "relative").exists()
    settings, *_ = answer(capsys, "where")["places"]
    assert settings["path"] == str(home / ".config/hapkit-studio/hapkit-studio.conf")


def test_remove_also_removes_a_broken_link(home, capsys):
    path = home / ".local/share/applications/hapkit-studio.desktop"
    path.parent.mkdir(parents=True)
    path.symlink_to(home / "gone" / "file")
    assert answer(capsys, "integrate", "--remove", "--yes")["removed"] == [str(path)]
    assert not path.is_symlink()


@pytest.mark.parametrize("place", ["/opt/hapkit", "/srv/zoë/Ü b/hapkit-studio", '/a"b/$HOME/`c`/50%/d\\e'])
def test_the_menu_entry_starts_the_program_wherever_it_is(home, place):
    reader = configparser.RawConfigParser()
    reader.read_string(integrate.desktop_entry([place]))
    line = reader["Desktop Entry"]["Exec"]
    # the specification decodes a string's escapes first, then quotes as in a shell, then % codes
    shell = ["sh", "-c", f"printf '%s\\n' {line.replace(chr(92) * 2, chr(92))}"]
    args = subprocess.run(shell, capture_output=True, text=True, check=True).stdout.splitlines()
    found = [
        re.sub("%(.)", lambda code: "%" if code[1] == "%" else "a field code", word) for word in args[:-1]
    ]
    assert found == [place]
    assert args[-1] == "%f"


FILE_TYPE = """
import sys
from PySide6.QtCore import QMimeDatabase
for path in sys.argv[1:]:
    print(QMimeDatabase().mimeTypeForFile(path).name())
"""


def test_a_session_has_its_own_file_type_by_name_and_by_content(home, capsys):
    answer(capsys, "integrate", "--yes")
    import sqlite3

    session, renamed, other = home / f"a{SUFFIX}", home / "renamed", home / "other"
    for path, number in ((session, 0x4861706B), (renamed, 0x4861706B), (other, 7)):
        with sqlite3.connect(path) as database:  # SQLite writes the header, not the studio
            database.execute(f"PRAGMA application_id = {number}")
            database.execute("CREATE TABLE t (x)")
    environment = os.environ | {"XDG_DATA_HOME": str(home / ".local/share")}
    command = [sys.executable, "-c", FILE_TYPE, *map(str, (session, renamed, other))]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split()[:2] == ["application/x-hapkit-session"] * 2
    assert done.stdout.split()[2] != "application/x-hapkit-session"


def test_changes_that_need_root_are_printed_as_commands(home, monkeypatch, tmp_path):
    rules, limits = tmp_path / "rules", tmp_path / "limits"
    monkeypatch.setattr(integrate, "UDEV", rules)
    monkeypatch.setattr(integrate, "LIMITS", limits)
    normal = integrate.priority.Priority("Normal priority", how="Ask.")
    monkeypatch.setattr(integrate.priority, "probe", lambda: normal)
    monkeypatch.setattr(integrate.getpass, "getuser", lambda: "zoe")
    commands = integrate.root_commands()
    for command in commands:
        if "tee" in command:
            subprocess.run(["sh", "-c", command.replace("sudo ", "")], check=True, capture_output=True)
    assert limits.read_text() == "zoe - rtprio 80\nzoe - memlock unlimited\n"
    (rule,) = rules.read_text().splitlines()
    assert 'SUBSYSTEM=="tty"' in rule
    assert 'TAG+="uaccess"' in rule
    # the vendors are FTDI, Arduino and WCH (usb.ids)
    assert all(vendor in rule for vendor in ("0403", "2341", "1a86"))
    assert integrate.root_commands() == []  # both files exist, so no command is left


def test_a_double_clicked_session_is_replayed(monkeypatch):
    from hapkit_studio.gui.shell import app

    seen = []
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    monkeypatch.setattr(app, "run", lambda given, _preparing: seen.append(given) or 0)
    monkeypatch.setattr("hapkit_studio.gui.state.prepare.begin", lambda *_: None)
    assert cli.main(["/tmp/my press.hapkit"]) == 0
    from hapkit_studio.arguments import window_parser

    assert window_parser().parse_args(seen[0]).replay == Path("/tmp/my press.hapkit")
    assert cli.SESSION_SUFFIX == SUFFIX


@pytest.mark.parametrize(
    ("system", "place"),
    [
        ("win32", r"HKEY_CURRENT_USER\Software\hapkit-studio\hapkit-studio"),
        ("darwin", "/Library/Preferences/com.hapkit-studio.hapkit-studio.plist"),
        ("linux", "/.config/hapkit-studio/hapkit-studio.conf"),
    ],
)
def test_where_names_the_place_in_which_qt_stores_settings(system, place):
    assert where.settings_place(system).endswith(place)


def test_where_names_the_file_that_qt_writes_here(home):
    code = (
        "from PySide6.QtCore import QSettings; print(QSettings('hapkit-studio', 'hapkit-studio').fileName())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.strip() == where.settings_place()
