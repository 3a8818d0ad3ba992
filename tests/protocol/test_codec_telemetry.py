"""What a board says that renders by itself, and what it is told: the compiled codec against the plain one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hapkit_studio.protocol import codec, law_frames
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import (
    PIECE,
    TUNED,
    Alive,
    Board,
    Force,
    HelloRequest,
    Law,
    Leave,
    Piece,
    Sample,
    Settings,
    Telemetry,
    Tune,
)
from tests.protocol.strategies import messages_of

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
