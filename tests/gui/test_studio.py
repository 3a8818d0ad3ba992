"""Devices from the window: slow, busy, gone, wrong; the window stays alive and says what is the matter."""

import dataclasses
import threading

import pytest
from PySide6.QtCore import Qt, QTimer
from PySide6.QtTest import QTest

from hapkit_studio import errors
from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.gui import device_link
from hapkit_studio.gui.device_link import Connector
from hapkit_studio.haptics.engine import Engine
from tests.gui.window_support import PATIENCE_MS, SIMULATED, build_engine

FAILURES = [
    (errors.PortBusyError("ttyUSB0 is used by another program. Close it."), "ttyUSB0 is used by another"),
    (ZeroDivisionError("division by zero"), "The device failed:"),
]


def failing(error: Exception) -> DeviceEntry:
    def make():
        raise error

    return DeviceEntry("/dev/ttyUSB0", "Hapkit on ttyUSB0", make)


@pytest.mark.parametrize(("error", "line"), FAILURES)
def test_each_failure_says_its_own_line_and_leaves_no_force(make_window, qtbot, error, line):
    window = make_window((SIMULATED, failing(error)))
    window.studio.device.open(SIMULATED)
    qtbot.waitUntil(lambda: window.studio.engine is not None, timeout=PATIENCE_MS)
    before = window.studio.engine
    window.studio.device.open(failing(error))
    qtbot.waitUntil(lambda: window.studio.link.state == "failed", timeout=PATIENCE_MS)
    (banner,) = window.banners.banners
    assert f"{banner.title.text()} {banner.text.text()}".startswith(line)
    assert "\n" not in window.studio.link.text
    assert window.studio.engine is None
    assert not before.health().running
    assert window.header.devices.dot.filled is False
    QTest.mouseClick(banner.buttons[-1], Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: window.studio.engine is not None, timeout=PATIENCE_MS)
    assert window.banners.banners == []


def test_the_window_goes_on_while_a_port_takes_its_time(make_window, qtbot):
    gate, beats = threading.Event(), []

    def slowly():
        gate.wait(PATIENCE_MS / 1000)
        return SimulatedHapkit()

    window = make_window()
    window.studio.device.open(DeviceEntry("slow", "Slow Hapkit", slowly))
    assert window.header.devices.word.text() == "Connecting…"
    timer = QTimer(window, interval=1)
    timer.timeout.connect(lambda: beats.append(1))
    timer.start()
    qtbot.waitUntil(lambda: len(beats) >= 10, timeout=PATIENCE_MS)
    window.studio.set_value("stiffness", 444.0)
    gate.set()
    qtbot.waitUntil(lambda: window.studio.engine is not None, timeout=PATIENCE_MS)
    assert window.studio.engine.values["stiffness"] == 444.0


def test_of_two_wishes_the_newest_wins(make_window, qtbot):
    gate, begun, engines = threading.Event(), threading.Event(), []

    def build(entry):
        engines.append(build_engine(entry))
        return engines[-1]

    def slowly():
        begun.set()
        gate.wait(PATIENCE_MS / 1000)
        return SimulatedHapkit(mass=0.1)

    window = make_window(build=build)
    window.studio.device.open(DeviceEntry("slow", "Slow Hapkit", slowly))
    assert begun.wait(PATIENCE_MS / 1000)
    window.studio.device.open(SIMULATED)
    gate.set()
    qtbot.waitUntil(lambda: window.studio.engine is not None, timeout=PATIENCE_MS)
    assert window.studio.engine.device.mass == 0.044
    assert [engine.device.mass for engine in engines] == [0.1, 0.044]
    qtbot.waitUntil(lambda: not engines[0].health().running, timeout=PATIENCE_MS)
    assert engines[1].health().running


def test_a_device_that_went_away_is_looked_for_until_it_is_back(make_window, qtbot, monkeypatch):
    monkeypatch.setattr(device_link, "LOOK_AGAIN_MS", 10)
    plugged, tries = threading.Event(), []
    plugged.set()

    class Pluggable(Engine):
        def health(self):
            alive = plugged.is_set()
            text = "" if alive else "Hapkit on ttyUSB0 is gone. Force is zero. Looking again every second."
            return dataclasses.replace(super().health(), running=alive, message=text)

    def make():
        tries.append(1)
        if not plugged.is_set():
            raise errors.PortGoneError("ttyUSB0 is gone.")
        return SimulatedHapkit()

    entry = DeviceEntry("/dev/ttyUSB0", "Hapkit on ttyUSB0", make)
    window = make_window((SIMULATED, entry), build=lambda e: Pluggable(e.make(), realtime=False))
    window.studio.device.open(entry)
    qtbot.waitUntil(lambda: window.studio.engine is not None, timeout=PATIENCE_MS)
    plugged.clear()
    window.live.look()
    (banner,) = window.banners.banners
    assert banner.title.text() == "Hapkit on ttyUSB0 is gone."
    assert banner.text.text() == "Force is zero. Looking again every second."
    qtbot.waitUntil(lambda: len(tries) >= 3, timeout=PATIENCE_MS)
    assert window.studio.link.state == "gone"
    plugged.set()
    qtbot.waitUntil(lambda: window.studio.link.state == "running", timeout=PATIENCE_MS)
    assert window.banners.banners == []


