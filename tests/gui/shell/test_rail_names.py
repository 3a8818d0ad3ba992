"""The names beside the narrow gallery are visible at the first start until an environment is selected."""

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QFontMetricsF
from PySide6.QtTest import QTest

from hapkit_studio.gui.widgets.theme import theme
from tests.gui.shell.test_layout import place, resize


@pytest.fixture
def window(make_window, qapp):
    shown = make_window(size=(1280, 720))
    resize(qapp, shown, (1280, 720))
    return shown


@pytest.mark.slow
def test_the_names_are_fully_visible_beside_their_icons_only_in_live(window, qapp):
    names, gallery = window.rail_names, window.gallery
    for size in ((1280, 720), (960, 600), (640, 360)):
        resize(qapp, window, size)
        assert names.isVisible()
        assert place(names, window).left() == place(gallery, window).right() + 1
        assert window.rect().contains(place(names, window))
        metrics = QFontMetricsF(theme.font("strong"))
        assert max(metrics.horizontalAdvance(row.title) for row in gallery.rows.values()) < names.width() - 8
    window.views.show("sessions")
    assert names.isHidden()
    window.views.show("live")
    assert names.isVisible()
    window.views.cover(window.panel)
    assert names.isHidden(), "a quiz or an experiment covers the view"
    window.views.cover(None)
    assert names.isVisible()
    resize(qapp, window, (1440, 900))
    assert names.isHidden(), "the gallery has the names itself"


@pytest.mark.slow
@pytest.mark.parametrize("by_mouse", [True, False])
def test_the_names_disappear_permanently_once_an_environment_is_selected(window, make_window, by_mouse):
    names = window.rail_names
    if by_mouse:
        row = place(window.gallery.rows["spring"], window).center().y() - place(names, window).y()
        QTest.mouseClick(names, Qt.MouseButton.LeftButton, pos=QPoint(names.width() // 2, row))
    else:
        QTest.keyClick(window, Qt.Key.Key_1)
    assert window.studio.environment.key == "spring"
    assert names.isHidden()
    assert make_window(size=(1280, 720)).rail_names.isHidden()
