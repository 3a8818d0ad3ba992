"""Compiled frames for the real-time loop: received bytes to rows, forces to bytes, without allocation.

A reader is two arrays, zero at the start: ``state`` (int64, STATE_WIDTH) and ``buffer`` (uint8, BUFFER_SIZE).
"""

import numpy as np

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.protocol.framing import CRC_SIZE, CRC_START
from hapkit_studio.protocol.messages import BoardFlag, Force, Release, Sample, Stop

# Columns of a decoded sample.
SEQ, BOARD_TIME, COUNT, ANSWERED, DELAY, FLAGS, PWM, LOST, RX_ERRORS = range(9)
SAMPLE_WIDTH = 9

# Places in the state: counters for everybody, then the reader's own.
FRAMES, BAD_FRAMES, OTHER_FRAMES, LOST_FRAMES, SKIPPED = range(5)
_SIZE, _LEFT, _ZERO_DUE, _CRC, _STARTED, _LAST_SEQ, _LAST_TIME, _EPOCH = range(5, 13)
STATE_WIDTH = 16

BUFFER_SIZE = 64
"""Bytes of the longest body that is kept; longer frames are only checked."""

FRAME_SIZE = 1 + Force.size() + CRC_SIZE + 2
"""Bytes that an encoded command takes at most."""

FLAG_WATCHDOG = int(BoardFlag.WATCHDOG)
FLAG_STOPPED = int(BoardFlag.STOPPED)
FLAG_CLAMPED = int(BoardFlag.CLAMPED)
FLAG_OVERRUN = int(BoardFlag.OVERRUN)
FLAG_REFUSED = int(BoardFlag.REFUSED)

STOP = Stop.ID
RELEASE = Release.ID

_SAMPLE_ID = Sample.ID
_SAMPLE_BODY = 1 + Sample.size()
_AT_SEQ = Sample.offset("seq")
_AT_TIME = Sample.offset("time_us")
_AT_COUNT = Sample.offset("count")
_AT_ANSWERED = Sample.offset("answered")
_AT_DELAY = Sample.offset("delay_us")
_AT_FLAGS = Sample.offset("flags")
_AT_PWM = Sample.offset("pwm")
_AT_RX_ERRORS = Sample.offset("rx_errors")
_FORCE_ID = Force.ID
_COBS_FULL = 0xFF
_US = 1e-6


def new_reader() -> tuple[np.ndarray, np.ndarray]:
    """Return state and buffer of a reader that has seen nothing."""
    return np.zeros(STATE_WIDTH, np.int64), np.zeros(BUFFER_SIZE, np.uint8)


def rows_for(size: int) -> int:
    """Return how many samples a chunk of size bytes can complete at most."""
    return size // (_SAMPLE_BODY + CRC_SIZE + 2) + 1


@compiled
def crc_update(crc, byte):
    """Return the CRC-16/CCITT-FALSE after one more byte."""
    mix = ((crc >> 8) ^ byte) & 0xFF
    mix ^= mix >> 4
    return ((crc << 8) ^ (mix << 12) ^ (mix << 5) ^ mix) & 0xFFFF


@compiled
def _unsigned(buffer, at, size):
    value = 0
    for i in range(size):
        value |= int(buffer[at + i]) << (8 * i)
    return value


@compiled
def _signed(buffer, at, size):
    value = _unsigned(buffer, at, size)
    half = 1 << (8 * size - 1)
    return value - 2 * half if value >= half else value


@compiled
def _store(state, buffer, byte):
    size = state[_SIZE]
    if size < buffer.shape[0]:
        buffer[size] = byte
    state[_SIZE] = size + 1
    state[_CRC] = crc_update(state[_CRC], byte)


@compiled
def _begin(state):
    state[_SIZE] = 0
    state[_LEFT] = 0
    state[_ZERO_DUE] = 0
    state[_STARTED] = 0
    state[_CRC] = CRC_START


@compiled
def _push(state, buffer, byte):
    """Take a byte that is not the delimiter."""
    if state[_STARTED] == 0:
        _begin(state)
        state[_STARTED] = 1
    if state[_LEFT] == 0:
        if state[_ZERO_DUE]:
            _store(state, buffer, 0)
        state[_LEFT] = byte - 1
        state[_ZERO_DUE] = byte != _COBS_FULL
    else:
        state[_LEFT] -= 1
        _store(state, buffer, byte)


@compiled
def _lost_before(state, seq):
    """Return how many samples are missing since the last one."""
    lost = (seq - state[_LAST_SEQ] - 1) & 0xFFFF if state[FRAMES] > 0 else 0
    state[_LAST_SEQ] = seq
    state[LOST_FRAMES] += lost
    return lost


@compiled
def _unwrapped(state, time_us):
    """Return the board's time in s, continued where its 32 bits of microseconds overflow."""
    if time_us < state[_LAST_TIME]:
        state[_EPOCH] += 1 << 32
    state[_LAST_TIME] = time_us
    return (state[_EPOCH] + time_us) * _US


@compiled
def _read_sample(state, buffer, row):
    seq = _unsigned(buffer, _AT_SEQ, 2)
    row[SEQ] = seq
    row[LOST] = _lost_before(state, seq)
    row[BOARD_TIME] = _unwrapped(state, _unsigned(buffer, _AT_TIME, 4))
    row[COUNT] = _signed(buffer, _AT_COUNT, 4)
    row[ANSWERED] = _unsigned(buffer, _AT_ANSWERED, 2)
    row[DELAY] = _unsigned(buffer, _AT_DELAY, 2) * _US
    row[FLAGS] = buffer[_AT_FLAGS]
    row[PWM] = _signed(buffer, _AT_PWM, 2)
    row[RX_ERRORS] = buffer[_AT_RX_ERRORS]
    state[FRAMES] += 1


@compiled
def _finish(state, buffer, out, rows):
    """End a frame at its delimiter; return 1 if it was a sample and out had room for it."""
    started = state[_STARTED]
    state[_STARTED] = 0
    if started == 0:
        return 0
    if state[_LEFT] != 0 or state[_SIZE] <= CRC_SIZE or state[_CRC] != 0:
        state[BAD_FRAMES] += 1
        return 0
    if buffer[0] != _SAMPLE_ID or state[_SIZE] != _SAMPLE_BODY + CRC_SIZE:
        state[OTHER_FRAMES] += 1
        return 0
    if rows >= out.shape[0]:
        state[SKIPPED] += 1
        return 0
    _read_sample(state, buffer, out[rows])
    return 1


@compiled
def feed(state, buffer, data, n, out):
    """Decode the first n received bytes; return the number of rows of out that were filled.

    out: float64 (rows, SAMPLE_WIDTH), one row per valid Sample in SI units, with rows >= rows_for(n).
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
def _frame(out, size):
    """Turn the body at out[1 : 1 + size] into its frame in place; return the frame's length.

    COBS in place: every zero, and the byte before the body, becomes the distance to the next zero.
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
def encode_force(out, seq, force):
    """Write the frame of Force to out (uint8, FRAME_SIZE); return its length."""
    bits = int(np.float32(force).view(np.uint32))
    out[1] = _FORCE_ID
    out[2] = seq & 0xFF
    out[3] = (seq >> 8) & 0xFF
    for i in range(4):
        out[4 + i] = (bits >> (8 * i)) & 0xFF
    return _frame(out, 1 + 2 + 4)


@compiled
def encode_simple(out, message_id):
    """Write the frame of a message without fields, STOP or RELEASE, to out; return its length."""
    out[1] = message_id
    return _frame(out, 1)
