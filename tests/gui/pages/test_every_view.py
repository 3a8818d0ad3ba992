"""Every view: its tab, its menu entry with a shortcut, and its name in a lesson."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.gui import pages
from hapkit_studio.gui.shell import texts
from hapkit_studio.lessons.parse import views

VIEWS = pages.discover()
PLACES = range(2, 9)  # digits of the views' shortcuts; Ctrl+1 shows Live, and Ctrl+9 shows the law


@pytest.mark.slow
@pytest.mark.parametrize("key", VIEWS)
def test_every_view_has_a_tab_a_menu_entry_and_a_key_if_one_is_free(reset_idle_window, key):
    window, view, place = reset_idle_window, VIEWS[key], 2 + list(VIEWS).index(key)
    action, tabs = window.actions_by_key.qt[f"view.tab.{key}"], window.header.tabs
    assert tabs.tabText(place - 1) == action.text() == view.title
    assert action.shortcut().toString() == (f"Ctrl+{place}" if place in PLACES else "")
    shows = [action.trigger, lambda: tabs.setCurrentIndex(place - 1)]
    if place in PLACES:
        number = Qt.Key(Qt.Key.Key_0 + place)
        shows.append(lambda: QTest.keyClick(window, number, Qt.KeyboardModifier.ControlModifier))
    for show in shows:
        window.views.show("live")
        show()
        assert (window.views.key, tabs.currentIndex()) == (key, place - 1)
        assert window.views.shown.isVisible()
        assert action.isChecked()
    shown = texts.of_widgets(window.views.shown, "")
    assert f"{view.title} view" in {text.place.partition(":")[0] for text in shown}


def test_a_lesson_may_name_every_view():
    assert views() == ("live", *sorted(VIEWS))
