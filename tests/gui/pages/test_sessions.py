"""The page Sessions: listing, viewing, exporting, deleting; unreadable files are explained in their rows."""

import json
import os
import random
import shutil
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from pyarrow import parquet
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog, QLabel, QPushButton

from hapkit_studio.cli import main
from hapkit_studio.gui.editor.controller import DeleteDialog
from hapkit_studio.gui.pages import sessions
from hapkit_studio.gui.widgets.dialogs import WordsDialog
from hapkit_studio.haptics import rows
from hapkit_studio.sessions.file import MARKER, Event, SessionWriter
from hapkit_studio.sessions.folder import folder
from hapkit_studio.sessions.overview import overview
from hapkit_studio.sessions.session import Session
from tests.gui.shell.test_layout import cut_off, resize
from tests.gui.window_support import PATIENCE_MS
from tests.sessions.damaged import ESCAPES, mutate, set_value
from tests.sessions.test_chunk import QUANTUM
from tests.sessions.test_file import written
from tests.sessions.test_overview import motion, write


@pytest.fixture
def page(shared_window, qtbot, home):
    """Return the visible page with three sessions, one of them unreadable, and another file."""
    folder().mkdir()
    write(folder() / "friction in the lab.hapkit", motion(2.0))
    write(folder() / "Wall to its limit.hapkit", motion(1.0))
    (folder() / "broken.hapkit").write_text("a letter")
    (folder() / "notes.txt").write_text("not a session")
    shown = shared_window.views.page("sessions")
    shown.search.clear()
    shown._others.clear()
    shared_window.views.show("sessions")
    shown.load()  # reads the folder again if the page was visible already
    qtbot.waitUntil(lambda: not shown._reading.running)
    yield shown
    shared_window.views.show("live")


def listed(page):
    return {row[0] for row in page.table.texts()[1:]}


def choose(page, name):
    """Select a row with a click."""
    row = [texts[0] for texts in page.table.texts()[1:]].index(name)
    if page.table.currentIndex().row() != row:
        place = page.table.visualRect(page.table.model().index(row, 0)).center()
        QTest.mouseClick(page.table.viewport(), Qt.MouseButton.LeftButton, pos=place)


def test_the_folder_is_listed_and_unreadable_files_say_why(page):
    assert listed(page) == {"friction in the lab", "Wall to its limit", "broken"}
    choose(page, "broken")
    assert page.side.label.text() == "broken.hapkit is not a session of Hapkit Studio."
    assert not page.export.isEnabled()
    assert page.chart.isHidden()
    choose(page, "friction in the lab")
    assert page.side.heading.text() == "friction in the lab"
    assert page.side.label.text() == "2.0 s, 2,000 samples"
    assert dict(page.facts.pairs)["Environments"] == "Wall, Spring"
    assert page.happened.pairs == [
        ("0.25 s", "a quarter"),
        ("0.50 s", "environment wall → spring"),
        ("0.70 s", "environment spring → wall"),
    ]
    assert page.chart.isVisible()


def test_a_search_needs_every_word_and_only_new_files_are_read(page, qtbot, monkeypatch):
    whole = {"friction in the lab", "Wall to its limit"}
    for text, found in (
        ("LIMIT wall", {"Wall to its limit"}),
        ("quarter", whole),
        ("spring simulated", whole),
        ("quarter broken", set()),
    ):
        page.search.clear()
        QTest.keyClicks(page.search, text)
        assert listed(page) == found
        assert (page.chosen is not None) == bool(found)
    page.search.clear()
    read, any_one = [], page.chosen
    monkeypatch.setattr(sessions, "overview", lambda path: read.append(path.name) or any_one)
    write(folder() / "new.hapkit", motion(1.0))
    page.load()
    qtbot.waitUntil(lambda: not page._reading.running)
    assert read == ["new.hapkit"]


def exported(page, qtbot, kind, output):
    """Export the chosen session to a file of a type; return the message."""
    page.status.setText("")
    page.export.click()
    dialog = page.findChildren(QFileDialog)[-1]
    assert not dialog.isModal()
    dialog.selectNameFilter(kind)
    dialog.fileSelected.emit(str(output))
    dialog.close()
    qtbot.waitUntil(lambda: page.status.text() and not page.status.text().startswith("Exporting"))
    return page.status.text()


