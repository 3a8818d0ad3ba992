"""A link that is slow, silent, or has an unknown delay: the window shows it with a possible remedy."""

import pytest

from hapkit_studio.devices.hapkit import PACKET, HapkitBoard
from hapkit_studio.devices.serial_ports import Latency
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.gui.panel.stability_card import LONG, delay_reason
from hapkit_studio.gui.shell import notices
from hapkit_studio.haptics import arrays
from hapkit_studio.haptics.clib import store_release
from hapkit_studio.haptics.link import latch
from hapkit_studio.haptics.tick import mark_stale
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import Stream
from tests.devices.fake_board import sample
from tests.gui.board_fixtures import answered

WAY_OUT = "Render on the board"


def ways_on(window, key):
    """Return a banner's buttons by their text."""
    return dict(window.banners.get(key).buttons)


def measure(window, delay, which=0):
    """Store 500 measured delays in s for one way of rendering."""
    delays = window.studio.engine.driver.conn.delays
    delays.values[which, :500], delays.counts[which] = delay, 500
    window.live.refresh()


def test_only_a_slow_link_fault_offers_to_render_on_the_board(board_window):
    studio, engine = board_window.studio, board_window.studio.engine
    latch(engine.arrays, arrays.OVER_SPEED, 3.4, 0.0)
    board_window.live.refresh()
    assert list(ways_on(board_window, "fault")) == ["Clear fault", "Help"]
    store_release(engine.arrays.control.fault, 0, arrays.NO_FAULT)
    latch(engine.arrays, arrays.SLOW_LINK, 0.032, 0.025)
    board_window.live.refresh()
    notice = board_window.banners.get("fault")
    assert "a force came 32 ms after its sample" in notice.title
    assert [text for text, _ in notice.buttons] == [WAY_OUT, "Clear fault", "Help"]
    ways_on(board_window, "fault")[WAY_OUT]()
    assert studio.loop.where == engine.where == "board"


def test_a_slow_law_fault_names_the_law_its_duration_and_the_period(board_window):
    r = board_window.studio.engine.arrays
    r.tick.slow_law = board_window.studio.environment.force.compiled().address
    latch(r, arrays.SLOW_LAW, 0.0168, 1e-3)
    board_window.live.refresh()
    notice = board_window.banners.get("fault")
    assert notice.title == "Fault: the law of Wall takes 16.8 ms, but the period is 1 ms."
    assert notice.text == "Force is zero. Simplify the law or lower the servo rate. Then clear the fault."
    assert [text for text, _ in notice.buttons] == ["Clear fault", "Help"]


def test_a_clock_jump_is_shown_while_the_force_is_zero(board_window):
    engine = board_window.studio.engine
    mark_stale(engine.arrays, 10.0, arrays.CLOCK_JUMP)
    board_window.live.refresh()
    notice = board_window.banners.get("stale")
    assert notice.title == "Fault: the board's clock jumped."
    assert notice.text == "The force is zero, and comes back by itself when the sensor answers again."


@pytest.mark.slow
def test_a_long_delay_is_shown_in_the_card_with_a_remedy(board_window, qtbot):
    label = board_window.stability.label
    board_window.studio.set_value("stiffness", 1500.0)
    measure(board_window, 4e-3)
    qtbot.waitUntil(lambda: "The delay is 4.00 ms" in label.text())
    assert "et the board render" in label.text()
    assert board_window.banners.banners == []


@pytest.mark.slow
def test_rendering_on_the_board_is_not_offered_if_it_is_impossible(board_window, qtbot):
    studio = board_window.studio
    studio.choose("mass_spring_damper")
    studio.set_values({"integrator": "exact", "stiffness": 2000.0, "contact_stiffness": 5000.0})
    answered(board_window, qtbot)
    latch(studio.engine.arrays, arrays.SLOW_LINK, 0.032, 0.025)
    board_window.live.refresh()
    assert list(ways_on(board_window, "fault")) == ["Clear fault", "Help"]


