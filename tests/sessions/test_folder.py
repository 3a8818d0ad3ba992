"""The user chooses the folder of sessions, which is stored; names are never overwritten."""

import os
from pathlib import Path

import pytest

from hapkit_studio.cli import main
from hapkit_studio.errors import FileError
from hapkit_studio.sessions import folder as folders
from hapkit_studio.sessions.file import SessionError
from hapkit_studio.sessions.folder import choose_folder, chosen_folder, folder, new_path, rename, usual_folder
from hapkit_studio.sessions.session import Session
from tests.sessions.test_file import written


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HAPKIT_STUDIO_FOLDER", str(tmp_path / "home"))
    return tmp_path / "home"


def test_the_chosen_folder_is_created_and_used_until_the_default_is_chosen(home, tmp_path):
    assert folder() == usual_folder() == home / "Hapkit sessions"
    chosen = tmp_path / "on a stick" / "Gruppe 3 – Wände"
    choose_folder(chosen)
    assert chosen.is_dir()
    assert folder() == chosen_folder() == chosen
    assert new_path("wall").parent == chosen
    choose_folder(usual_folder())
    assert chosen_folder() is None
    assert folder() == usual_folder()


def test_a_folder_is_chosen_and_shown_on_the_command_line(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["sessions", "where", "relative"]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'relative'}\n"
    monkeypatch.chdir("/")
    assert main(["sessions", "where"]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'relative'}\n"
    (tmp_path / "file").touch()
    assert main(["sessions", "where", str(tmp_path / "file")]) == 2
    assert capsys.readouterr().err == f"hapkit-studio: {tmp_path / 'file'} cannot be chosen: File exists.\n"
    assert folder() == tmp_path / "relative"


def test_a_write_protected_folder_is_not_chosen(tmp_path, monkeypatch):
    monkeypatch.setattr(folders.os, "access", lambda _path, _how: False)
    with pytest.raises(
        SessionError, match=r"^You have no permission to write into .*: choose another folder\.$"
    ):
        choose_folder(tmp_path / "locked")
    assert folder() == usual_folder()


@pytest.mark.parametrize("stored", [b"\xff\xfe", b"relative", b"", b"/a\nb", b"/a\x1b[2J", b"/" * 100_000])
def test_an_unreadable_choice_gives_the_default_folder_and_one_message(home, stored, capsys):
    home.mkdir()
    (home / "recording-folder.txt").write_bytes(stored)
    assert folder() == usual_folder()
    with pytest.raises(FileError, match=r"recording-folder\.txt"):
        chosen_folder()
    assert main(["sessions", "where"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("name", ["wall, 400 N", "wall, 400 N.hapkit", " wall, 400 N "])
def test_a_session_is_renamed_in_its_folder(tmp_path, name, capsys):
    written(tmp_path / "a.hapkit", 1)
    assert main(["sessions", "rename", str(tmp_path / "a.hapkit"), name]) == 0
    assert capsys.readouterr().out == "a.hapkit is now wall, 400 N.hapkit.\n"
    assert Session(tmp_path / "wall, 400 N.hapkit").check() == ()
    assert [path.name for path in tmp_path.iterdir()] == ["wall, 400 N.hapkit"]


@pytest.mark.parametrize(
    "name",
    [
        "",
        " ",
        ".hapkit",
        ".hidden",
        "a/b",
        "../a",
        "a\\b",
        "a:b",
        "a\x1b[2J",
        "a\nb",
        "a.",
        "é" * 101,
        "\ud800",
    ],
)
def test_a_name_that_some_system_forbids_is_refused(tmp_path, name):
    written(tmp_path / "a.hapkit", 1)
    with pytest.raises(SessionError, match=r"^A name must (not contain|have at most 200 bytes)[^\n\x1b]*$"):
        rename(tmp_path / "a.hapkit", name)
    assert [path.name for path in tmp_path.iterdir()] == ["a.hapkit"]


def test_an_existing_name_is_refused_and_both_files_remain(tmp_path):
    written(tmp_path / "a.hapkit", 1)
    (tmp_path / "b.hapkit").write_text("mine")
    with pytest.raises(SessionError, match=r"^b\.hapkit exists already: choose another name\.$"):
        rename(tmp_path / "a.hapkit", "b")
    assert (tmp_path / "b.hapkit").read_text() == "mine"
    assert rename(tmp_path / "a.hapkit", "a") == tmp_path / "a.hapkit"
    with pytest.raises(SessionError, match=r"^none\.hapkit cannot be renamed: No such file"):
        rename(tmp_path / "none.hapkit", "c")
    assert not (tmp_path / "c.hapkit").exists()


def test_a_recording_that_was_not_ended_is_not_separated_from_its_log(tmp_path):
    written(tmp_path / "a.hapkit", 1, close=False)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(
        SessionError, match=r"is incomplete and needs a\.hapkit-wal: save a copy instead of renaming it"
    ):
        rename(tmp_path / "a.hapkit", "b")
    assert sorted(tmp_path.iterdir()) == before


def test_a_failed_rename_leaves_the_old_name(tmp_path, monkeypatch):
    written(tmp_path / "a.hapkit", 1)

    def refuse(_path, _new):
        raise PermissionError(13, os.strerror(13))

    monkeypatch.setattr(Path, "replace", refuse)
    with pytest.raises(SessionError, match=r"^a\.hapkit cannot be renamed: Permission denied\.$"):
        rename(tmp_path / "a.hapkit", "b")
    assert [path.name for path in tmp_path.iterdir()] == ["a.hapkit"]


@pytest.mark.parametrize(
    "args", [["rename", "a.hapkit"], ["rename"], ["show", "a.hapkit", "b"], ["where", "a", "b"]]
)
def test_too_few_or_too_many_names_are_one_line(args, capsys):
    assert main(["sessions", *args]) == 2
    assert capsys.readouterr().err.count("\n") == 1