def test_an_export_contains_the_samples_with_the_selected_decimal_mark(page, qtbot, tmp_path):
    choose(page, "Wall to its limit")
    for kind, name, separator, decimal in (
        ("Table (*.csv)", "a.csv", ",", "."),
        ("Table with decimal commas (*.csv)", "b.csv", ";", ","),
    ):
        assert exported(page, qtbot, kind, tmp_path / name) == f"The file {name} was saved with 1,000 samples"
        head, *lines = [x for x in (tmp_path / name).read_text().splitlines() if not x.startswith("#")]
        place = head.split(separator).index("position_m")
        values = [float(line.split(separator)[place].replace(decimal, ".")) for line in lines]
        assert np.abs(np.array(values) - motion(1.0)[:, rows.POSITION]).max() <= 0.5 * QUANTUM
    assert (
        exported(page, qtbot, "Parquet (*.parquet)", tmp_path / "c.parquet")
        == "The file c.parquet was saved with 1,000 samples"
    )
    found = parquet.read_table(tmp_path / "c.parquet")
    assert np.abs(found["position_m"].to_numpy() - motion(1.0)[:, rows.POSITION]).max() <= 0.5 * QUANTUM
    changes = json.loads(found.schema.metadata[b"settings"])["changes"]
    assert [(change["time_s"], change["environment"]) for change in changes] == [
        (0.5, "spring"),
        (0.7, "wall"),
    ]
    status = exported(page, qtbot, "Table (*.csv)", tmp_path / "none" / "a.csv")
    assert status == "The file a.csv cannot be written: No such file or directory."
    assert page.status.property("role") == "error"


def test_a_session_opened_from_any_folder_is_listed_and_selected(page, qtbot, tmp_path):
    write(tmp_path / "from a friend.hapkit", motion(1.0))
    page.open_other(str(tmp_path / "from a friend.hapkit"))
    qtbot.waitUntil(lambda: page.chosen is not None and page.chosen.path.stem == "from a friend")
    assert len(listed(page)) == 4


def test_recent_sessions_from_other_folders_are_remembered_while_they_exist(page, tmp_path):
    kept = [tmp_path / f"{number}.hapkit" for number in range(12)]
    for path in kept:
        path.touch()
        page.open_other(str(path))
    kept[5].unlink()
    assert sessions.recent(page._settings) == [*kept[11:5:-1], *kept[4:1:-1]]


@pytest.mark.slow
@pytest.mark.parametrize("way", ["button", "double click", "enter"])
def test_a_replay_starts_in_the_live_view(page, shared_window, qtbot, way):
    choose(page, "friction in the lab")
    if way == "button":
        QTest.mouseClick(page.replay, Qt.MouseButton.LeftButton)
    elif way == "enter":
        QTest.keyClick(page.table, Qt.Key.Key_Return)
    else:
        place = page.table.visualRect(page.table.currentIndex()).center()
        QTest.mouseDClick(page.table.viewport(), Qt.MouseButton.LeftButton, pos=place)
    qtbot.waitUntil(lambda: shared_window.replay.history is not None)
    assert shared_window.replay.history.session.path.stem == "friction in the lab"
    assert shared_window.views.key == "live"
    shared_window.replay.close()
    shared_window.history.forget()


@pytest.mark.slow
@pytest.mark.parametrize("size", [pytest.param((1920, 1080), marks=pytest.mark.slow), (800, 560)])
def test_nothing_is_cut_off(page, shared_window, qapp, size):
    QTest.keyClicks(page.search, "wall")  # this also shows the field's clear button, which fades out slowly
    resize(qapp, shared_window, size)
    assert cut_off(shared_window) == []
    assert all(button.isVisible() for button in page.findChildren(QPushButton) if button.text())
    resize(qapp, shared_window, (1440, 900))


def test_the_list_of_events_ends_between_two_lines(page, shared_window, qapp):
    """Twenty lines in one form are higher than the panel."""
    page.happened.show_pairs([(f"{number} s", "stiffness 300 → 350 N/m") for number in range(20)])
    bottom = page.side.viewport()
    for height in range(720, 760, 4):  # a line is about 20 high
        resize(qapp, shared_window, (1280, height))
        lines = page.happened.findChildren(QLabel)
        tops = [line.mapTo(bottom, QPoint()).y() for line in lines]
        end = page.side._cover.mapTo(page.side, QPoint()).y()
        assert bottom.height() - 40 < end < max(tops)
        cut = [top for top, line in zip(tops, lines, strict=True) if top < end < top + line.height()]
        assert not cut, height
    resize(qapp, shared_window, (1440, 900))


def test_a_deleted_session_is_moved_to_the_trash_and_leaves_the_list(page, shared_window, qtbot, monkeypatch):
    def to_bin(name):
        (folder() / name.rpartition("/")[2]).rename(folder().parent / "bin")
        return True

    monkeypatch.setattr("hapkit_studio.gui.editor.controller.QFile.moveToTrash", to_bin)
    choose(page, "Wall to its limit")
    page.delete.click()
    assert "Wall to its limit" in listed(page)
    shared_window.findChildren(DeleteDialog)[-1].delete.click()
    qtbot.waitUntil(lambda: listed(page) == {"friction in the lab", "broken"})


def dialog_of(window, kind):
    (dialog,) = [d for d in window.findChildren(kind) if d.isVisible()]
    return dialog