def test_a_port_that_never_was_there_is_looked_for_as_its_banner_says(make_window, qtbot, monkeypatch):
    monkeypatch.setattr(device_link, "LOOK_AGAIN_MS", 10)
    plugged, tries = threading.Event(), []

    def make():
        tries.append(1)
        if not plugged.is_set():
            raise errors.PortGoneError(
                "Hapkit on ttyUSB0 is gone. Force is zero. Looking again every second."
            )
        return SimulatedHapkit()

    window = make_window()
    window.studio.device.open(DeviceEntry("/dev/ttyUSB0", "Hapkit on ttyUSB0", make))
    qtbot.waitUntil(lambda: len(tries) >= 3, timeout=PATIENCE_MS)
    assert window.studio.link.state == "failed"
    (banner,) = window.banners.banners
    assert "Looking again" in banner.text.text()
    plugged.set()
    qtbot.waitUntil(lambda: window.studio.link.state == "running", timeout=PATIENCE_MS)
    assert window.banners.banners == []
    assert not window.studio.device._again.isActive()


def test_the_bar_grows_while_the_loop_is_prepared_and_is_gone_afterwards(idle_window, qtbot):
    scene = idle_window.centre.scene
    first = scene._fraction
    qtbot.waitUntil(lambda: first < scene._fraction < 1.0, timeout=PATIENCE_MS)
    idle_window.studio.device.open(SIMULATED)
    qtbot.waitUntil(lambda: idle_window.studio.engine is not None, timeout=PATIENCE_MS)
    assert scene._fraction is None
    assert not idle_window.display._bar.isActive()


def test_a_fault_shows_its_reason_and_is_cleared_by_hand(window, qtbot):
    from hapkit_studio.haptics import arrays

    window.studio.engine.arrays.control[arrays.FAULT] = arrays.OVER_SPEED
    window.studio.engine.arrays.real[arrays.FAULT_VALUE] = 3.4
    window.live.look()
    (banner,) = window.banners.banners
    assert banner.title.text().startswith("Fault: over-speed, 3.4 m/s (limit ")
    assert banner.text.text() == "Force is zero. Hold the handle, then clear."
    QTest.mouseClick(banner.buttons[0], Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: window.studio.fault is None, timeout=PATIENCE_MS)
    window.live.look()
    assert window.banners.banners == []


def test_at_most_two_banners_the_worse_first(window):
    from hapkit_studio.gui.banners import Notice

    window.banners.set("limit", Notice("limit", 3, "danger", "cross", "Third", "…"))
    window.banners.set("device", Notice("device", 2, "warn", "unplugged", "Second", "…"))
    window.studio.stop()
    shown = [banner.title.text() for banner in window.banners.banners]
    assert shown == ["Stopped. Force is zero.", "Second"]
    window.studio.release_stop()
    assert [banner.title.text() for banner in window.banners.banners] == ["Second", "Third"]


def test_values_that_do_not_go_together_are_refused_with_and_without_an_engine(idle_window, window, qtbot):
    """A button's snap starts within its travel; a reset from there changes both at once."""
    for shown in (idle_window, window):
        studio = shown.studio
        studio.choose("button")
        studio.set_value("snap_start", 0.002)
        studio.set_value("travel", 0.003)
        with pytest.raises(errors.ParameterError, match="ravel"):
            studio.set_value("snap_start", 0.0035)
        assert studio.values["snap_start"] == 0.002
        studio.reset_values()
        assert studio.values == studio.environment.values()
    assert window.studio.engine.values == studio.values


def test_a_device_that_opens_as_the_window_closes_is_closed_with_it(qapp):
    begun, gate, ready, opened = threading.Event(), threading.Event(), [], []

    def build(entry):
        begun.set()
        gate.wait(PATIENCE_MS / 1000.0)
        return build_engine(entry)

    connector = Connector(build)
    connector.opened.connect(opened.append)
    connector.open(SIMULATED, None, ready.append)
    assert begun.wait(PATIENCE_MS / 1000.0)
    gate.set()
    connector.close(None)
    qapp.processEvents()  # what the worker has said meanwhile finds nobody
    (engine,) = ready
    assert not engine.health().running
    assert not opened
