"""Plain frames: the COBS authors' examples, the CRC's catalogue value, and round trips of every message."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hapkit_studio.protocol.framing import Decoder, cobs_decode, cobs_encode, crc16, encode, frame
from hapkit_studio.protocol.messages import MESSAGES, Force, Hello, Sample, Settings, Stop, Telemetry
from tests.protocol.strategies import any_message


def test_the_crc_of_the_check_string():
    assert crc16(b"123456789") == 0x29B1


@pytest.mark.parametrize(
    ("raw", "coded"),
    [
        (b"", b"\x01"),
        (b"\0", b"\x01\x01"),
        (b"\0\0", b"\x01\x01\x01"),
        (b"\x11\x22\0\x33", b"\x03\x11\x22\x02\x33"),
        (b"\x11\0\0\0", b"\x02\x11\x01\x01\x01"),
        (bytes(range(1, 254)), b"\xfe" + bytes(range(1, 254))),
        (bytes(range(256)), b"\x01\xff" + bytes(range(1, 255)) + b"\x02\xff"),
    ],
)
def test_the_cobs_examples_of_its_authors(raw, coded):
    """The examples are from Cheshire & Baker, Consistent Overhead Byte Stuffing, 1999."""
    assert cobs_encode(raw) == coded
    assert cobs_decode(coded) == raw


@given(st.binary(max_size=600))
def test_cobs_round_trip(raw):
    coded = cobs_encode(raw)
    assert 0 not in coded
    assert cobs_decode(coded) == raw
    assert len(coded) <= len(raw) + 1 + len(raw) // 254


def test_ids_are_distinct_and_encode_the_direction():
    ids = [m.ID for m in MESSAGES]
    assert len(set(ids)) == len(ids)
    from_board = {Hello, Sample, Telemetry, Settings}
    assert all(m.from_board() == (m in from_board) for m in MESSAGES)


@given(st.lists(any_message, max_size=8), st.integers(1, 30))
def test_messages_survive_any_chunking(messages, cut):
    stream = b"".join(map(encode, messages))
    decoder = Decoder()
    found = [m for at in range(0, len(stream), cut) for m in decoder.feed(stream[at : at + cut])]
    assert found == messages
    assert decoder.bad_frames == 0


@pytest.mark.parametrize("kind", MESSAGES)
def test_other_sizes_and_ids_are_rejected(kind):
    body = bytes([kind.ID]) + bytes(kind.size())
    assert kind.unpack(body).pack()[:1] == body[:1]
    for wrong in (body + b"\0", body[:-1], bytes([kind.ID ^ 1]) + body[1:]):
        with pytest.raises(ValueError, match="bytes starting with"):
            kind.unpack(wrong)
    assert Decoder().feed(frame(body + b"\0")) == []


@settings(derandomize=True, max_examples=30)
@given(any_message)
def test_one_damaged_byte_is_always_detected(message):
    good = encode(message)
    for at in range(len(good) - 1):
        for change in (0x01, 0x80, 0xFF):
            bad = bytearray(good)
            bad[at] ^= change
            assert Decoder().feed(bytes(bad)) == []


def test_the_decoder_resynchronises_at_the_next_frame():
    decoder = Decoder()
    assert decoder.feed(encode(Force(1, 0, 2.0))[3:]) == []
    assert decoder.feed(b"noise\x00\x00\x07") == []
    assert decoder.feed(b"\x00" + encode(Stop())) == [Stop()]
    assert decoder.bad_frames == 3


def test_the_largest_sample_and_command_fit_their_periods():
    """At 1 Mbaud a byte takes 10 µs; both directions must take much less than 1 ms."""
    sample = Sample(0xFFFF, 0xFFFFFFFF, -1, *3 * (0xFFFF,), 255, -1, 255, 255, 255, 0xFFFF, 255)
    assert len(encode(sample)) <= 32
    assert len(encode(Force(0xFFFF, 255, 1.1))) <= 12
