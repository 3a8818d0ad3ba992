"""E-stop: it works from everywhere and immediately, and is released only deliberately."""

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QMessageBox

from hapkit_studio.haptics import rows


def press_esc():
    """Press Esc as the window system does: in the widget with the keyboard focus."""
    target = QApplication.activePopupWidget() or QApplication.focusWidget() or QApplication.activeWindow()
    QTest.keyClick(target, Qt.Key.Key_Escape)


def in_front(window):
    """Return the window, dialog or menu in front, which has the keyboard focus."""
    front = QApplication.activePopupWidget() or QApplication.activeWindow()
    return front if front is not window and front is not None and front.isVisible() else None


def open_menu(window):
    window.menuBar().actions()[0].menu().popup(window.pos() + QPoint(20, 30))


PLACES = {
    "number": lambda window: window.panel.parameters.rows["stiffness"].box.setFocus(),
    "list": lambda window: window.centre.toolbar.span.setFocus(),
    "gallery": lambda window: window.gallery.rows["spring"].setFocus(),
}
FRONTS = {
    "open list": lambda window: window.centre.toolbar.span.showPopup(),
    "open menu": open_menu,
    "device menu": lambda window: QTest.mouseClick(window.header.devices, Qt.MouseButton.LeftButton),
    "message box": lambda window: QMessageBox(window, text="Words").open(),
    "file": lambda window: window.presets.bring(),
    "sheet of keys": lambda window: window.show_keys(),
    "commands": lambda window: window.show_commands(),
    "marker": lambda window: window.show_marker(),
    "priority": lambda window: window.show_priority(),
    "about": lambda window: window.show_about(),
    "flash": lambda window: window.show_flash(),
    "export": lambda window: window.show_export(),
    "preset": lambda window: window.presets.ask_to_save(),
}


@pytest.fixture
def window(reset_window):
    """Return this test file's window with a running simulated device."""
    return reset_window


@pytest.mark.parametrize("device", ["window", "board_window"])
def test_esc_stops_from_everywhere_and_without_a_motor_closes_the_dialog_first(request, qtbot, device):
    window = request.getfixturevalue(device)
    engine = window.studio.engine
    for place, go in {**PLACES, **FRONTS}.items():
        go(window)
        if place in FRONTS:
            qtbot.waitUntil(lambda: in_front(window) is not None)
        press_esc()
        QApplication.processEvents()
        assert engine.stopped == (place in PLACES or device == "board_window"), place
        assert in_front(window) is None, place
        window.activateWindow()
        qtbot.waitUntil(window.isActiveWindow)
        window.studio.release_stop()
        assert not engine.stopped


def test_esc_stops_behind_a_dialog_that_stays_open(window, qtbot, monkeypatch):
    """For example, the flash dialog stays open while it writes."""
    dialog = QDialog(window)
    monkeypatch.setattr(dialog, "reject", lambda: None)
    dialog.show()
    dialog.activateWindow()
    qtbot.waitUntil(dialog.isActiveWindow)
    press_esc()
    qtbot.waitUntil(lambda: window.studio.engine.stopped)
    dialog.deleteLater()


def test_the_force_is_zero_in_all_rows_after_the_stop(window, qtbot):
    engine = window.studio.engine
    reader, taken = engine.reader(), []
    engine.move_hand(0.020)

    def last():
        taken.append(reader.read())
        return taken[-1][-1] if len(taken[-1]) else np.zeros(taken[-1].shape[1])

    qtbot.waitUntil(lambda: abs(last()[rows.APPLIED_FORCE]) > 0.5)
    QTest.keyClick(window, Qt.Key.Key_Escape)
    written = int(np.concatenate([*taken, reader.read()])[-1, rows.TICK])
    taken.clear()
    qtbot.waitUntil(lambda: last()[rows.TICK] > written + 200)
    after = np.concatenate(taken)
    after = after[after[:, rows.TICK] > written + 1]
    assert len(after) > 100
    assert np.all(after[:, rows.APPLIED_FORCE] == 0.0)
    assert np.all(after[:, rows.FLAGS].astype(int) & rows.STOPPED)


def test_the_stop_button_acts_on_press_and_only_the_banner_releases_it(window, qtbot):
    header, button = window.header, window.header.stop
    before = button.geometry(), header.pause.geometry()
    assert window.banners.banners == []
    QTest.mousePress(button, Qt.MouseButton.LeftButton)
    assert window.studio.engine.stopped
    QTest.mouseRelease(button, Qt.MouseButton.LeftButton)
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    QTest.keyClick(window, Qt.Key.Key_Escape)
    qtbot.wait(20)
    assert window.studio.engine.stopped
    assert (button.geometry(), header.pause.geometry()) == before
    (banner,) = window.banners.banners
    assert (banner.title.text(), banner.height()) == ("Stopped. Force is zero.", 54)
    (release,) = banner.buttons
    assert release.text() == "Release E-stop"
    QTest.mouseClick(release, Qt.MouseButton.LeftButton)
    assert not window.studio.engine.stopped
    assert button.word.text() == "E-STOP"
    assert window.banners.banners == []


def test_releasing_the_stop_does_not_move_the_focus(window):
    window.centre.scene.setFocus()
    window.studio.stop()
    QTest.mouseClick(window.banners.banners[0].buttons[0], Qt.MouseButton.LeftButton)
    QApplication.processEvents()
    assert QApplication.focusWidget() is window.centre.scene
