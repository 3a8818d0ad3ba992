"""A compiled codec for the real-time loop; it decodes rows and encodes forces without allocation.

A reader consists of two arrays that are initially zero: ``state`` (int64, STATE_WIDTH) and ``buffer`` (uint8,
BUFFER_SIZE).
"""

import numpy as np

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.protocol.framing import CRC_SIZE, CRC_START
from hapkit_studio.protocol.messages import (
    BoardFlag,
    Force,
    Message,
    Release,
    Sample,
    Settings,
    Stop,
    Telemetry,
)

# columns of a decoded row: first those of a sample, then those that only telemetry has
SEQ, BOARD_TIME, COUNT, ANSWERED, DELAY, FLAGS, PWM, LOST, RX_ERRORS = range(9)
KIND, GENERATION, STALE, RECEIVED, REFUSAL = range(9, 14)
VELOCITY, ASKED, OVERRUNS, STATE_AT, STATE = range(14, 19)
SAMPLE_WIDTH = 19

# kind of a row; LOST counts lost samples for SAMPLE, and ticks without a frame for TELEMETRY
SAMPLE, TELEMETRY = 0, 1

US = 1e-6

_COLUMNS = {
    "seq": SEQ, "count": COUNT, "answered": ANSWERED, "delay_us": DELAY, "flags": FLAGS, "pwm": PWM,
    "rx_errors": RX_ERRORS, "generation": GENERATION, "stale": STALE, "received": RECEIVED,
    "refusal": REFUSAL, "velocity": VELOCITY, "asked": ASKED, "overruns": OVERRUNS, "state_at": STATE_AT,
    "state": STATE,
}  # fmt: skip
"""Fields copied to a row unchanged; the time is unwrapped."""
_UNSIGNED, _SIGNED, _FLOAT = range(3)


def layout_of(kind: type[Message]) -> np.ndarray:
    """Return for each field of a message: column in a row or -1, offset from the id, size in bytes, kind."""
    kinds = {"f": _FLOAT, "b": _SIGNED, "h": _SIGNED, "i": _SIGNED}
    fields = [
        (_COLUMNS.get(w.name, -1), kind.offset(w.name), w.size, kinds.get(w.code, _UNSIGNED))
        for w in kind.layout()
    ]
    return np.array(fields, np.int64)


SAMPLE_ID, TELEMETRY_ID = Sample.ID, Telemetry.ID
SAMPLE_BODY, TELEMETRY_BODY = 1 + Sample.size(), 1 + Telemetry.size()
_SAMPLE, _TELEMETRY, _FORCE = map(layout_of, (Sample, Telemetry, Force))
_TIME = Sample.offset("time_us")
assert Telemetry.offset("time_us") == _TIME


@compiled
def unsigned(buffer: np.ndarray, at: int, size: int) -> int:
    """Return the unsigned integer of ``size`` bytes at an offset."""
    value = 0
    for i in range(size):
        value |= int(buffer[at + i]) << (8 * i)
    return value


@compiled
def signed(buffer: np.ndarray, at: int, size: int) -> int:
    """Return the signed integer of ``size`` bytes at an offset."""
    value = unsigned(buffer, at, size)
    half = 1 << (8 * size - 1)
    return value - 2 * half if value >= half else value


@compiled
def put_integer(out: np.ndarray, at: int, size: int, value: int) -> None:
    """Write an integer as ``size`` bytes at an offset."""
    for i in range(size):
        out[at + i] = (value >> (8 * i)) & 0xFF


@compiled
def _read(buffer, layout, row):
    """Fill the columns of a row, except the time and the number of losses."""
    row[:] = 0.0
    for i in range(layout.shape[0]):
        column, at, size, kind = layout[i, 0], layout[i, 1], layout[i, 2], layout[i, 3]
        if column < 0:
            continue
        if kind == _FLOAT:
            row[column] = float(np.uint32(unsigned(buffer, at, size)).view(np.float32))
        else:
            row[column] = signed(buffer, at, size) if kind == _SIGNED else unsigned(buffer, at, size)
    row[DELAY] *= US


