"""The gallery: own environments below the library, all of it in reach at every size."""

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.gui.editor.controller import DeleteDialog
from hapkit_studio.gui.gallery import GalleryRow
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.palette import luminance
from tests.gui.own_support import put, spring

SEEN_AT_LEAST = 13
"""Rows of the library that have room in the smallest window; beyond them the gallery scrolls."""


def shown_whole(gallery, row) -> bool:
    top = row.mapTo(gallery, row.rect().topLeft()).y()
    return top >= 0 and top + row.height() <= gallery.new_row.y()


def next_stop(widget):
    widget = widget.nextInFocusChain()
    while not widget.focusPolicy() & Qt.FocusPolicy.TabFocus:
        widget = widget.nextInFocusChain()
    return widget


def settle(qapp, window, size) -> None:
    window.resize(*size)
    for _ in range(3):
        qapp.processEvents()


def test_the_whole_library_and_the_way_to_a_new_one_are_seen(idle_window, qapp):
    assert not idle_window.gallery.own_heading.isVisible()
    for size in ((1440, 900), (1280, 720), (960, 600)):
        settle(qapp, idle_window, size)
        gallery = idle_window.gallery
        assert gallery.rail == (size[0] < 1440)
        seen = [shown_whole(gallery, row) for row in gallery.rows.values()]
        assert all(seen) or (sum(seen) >= SEEN_AT_LEAST and gallery.verticalScrollBar().maximum() > 0), size
        assert gallery.new_row.geometry().bottom() < gallery.height()
        assert all(row.height() >= 34 for row in gallery.rows.values())


def test_own_environments_have_room_beside_the_library(home, make_window, qapp):
    paths = [put(home, f"{name}.py", spring(name, f"My {name}")) for name in ("a", "b")]
    window = make_window()
    settle(qapp, window, (1440, 900))
    assert window.gallery.own_heading.isVisible()
    assert all(shown_whole(window.gallery, window.gallery.own_rows[path]) for path in paths)
    settle(qapp, window, (1280, 720))
    assert not window.gallery.own_heading.isVisible()
    assert window.gallery.own_rows[paths[0]].toolTip() == "My a: For a test"


def test_many_own_environments_scroll_and_the_new_one_stays(home, make_window, qapp):
    for number in range(20):
        put(home, f"law_{number:02}.py", spring(f"law_{number}", f"A law with a long title, number {number}"))
    window = make_window()
    settle(qapp, window, (1440, 900))
    gallery = window.gallery
    assert len(gallery.own_rows) == 20
    assert gallery.verticalScrollBar().maximum() > 0
    assert gallery.horizontalScrollBar().maximum() == 0
    assert gallery.new_row.geometry().bottom() < gallery.height()
    assert all(row.width() <= gallery.viewport().width() for row in gallery.rows.values())


def test_a_row_under_the_mouse_can_be_read(qtbot, monkeypatch):
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


def test_keys_reach_own_environments(home, make_window, monkeypatch):
    path = put(home, "mine.py", spring("mine"))
    window = make_window()
    gallery, row = window.gallery, window.gallery.own_rows[path]
    assert next_stop(list(gallery.rows.values())[-1]) is row
    assert next_stop(row) is gallery.new_row
    assert row.accessibleName() == "Test spring: For a test"
    assert row.pencil.accessibleName() == "Edit Test spring"
    chosen = []
    monkeypatch.setattr(window.own, "choose", chosen.append)
    QTest.keyClick(row, Qt.Key.Key_Return)
    assert chosen == [path]
    QTest.keyClick(gallery.new_row, Qt.Key.Key_Return)
    assert window.editor.editor.chooser.isVisible()


def test_pencil_and_menu_lead_to_the_law(home, make_window):
    path = put(home, "mine.py", spring("mine"))
    window = make_window()
    row = window.gallery.own_rows[path]
    row.pencil.click()
    assert window.editor.path == path
    assert window.editor.page.isVisible()
    assert [action.text() for action in row.menu().actions()] == ["Edit", "Show in folder", "Delete…"]


def test_a_strangers_file_cannot_be_edited_before_it_was_read(home, make_window):
    path = put(home, "ada.py", spring("ada"), trusted=False)
    window = make_window()
    row = window.gallery.own_rows[path]
    assert not row.pencil.isVisible()
    assert [action.text() for action in row.menu().actions()] == ["Show in folder", "Delete…"]
    window.editor.edit(path)
    assert window.editor.editor.source.isVisible()


def test_deleting_asks_first_and_uses_the_bin(home, make_window, monkeypatch):
    path = put(home, "mine.py", spring("mine"))
    window = make_window()
    binned = []
    monkeypatch.setattr(
        "hapkit_studio.gui.editor.controller.QFile.moveToTrash", lambda name: binned.append(name) or True
    )
    window.file_actions.delete(path)
    sheet = window.findChild(DeleteDialog)
    assert sheet.isVisible()
    assert not sheet.isModal()
    assert binned == []
    sheet.keep.click()
    window.file_actions.delete(path)
    window.findChildren(DeleteDialog)[-1].delete.click()
    assert binned == [str(path)]


def test_own_environments_stand_in_the_menu_too(home, make_window):
    put(home, "mine.py", spring("mine"))
    window = make_window()
    menu = next(a.menu() for a in window.menuBar().actions() if a.text() == "Environment")
    menu.aboutToShow.emit()
    yours = next(a for a in menu.actions() if a.text() == "Yours")
    assert yours.isVisible()
    assert [action.text() for action in yours.menu().actions()] == ["Test spring"]


def test_the_last_row_begins_a_new_environment(idle_window):
    QTest.mouseClick(idle_window.gallery.new_row, Qt.MouseButton.LeftButton)
    assert idle_window.editor.editor.chooser.isVisible()
    assert idle_window.editor.editor.chooser.title.hasFocus()
    assert idle_window.studio.environment.key == "wall"
