"""Devices that are slow, in use, unplugged or wrong: the window keeps running and names the problem."""

import threading

import numpy as np
import pytest
from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest

from hapkit_studio import errors
from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.gui.state import device_link
from hapkit_studio.gui.state.device_link import DeviceLink
from hapkit_studio.protocol.messages import HelloRequest
from tests.devices.fake_board import FakeKit
from tests.gui.window_support import PATIENCE_MS, SIMULATED, build_engine

GONE = "Hapkit on ttyUSB0 is disconnected. The force is zero. Trying to reconnect every second."
COMMAND = "sudo usermod -a -G dialout $USER"
NO_RIGHT = f"You have no permission to open ttyUSB0. Run `{COMMAND}`. Then log out and in again."
FAILURES = [
    (ZeroDivisionError("division by zero"), "The device failed:", []),
    (errors.PortBusyError("ttyUSB0 is used by minicom (process 41). Close it."), "ttyUSB0 is used by", []),
    (errors.NoFirmwareError("ttyUSB0 does not answer.", step="flash"), "ttyUSB0 does", ["Flash firmware"]),
    (
        errors.WrongProtocolError("The firmware has protocol version 1.", step="update"),
        "The firm",
        ["Update firmware"],
    ),
    (errors.PortPermissionError(NO_RIGHT, command=COMMAND), NO_RIGHT, ["Copy command"]),
]


def entry_that(make):
    return DeviceEntry("/dev/ttyUSB0", "ttyUSB0: Hapkit board (FT232)", make)


class Plugged:
    """A factory that raises ``error`` or, if ``error`` is None, returns a device.

    ``tries`` counts its calls.
    """

    def __init__(self, error=None):
        self.error, self.tries = error, 0

    def __call__(self):
        self.tries += 1
        if self.error is not None:
            raise self.error
        return SimulatedHapkit()


@pytest.fixture
def until(qtbot):
    """Return a function that waits until a window's link is in a state."""
    return lambda window, state: qtbot.waitUntil(lambda: window.studio.link.state == state)


def test_each_failure_shows_its_message_and_buttons_and_stops_the_engine(window, qtbot, until):
    studio, flash = window.studio, []
    window.notices.flash.disconnect()
    window.notices.flash.connect(lambda: flash.append(1))
    for error, line, steps in FAILURES:
        before = studio.engine
        studio.device.open(entry_that(Plugged(error)))
        until(window, "failed")
        (banner,) = window.banners.banners
        assert f"{banner.title.text()} {banner.text.text()}".startswith(line)
        assert [b.text() for b in banner.buttons] == [*steps, "Try again", "Use simulated Hapkit", "Help"]
        assert "\n" not in studio.link.text
        assert studio.engine is None
        assert not before.health().running
        assert not window.header.devices.dot.filled
        for button in (*banner.buttons[: len(steps)], banner.buttons[-2]):
            QTest.mouseClick(button, Qt.MouseButton.LeftButton)
        qtbot.waitUntil(lambda: studio.engine is not None)
        assert window.banners.banners == []
    assert len(flash) == 2
    assert QGuiApplication.clipboard().text() == COMMAND


@pytest.mark.slow
def test_the_window_keeps_running_while_a_port_opens_slowly(idle_window, qtbot):
    gate, beats, studio = threading.Event(), [], idle_window.studio

    def slowly():
        gate.wait(PATIENCE_MS / 1000)
        return SimulatedHapkit()

    studio.device.open(DeviceEntry("slow", "Slow Hapkit", slowly))
    assert idle_window.header.devices.word.text() == "Connecting…"
    timer = QTimer(idle_window, interval=1)
    timer.timeout.connect(lambda: beats.append(1))
    timer.start()
    qtbot.waitUntil(lambda: len(beats) >= 10)
    studio.set_value("stiffness", 444.0)
    studio.stop()
    gate.set()
    qtbot.waitUntil(lambda: studio.engine is not None)
    assert studio.engine.values["stiffness"] == 444.0
    assert studio.engine.stopped


@pytest.mark.slow
def test_only_the_device_selected_last_is_opened(make_window, qtbot):
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
    qtbot.waitUntil(lambda: window.studio.engine is not None)
    assert window.studio.engine.device.mass == 0.044
    assert [engine.device.mass for engine in engines] == [0.1, 0.044]
    qtbot.waitUntil(lambda: not engines[0].health().running)
    assert engines[1].health().running