def finished(page, qtbot):
    """Wait until the job is done and the list is read again."""
    qtbot.waitUntil(lambda: not (page._changing.running or page._reading.running))


def test_a_session_is_renamed_with_f2_and_stays_chosen(page, shared_window, qtbot):
    choose(page, "friction in the lab")
    for name, text in (("Wall to its limit", "exists already"), ("a/b", "A name must not contain")):
        shared_window.activateWindow()
        assert QTest.qWaitForWindowActive(shared_window, PATIENCE_MS)
        QTest.keyClick(page.table, Qt.Key.Key_F2)
        dialog = dialog_of(shared_window, WordsDialog)
        assert (dialog.text.text(), dialog.text.selectedText()) == ("friction in the lab",) * 2
        dialog.text.setText(name)
        dialog.add.click()
        finished(page, qtbot)
        assert text in page.status.text()
        assert page.status.property("role") == "error"
    page.rename.click()
    dialog_of(shared_window, WordsDialog).text.setText("Gruppe 3")
    dialog_of(shared_window, WordsDialog).add.click()
    finished(page, qtbot)
    assert listed(page) == {"Gruppe 3", "Wall to its limit", "broken"}
    assert page.chosen.path == folder() / "Gruppe 3.hapkit"
    assert page.status.text() == "friction in the lab was renamed to Gruppe 3."


def kill(name):
    """Write the files of a recording whose program was killed; return the recorded data."""
    elsewhere = folder().parent / "killed"
    elsewhere.mkdir()
    made = written(elsewhere / name, 5, close=False)
    for file in elsewhere.iterdir():
        shutil.copy(file, folder())
    return made


@pytest.mark.slow
def test_an_unfinished_recording_says_so_and_can_be_saved_as_a_complete_file(
    page, shared_window, qtbot, tmp_path, monkeypatch
):
    made = kill("killed.hapkit")
    page.load()
    finished(page, qtbot)
    choose(page, "killed")
    assert next(row[3] for row in page.table.texts() if row[0] == "killed") == "Recording not ended"
    assert (
        "its newest samples are in killed.hapkit-wal. To make one complete file, save a copy"
        in page.side.label.text()
    )
    enabled = {button.text(): button.isEnabled() for button in page.side.findChildren(QPushButton)}
    assert {text for text, on in enabled.items() if not on} == {"Note…", "Rename…"}
    assert len(enabled) == 7
    assert not shared_window.actions_by_key.run("session.rename")
    assert not [d for d in shared_window.findChildren(WordsDialog) if d.isVisible()]
    for output in (folder() / "whole.hapkit", tmp_path / "elsewhere.hapkit"):
        shared_window.actions_by_key.run("session.save_copy")
        dialog = dialog_of(page, QFileDialog)
        assert not dialog.isModal()
        dialog.fileSelected.emit(str(output))
        dialog.close()
        finished(page, qtbot)
        assert page.chosen.path == output
        assert page.status.text() == f"The copy {output.name} was saved as one complete file."
        with closing(Session(output)) as session:
            assert (session.complete, session.check()) == (True, ())
            assert np.array_equal(session.read(("tick",))["tick"], made[:, rows.TICK])
        choose(page, "killed")
    gone = []
    monkeypatch.setattr(
        "hapkit_studio.gui.editor.controller.QFile.moveToTrash",
        lambda name: gone.append(Path(name).name) or True,
    )
    page.delete.click()
    shared_window.findChildren(DeleteDialog)[-1].delete.click()
    assert gone == ["killed.hapkit", "killed.hapkit-wal", "killed.hapkit-shm"]


@pytest.mark.slow
def test_damaged_files_hide_no_other_file(page, qtbot):
    whole = (folder() / "Wall to its limit.hapkit").read_bytes()
    for seed in range(40):
        (folder() / f"{seed}.hapkit").write_bytes(whole)
        mutate(folder() / f"{seed}.hapkit", random.Random(seed))
    name = f"esc{ESCAPES}.hapkit"
    (folder() / name).write_bytes(whole)
    set_value(folder() / name, "event", 1, "what", json.dumps({"device": ESCAPES + 200 * "W"}))
    os.utime(folder() / name, (1e11, 1e11))  # in the year 5138, or what the file system stores instead
    page.load()
    finished(page, qtbot)
    assert len(listed(page)) == 3 + 40 + 1
    assert all(text.isprintable() for row in page.table.texts() for text in row)
    assert page.status.isHidden() or page.status.property("role") != "error"
    for row in range(len(page.table.content.rows)):
        page.table.selectRow(row)
        assert page.chosen is page.table.content.rows[row]


