"""Recording from the window: a file contains the loop's rows, and every failure is a one-line message."""

from datetime import datetime
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

import hapkit_studio as hs
from hapkit_studio.formatting import clock, megabytes
from hapkit_studio.gui.shell.window_dialogs import MarkerDialog
from hapkit_studio.haptics import rows
from hapkit_studio.sessions.file import MARKER
from hapkit_studio.sessions.folder import folder
from hapkit_studio.sessions.overview import overview
from hapkit_studio.sessions.recorder import Progress
from hapkit_studio.sessions.session import Session
from tests.gui.shell.test_layout import resize
from tests.gui.window_support import SIMULATED
from tests.wide import wide


@pytest.fixture
def window(reset_window, home):
    """Return this test file's window with its own folder and a running simulated device."""
    yield reset_window
    if reset_window.studio.recording.progress is not None:
        reset_window.studio.recording.toggle()
        reset_window.studio.recording._turn.wait()


def begin(window, qtbot):
    """Start a recording by key and wait until the file contains rows; return its path."""
    recording = window.studio.recording
    qtbot.waitUntil(lambda: not recording._turn.running)
    qtbot.keyClick(window.centre.scene, Qt.Key.Key_R)
    qtbot.waitUntil(lambda: recording.progress is not None and recording.progress.samples > 0)
    return recording.progress.path


def end(window, qtbot):
    """Stop the recording with the button."""
    recording = window.studio.recording
    qtbot.mouseClick(window.header.record, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: recording.newest is not None and not recording._turn.running)


@pytest.mark.slow
def test_a_recording_contains_the_rings_rows_and_the_settings(window, qtbot):
    reader = window.studio.engine.reader()
    path = begin(window, qtbot)
    begun = reader.read()
    window.studio.set_value("stiffness", 321.0)
    window.studio.move_hand(0.02)
    window.live.toggle_paused()  # the recording continues
    samples = window.studio.recording.progress.samples
    qtbot.waitUntil(lambda: window.studio.recording.progress.samples > samples + 500)
    during = reader.read()
    end(window, qtbot)
    ring, session = np.concatenate([begun, during]), Session(path)
    found = session.read(("tick", "position", "applied_force"))
    assert (np.diff(found["tick"]) == 1.0).all()
    both, ours, theirs = np.intersect1d(found["tick"], ring[:, rows.TICK], return_indices=True)
    assert len(both) > 500
    assert len(np.setdiff1d(during[:, rows.TICK], both)) == 0
    quantum = window.studio.engine.device.quantum
    assert np.abs(found["position"][ours] - ring[theirs, rows.POSITION]).max() < 0.01 * quantum
    assert hs.open_session(path).settings["parameters"]["stiffness"] == 321.0
    assert path.parent == folder()
    assert path.stem.startswith("wall ")


def test_header_and_status_bar_show_the_state_of_the_recording(window, qtbot):
    header, label = window.header.record, window.status.record.label
    assert header.word.text() == "Record"
    path = begin(window, qtbot)
    window.record_display.show_state()
    progress = window.studio.recording.progress
    assert header.word.text() == f"Stop {clock(progress.seconds)}"
    # actions are updated only when a menu opens
    assert not window.actions_by_key.qt["session.record"].isChecked()
    window.actions_by_key.refresh()
    assert window.actions_by_key.qt["session.record"].isChecked()
    qtbot.waitUntil(lambda: label.text().startswith("Recording 0:0"))
    end(window, qtbot)
    window.record_display.show_state()
    size = path.stat().st_size
    assert label.text() == f"{path.stem}, {megabytes(size)}"
    assert window.status.record.link.isVisible()
    assert header.word.text() == "Record"
    qtbot.mouseClick(window.status.record.link, Qt.MouseButton.LeftButton)
    page = window.views.page("sessions")
    assert window.views.key == "sessions"
    qtbot.waitUntil(lambda: page.chosen is not None and page.chosen.path == path)
    assert label.text().startswith("You can save the last ")
    assert not window.status.record.link.isVisible()


