"""Files that come, go and fail beside the window: it follows them without being asked to look."""

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.workshop.source import read
from hapkit_studio.workshop.trying import failed
from tests.gui.own_support import law_tab, put, spring
from tests.gui.window_support import PATIENCE_MS


def test_a_file_copied_in_or_taken_away_is_noticed_at_once(home, make_window, qtbot):
    window = make_window()
    assert window.own.files == []
    path = put(home, "ada.py", spring("ada", "First"), trusted=False)
    qtbot.waitUntil(lambda: path in window.gallery.own_rows, timeout=PATIENCE_MS)
    row = window.gallery.own_rows[path]
    path.write_text(spring("ada", "Second"), encoding="utf-8")
    qtbot.waitUntil(lambda: row.title == "Second", timeout=PATIENCE_MS)
    path.unlink()
    qtbot.waitUntil(lambda: window.own.files == [], timeout=PATIENCE_MS)


def test_a_file_that_failed_is_known_to_after_the_next_start(home, make_window):
    path = put(home, "mine.py", spring("mine", force="-p.stifness * x"))
    fine = put(home, "fine.py", spring("fine"))
    window = make_window()
    assert window.gallery.own_rows[path].picture != "triangle"
    window.own.runner.finished.emit(read(path), failed("wrong", 10))
    again = make_window()
    assert again.gallery.own_rows[path].summary == "Does not run yet"
    assert again.gallery.own_rows[fine].summary == "For a test"
    put(home, "mine.py", spring("mine"))
    again.file_watcher.check_files()
    assert again.gallery.own_rows[path].summary == "For a test"


def test_a_built_in_environment_closes_a_strangers_source(home, make_window):
    path = put(home, "ada.py", spring("ada"), trusted=False)
    window = make_window()
    source = window.editor.editor.source
    for leave in (
        lambda: QTest.mouseClick(window.gallery.rows["wall"], Qt.MouseButton.LeftButton),  # in force already
        lambda: window.studio.choose("spring"),
        lambda: (path.unlink(), window.own.refresh()),
    ):
        window.own.choose(path)
        assert source.isVisible()
        leave()
        assert not source.isVisible()
        assert law_tab(window) is None
