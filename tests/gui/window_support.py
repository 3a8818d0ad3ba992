"""Support for tests of the window: the simulated device, and an engine at normal priority."""

from PySide6.QtCore import QCoreApplication, QEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDialog, QLabel

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import FIELDS, USUAL_LOOP
from hapkit_studio.gui.widgets.dialogs import TextDialog
from hapkit_studio.haptics.engine import Engine
from tests.lateness import clear_lateness

PATIENCE_MS = 180_000
"""Longest wait of a test: compiling the first loop takes a busy machine more than a minute."""
SIMULATED = DeviceEntry("simulated", "Simulated Hapkit", SimulatedHapkit)


def usual_loop():
    """Return the loop's default settings by name."""
    return {name: getattr(USUAL_LOOP, name) for name in FIELDS}


def build_engine(entry: DeviceEntry) -> Engine:
    """Make an engine at normal priority."""
    return Engine(entry.make(), realtime=False)


def delete_deferred() -> None:
    """Delete widgets whose deletion is deferred; without an event loop, Qt would keep and restyle them."""
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


def sheets(window) -> list[TextDialog]:
    """Return the visible dialogs."""
    return [sheet for sheet in window.findChildren(TextDialog) if sheet.isVisible()]


def sheet_of(window, kind=TextDialog):
    """Return the only visible dialog of a class."""
    (sheet,) = [sheet for sheet in sheets(window) if isinstance(sheet, kind)]
    return sheet


def label_texts(part) -> list[str]:
    """Return the texts of all labels in a widget."""
    return [label.text() for label in part.findChildren(QLabel)]


def put_back(window) -> None:
    """Restore a window's initial state for the next test."""
    studio = window.studio
    clear_lateness(studio)
    window.views.show("live")
    for dialog in window.findChildren(QDialog):
        dialog.close()
    for banner in list(window.banners.banners):
        window.banners.set(banner.notice.key, None)
    window.display.go_live()
    window.centre.view.set_locked(False)
    if not window.single_keys:
        window.toggle_single_keys()
    if studio.stopped:
        studio.release_stop()
    for key, environment in studio.environments.items():
        studio.library.values[key].update(environment.values())
    studio.choose("wall")
    studio.reset_values()
    if studio.loop != USUAL_LOOP:
        studio.set_loop(**usual_loop())
    studio.set_loop(hand="medium")
    studio.move_hand(None)
    window.loop.set_folded(True)
    window.loop.set_more(False)
    window.status.show_figures(False)
    window.panel.title.help.setChecked(False)
    window.body.open_drawer(None)
    window.resize(1440, 900)
    QCoreApplication.processEvents()
    window.activateWindow()
    assert QTest.qWaitForWindowActive(window, PATIENCE_MS)
