"""The link in the window: each failure with its next step, a board that takes its time, a mute one."""

import threading

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest

from hapkit_studio import errors
from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.gui import device_link, notices
from hapkit_studio.gui.banners import Notice
from hapkit_studio.gui.live.time_plots import gaps
from hapkit_studio.haptics.rows import HOST_TIME
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import HelloRequest
from tests.devices.fake_board import FakeBoard, FakeKit
from tests.gui.live.plot_support import colored
from tests.gui.window_support import PATIENCE_MS, SIMULATED

PORT = "Hapkit on ttyUSB0"


def entry_that(make):
    return DeviceEntry("/dev/ttyUSB0", "ttyUSB0: Hapkit board (FT232)", make)


def failing(error):
    def make():
        raise error

    return entry_that(make)


@pytest.fixture
def peers():
    """Return a list of scripted boards; they are unplugged in the end."""
    found = []
    yield found
    for peer in found:
        peer.unplug()


def failed(make_window, qtbot, error):
    """Return the window and the one banner after a device failed to open."""
    window = make_window((SIMULATED, failing(error)))
    window.studio.device.open(failing(error))
    qtbot.waitUntil(lambda: window.studio.link.state == "failed", timeout=PATIENCE_MS)
    (banner,) = window.banners.banners
    return window, banner


def words(banner):
    return [button.text() for button in banner.buttons]


@pytest.mark.parametrize(
    ("error", "first"),
    [
        (errors.NoFirmwareError("ttyUSB0 does not answer.", step="flash"), "Flash firmware"),
        (errors.WrongProtocolError("Firmware speaks version 1.", step="update"), "Update firmware"),
        (errors.PortBusyError("ttyUSB0 is used by minicom (process 41). Close it."), None),
    ],
)
def test_what_flashing_mends_is_offered_to_be_flashed(make_window, qtbot, error, first):
    window, banner = failed(make_window, qtbot, error)
    assert words(banner) == [*([first] if first else []), "Try again", "Use simulated Hapkit"]
    if first is None:
        return
    with qtbot.waitSignal(window.notices.flash, timeout=PATIENCE_MS):
        QTest.mouseClick(banner.buttons[0], Qt.MouseButton.LeftButton)


def test_the_line_to_run_can_be_copied(make_window, qtbot):
    command = "sudo usermod -a -G dialout $USER"
    text = f"You may not open ttyUSB0. Run `{command}`. Then log out and in again."
    _, banner = failed(make_window, qtbot, errors.PortPermissionError(text, command=command))
    assert words(banner) == ["Copy command", "Try again", "Use simulated Hapkit"]
    assert command in banner.text.text()
    QTest.mouseClick(banner.buttons[0], Qt.MouseButton.LeftButton)
    assert QGuiApplication.clipboard().text() == command


def test_a_starting_board_is_said_and_never_started_anew(make_window, qtbot, monkeypatch, peers):
    """A look again in the middle of the handshake would open the port and reset the board once more."""
    monkeypatch.setattr(device_link, "LOOK_AGAIN_MS", 5)
    plugged, kit, opened, asked = threading.Event(), FakeKit(), [], []

    def slow(message):
        if isinstance(message, HelloRequest):
            asked.append(message)
            return kit(message) if len(asked) > 3 else None
        return kit(message)

    def make():
        if not plugged.is_set():
            raise errors.PortGoneError(f"{PORT} is gone. Force is zero. Looking again every second.")
        opened.append(1)
        return HapkitBoard(peers[0].path)

    peers.append(FakeBoard(slow))
    window = make_window()
    window.studio.device.open(entry_that(make))
    qtbot.waitUntil(lambda: window.studio.link.state == "failed", timeout=PATIENCE_MS)
    said = []
    window.studio.device._connector.waiting.connect(said.append)
    plugged.set()
    qtbot.waitUntil(lambda: window.studio.link.state == "running", timeout=PATIENCE_MS)
    assert opened == [1]
    assert said == ["Starting board…"]


def test_the_header_says_what_it_waits_for(idle_window, qtbot, peers):
    gate = threading.Event()
    kit = FakeKit()

    def waits(message):
        gate.wait(PATIENCE_MS / 1000)
        return kit(message)

    peers.append(FakeBoard(waits))
    idle_window.studio.device.open(entry_that(lambda: HapkitBoard(peers[0].path)))
    word = idle_window.header.devices.word
    qtbot.waitUntil(lambda: word.text() == "Starting board…", timeout=PATIENCE_MS)
    gate.set()
    qtbot.waitUntil(lambda: idle_window.studio.link.state == "running", timeout=PATIENCE_MS)
    assert word.text() == f"Hapkit on {peers[0].path.removeprefix('/dev/')}"


