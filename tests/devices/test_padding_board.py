"""Filled frames on the real firmware behind the virtual board's FTDI chip, against the rule of 62 bytes."""

import time
from functools import cache

import pytest

from hapkit_studio.devices.hapkit import PACKET
from hapkit_studio.devices.padding import measure_padding
from hapkit_studio.devices.virtual_board import VirtualBoard, built
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.protocol.framing import encode
from tests.devices.fake_kit import sample
from tests.lateness import ATTEMPTS

pytestmark = pytest.mark.skipif(not built(), reason="the virtual board is not built")
BYTE = 10e-6
FILLING = BYTE / 10 + 6 / 16e6
"""s a byte of filling takes besides its own bits: the line rests for two bits after every second byte, and
the board's main program queues a byte in 6 cycles."""
BUSY = 0.2e-3
"""s for which the board's main program makes and fills its next frame before it reads an answer."""
PERIOD = 1e-3
FRAME = len(encode(sample(1)))


@cache
def measured(latency):
    board = VirtualBoard("lockstep", options=["--latency", str(latency)])
    board.open()
    try:
        return measure_padding(board, 0.4)
    finally:
        board.close()


def test_filling_saves_what_the_latency_timer_costs():
    direct = measured(0.0)
    rest = direct.plain - FRAME * BYTE  # all that is not the frame's own way down the wire
    behind = measured(0.016)
    # a filled frame ends its own packet
    filling = (PACKET - FRAME) * FILLING
    arrival = PACKET * BYTE + filling + rest
    # which comes when the board makes its next frame
    assert PERIOD < arrival < PERIOD + BUSY
    assert 0.98 * arrival < behind.padded < arrival + BUSY
    # A plain packet is full in the middle of a frame, but for one in FRAME: the newest whole one is a period
    # older. And it is answered only every 62 / FRAME periods.
    age = PERIOD * (FRAME - 1) / FRAME + FRAME * BYTE / 2
    held = (PACKET / FRAME - 1) * PERIOD / 2
    assert behind.plain == pytest.approx(age + rest + held, rel=0.04)
    assert behind.better == PACKET
    assert direct.better == 0


def looped(padding):
    """Run the loop for a second of the board; return the delay it measured."""
    board = VirtualBoard("lockstep", options=["--latency", "0.016"])
    board.padding = padding
    engine = Engine(board, "spring", realtime=False)
    reader, rows = engine.reader(), 0
    engine.start()
    try:
        while rows < 1000 and engine.health().running:
            rows += len(reader.read())
            time.sleep(0.01)
        delay = engine.health().delay
    finally:
        engine.close()
    assert rows >= 1000
    return delay


@pytest.mark.parametrize("padding", [0, PACKET])
def test_the_loop_itself_measures_the_same_delay(padding):
    """What keeps the loop from answering, as its being compiled does, is measured as well: then again."""
    want, found = pytest.approx(measured(0.016)[padding > 0], rel=0.04), []
    while len(found) < ATTEMPTS and (not found or found[-1] != want):
        found.append(looped(padding))
    assert found[-1] == want, found