@pytest.mark.slow
def test_long_words_from_a_file_leave_space_for_others(page, shared_window, qtbot, qapp):
    path = folder() / f"{'W' * 120}.hapkit"
    write(path, motion(1.0))
    set_value(path, "event", 1, "what", json.dumps({"device": "D" * 200}))
    set_value(path, "event", 2, "what", json.dumps({"environment": "E" * 200}))
    page.load()
    finished(page, qtbot)
    choose(page, path.stem)
    for size in ((1280, 720), (800, 560)):
        resize(qapp, shared_window, size)
        header = page.table.horizontalHeader()
        assert header.sectionSize(0) >= 80
        assert header.length() <= page.table.viewport().width()
        panel = page.side.viewport().width()
        assert all(label.width() <= panel for label in page.side.findChildren(QLabel) if label.isVisible())
    resize(qapp, shared_window, (1440, 900))


@pytest.mark.slow
def test_events_beyond_the_limit_are_counted(page):
    path = folder() / "many.hapkit"
    write(path, motion(1.0))
    with closing(SessionWriter.reopen(path)) as writer:
        writer._database.execute("PRAGMA synchronous=OFF")
        for number in range(300):
            writer.note(Event(100.0 + 1e-3 * number, MARKER, {"text": f"marker {number}"}))
    page.show_session(overview(path))
    assert len(page.happened.pairs) == 201
    assert page.happened.pairs[-1] == (
        "",
        "103 more events: run “hapkit-studio sessions show” in a terminal to list them",
    )


@pytest.mark.slow
def test_open_lists_the_file_from_any_view(page, shared_window, qtbot, tmp_path):
    write(tmp_path / "from a friend.hapkit", motion(1.0))
    shared_window.views.show("live")
    assert not shared_window.actions_by_key.qt["session.rename"].isEnabled()
    shared_window.actions_by_key.run("session.open")
    assert shared_window.views.key == "sessions"
    dialog = dialog_of(page, QFileDialog)
    assert not dialog.isModal()
    dialog.fileSelected.emit(str(tmp_path / "from a friend.hapkit"))
    dialog.close()
    qtbot.waitUntil(lambda: page.chosen is not None and page.chosen.path.stem == "from a friend")
    shared_window.actions_by_key.refresh()
    assert shared_window.actions_by_key.qt["session.rename"].isEnabled()


def test_the_recording_folder_is_chosen_in_the_window_and_stored(page, shared_window, qtbot, tmp_path):
    usual, chosen = folder(), tmp_path / "Gruppe 3"
    chosen.mkdir()
    write(chosen / "ours.hapkit", motion(1.0))
    shared_window.actions_by_key.run("session.folder")
    dialog = dialog_of(page, QFileDialog)
    assert (dialog.isModal(), dialog.fileMode()) == (False, QFileDialog.FileMode.Directory)
    dialog.fileSelected.emit(str(chosen))
    dialog.close()
    finished(page, qtbot)
    assert folder() == chosen
    assert listed(page) == {"ours"}
    assert page.status.text() == f"New sessions will be recorded into the folder {chosen}."
    (tmp_path / "file").touch()
    page.record_into(str(tmp_path / "file"))
    assert page.status.text() == f"{tmp_path / 'file'} cannot be chosen: File exists."
    assert folder() == chosen
    page.record_into(str(usual))
    finished(page, qtbot)
    assert listed(page) == {"friction in the lab", "Wall to its limit", "broken"}


def test_without_sessions_the_page_says_how_to_record_one(shared_window, qtbot, home):
    page = sessions.SessionsPage(shared_window.studio, shared_window.live)
    qtbot.addWidget(page)
    page._others.clear()
    page.show()
    page.load()
    assert (page.empty.isVisible(), page.empty.text()) == (True, "Reading the sessions…")
    qtbot.waitUntil(lambda: not page._reading.running)
    assert listed(page) == set()
    assert page.empty.isVisible()
    assert "(R)" in page.empty.text()
    assert str(folder()) in page.empty.text()


@pytest.mark.slow
def test_a_note_is_stored_in_the_file_and_found_by_the_search(page, shared_window, qtbot, capsys):
    path = folder() / "friction in the lab.hapkit"
    date = path.stat().st_mtime_ns
    choose(page, path.stem)
    for text in ("Überschwinger bei 4 kHz", "second"):
        page.note.click()
        (dialog,) = [d for d in shared_window.findChildren(WordsDialog) if d.isVisible()]
        dialog.text.setText(text)
        dialog.add.click()
        qtbot.waitUntil(lambda: not (page._changing.running or page._reading.running))
    page.search.setText("überschwinger")
    assert listed(page) == {path.stem}
    assert ("Note", "Überschwinger bei 4 kHz") in page.facts.pairs
    assert path.stat().st_mtime_ns == date
    assert main(["sessions", "show", str(path)]) == 0
    assert "note: Überschwinger bei 4 kHz\nnote: second\n" in capsys.readouterr().out