@pytest.mark.slow
def test_a_missing_port_or_one_without_permission_is_retried(idle_window, qtbot, monkeypatch, until):
    link = idle_window.studio.device
    link._again.setInterval(5)
    device = Plugged(errors.PortGoneError(GONE))
    link.open(entry_that(device))
    qtbot.waitUntil(lambda: device.tries >= 3)
    assert link.link.state == "failed"
    (banner,) = idle_window.banners.banners
    assert "Trying to reconnect" in banner.text.text()
    device.error = errors.PortPermissionError("You have no permission to open ttyUSB0. Run it.", command="x")
    qtbot.waitUntil(lambda: link.link.command == "x")
    assert link._refusals >= device_link.TRIES
    device.error = errors.PortGoneError(GONE)
    qtbot.waitUntil(lambda: "is disconnected" in link.link.text)
    device.error = None
    until(idle_window, "running")
    assert idle_window.banners.banners == []
    assert not link._again.isActive()


@pytest.mark.slow
def test_a_starting_board_is_shown_and_opened_only_once(idle_window, fake_board, qtbot, until):
    """Another attempt during the handshake would open the port again and reset the board."""
    link, word, gate = idle_window.studio.device, idle_window.header.devices.word, threading.Event()
    link._again.setInterval(5)
    kit, opened, asked, texts = FakeKit(), [], [], []

    def slow(message):
        if isinstance(message, HelloRequest):
            asked.append(message)
            return kit(message) if len(asked) > 3 else gate.wait(PATIENCE_MS / 1000) and None
        return kit(message)

    board, missing = fake_board(slow), Plugged(errors.PortGoneError(GONE))

    def make():
        if missing.error is not None:
            missing()
        opened.append(1)
        return HapkitBoard(board.path)

    link.open(entry_that(make))
    until(idle_window, "failed")
    link._waits.connect(lambda _request, text: texts.append(text))
    missing.error = None
    qtbot.waitUntil(lambda: texts == ["Starting board…"])
    gate.set()
    until(idle_window, "running")
    assert opened == [1]
    assert word.text() == f"Hapkit on {board.path.removeprefix('/dev/')}"
    gate.clear()
    asked.clear()
    link.reconnect()
    qtbot.waitUntil(lambda: word.text() == "Starting board…")
    gate.set()


@pytest.mark.slow
def test_a_released_port_is_free_and_reconnect_opens_it_again(window, qtbot):
    engine = window.studio.engine
    window.studio.device.release_port()
    qtbot.waitUntil(lambda: not engine.health().running)
    assert window.studio.engine is None
    assert window.header.devices.word.text() == "Not connected"
    assert window.banners.banners == []
    window.studio.device.reconnect()
    qtbot.waitUntil(lambda: window.studio.engine is not None)


@pytest.mark.slow
def test_history_is_kept_with_a_gap_on_reconnection_and_change_of_device(window, qtbot):
    def kept(least):
        qtbot.waitUntil(lambda: window.live.tick() or len(window.live.history) >= least)
        return window.live.history.start

    other = DeviceEntry("other", "Another Hapkit", SimulatedHapkit)
    for entry, named in ((SIMULATED, []), (other, ["Another Hapkit"])):
        start = kept(100)
        with qtbot.waitSignal(window.studio.engine_changed):
            window.studio.device.open(entry)
        qtbot.waitUntil(lambda: window.studio.engine is not None)
        assert kept(len(window.live.history) + 100) == start
        assert np.isnan(window.live.history.between(-np.inf, np.inf).x).any()
        assert [text for _, text in window.live.history.dividers] == named


@pytest.mark.parametrize("fails", [False, True])
def test_a_port_that_is_released_while_it_opens_stays_released(qtbot, fails):
    begun, gate, ready, opened = threading.Event(), threading.Event(), [], []

    def build(entry):
        begun.set()
        gate.wait(PATIENCE_MS / 1000.0)
        if fails:
            raise errors.PortBusyError("ttyUSB0 is used by minicom.")
        return build_engine(entry)

    link = DeviceLink(lambda: [SIMULATED], build, ready.append, opened.append)
    link.open(SIMULATED)
    assert begun.wait(PATIENCE_MS / 1000.0)
    link.release_port()
    with qtbot.waitSignal(link._finished):
        gate.set()
    assert link.link.state == "idle"
    assert link.engine is None
    link.close()
    assert not any(engine.health().running for engine in ready)
    assert not opened


def test_a_device_that_opens_while_the_window_closes_is_closed(qapp):
    begun, gate, ready, opened = threading.Event(), threading.Event(), [], []

    def build(entry):
        begun.set()
        gate.wait(PATIENCE_MS / 1000.0)
        return build_engine(entry)

    link = DeviceLink(lambda: [SIMULATED], build, ready.append, opened.append)
    link.open(SIMULATED)
    assert begun.wait(PATIENCE_MS / 1000.0)
    gate.set()
    link.close()
    qapp.processEvents()  # the worker's signals have no receiver any more
    (engine,) = ready
    assert not engine.health().running
    assert not opened
