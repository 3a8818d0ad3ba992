"""Every view: its tab, its menu entry with a shortcut, and its name in a lesson."""

import math
from contextlib import suppress

import pytest
from PySide6.QtCore import QCoreApplication, Qt
from PySide6.QtTest import QTest

from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.dynamics.hand import GRIPS, RUBBER_BAND, grip_named
from hapkit_studio.errors import StudioError
from hapkit_studio.gui import pages
from hapkit_studio.gui.pages.identify import newest_samples
from hapkit_studio.gui.pages.stability.page import HANDS
from hapkit_studio.gui.shell import texts
from hapkit_studio.lessons.parse import views
from tests.gui.pages.stability_support import follow
from tests.lateness import clear_lateness

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


@pytest.mark.slow
def test_every_view_works_with_a_rubber_band(window, qtbot):
    """The limits of the stability view are those of people's hands; the verdict is that of the band."""
    studio, band = window.studio, grip_named(RUBBER_BAND)
    window.live.start()
    studio.choose("spring")
    studio.set_loop(hand=RUBBER_BAND)
    window.views.show("stability")
    page = window.views.page("stability")
    plane = follow(page, qtbot)
    assert list(plane.hands) == list(GRIPS)
    judged, loop = plane.verdict, plane.setting
    assert set(judged.does) == {RUBBER_BAND, "released"}
    held = stiffness_limit(loop.mass, loop.viscous, rate=loop.rate, delay=loop.delay, hand=band)
    assert judged.margins[RUBBER_BAND].limit == pytest.approx(held)
    for index in range(len(HANDS)):
        page.hands.button(index).click()
        follow(page, qtbot)
    window.views.show("zwidth")
    walls = window.views.page("zwidth")
    qtbot.waitUntil(lambda: walls.result is not None)
    assert walls.result.hand == RUBBER_BAND
    studio.move_hand(0.01)

    def held():
        clear_lateness(studio)
        with suppress(StudioError):  # until there are enough samples
            return newest_samples(studio, window.live, math.inf)().setup.grip == band
        return False

    qtbot.waitUntil(held)
    for key in VIEWS:
        window.views.show(key)
        window.live.tick()
        QCoreApplication.processEvents()
        assert window.views.key == key
