"""A long delay has its reason and its remedy in words; frames can be filled while the board runs."""

from types import SimpleNamespace

import pytest

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.hapkit import PACKET, HapkitBoard
from hapkit_studio.devices.serial_ports import Latency
from hapkit_studio.gui.panel.stability_card import LONG, delay_reason
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import Stream
from tests.devices.fake_board import FakeBoard, FakeKit, sample
from tests.gui.window_support import PATIENCE_MS


def device(timer=None, padding=0, simulated=False):
    return SimpleNamespace(simulated=simulated, latency=Latency(timer), padding=padding)


@pytest.mark.parametrize(
    ("what", "delay", "words"),
    [
        (device(0.016), 1.01 * LONG, "The USB chip holds frames back, up to 16 ms: fill its frames"),
        (device(0.016), 0.99 * LONG, ""),
        (device(0.001), 1.01 * LONG, "The line holds frames back: fill its frames"),
        (device(), 1.01 * LONG, "render on the board"),
        (device(simulated=True), 0.1, ""),
        (device(padding=PACKET), 0.1, "The line holds frames back: render on the board"),
        (
            SimpleNamespace(simulated=False, hand=True),
            1.01 * LONG,
            "The virtual board shares this computer's",
        ),
    ],
)
def test_only_a_long_delay_has_a_reason(what, delay, words):
    said = delay_reason(what, delay)
    assert words in said
    assert bool(said) == bool(words)


@pytest.fixture
def board_window(make_window, qtbot):
    """Return a window on a scripted board, and the board."""
    peer = FakeBoard(FakeKit())
    window = make_window()
    window.studio.device.open(DeviceEntry("/dev/ttyUSB0", "Hapkit", lambda: HapkitBoard(peer.path)))
    qtbot.waitUntil(lambda: window.studio.link.state == "running", timeout=PATIENCE_MS)
    yield window, peer
    window.studio.close()
    peer.unplug()


def test_frames_are_filled_at_once_and_after_every_connection(board_window, qtbot):
    window, peer = board_window

    def told():
        return [m.padded for m in list(peer.received) if isinstance(m, Stream) and m.on]

    qtbot.waitUntil(lambda: told() == [0], timeout=PATIENCE_MS)
    window.studio.device.set_padding(PACKET)
    qtbot.waitUntil(lambda: told() == [0, PACKET], timeout=PATIENCE_MS)
    window.studio.device.reconnect()
    qtbot.waitUntil(lambda: told() == [0, PACKET, PACKET], timeout=PATIENCE_MS)


def test_the_next_start_fills_frames_as_the_last_one_did(make_window):
    first = make_window()
    assert first.studio.device.padding == 0
    first.studio.device.set_padding(PACKET)
    first.close()
    assert make_window().studio.device.padding == PACKET


def test_the_stability_card_says_why_it_is_late_but_not_what_was_added(board_window, qtbot):
    window, peer = board_window
    window.studio.engine.device.latency = Latency(0.016, True, "/dev/ttyUSB0")
    seq = [0]

    def late():
        for _ in range(5):
            peer.say(encode(sample(seq[0], answered=(seq[0] - 4) & 0xFFFF, delay_us=3500)))
            seq[0] += 1
        window.live.tick()
        window.live.look()
        return "ms from sensor to motor" in window.stability.words.text()

    qtbot.waitUntil(lambda: late() and "3.5" in window.stability.words.text(), timeout=PATIENCE_MS)
    assert "holds frames back, up to 16 ms" in window.stability.words.text()
    assert "latency_timer`" in window.stability.words.toolTip()