@compiled
def put_fields(out: np.ndarray, message_id: int, layout: np.ndarray, values: tuple[float, ...]) -> int:
    """Write the id and the first fields of a message, given as floats, to out[1:]; return their length."""
    out[1] = message_id
    size = 1
    for i in range(len(values)):
        size = layout[i, 1] + layout[i, 2]
        value = values[i]
        bits = int(np.float32(value).view(np.uint32)) if layout[i, 3] == _FLOAT else int(value)
        put_integer(out, 1 + layout[i, 1], layout[i, 2], bits)
    return size


# layout of the state: public counters, then the reader's private values
FRAMES, BAD_FRAMES, OTHER_FRAMES, LOST_FRAMES, SKIPPED = range(5)
_SIZE, _LEFT, _ZERO_DUE, _CRC, _STARTED, _LAST_SEQ, _LAST_TIME, _TIME_US = range(5, 13)
SETTINGS_FRAMES = 13  # these frames are also counted in OTHER_FRAMES
_LAST_KIND = 14
STATE_WIDTH = 16

BUFFER_SIZE = 64
"""Size in bytes of the longest body that is stored; longer frames are only checked."""

FRAME_SIZE = 1 + Force.size() + CRC_SIZE + 2
"""Largest encoded command in bytes."""

FLAG_WATCHDOG = int(BoardFlag.WATCHDOG)
FLAG_STOPPED = int(BoardFlag.STOPPED)
FLAG_CLAMPED = int(BoardFlag.CLAMPED)
FLAG_REFUSED = int(BoardFlag.REFUSED)
FLAG_OVER_SPEED = int(BoardFlag.OVER_SPEED)
FLAG_SENSOR = int(BoardFlag.SENSOR)

STOP = Stop.ID
RELEASE = Release.ID

_SETTINGS_ID = Settings.ID
_SETTINGS_BODY = 1 + Settings.size()
_FORCE_ID = Force.ID
_COBS_FULL = 0xFF


def new_reader() -> tuple[np.ndarray, np.ndarray]:
    """Return state and buffer of a new reader."""
    return np.zeros(STATE_WIDTH, np.int64), np.zeros(BUFFER_SIZE, np.uint8)


def rows_for(size: int) -> int:
    """Return the largest number of rows that a chunk of ``size`` bytes can complete."""
    return size // (SAMPLE_BODY + CRC_SIZE + 2) + 1


@compiled
def crc_update(crc: int, byte: int) -> int:
    """Return the CRC-16/CCITT-FALSE after one more byte."""
    mix = ((crc >> 8) ^ byte) & 0xFF
    mix ^= mix >> 4
    return ((crc << 8) ^ (mix << 12) ^ (mix << 5) ^ mix) & 0xFFFF


@compiled
def _store(state, buffer, byte):
    size = state[_SIZE]
    if size < buffer.shape[0]:
        buffer[size] = byte
    state[_SIZE] = size + 1
    state[_CRC] = crc_update(state[_CRC], byte)


@compiled
def _push(state, buffer, byte):
    """Process a byte other than the delimiter."""
    if state[_STARTED] == 0:
        state[_SIZE] = state[_LEFT] = state[_ZERO_DUE] = 0
        state[_STARTED], state[_CRC] = 1, CRC_START
    if state[_LEFT] == 0:
        if state[_ZERO_DUE]:
            _store(state, buffer, 0)
        state[_LEFT] = byte - 1
        state[_ZERO_DUE] = byte != _COBS_FULL
    else:
        state[_LEFT] -= 1
        _store(state, buffer, byte)


@compiled
def _lost_before(state, seq, kind):
    """Return how many sequence numbers are missing since the last row; 0 after a row of the other kind.

    For telemetry, the result is not the number of lost frames, because the spacing of ticks depends on the
    rate.
    """
    follows = state[FRAMES] > 0 and state[_LAST_KIND] == kind
    lost = (seq - state[_LAST_SEQ] - 1) & 0xFFFF if follows else 0
    state[_LAST_SEQ], state[_LAST_KIND] = seq, kind
    return lost


