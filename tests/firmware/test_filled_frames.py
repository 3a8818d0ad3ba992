"""Filled frames as the chip queues them, up to all 112 bytes of its queue."""

import re

import pytest

from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import Sample, Stream
from tests.devices.fake_kit import sample
from tests.firmware.faults_turns import Turns
from tests.firmware.vb import needs_board

QUEUE = 112
FRAMES = 140
BYTE, PERIOD = 10e-6, 1e-3
PLAIN = len(encode(sample(1)))


@needs_board
@pytest.mark.parametrize("multiple", [0, 1, 61, 62, 80, 112, 113])
def test_every_frame_is_as_long_as_whole_packets(tmp_path, multiple):
    packets = -(-PLAIN // multiple) * multiple if 0 < multiple <= QUEUE else PLAIN
    turns = Turns(tmp_path, (), ("--await", str(Sample.ID)))
    turns.say(encode(Stream(1, multiple)))
    said = b""
    while len(said) < FRAMES * packets:
        turns.turn()
        said += turns.take(4096)
    turns.end()
    frames = re.findall(rb"[^\0]+\0+", said)[:-1]  # the last one may not be there wholly
    assert {len(frame) for frame in frames} == {packets}
    decoder = Decoder()
    numbers = [message.seq for message in decoder.feed(b"".join(frames))]
    periods = 1 if packets * BYTE < PERIOD else 2  # a line that is full takes every other sample
    assert numbers == list(range(numbers[0], numbers[0] + periods * len(frames), periods))
    assert decoder.bad_frames == 0
