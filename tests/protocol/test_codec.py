"""The compiled codec agrees with the plain one: frames, noise, losses, telemetry, and laws in pieces."""

import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hapkit_studio.protocol import codec, law_frames
from hapkit_studio.protocol.framing import Decoder, encode, frame
from hapkit_studio.protocol.messages import (
    PIECE,
    TUNED,
    Alive,
    Board,
    BoardFlag,
    Force,
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
from tests.protocol.strategies import any_message, bodies, messages_of, samples


class Reader:
    """The compiled reader with the arrays that it writes."""

    def __init__(self):
        self.state, self.buffer = codec.new_reader()

    def __call__(self, data, cut=None):
        chunks = [data[at : at + cut] for at in range(0, len(data), cut)] if cut else [data]
        return np.vstack([self._rows(chunk) for chunk in chunks] or [np.empty((0, codec.SAMPLE_WIDTH))])

    def _rows(self, chunk):
        out = np.full((codec.rows_for(len(chunk)), codec.SAMPLE_WIDTH), np.nan)
        # the reader must ignore the bytes after n, the chunk's length
        data = np.frombuffer(chunk + b"\x55" * 5, np.uint8).copy()
        return out[: codec.feed(self.state, self.buffer, data, len(chunk), out)]


def sample(seq, time_us=0, count=0):
    return Sample(seq & 0xFFFF, time_us & 0xFFFFFFFF, count, *10 * (0,))


def telemetry(seq):
    return Telemetry(seq, *12 * (0,))


def is_one(body, kind):
    return body[0] == kind.ID and len(body) == 1 + kind.size()


def stream(*messages):
    return b"".join(map(encode, messages))


def test_a_row_is_in_si_units():
    [row] = Reader()(encode(Sample(513, 2_500_000, -70000, 0, 511, 1234, 12, -255, 3, 7, 200, 513, 9)))
    assert row[codec.BOARD_TIME] == pytest.approx(2.5, abs=1e-12)
    assert row[codec.DELAY] == pytest.approx(1.234e-3, abs=1e-12)
    assert int(row[codec.FLAGS]) == BoardFlag.CLAMPED | BoardFlag.OVERRUN
    assert row[[codec.COUNT, codec.PWM, codec.KIND]].tolist() == [-70000, -255, codec.SAMPLE]
    [row] = Reader()(encode(Telemetry(7, 1000, -300, -0.25, 1.5, -120, 180, 4, 2, 9, 200, 3, 0.125)))
    assert row[codec.BOARD_TIME] == pytest.approx(1e-3)
    assert row[codec.DELAY] == pytest.approx(180e-6)
    assert row[[codec.VELOCITY, codec.ASKED, codec.STATE]].tolist() == [-0.25, 1.5, 0.125]
    assert row[[codec.KIND, codec.ANSWERED]].tolist() == [codec.TELEMETRY, 7]


SHARED = {
    "seq": codec.SEQ, "count": codec.COUNT, "flags": codec.FLAGS, "pwm": codec.PWM,
    "rx_errors": codec.RX_ERRORS, "generation": codec.GENERATION,
}  # fmt: skip
OWN = {
    Sample: {"answered": codec.ANSWERED, "stale": codec.STALE, "received": codec.RECEIVED,
             "refusal": codec.REFUSAL},
    Telemetry: {"velocity": codec.VELOCITY, "asked": codec.ASKED, "overruns": codec.OVERRUNS,
                "state_at": codec.STATE_AT, "state": codec.STATE},
}  # fmt: skip


@given(st.lists(messages_of(Sample) | messages_of(Telemetry), max_size=10), st.integers(1, 60))
def test_rows_agree_with_the_plain_codec(messages, cut):
    rows = Reader()(stream(*messages), cut)
    assert len(rows) == len(messages)
    for row, message in zip(rows, messages, strict=True):
        for name, column in (SHARED | OWN[type(message)]).items():
            assert row[column] == getattr(message, name), name
        for column in OWN[Telemetry if isinstance(message, Sample) else Sample].values():
            assert row[column] == (message.seq if column == codec.ANSWERED else 0)
        assert row[codec.DELAY] == pytest.approx(message.delay_us * 1e-6)
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
def test_it_agrees_with_the_plain_codec_on_any_bytes(parts, cut):
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


def test_lost_samples_are_counted_across_overflow():
    reader = Reader()
    rows = reader(stream(sample(65533), sample(65534), sample(1), sample(2), sample(12)))
    assert rows[:, codec.LOST].tolist() == [0, 0, 2, 0, 9]
    assert reader.state[codec.LOST_FRAMES] == 11
    rows = reader(stream(*map(telemetry, (65532, 0, 8)), sample(500)))
    assert rows[:, codec.LOST].tolist() == [0, 3, 7, 0]
    assert rows[:, codec.KIND].tolist() == [codec.TELEMETRY] * 3 + [codec.SAMPLE]
    assert reader.state[codec.LOST_FRAMES] == 11


def test_time_is_unwrapped():
    start = 2**32 - 1500
    times = [start + 1000 * k for k in range(4)]
    rows = Reader()(stream(*(sample(k, t) for k, t in enumerate(times))))
    np.testing.assert_allclose(rows[:, codec.BOARD_TIME], np.array(times) * 1e-6, rtol=0, atol=1e-9)


def test_rows_beyond_the_output_are_skipped_and_counted():
    state, buffer = codec.new_reader()
    # the copy is writable, like the loop's array
    data = np.frombuffer(stream(*(sample(k) for k in range(5))), np.uint8).copy()
    out = np.full((2, codec.SAMPLE_WIDTH), np.nan)
    assert codec.feed(state, buffer, data, len(data), out) == 2
    assert state[codec.SKIPPED] == 3
    assert out[:, codec.SEQ].tolist() == [0, 1]


# --- frames to the board
def encoded(encoder, *arguments):
    out = np.full(law_frames.ROOM, 0x99, np.uint8)
    return bytes(out[: encoder(out, *arguments)])


@given(st.integers(0, 65535), st.integers(0, 255), st.floats(width=32))
def test_a_force_is_encoded_as_by_the_plain_codec(seq, behind, force):
    frame = encoded(codec.encode_force, seq, behind, force)
    if force == force:
        assert frame == encode(Force(seq, behind, force))
    else:
        [decoded] = Decoder().feed(frame)
        assert (decoded.seq, decoded.behind) == (seq, behind)
        assert decoded.force != decoded.force


@pytest.mark.parametrize("message", [Stop(), Release(), Alive(), Leave(), HelloRequest()])
def test_messages_without_fields_are_encoded_as_by_the_plain_codec(message):
    assert encoded(codec.encode_simple, message.ID) == encode(message)


@given(messages_of(Law))
def test_a_law_is_encoded_as_by_the_plain_codec(law):
    assert encoded(law_frames.encode_law, *vars(law).values()) == encode(law)


@pytest.mark.slow
@given(st.binary(min_size=1, max_size=300), st.integers(0, 255), st.data())
def test_pieces_are_encoded_as_by_the_plain_codec(program, generation, data):
    words = law_frames.packed(program, 38)  # the last piece may extend beyond these 38 words
    at = data.draw(st.integers(0, len(program) - 1))
    taken = program[at : at + PIECE].ljust(PIECE, b"\0")
    assert encoded(law_frames.encode_piece, generation, at, words) == encode(
        Piece(generation, at, tuple(taken))
    )


finite = st.floats(width=32, allow_nan=False, allow_infinity=False)


@given(st.integers(0, 255), st.integers(0, 255), st.lists(finite, min_size=1, max_size=TUNED))
def test_a_change_of_constants_is_encoded_as_by_the_plain_codec(law, generation, values):
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
def test_settings_with_a_new_zero_are_encoded_as_by_the_plain_codec(board, zero, sense):
    body = np.frombuffer(board.pack(), np.uint8).copy()
    assert len(body) == law_frames.BOARD_BODY
    assert codec.signed(body, law_frames.AT_ZERO, 4) == board.zero
    law_frames.put_integer(body, law_frames.AT_ZERO, 4, zero)
    law_frames.put_integer(body, law_frames.AT_SENSE, 1, sense)
    wanted = Board(**{**vars(board), "zero": zero, "sense": sense})
    assert encoded(law_frames.encode_body, body) == encode(wanted)


LONGEST = (Board, Alive), (Piece, Piece, Piece, Alive), (Law, Force, Alive), (Tune, Alive)


@pytest.mark.parametrize("kinds", LONGEST)
def test_the_longest_reply_fits_the_buffer(kinds):
    whole = (frame(bytes([kind.ID]) + b"\1" * kind.size()) for kind in kinds)
    assert len(b"".join(whole)) + codec.FRAME_SIZE <= law_frames.ROOM


@pytest.mark.slow
def test_results_are_the_same_without_compilation():
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
    command = [sys.executable, "-c", program]
    results = {
        subprocess.run(
            command, env=os.environ | {"NUMBA_DISABLE_JIT": flag}, capture_output=True, text=True, check=True
        ).stdout
        for flag in "01"
    }
    assert len(results) == 1
    assert results.pop().startswith("1 [5.0, 7e-06, -9.0, 4.0, 0.0003, 1.0, -2.0, 0.0, 0.0, 0.0")
