"""The compiled codec against the plain one: frames, noise, losses, telemetry."""

import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hapkit_studio.protocol import codec, law_frames
from hapkit_studio.protocol.framing import Decoder, crc16, encode, frame
from hapkit_studio.protocol.messages import (
    PIECE,
    TUNED,
    Alive,
    Board,
    BoardFlag,
    Force,
    Hello,
    HelloRequest,
    Law,
    Leave,
    Piece,
    Release,
    Sample,
    Settings,
    Stop,
    Telemetry,
    Tune,
)
from tests.devices.fake_board import HELLO_FIELDS
from tests.protocol.strategies import any_message, bodies, messages_of, samples


class Reader:
    """The compiled reader with its arrays."""

    def __init__(self):
        self.state, self.buffer = codec.new_reader()

    def __call__(self, data, cut=None):
        chunks = [data[at : at + cut] for at in range(0, len(data), cut)] if cut else [data]
        return np.vstack([self._rows(chunk) for chunk in chunks] or [np.empty((0, codec.SAMPLE_WIDTH))])

    def _rows(self, chunk):
        out = np.full((codec.rows_for(len(chunk)), codec.SAMPLE_WIDTH), np.nan)
        data = np.frombuffer(chunk + b"\x55" * 5, np.uint8).copy()  # n says where the chunk ends
        return out[: codec.feed(self.state, self.buffer, data, len(chunk), out)]


def sample(seq, time_us=0, count=0):
    return Sample(seq & 0xFFFF, time_us & 0xFFFFFFFF, count, *10 * (0,))


def is_one(body, kind):
    return body[0] == kind.ID and len(body) == 1 + kind.size()


def stream(*messages):
    return b"".join(map(encode, messages))


def test_sample_becomes_a_row_in_si_units():
    flags = BoardFlag.CLAMPED | BoardFlag.OVERRUN
    link = {"rx_errors": 3, "stale": 7, "generation": 200, "received": 513, "refusal": 9}
    [row] = Reader()(encode(Sample(513, 2_500_000, -70000, 0, 511, 1234, int(flags), -255, **link)))
    assert row[codec.SEQ] == 513
    assert row[codec.BOARD_TIME] == pytest.approx(2.5, abs=1e-12)
    assert row[codec.COUNT] == -70000
    assert row[codec.ANSWERED] == 511
    assert row[codec.DELAY] == pytest.approx(1.234e-3, abs=1e-12)
    assert int(row[codec.FLAGS]) == codec.FLAG_CLAMPED | codec.FLAG_OVERRUN
    assert row[codec.PWM] == -255
    assert row[codec.LOST] == 0
    assert row[codec.RX_ERRORS] == 3
    columns = codec.STALE, codec.GENERATION, codec.RECEIVED, codec.REFUSAL
    assert [row[c] for c in columns] == [7, 200, 513, 9]


@given(st.lists(samples, max_size=10), st.integers(1, 60))
def test_agrees_with_the_plain_codec_on_samples(messages, cut):
    rows = Reader()(stream(*messages), cut)
    assert len(rows) == len(messages)
    for row, message in zip(rows, messages, strict=True):
        assert row[codec.SEQ] == message.seq
        assert row[codec.COUNT] == message.count
        assert row[codec.ANSWERED] == message.answered
        assert row[codec.DELAY] == pytest.approx(message.delay_us * 1e-6)
        assert row[codec.FLAGS] == message.flags
        assert row[codec.STALE] == message.stale
        assert row[codec.GENERATION] == message.generation
        assert row[codec.RECEIVED] == message.received
        assert row[codec.REFUSAL] == message.refusal
        assert row[codec.PWM] == message.pwm
        assert row[codec.RX_ERRORS] == message.rx_errors
        assert round(row[codec.BOARD_TIME] * 1e6) % 2**32 == message.time_us


pieces = st.one_of(
    any_message.map(encode),
    samples.map(encode),
    bodies.map(frame),
    st.binary(max_size=30),
    samples.map(lambda s: encode(s)[4:]),
    st.just(b"\x00"),
    st.just(b"\x41" * 300),
)


