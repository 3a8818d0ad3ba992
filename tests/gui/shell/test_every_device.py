"""Every device with a simulated handle in the window: move, record, show the verdict and all pages."""

import pytest
from PySide6.QtWidgets import QMenu

from hapkit_studio import api
from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.base import SIMULATED as SIMULATED_DRIVER
from hapkit_studio.devices.base import Device
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.gui import pages
from hapkit_studio.gui.panel.limits import JUDGING
from hapkit_studio.gui.shell import app
from hapkit_studio.gui.shell.header import fill_menu
from hapkit_studio.haptics import rows
from tests.devices.test_every_device import MODELLED, every_device
from tests.gui.state.test_recording import begin, end
from tests.gui.window_support import SIMULATED


@pytest.fixture
def shown(entry, make_window, qtbot):
    """Return a window whose device was selected with ``--device``."""
    window = make_window(tuple(MODELLED))
    app._open_device(window, entry.key)
    qtbot.waitUntil(lambda: window.studio.engine is not None)
    return window


@pytest.mark.slow
@every_device
def test_the_window_renders_records_judges_and_shows_all_pages(entry, shown, qtbot):
    studio, device = shown.studio, entry.make()
    menu = QMenu()
    fill_menu(menu, studio)
    assert [action.text() for action in menu.actions() if action.isChecked()] == [entry.title]
    assert studio.hand_is_ours
    assert studio.engine.loop.rate == (device.rate or studio.loop.rate)
    assert shown.loop.rate.isEnabled() or device.own_clock
    path = begin(shown, qtbot)
    studio.move_hand(0.01)

    def pressed():
        shown.live.tick()
        return shown.live.last is not None and shown.live.last[rows.APPLIED_FORCE] < -0.1

    qtbot.waitUntil(pressed)
    end(shown, qtbot)
    assert api.open_session(path).settings["device"]["title"] == device.title
    card = shown.stability
    qtbot.waitUntil(
        lambda: bool(card.verdict.text) and bool(card.label.text()) and card.verdict.text != JUDGING
    )
    for key in pages.discover():
        shown.views.show(key)
        assert shown.views.key == key
    assert studio.fault is None


@pytest.mark.slow
@every_device
def test_changing_to_the_device_keeps_all_settings_that_it_supports(entry, make_window, qtbot):
    window = make_window((SIMULATED, *(one for one in MODELLED if one.key != SIMULATED.key)))
    studio = window.studio
    studio.device.open(SIMULATED)
    qtbot.waitUntil(lambda: studio.engine is not None)
    studio.set_value("stiffness", 321.0)
    studio.set_loop(rate=1500.0, delay=1e-3)
    app_entry = next(one for one in studio.device.entries() if one.key == entry.key)
    studio.device.open(app_entry)
    qtbot.waitUntil(lambda: studio.engine is not None and studio.entry.key == entry.key)
    assert studio.engine.values["stiffness"] == 321.0
    assert (studio.engine.loop.rate, studio.engine.loop.delay) == (entry.make().rate or 1500.0, 1e-3)


class Undeclared(Device):
    """A device that does not declare its capabilities."""

    title, driver = "Undeclared", SIMULATED_DRIVER
    model = SimulatedHapkit()
    mass, viscous, coulomb_force, quantum, max_force = 0.044, 0.5, 0.1, 2e-5, 3.0


def test_a_device_without_declared_capabilities_waits_for_render_like_a_motor(make_window, qtbot):
    entry = DeviceEntry("undeclared", "Undeclared", Undeclared)
    studio = make_window((entry,)).studio
    studio.stop_state.wait_for_render()
    studio.device.open(entry)
    qtbot.waitUntil(lambda: studio.engine is not None)
    assert studio.waits_for_render
    assert studio.engine.stopped
    assert not studio.hand_is_ours
    assert studio.engine.health().delay is None
    studio.release_stop()
    assert not studio.engine.stopped