def test_a_board_without_samples_is_noticed_until_they_come(make_window, qtbot, monkeypatch, peers):
    monkeypatch.setattr(notices, "NO_DATA_MS", 50)
    peers.append(FakeBoard(FakeKit()))
    window = make_window()
    window.studio.device.open(entry_that(lambda: HapkitBoard(peers[0].path)))
    qtbot.waitUntil(lambda: window.studio.link.state == "running", timeout=PATIENCE_MS)

    def shown():
        window.live.look()
        return window.banners.get("silence") is not None

    qtbot.waitUntil(shown, timeout=PATIENCE_MS)
    notice = window.banners.get("silence")
    assert notice.title.endswith("says hello, but sends no samples.")
    assert [text for text, _ in notice.buttons] == ["Try again", "Use simulated Hapkit"]
    from tests.devices.fake_board import sample

    def heard():
        peers[0].say(encode(sample(heard.seq, answered=0)))
        heard.seq += 1
        window.live.tick()
        window.live.look()
        return window.banners.get("silence") is None

    heard.seq = 0
    qtbot.waitUntil(heard, timeout=PATIENCE_MS)


def test_a_port_that_comes_back_without_rights_is_said_in_the_end_and_tried_on(
    make_window, qtbot, monkeypatch
):
    monkeypatch.setattr(device_link, "LOOK_AGAIN_MS", 5)
    error = [errors.PortGoneError(f"{PORT} is gone. Force is zero. Looking again every second.")]

    def make():
        if error:
            raise error[0]
        return SimulatedHapkit()

    window = make_window()
    window.studio.device.open(entry_that(make))
    qtbot.waitUntil(lambda: window.studio.link.state == "failed", timeout=PATIENCE_MS)
    error[0] = errors.PortPermissionError("You may not open ttyUSB0. Run it.", command="x")
    qtbot.waitUntil(lambda: window.studio.link.command == "x", timeout=PATIENCE_MS)
    assert window.studio.device._refusals >= device_link.TRIES
    error[0] = errors.PortGoneError(f"{PORT} is gone. Force is zero. Looking again every second.")
    qtbot.waitUntil(lambda: "is gone" in window.studio.link.text, timeout=PATIENCE_MS)
    error.clear()
    qtbot.waitUntil(lambda: window.studio.link.state == "running", timeout=PATIENCE_MS)


def test_letting_go_frees_the_port_and_reconnect_takes_it_back(window, qtbot):
    engine = window.studio.engine
    window.studio.device.let_go()
    qtbot.waitUntil(lambda: not engine.health().running, timeout=PATIENCE_MS)
    assert window.studio.engine is None
    assert window.header.devices.word.text() == "Not connected"
    assert window.banners.banners == []
    window.studio.device.reconnect()
    qtbot.waitUntil(lambda: window.studio.engine is not None, timeout=PATIENCE_MS)


def test_a_gap_is_hatched_and_named_in_the_picture(window, qtbot):
    """Also the part of it that is seen while its beginning has left the picture on the left."""
    history, plots = window.live.history, window.centre.time

    def take():
        window.live.tick()
        return len(history) > 200

    qtbot.waitUntil(take, timeout=PATIENCE_MS)
    window.live._reader = None  # from here on only these rows
    history._time[: history._end] -= 8.0
    rows = np.zeros((50, len(window.live.last)))
    rows[:, 0] = 10**6 + np.arange(50)
    rows[:, HOST_TIME] = history.now + 8.0 + 1e-3 * np.arange(50)
    history.append(rows)
    for span in (10.0, 5.0):
        plots.set_span(span)
        plots.refresh()
        ((start, stop),) = plots.shown.gaps
        assert stop - start == pytest.approx(8.0, abs=0.01)
        assert len(colored(plots.canvases[0].grab().toImage(), "warn")) > 20


def test_gaps_lie_between_the_last_and_the_first_sample():
    nan = np.nan
    x = np.array([0.0, 0.1, nan, 2.1, 2.2, nan, 2.3, nan])
    assert gaps(x) == [(0.1, 2.1)]
    assert gaps(np.array([nan, 1.0])) == []
    # one that began left of the window is a gap all the same; nothing was ever before the first sample
    assert gaps(np.array([5.0, 5.1]), before=1.0) == [(1.0, 5.0)]
    assert gaps(np.array([nan, 5.0, 5.1]), before=1.0) == [(1.0, 5.0)]
    assert gaps(np.array([5.0, 5.1]), before=4.9) == []
    assert gaps(np.empty(0), before=1.0) == []
    assert gaps(np.empty(0)) == []


def test_new_words_change_a_banner_in_its_place(window):
    """A measured number changes twice a second: banner and button must not be built anew each time."""
    done = []

    def notice(words, result, *more):
        return Notice(
            "device", 2, "danger", "cross", words, "…", (("Do", lambda: done.append(result)), *more)
        )

    window.banners.set("device", notice("181 N/m", 1))
    (banner,) = window.banners.banners
    window.banners.set("device", notice("182 N/m", 2))
    assert window.banners.banners == [banner]
    assert banner.title.text() == "182 N/m"
    assert banner.accessibleName().startswith("182")
    QTest.mouseClick(banner.buttons[0], Qt.MouseButton.LeftButton)
    assert done == [2]
    window.banners.set("device", notice("182 N/m", 2, ("Else", done.clear)))
    assert words(window.banners.banners[0]) == ["Do", "Else"]
    window.banners.set("device", None)
    assert window.banners.banners == []