@pytest.mark.parametrize(
    "size",
    wide(
        [((800, 560),), ((1280, 720),), ((1366, 768),), ((1440, 900),), ((1920, 1080),)],
        lambda size: size in ((800, 560), (1280, 720)),
    ),
)
def test_the_time_of_a_long_recording_fits_beside_device_and_tabs(window, qapp, qtbot, monkeypatch, size):
    resize(qapp, window, size)
    header, show = window.header, window.header.show_recording
    monkeypatch.setattr(header, "show_recording", lambda *_: None)  # no updates by the display's timer
    parts = header.record, header.devices
    for time in ("", "1:02:03"):
        show(time)
        qtbot.waitUntil(lambda: all(part.width() >= part.sizeHint().width() for part in parts))
        assert header.tabs.isTabVisible(0)


@pytest.mark.slow
def test_the_shown_size_is_that_of_the_file(window, qtbot):
    path = begin(window, qtbot)
    recorder = window.studio.recording._recorder
    recorder._wait(recorder._flush)
    size = window.studio.recording.progress.size
    end(window, qtbot)
    # since the update, at most one chunk was written: one or two pages of 4096 bytes per column
    assert size <= path.stat().st_size <= size + 12 * 4096


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.9, "0:00"), (42.99, "0:42"), (60.0, "1:00"), (3599.9, "59:59"), (3723.0, "1:02:03")],
)
def test_a_duration_is_rounded_down(seconds, text):
    assert clock(seconds) == text


@pytest.mark.parametrize(
    ("seconds", "text"), [(12.3, "12 s"), (58.9, "59 s"), (179.5, "3 min"), (599.8, "10 min")]
)
def test_the_status_bar_shows_how_much_data_is_available(window, seconds, text, monkeypatch):
    monkeypatch.setattr(window.studio.recording._recorder, "buffered", seconds)
    window.studio.recording.newest = None
    window.record_display.show_state()
    assert window.status.record.label.text() == f"You can save the last {text}"


def test_earlier_data_is_saved_during_a_recording(window, qtbot):
    recorded = begin(window, qtbot)
    qtbot.keyClick(
        window.centre.scene,
        Qt.Key.Key_S,
        Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier,
    )
    qtbot.waitUntil(lambda: window.studio.recording.newest is not None)
    saved = window.studio.recording.newest[0]
    end(window, qtbot)
    assert saved != recorded
    earlier, later = (Session(path).read(("tick",))["tick"] for path in (saved, recorded))
    assert earlier[0] < later[0]  # the saved samples begin before the start of the recording


def test_a_file_is_never_overwritten(window, qtbot, monkeypatch):
    noon = datetime(2026, 11, 23, 12, 0, 5)
    monkeypatch.setattr("hapkit_studio.sessions.folder.datetime", SimpleNamespace(now=lambda: noon))
    folder().mkdir()
    first = folder() / "wall 2026-11-23 12.00.05.hapkit"
    first.write_text("mine")
    assert begin(window, qtbot).name == "wall 2026-11-23 12.00.05 (2).hapkit"
    assert first.read_text() == "mine"


def test_a_read_only_folder_gives_a_one_line_message_and_nothing_else_stops(window, qtbot):
    folder().write_text("a file in the folder's place")
    ticks = window.studio.engine.reader()
    qtbot.keyClick(window.centre.scene, Qt.Key.Key_R)
    qtbot.waitUntil(lambda: window.banners.get("recording") is not None)
    notice = window.banners.get("recording")
    assert notice.title == "Recording failed."
    assert notice.text == f"{folder()} cannot be created: File exists."
    qtbot.waitUntil(lambda: len(ticks.read()) > 0)
    assert window.studio.fault is None
    notice.buttons[0][1]()
    assert window.banners.get("recording") is None