@compiled
def _continued(state, time_us):
    """Return the board's unwrapped time in µs; the clock may also go back by up to half of its range."""
    passed = (time_us - state[_LAST_TIME]) & 0xFFFFFFFF
    if state[FRAMES] > 0 and passed >= 1 << 31:
        passed -= 1 << 32
    state[_LAST_TIME] = time_us
    state[_TIME_US] += passed
    return state[_TIME_US]


@compiled
def _kind(state, buffer):
    """Return the kind of the row that a complete frame contains.

    Count a frame without a row, and return -1.
    """
    size = state[_SIZE] - CRC_SIZE
    if buffer[0] == SAMPLE_ID and size == SAMPLE_BODY:
        return SAMPLE
    if buffer[0] == TELEMETRY_ID and size == TELEMETRY_BODY:
        return TELEMETRY
    state[OTHER_FRAMES] += 1
    if buffer[0] == _SETTINGS_ID and size == _SETTINGS_BODY:
        state[SETTINGS_FRAMES] += 1
    return -1


@compiled
def _finish(state, buffer, out, rows):
    """End a frame at its delimiter; return 1 if the frame gave a row and ``out`` had room for the row."""
    started = state[_STARTED]
    state[_STARTED] = 0
    if started == 0:
        return 0
    if state[_LEFT] != 0 or state[_SIZE] <= CRC_SIZE or state[_CRC] != 0:
        state[BAD_FRAMES] += 1
        return 0
    kind = _kind(state, buffer)
    if kind < 0:
        return 0
    if rows >= out.shape[0]:
        state[SKIPPED] += 1
        return 0
    row = out[rows]
    _read(buffer, _SAMPLE if kind == SAMPLE else _TELEMETRY, row)
    lost = _lost_before(state, int(row[SEQ]), kind)
    if kind == SAMPLE:
        state[LOST_FRAMES] += lost
    else:
        row[ANSWERED] = row[SEQ]
    row[KIND], row[LOST] = kind, lost
    row[BOARD_TIME] = _continued(state, unsigned(buffer, _TIME, 4)) * US
    state[FRAMES] += 1
    return 1


@compiled
def feed(state: np.ndarray, buffer: np.ndarray, data: np.ndarray, n: int, out: np.ndarray) -> int:
    """Decode the first n received bytes; return the number of rows filled.

    ``out`` is float64 (rows, SAMPLE_WIDTH), and rows is at least rows_for(n). Each valid Sample or Telemetry
    gives one row in SI units.
    """
    rows = 0
    for i in range(n):
        byte = int(data[i])
        if byte == 0:
            rows += _finish(state, buffer, out, rows)
        else:
            _push(state, buffer, byte)
    return rows


@compiled
def enclose(out: np.ndarray, size: int) -> int:
    """Frame the body at out[1 : 1 + size] in place; return the frame's length.

    COBS: every zero, and the byte before the body, is replaced by the distance to the next zero.
    """
    crc = CRC_START
    for i in range(1, size + 1):
        crc = crc_update(crc, int(out[i]))
    out[size + 1] = crc >> 8
    out[size + 2] = crc & 0xFF
    end = size + 1 + CRC_SIZE
    code = 0
    for i in range(1, end):
        if out[i] == 0:
            out[code] = i - code
            code = i
    out[code] = end - code
    out[end] = 0
    return end + 1


@compiled
def encode_force(out: np.ndarray, seq: int, behind: int, force: float) -> int:
    """Write the frame of Force to out (uint8, FRAME_SIZE); return its length."""
    return enclose(out, put_fields(out, _FORCE_ID, _FORCE, (float(seq), float(behind), float(force))))


@compiled
def encode_simple(out: np.ndarray, message_id: int) -> int:
    """Write the frame of a message without fields, e.g. STOP or RELEASE, to out; return its length."""
    out[1] = message_id
    return enclose(out, 1)