@pytest.mark.slow
def test_an_unmeasurable_delay_is_shown_while_forces_are_sent(board_window, monkeypatch):
    window, studio = board_window, board_window.studio
    monkeypatch.setattr(notices, "NO_DELAY_MS", -1)

    def notice():
        window.live.refresh()
        return window.banners.get("delay")

    assert notice() is None  # without a sample, no force was sent
    window.notices._heard = True
    studio.stop()
    assert notice() is None
    studio.release_stop()
    control = studio.engine.arrays.control
    store_release(control.fault, 0, arrays.OVER_SPEED)
    assert notice() is None
    store_release(control.fault, 0, arrays.NO_FAULT)
    assert notice().title == "The delay of the link cannot be measured."
    assert list(ways_on(window, "delay")) == [WAY_OUT, "Help"]
    measure(window, 1e-3)
    assert window.banners.get("delay") is None


@pytest.mark.slow
def test_a_board_without_samples_is_reported_and_late_samples_are_explained(
    board_window, scripted, qtbot, monkeypatch
):
    window, seq = board_window, [0]
    monkeypatch.setattr(notices, "NO_DATA_MS", 50)
    qtbot.waitUntil(lambda: window.live.refresh() or window.banners.get("silence") is not None)
    notice = window.banners.get("silence")
    assert notice.title.endswith("sends no samples.")
    assert [text for text, _ in notice.buttons] == ["Try again", "Use simulated Hapkit", "Help"]

    def late():
        for _ in range(5):
            scripted.send(encode(sample(seq[0], answered=(seq[0] - 4) & 0xFFFF, delay_us=3500)))
            seq[0] += 1
        # check this every time, because a slow computer may have closed the board meanwhile
        if window.studio.engine is None:
            return False
        window.studio.engine.device.latency = Latency(0.016, True, "/dev/ttyUSB0")
        window.live.tick()
        window.live.refresh()
        return "3.5" in window.stability.label.text()

    qtbot.waitUntil(late)
    assert window.banners.get("silence") is None
    assert "The delay is 3.50 ms" in window.stability.label.text()
    assert "delays each force by up to 16 ms" in window.stability.label.text()
    assert "latency_timer`" in window.stability.label.toolTip()


def board(timer=None, padding=0):
    made = HapkitBoard("port")
    made.latency, made.padding = Latency(timer), padding
    return made


@pytest.mark.parametrize(
    ("what", "delay", "text"),
    [
        (
            board(0.016),
            1.01 * LONG,
            "delays each force by up to 16 ms. Run Set up my Hapkit…",
        ),
        (board(0.016), 0.99 * LONG, ""),
        (board(0.001), 1.01 * LONG, "USB delays each force. Run Set up my Hapkit…"),
        (board(), 1.01 * LONG, "or let the board render"),
        (SimulatedHapkit(), 0.1, ""),
        (board(padding=PACKET), 0.1, "USB delays each force. Let the board compute the force"),
        (VirtualBoard(), 1.01 * LONG, "The virtual board and the window share this computer's"),
    ],
)
def test_only_a_long_delay_is_explained(what, delay, text):
    reason = delay_reason(what, delay)
    assert text in reason
    assert bool(reason) == bool(text)


@pytest.mark.slow
def test_padding_is_sent_immediately_after_every_connection_and_in_the_next_window(
    board_window, scripted, make_window, qtbot
):
    def padding_sent(*padded):
        streams = [m.padded for m in list(scripted.received) if isinstance(m, Stream) and m.on]
        return streams == list(padded)

    link = board_window.studio.device
    assert link.padding == 0
    qtbot.waitUntil(lambda: padding_sent(0))
    link.set_padding(PACKET)
    qtbot.waitUntil(lambda: padding_sent(0, PACKET))
    link.reconnect()
    qtbot.waitUntil(lambda: padding_sent(0, PACKET, PACKET))
    board_window.close()
    assert make_window().studio.device.padding == PACKET