def test_a_recording_that_ends_itself_shows_when_and_why_once(window, monkeypatch):
    recording, messages = window.studio.recording, []
    recording.failed.connect(lambda *args: messages.append(args))
    (folder()).mkdir()
    path = folder() / "full.hapkit"
    path.write_bytes(b"1234")
    why = "The disk is full. Everything up to there is saved."
    monkeypatch.setattr(recording._recorder, "progress", Progress(path, 252_000, 4, 252.9, why))
    recording._refresh()
    recording._refresh()
    assert messages == [("Recording stopped at 4:12.", why)]
    assert window.header.record.word.text() == "Record"
    assert window.status.record.label.text() == "full, 0 kB"


@pytest.mark.slow
def test_a_recording_whose_file_is_deleted_says_so_and_offers_to_save_the_rest(window, qtbot):
    path = begin(window, qtbot)
    path.unlink()
    qtbot.waitUntil(lambda: window.banners.get("recording") is not None)
    notice = window.banners.get("recording")
    assert notice.title.startswith("Recording stopped at 0:0")
    assert notice.text == (
        f"{path.name} was deleted or moved while it was written. "
        "The samples are still in memory: choose Save the last 10 minutes (Ctrl+Shift+S)."
    )
    assert window.studio.recording.newest is None
    window.actions_by_key.run("session.save_kept")
    qtbot.waitUntil(lambda: window.studio.recording.newest is not None)
    assert Session(window.studio.recording.newest[0]).check() == ()


def test_an_unreadable_folder_gives_one_message_and_the_default_is_used(make_window, home):
    (home / "recording-folder.txt").write_text("not a whole path")
    notice = make_window().banners.get("recording")
    assert notice.title == f"Recordings are saved in the folder {folder()}."
    assert notice.text == "recording-folder.txt is 'not a whole path'; it must be the whole path of a folder."
    assert folder() == home / "Hapkit sessions"


def test_a_marker_has_the_time_at_which_it_was_requested(window, qtbot):
    path = begin(window, qtbot)
    live = window.live
    live.tick()
    asked = live.history.now
    qtbot.keyClick(window.centre.scene, Qt.Key.Key_M, Qt.KeyboardModifier.ControlModifier)
    dialog = window.findChildren(MarkerDialog)[-1]
    assert not dialog.isModal()
    QTest.keyClicks(dialog.text, "r2 first push")  # letters that are also keys of actions
    samples = window.studio.recording.progress.samples
    qtbot.waitUntil(lambda: window.studio.recording.progress.samples > samples)
    live.tick()
    assert live.history.now > asked
    QTest.keyClick(dialog.text, Qt.Key.Key_Return)
    assert (asked, "r2 first push") in live.history.dividers
    end(window, qtbot)
    found = overview(path)
    start = Session(path).starts[0]
    assert [text for _, text in found.markers] == ["r2 first push"]
    assert found.markers[0][0] == pytest.approx(asked - start, abs=2e-6)


def test_a_marker_set_at_once_after_the_request_is_recorded(window, qtbot):
    recording = window.studio.recording
    qtbot.waitUntil(lambda: not recording._turn.running)
    recording.toggle()
    recording.note(MARKER, {"text": "early"})
    qtbot.waitUntil(lambda: recording.progress is not None and recording.progress.samples > 0)
    path = recording.progress.path
    end(window, qtbot)
    assert [event.what for event in Session(path).events if event.kind == MARKER] == [{"text": "early"}]


@pytest.mark.slow
def test_closing_the_window_completes_the_file(make_window, qtbot, home):
    window = make_window()
    window.studio.device.open(SIMULATED)
    qtbot.waitUntil(lambda: window.studio.engine is not None)
    path = begin(window, qtbot)
    window.close()
    assert not path.with_name(f"{path.name}-wal").exists()
    session = Session(path)
    assert session.check() == ()
    assert session.counts.sum() > 0