@given(st.lists(pieces, max_size=12), st.integers(1, 100))
def test_agrees_with_the_plain_codec_on_anything(parts, cut):
    data = b"".join(parts) + b"\x00"
    plain = Decoder()
    found = plain.bodies(data)
    expected = [kind.unpack(b) for b in found for kind in (Sample, Telemetry) if is_one(b, kind)]
    reader = Reader()
    rows = reader(data, cut)
    assert [int(r[codec.COUNT]) for r in rows] == [message.count for message in expected]
    assert reader.state[codec.SETTINGS_FRAMES] == sum(is_one(b, Settings) for b in found)
    assert reader.state[codec.FRAMES] == len(expected)
    assert reader.state[codec.BAD_FRAMES] == plain.bad_frames
    assert reader.state[codec.OTHER_FRAMES] == len(found) - len(expected)


@pytest.mark.slow
def test_damage_gives_no_false_sample(rng):
    """A CRC-16 lets damage pass once in 65536 by chance: 0.3 expected here."""
    wrong = 0
    reader = Reader()
    for _ in range(20000):
        good = bytearray(
            encode(sample(int(rng.integers(65536)), int(rng.integers(2**32)), int(rng.integers(2**31))))
        )
        for at in rng.integers(0, len(good) - 1, size=rng.integers(1, 6)):
            good[at] ^= int(rng.integers(1, 256))
        if bytes(good) != encode(Stop()):
            wrong += len(reader(bytes(good)))
    assert wrong <= 4
    assert reader.state[codec.BAD_FRAMES] > 19000


@given(st.binary(max_size=80), samples)
def test_in_step_again_within_one_frame(garbage, message):
    rows = Reader()(garbage + encode(message) + encode(message))
    assert len(rows) >= 1
    assert rows[-1][codec.COUNT] == message.count


def test_lost_frames_are_counted_across_the_overflow():
    reader = Reader()
    rows = reader(stream(sample(65533), sample(65534), sample(1), sample(2), sample(12)))
    assert rows[:, codec.LOST].tolist() == [0, 0, 2, 0, 9]
    assert reader.state[codec.LOST_FRAMES] == 11


def test_time_goes_on_where_the_microseconds_overflow():
    start = 2**32 - 1500
    times = [start + 1000 * k for k in range(4)]
    rows = Reader()(stream(*(sample(k, t) for k, t in enumerate(times))))
    np.testing.assert_allclose(rows[:, codec.BOARD_TIME], np.array(times) * 1e-6, rtol=0, atol=1e-9)


def test_rows_beyond_the_room_are_skipped_and_counted():
    state, buffer = codec.new_reader()
    data = np.frombuffer(stream(*(sample(k) for k in range(5))), np.uint8)
    out = np.full((2, codec.SAMPLE_WIDTH), np.nan)
    assert codec.feed(state, buffer, data, len(data), out) == 2
    assert state[codec.SKIPPED] == 3
    assert out[:, codec.SEQ].tolist() == [0, 1]


def test_other_messages_pass_by():
    reader = Reader()
    rows = reader(stream(Hello(**HELLO_FIELDS), sample(7), Stop(), Force(1, 0, 1.0)))
    assert rows[:, codec.SEQ].tolist() == [7]
    assert reader.state[codec.OTHER_FRAMES] == 3
    assert reader.state[codec.BAD_FRAMES] == 0


@given(st.integers(0, 65535), st.integers(0, 255), st.floats(width=32))
def test_force_is_coded_as_the_plain_codec_does(seq, behind, force):
    out = np.full(codec.FRAME_SIZE, 0x99, np.uint8)
    size = codec.encode_force(out, seq, behind, force)
    if force == force:
        assert bytes(out[:size]) == encode(Force(seq, behind, force))
    else:
        [decoded] = Decoder().feed(bytes(out[:size]))
        assert (decoded.seq, decoded.behind) == (seq, behind)
        assert decoded.force != decoded.force


