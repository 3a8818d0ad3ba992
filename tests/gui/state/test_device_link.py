"""Devices from the window: slow, busy, gone, wrong; the window stays alive and says what is the matter."""

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
NO_RIGHT = f"You may not open ttyUSB0. Run `{COMMAND}`. Then log out and in again."
FAILURES = [
    (ZeroDivisionError("division by zero"), "The device failed:", []),
    (errors.PortBusyError("ttyUSB0 is used by minicom (process 41). Close it."), "ttyUSB0 is used by", []),
    (errors.NoFirmwareError("ttyUSB0 does not answer.", step="flash"), "ttyUSB0 does", ["Flash firmware"]),
    (errors.WrongProtocolError("Firmware speaks version 1.", step="update"), "Firm", ["Update firmware"]),
    (errors.PortPermissionError(NO_RIGHT, command=COMMAND), NO_RIGHT, ["Copy command"]),
]


def entry_that(make):
    return DeviceEntry("/dev/ttyUSB0", "ttyUSB0: Hapkit board (FT232)", make)


class Plugged:
    """A device that fails with ``error`` while there is one; ``tries``: how often it was looked for."""

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


def test_each_failure_says_its_line_and_the_next_step_and_leaves_no_force(window, qtbot, until):
    studio, flash = window.studio, []
    window.notices.flash.disconnect()
    window.notices.flash.connect(lambda: flash.append(1))
    for error, line, steps in FAILURES:
        before = studio.engine
        studio.device.open(entry_that(Plugged(error)))
        until(window, "failed")
        (banner,) = window.banners.banners
        assert f"{banner.title.text()} {banner.text.text()}".startswith(line)
        assert [b.text() for b in banner.buttons] == [*steps, "Try again", "Use simulated Hapkit"]
        assert "\n" not in studio.link.text
        assert studio.engine is None
        assert not before.health().running
        assert not window.header.devices.dot.filled
        for button in (*banner.buttons[: len(steps)], banner.buttons[-1]):
            QTest.mouseClick(button, Qt.MouseButton.LeftButton)
        qtbot.waitUntil(lambda: studio.engine is not None)
        assert window.banners.banners == []
    assert len(flash) == 2
    assert QGuiApplication.clipboard().text() == COMMAND


@pytest.mark.slow
def test_the_window_goes_on_while_a_port_takes_its_time(idle_window, qtbot):
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
    qtbot.waitUntil(lambda: window.studio.engine is not None)
    assert window.studio.engine.device.mass == 0.044
    assert [engine.device.mass for engine in engines] == [0.1, 0.044]
    qtbot.waitUntil(lambda: not engines[0].health().running)
    assert engines[1].health().running


@pytest.mark.slow
def test_a_port_that_was_never_there_or_comes_back_without_rights_is_tried_on(
    idle_window, qtbot, monkeypatch, until
):
    link = idle_window.studio.device
    link._again.setInterval(5)
    device = Plugged(errors.PortGoneError(GONE))
    link.open(entry_that(device))
    qtbot.waitUntil(lambda: device.tries >= 3)
    assert link.link.state == "failed"
    (banner,) = idle_window.banners.banners
    assert "Trying to reconnect" in banner.text.text()
    device.error = errors.PortPermissionError("You may not open ttyUSB0. Run it.", command="x")
    qtbot.waitUntil(lambda: link.link.command == "x")
    assert link._refusals >= device_link.TRIES
    device.error = errors.PortGoneError(GONE)
    qtbot.waitUntil(lambda: "is disconnected" in link.link.text)
    device.error = None
    until(idle_window, "running")
    assert idle_window.banners.banners == []
    assert not link._again.isActive()


@pytest.mark.slow
def test_a_starting_board_is_said_and_never_started_anew(idle_window, fake_board, qtbot, until):
    """A look again in the middle of the handshake would open the port and reset the board once more."""
    link, word, gate = idle_window.studio.device, idle_window.header.devices.word, threading.Event()
    link._again.setInterval(5)
    kit, opened, asked, said = FakeKit(), [], [], []

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
    link._waits.connect(lambda _request, words: said.append(words))
    missing.error = None
    qtbot.waitUntil(lambda: said == ["Starting board…"])
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
def test_letting_go_frees_the_port_and_reconnect_takes_it_back(window, qtbot):
    engine = window.studio.engine
    window.studio.device.release_port()
    qtbot.waitUntil(lambda: not engine.health().running)
    assert window.studio.engine is None
    assert window.header.devices.word.text() == "Not connected"
    assert window.banners.banners == []
    window.studio.device.reconnect()
    qtbot.waitUntil(lambda: window.studio.engine is not None)


@pytest.mark.slow
def test_history_survives_a_reconnection_and_another_device_with_a_gap(window, qtbot):
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
        assert [words for _, words in window.live.history.dividers] == named


def test_a_device_that_opens_as_the_window_closes_is_closed_with_it(qapp):
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
    qapp.processEvents()  # what the worker has said meanwhile finds nobody
    (engine,) = ready
    assert not engine.health().running
    assert not opened
