"""E-stop: from anywhere, at once, released on purpose only."""

import threading

import numpy as np
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QLineEdit, QMessageBox

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics import rows
from tests.gui.window_support import PATIENCE_MS


def press_esc():
    """Press Esc as the window system would: at whatever has the keyboard."""
    target = QApplication.activePopupWidget() or QApplication.focusWidget() or QApplication.activeWindow()
    QTest.keyClick(target, Qt.Key.Key_Escape)


def in_a_number(window):
    window.panel.parameters.rows["stiffness"].box.setFocus()


def in_a_list(window):
    window.centre.toolbar.span.setFocus()


def in_an_open_list(window):
    window.centre.toolbar.span.showPopup()


def in_the_gallery(window):
    window.gallery.rows["spring"].setFocus()


def in_an_open_menu(window):
    menu = window.menuBar().actions()[0].menu()
    menu.popup(window.mapToGlobal(QPoint(20, 30)))


def in_the_device_menu(window):
    QTest.mouseClick(window.header.devices, Qt.MouseButton.LeftButton)


def in_a_modal_dialog(window):
    dialog = QDialog(window)
    dialog.setModal(True)
    field = QLineEdit(dialog)
    dialog.show()
    dialog.activateWindow()
    field.setFocus()


def in_a_message_box(window):
    box = QMessageBox(window)
    box.setText("Words")
    box.open()


def in_the_sheet_of_keys(window):
    window.show_keys()


PLACES = [
    in_a_number, in_a_list, in_an_open_list, in_the_gallery, in_an_open_menu, in_the_device_menu,
    in_a_modal_dialog, in_a_message_box, in_the_sheet_of_keys,
]  # fmt: skip


def test_esc_stops_wherever_the_focus_is(window):
    for place in PLACES:
        place(window)
        QApplication.processEvents()
        press_esc()
        assert window.studio.engine.stopped, place.__name__
        assert window.header.stop.word.text() == "STOPPED"
        for over in (QApplication.activePopupWidget(), QApplication.activeModalWidget()):
            if over is not None:
                over.close()
        window.activateWindow()
        window.studio.release_stop()
        assert not window.studio.engine.stopped


def test_the_force_is_zero_in_every_row_after_the_stop(window, qtbot):
    engine = window.studio.engine
    reader = engine.reader()
    engine.move_hand(0.020)
    taken = []

    def pushed():
        taken.append(reader.read())
        return len(taken[-1]) > 0 and abs(taken[-1][-1, rows.APPLIED]) > 0.5

    qtbot.waitUntil(pushed, timeout=PATIENCE_MS)
    QTest.keyClick(window, Qt.Key.Key_Escape)
    written = int(reader.read()[-1, rows.TICK]) if len(taken) else 0
    qtbot.waitUntil(lambda: _ticks(reader, taken) > written + 200, timeout=PATIENCE_MS)
    after = np.concatenate(taken)
    after = after[after[:, rows.TICK] > written + 1]
    assert len(after) > 100
    assert np.all(after[:, rows.APPLIED] == 0.0)
    assert np.all(after[:, rows.FLAGS].astype(int) & rows.STOPPED)


def _ticks(reader, taken) -> int:
    new = reader.read()
    if len(new):
        taken.append(new)
    return int(taken[-1][-1, rows.TICK])


def test_the_red_button_stops_on_the_press_and_never_releases(window):
    button = window.header.stop
    QTest.mousePress(button, Qt.MouseButton.LeftButton)
    assert window.studio.engine.stopped
    QTest.mouseRelease(button, Qt.MouseButton.LeftButton)
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    QTest.keyClick(window, Qt.Key.Key_Escape)
    assert window.studio.engine.stopped


def test_nothing_in_the_header_moves_when_it_stops(window, qtbot):
    header = window.header
    before = header.stop.geometry(), header.pause.geometry()
    window.studio.stop()
    qtbot.wait(20)
    assert (header.stop.geometry(), header.pause.geometry()) == before


def test_only_the_banner_releases(window):
    assert window.banners.banners == []
    QTest.keyClick(window, Qt.Key.Key_Escape)
    (banner,) = window.banners.banners
    assert (banner.title.text(), banner.height()) == ("Stopped. Force is zero.", 54)
    (button,) = banner.buttons
    assert button.text() == "Release E-stop"
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    assert not window.studio.engine.stopped
    assert window.header.stop.word.text() == "E-STOP"
    assert window.banners.banners == []


def test_a_stop_while_connecting_holds_for_the_device_that_comes(make_window, qtbot):
    gate = threading.Event()

    def slowly():
        gate.wait(PATIENCE_MS / 1000)
        return SimulatedHapkit()

    window = make_window()
    window.studio.device.open(DeviceEntry("slow", "Slow Hapkit", slowly))
    press_esc()
    assert window.studio.stopped
    gate.set()
    qtbot.waitUntil(lambda: window.studio.engine is not None, timeout=PATIENCE_MS)
    assert window.studio.engine.stopped


def test_releasing_leaves_the_focus_where_it_was(window):
    window.centre.scene.setFocus()
    window.studio.stop()
    QTest.mouseClick(window.banners.banners[0].buttons[0], Qt.MouseButton.LeftButton)
    QApplication.processEvents()
    assert QApplication.focusWidget() is window.centre.scene
