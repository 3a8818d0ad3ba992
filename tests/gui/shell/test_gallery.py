"""The gallery lists own environments below the library; all rows are reachable at every window size."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.gui.editor.controller import DeleteDialog
from hapkit_studio.gui.shell.gallery import GalleryRow
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.palette import luminance
from tests.gui.own_support import put, spring
from tests.gui.shell.test_layout import resize

SEEN_AT_LEAST = 13
"""Minimum number of library rows visible in the smallest window; the others are reached by scrolling."""


def is_fully_visible(gallery, row) -> bool:
    top = row.mapTo(gallery, row.rect().topLeft()).y()
    return top >= 0 and top + row.height() <= gallery.new_row.y()


def next_stop(widget):
    widget = widget.nextInFocusChain()
    while not widget.focusPolicy() & Qt.FocusPolicy.TabFocus:
        widget = widget.nextInFocusChain()
    return widget


@pytest.fixture(scope="module", autouse=True)
def home(tmp_path_factory):
    """Return a home folder for the whole file, with two own files and one from someone else."""
    folder = tmp_path_factory.mktemp("home")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HAPKIT_STUDIO_FOLDER", str(folder))
        patch.setenv("XDG_DATA_HOME", str(folder / "data"))
        for name in ("a", "b"):
            put(folder, f"{name}.py", spring(name, f"My {name}"))
        put(folder, "c.py", spring("c", "Ada's"), trusted=False)
        yield folder / "environments"


@pytest.fixture
def rows(home, shared_window):
    """Return the rows of the own environments by file name."""
    return {path.stem: row for path, row in shared_window.gallery.own_rows.items()}


@pytest.mark.slow
def test_a_row_is_readable_under_the_mouse(qtbot, monkeypatch):
    row = GalleryRow("wall", "Wall", "Push", "2")
    qtbot.addWidget(row)
    row.resize(220, 48)
    monkeypatch.setattr(row, "underMouse", lambda: True)
    for mode in ("light", "dark", "contrast"):
        theme.set_mode(mode)
        ground = row.grab().toImage().pixelColor(215, 3).name()
        assert ground != theme.color("side").name()
        for token in ("ink", "ink3"):
            lights = sorted((luminance(theme.color(token).name()), luminance(ground)))
            assert (lights[1] + 0.05) / (lights[0] + 0.05) >= 4.5, token


@pytest.mark.slow
def test_the_whole_library_and_the_new_button_are_visible(home, monkeypatch, tmp_path, make_window, qapp):
    monkeypatch.setenv("HAPKIT_STUDIO_FOLDER", str(tmp_path))
    window = make_window()
    gallery = window.gallery
    assert not gallery.own_heading.isVisible()
    for size in ((1440, 900), (1280, 720), (960, 600)):
        resize(qapp, window, size)
        assert gallery.rail == (size[0] < 1440)
        seen = [is_fully_visible(gallery, row) for row in gallery.rows.values()]
        assert all(seen) or (sum(seen) >= SEEN_AT_LEAST and gallery.verticalScrollBar().maximum() > 0), size
        assert gallery.new_row.geometry().bottom() < gallery.height()
        assert all(row.height() >= 34 for row in gallery.rows.values())
    for number in range(20):
        put(tmp_path, f"law_{number:02}.py", spring(f"law_{number}", f"A law with a long title, {number}"))
    window.own.refresh()
    resize(qapp, window, (1440, 900))
    assert len(gallery.own_rows) == 20
    assert gallery.verticalScrollBar().maximum() > 0
    assert gallery.horizontalScrollBar().maximum() == 0
    assert gallery.new_row.geometry().bottom() < gallery.height()
    assert all(row.width() <= gallery.viewport().width() for row in gallery.rows.values())


def test_there_is_space_for_own_environments_below_the_library(shared_window, rows, qapp):
    gallery = shared_window.gallery
    resize(qapp, shared_window, (1440, 900))
    assert gallery.own_heading.isVisible()
    assert all(is_fully_visible(gallery, rows[name]) for name in "ab")
    resize(qapp, shared_window, (1280, 720))
    assert not gallery.own_heading.isVisible()
    assert rows["a"].toolTip() == "My a: For a test"
    resize(qapp, shared_window, (1440, 900))


def test_own_environments_and_the_new_button_are_reached_by_key(shared_window, rows, monkeypatch, home):
    gallery = shared_window.gallery
    stop = list(gallery.rows.values())[-1]
    for row in (*rows.values(), gallery.new_row):
        stop = next_stop(stop)
        assert stop is row
    assert rows["a"].accessibleName() == "My a: For a test"
    assert rows["a"].pencil.accessibleName() == "Edit My a"
    chosen = []
    monkeypatch.setattr(shared_window.own, "choose", chosen.append)
    QTest.keyClick(rows["a"], Qt.Key.Key_Return)
    assert chosen == [home / "a.py"]
    QTest.keyClick(gallery.new_row, Qt.Key.Key_Return)
    assert shared_window.editor.editor.chooser.isVisible()
    assert shared_window.editor.editor.chooser.title.hasFocus()
    assert shared_window.studio.environment.key == "wall"


def test_own_environments_are_in_the_menu(shared_window, rows):
    menu = next(a.menu() for a in shared_window.menuBar().actions() if a.text() == "Environment")
    menu.aboutToShow.emit()
    yours = next(a for a in menu.actions() if a.text() == "Your own")
    assert yours.isVisible()
    assert [action.text() for action in yours.menu().actions()] == [row.title for row in rows.values()]


def test_pencil_and_menu_open_an_own_law_and_a_foreign_one_must_be_read_first(shared_window, rows, home):
    texts = {name: [action.text() for action in rows[name].menu().actions()] for name in "ac"}
    assert texts == {"a": ["Edit", "Show in folder", "Delete…"], "c": ["Show in folder", "Delete…"]}
    rows["a"].pencil.click()
    assert shared_window.editor.path == home / "a.py"
    assert shared_window.editor.page.isVisible()
    assert not rows["c"].pencil.isVisible()
    shared_window.editor.edit(home / "c.py")
    assert shared_window.editor.editor.source.isVisible()


def test_deleting_asks_first_and_moves_the_file_to_the_bin(shared_window, rows, monkeypatch, home):
    binned = []
    monkeypatch.setattr(
        "hapkit_studio.gui.editor.controller.QFile.moveToTrash", lambda name: binned.append(name) or True
    )
    delete = rows["b"].menu().actions()[-1]
    delete.trigger()
    sheet = shared_window.findChild(DeleteDialog)
    assert sheet.isVisible()
    assert not sheet.isModal()
    assert binned == []
    sheet.keep.click()
    delete.trigger()
    shared_window.findChildren(DeleteDialog)[-1].delete.click()
    assert binned == [str(home / "b.py")]
