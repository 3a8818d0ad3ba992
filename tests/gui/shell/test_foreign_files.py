"""Damaged files in the window: each gives a readable message, and the rest of the window still works."""

import io
from collections.abc import Callable
from contextlib import redirect_stderr
from pathlib import Path

import pytest
from PySide6.QtCore import QDeadlineTimer, QSettings
from PySide6.QtGui import QAction
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDialog, QLabel

from hapkit_studio.arguments import window_parser
from hapkit_studio.formatting import printable
from hapkit_studio.gui.panel.preset_row import CompareDialog
from hapkit_studio.gui.shell import app
from hapkit_studio.gui.state import presets
from hapkit_studio.gui.state.stored import StoredSettings
from hapkit_studio.sessions.folder import folder as session_folder
from tests import foreign_files
from tests.gui.conftest import deleted_in_the_end
from tests.gui.window_support import delete_deferred, put_back
from tests.test_foreign_files import Hang, limited, originals, stamp  # noqa: F401

WAIT_MS = 20_000


def read_settings(_window, file: Path) -> list[str]:
    """Start another window with a settings file and return its problems."""
    place = Path(QSettings("hapkit-studio", "hapkit-studio").fileName())
    place.parent.mkdir(parents=True, exist_ok=True)
    with open(file, "rb") as given:
        place.write_bytes(given.read(1 << 20))
    StoredSettings().sync()
    with deleted_in_the_end() as windows:
        windows.append(app.build(window_parser().parse_args([])))
        wrong = unprintable_texts(windows[0])
        notice = windows[0].banners.get("settings")
    if notice is not None and ("\n" in notice.text or len(notice.text) > 200):
        wrong.append(f"notice: {notice.text!r:.200}")
    StoredSettings().clear()
    return wrong


def read_preset(window, file: Path) -> list[str]:
    """List, compare, store and apply a preset next to a valid one."""
    row = window.panel.preset
    row.fill()
    names = [action.text() for action in row.menu.actions()]
    wrong = [] if "neighbour" in names else [f"the menu has only {names}"]
    for name in presets.found("wall"):
        window.presets.remember({"wall": name})
    CompareDialog(window.studio, window.presets, window).show()
    window.presets.apply(file)
    return wrong + unprintable_texts(window)


def read_demo(window, file: Path) -> list[str]:
    """Play a demo until its first step."""
    window.play_demo(file)
    window.demos.tick()
    wrong = unprintable_texts(window)
    window.demos.end()
    return wrong


def read_session(window, file: Path) -> list[str]:
    """List a session on the page next to a valid one, select it, replay it."""
    window.views.show("sessions")  # it stays visible, so that its chart is drawn
    page = window.views.page("sessions")
    page.load()
    wait(lambda: not page._reading.running)
    listed = [row[0] for row in page.table.texts()[1:]]
    wrong = [] if "neighbour" in listed else [f"the page lists only {listed}"]
    for found in page.table.content.rows:
        if found.path == file:
            page.show_session(found)
    window.replay.open(file)
    wait(lambda: not window.replay._reading.running)
    for _ in range(3):
        window.replay.tick()
    wrong += unprintable_texts(window)
    window.replay.close()
    return wrong


def read_recording(window, file: Path) -> list[str]:
    """Open a table on the Identify page."""
    page = window.views.page("identify")
    window.views.show("identify")
    page.opener.open(str(file))
    wait(lambda: not page.opener._job.running)
    wait(lambda: not page.job.running)
    return unprintable_texts(window)


READERS: dict[str, tuple[Callable, Callable[[Path], Path]]] = {
    "preset": (read_preset, lambda _home: presets.folder("wall")),
    "demo": (read_demo, lambda home: home),
    "session": (read_session, lambda _home: session_folder()),
    "csv": (read_recording, lambda home: home),
}
"""By kind of file: a function that reads it in the window, and a function that returns its folder."""


def wait(done: Callable[[], bool]) -> None:
    deadline = QDeadlineTimer(WAIT_MS)
    while not done():
        assert not deadline.hasExpired()
        QTest.qWait(1)


def unprintable_texts(window) -> list[str]:
    """Return the texts in the window that contain unprintable characters."""
    texts = [QLabel.text(label) for label in window.findChildren(QLabel)]
    # a tab separates an action's title and its key
    texts += [action.text().replace("\t", " ") for action in window.findChildren(QAction)]
    return [f"shown: {text!r:.100}" for text in texts if printable(text) != text]


@pytest.fixture
def try_file(originals, reset_idle_window, home, qtbot):  # noqa: F811
    """Return a function that opens one file and returns the problems found."""

    def try_one(kind: str, seed: int) -> list[str]:
        reader, place = READERS.get(kind, (read_settings, lambda home: home))
        folder = place(home)
        folder.mkdir(parents=True, exist_ok=True)
        neighbour = folder / f"neighbour{foreign_files.SUFFIXES[kind]}"
        neighbour.write_bytes(originals[kind])
        file = foreign_files.write(kind, seed, originals[kind], folder)
        before, error, wrong = stamp(file), io.StringIO(), []
        window = reset_idle_window
        with qtbot.captureExceptions() as raised, redirect_stderr(error):
            try:
                with limited():
                    wrong += reader(window, file)
            except (Exception, Hang) as failure:
                wrong.append(f"{type(failure).__name__}: {failure!s:.300}")
        wrong += [f"{kind_.__name__}: {value}" for kind_, value, _ in raised]
        if "Traceback" in error.getvalue():
            wrong.append(error.getvalue()[-400:])
        if stamp(file) != before:
            wrong.append("the file was changed")
        for path in (file, neighbour):
            path.unlink()
        for dialog in window.findChildren(QDialog):
            dialog.close()
            dialog.deleteLater()
        delete_deferred()
        window.history.forget()
        window.presets._chosen.clear()
        return [f"{kind} {seed}: {text}" for text in wrong]

    yield try_one
    put_back(reset_idle_window)


KINDS = ("settings", *READERS)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_few_damaged_files_give_a_message_and_change_nothing_else(try_file, kind):
    if kind == "csv":
        pytest.importorskip("hapkit_studio.gui.pages.open_recording")
    assert [text for seed in foreign_files.FEW for text in try_file(kind, seed)] == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_many_damaged_files_give_a_message_and_change_nothing_else(try_file, kind):
    if kind == "csv":
        pytest.importorskip("hapkit_studio.gui.pages.open_recording")
    found = [text for seed in range(foreign_files.COUNTS[kind]) for text in try_file(kind, seed)]
    assert not found, "\n".join([f"{len(found)} complaints", *found])