@pytest.mark.parametrize(("number", "message"), [(codec.STOP, Stop()), (codec.RELEASE, Release())])
def test_simple_messages(number, message):
    out = np.full(codec.FRAME_SIZE, 0x99, np.uint8)
    assert bytes(out[: codec.encode_simple(out, number)]) == encode(message)


@given(st.binary(max_size=50))
def test_crc_is_the_plain_one(data):
    crc = 0xFFFF
    for byte in data:
        crc = codec.crc_update(crc, byte)
    assert crc == crc16(data)


@pytest.mark.slow
def test_same_results_without_compilation():
    program = """
import numpy as np
from hapkit_studio.protocol import codec, framing, messages
state, buffer = codec.new_reader()
data = np.frombuffer(framing.encode(messages.Sample(5, 7, -9, 0, 4, 300, 1, -2, 0, 0, 0, 0, 0)), np.uint8)
out = np.zeros((1, codec.SAMPLE_WIDTH))
command = np.zeros(codec.FRAME_SIZE, np.uint8)
size = codec.encode_force(command, 260, 3, -1.5)
print(codec.feed(state, buffer, data, len(data), out), out[0].tolist(), bytes(command[:size]).hex())
"""
    said = {
        subprocess.run(
            [sys.executable, "-c", program],
            env=os.environ | {"NUMBA_DISABLE_JIT": flag},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for flag in "01"
    }
    assert len(said) == 1
    assert said.pop().startswith("1 [5.0, 7e-06, -9.0, 4.0, 0.0003, 1.0, -2.0, 0.0, 0.0, 0.0")


FIRST = dict(
    seq=7, time_us=1000, count=-300, velocity=-0.25, asked=1.5, pwm=-120, delay_us=180, flags=4,
    rx_errors=2, overruns=9, generation=200, state_at=3, state=0.125,
)  # fmt: skip


def rows_of(*messages):
    state, buffer = codec.new_reader()
    data = np.frombuffer(b"".join(map(encode, messages)), np.uint8)
    out = np.full((codec.rows_for(len(data)), codec.SAMPLE_WIDTH), np.nan)
    return out[: codec.feed(state, buffer, data, len(data), out)], state


def telemetry(**changed):
    return Telemetry(**{**FIRST, **changed})


def test_telemetry_becomes_a_row_in_si_units():
    [row], _ = rows_of(telemetry())
    assert row[codec.KIND] == codec.TELEMETRY
    assert row[codec.BOARD_TIME] == pytest.approx(1e-3)
    assert row[codec.COUNT] == -300
    assert row[codec.VELOCITY] == -0.25
    assert row[codec.ASKED] == 1.5
    assert row[codec.PWM] == -120
    assert row[codec.DELAY] == pytest.approx(180e-6)
    assert [row[c] for c in (codec.FLAGS, codec.RX_ERRORS, codec.OVERRUNS)] == [4, 2, 9]
    assert [row[c] for c in (codec.GENERATION, codec.STATE_AT, codec.STATE)] == [200, 3, 0.125]


@given(messages_of(Telemetry))
def test_agrees_with_the_plain_codec(message):
    [row], _ = rows_of(message)
    for column, value in (
        (codec.SEQ, message.seq),
        (codec.COUNT, message.count),
        (codec.VELOCITY, message.velocity),
        (codec.ASKED, message.asked),
        (codec.PWM, message.pwm),
        (codec.FLAGS, message.flags),
        (codec.OVERRUNS, message.overruns),
        (codec.GENERATION, message.generation),
        (codec.STATE_AT, message.state_at),
        (codec.STATE, message.state),
    ):
        assert row[column] == value


def test_ticks_not_shown_are_no_lost_frames():
    rows, state = rows_of(telemetry(seq=65532), telemetry(seq=0), telemetry(seq=8))
    assert rows[:, codec.LOST].tolist() == [0, 3, 7]
    assert state[codec.LOST_FRAMES] == 0


def test_a_change_of_who_renders_is_no_loss():
    sample = Sample(500, *12 * (0,))
    rows, state = rows_of(sample, telemetry(seq=9000), telemetry(seq=9004), sample)
    assert rows[:, codec.LOST].tolist() == [0, 0, 3, 0]
    assert state[codec.LOST_FRAMES] == 0
    assert rows[:, codec.KIND].tolist() == [0, 1, 1, 0]


@given(messages_of(Settings))
def test_settings_are_counted(message):
    rows, state = rows_of(message, telemetry(), message)
    assert len(rows) == 1
    assert state[codec.SETTINGS_FRAMES] == 2
    assert state[codec.OTHER_FRAMES] == 2


def told(encoder, *arguments):
    out = np.full(law_frames.ROOM, 0x99, np.uint8)
    return bytes(out[: encoder(out, *arguments)])


@given(messages_of(Law))
def test_law(law):
    assert told(law_frames.encode_law, *vars(law).values()) == encode(law)


@given(st.binary(min_size=1, max_size=300), st.integers(0, 255), st.data())
def test_pieces(program, generation, data):
    words = law_frames.packed(program, 40)
    at = data.draw(st.integers(0, len(program) - 1))
    taken = program[at : at + PIECE].ljust(PIECE, b"\0")
    assert told(law_frames.encode_piece, generation, at, words) == encode(Piece(generation, at, tuple(taken)))


def test_a_piece_at_the_end_of_the_room_holds_zeros():
    frame = told(law_frames.encode_piece, 1, 8, law_frames.packed(bytes(range(1, 17)), 2))
    assert frame == encode(Piece(1, 8, (*range(9, 17), *(PIECE - 8) * (0,))))


finite = st.floats(width=32, allow_nan=False, allow_infinity=False)


@given(st.integers(0, 255), st.integers(0, 255), st.lists(finite, min_size=1, max_size=TUNED))
def test_tune(law, generation, values):
    given = np.array(values, np.float32)
    words = law_frames.packed(given.tobytes(), 8)
    out = np.full(law_frames.ROOM, 0x99, np.uint8)
    law_frames.begin_tune(out, law, generation)
    for i in range(len(values)):
        assert law_frames.add_constant(out, 10 + i, law_frames.constant_of(words, i)) == i + 1
    rest = (0,) * (TUNED - len(values))
    wanted = Tune(law, generation, len(values), (*range(10, 10 + len(values)), *rest), (*given, *rest))
    assert bytes(out[: law_frames.end_tune(out)]) == encode(wanted)


@given(messages_of(Board), st.integers(-(2**31), 2**31 - 1), st.sampled_from([-1, 1]))
def test_settings_with_another_zero(board, zero, sense):
    body = np.frombuffer(board.pack(), np.uint8).copy()
    assert len(body) == law_frames.BOARD_BODY
    assert codec.signed(body, law_frames.AT_ZERO, 4) == board.zero
    law_frames.put_whole(body, law_frames.AT_ZERO, 4, zero)
    law_frames.put_whole(body, law_frames.AT_SENSE, 1, sense)
    wanted = Board(**{**vars(board), "zero": zero, "sense": sense})
    assert told(law_frames.encode_body, body) == encode(wanted)


@pytest.mark.parametrize(
    ("number", "message"),
    [
        (law_frames.ALIVE, Alive()),
        (law_frames.LEAVE, Leave()),
        (law_frames.HELLO_REQUEST, HelloRequest()),
    ],
)
def test_words(number, message):
    assert told(codec.encode_simple, number) == encode(message)


LONGEST = (Board, Alive), (Piece, Piece, Piece, Alive), (Law, Force, Alive), (Tune, Alive)


@pytest.mark.parametrize("kinds", LONGEST)
def test_the_longest_answer_has_room(kinds):
    whole = (kind(**{w.name: _largest(w) for w in kind.layout()}) for kind in kinds)
    assert len(b"".join(map(encode, whole))) + codec.FRAME_SIZE <= law_frames.ROOM


def _largest(wire):
    if wire.code.endswith("s"):
        return "x" * wire.size
    one = {"f": 1.1, "b": -1}.get(wire.code[-1], 1)
    return (one,) * wire.numbers if wire.numbers > 1 else one
