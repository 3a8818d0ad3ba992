"""Compiled frames for the real-time loop: received bytes to rows, forces to bytes, without allocation.

A reader is two arrays, zero at the start: ``state`` (int64, STATE_WIDTH) and ``buffer`` (uint8, BUFFER_SIZE).
"""

import numpy as np

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.protocol.framing import CRC_SIZE, CRC_START
from hapkit_studio.protocol.messages import BoardFlag, Force, Release, Sample, Settings, Stop, Telemetry

# Columns of a decoded row: those of a sample, then what only telemetry has.
SEQ, BOARD_TIME, COUNT, ANSWERED, DELAY, FLAGS, PWM, LOST, RX_ERRORS = range(9)
KIND, GENERATION, STALE, RECEIVED, REFUSAL = range(9, 14)
VELOCITY, ASKED, OVERRUNS, STATE_AT, STATE = range(14, 19)
SAMPLE_WIDTH = 19

# What a row came from. LOST counts samples in the one, ticks not shown in the other.
SAMPLE, TELEMETRY = 0, 1

US = 1e-6

SAMPLE_ID = Sample.ID
SAMPLE_BODY = 1 + Sample.size()
TELEMETRY_ID = Telemetry.ID
TELEMETRY_BODY = 1 + Telemetry.size()
AT_SEQ = Sample.offset("seq")
assert Telemetry.offset("seq") == AT_SEQ
_AT_TIME = Sample.offset("time_us")
_AT_COUNT = Sample.offset("count")
_AT_ANSWERED = Sample.offset("answered")
_AT_DELAY = Sample.offset("delay_us")
_AT_FLAGS = Sample.offset("flags")
_AT_PWM = Sample.offset("pwm")
_AT_RX_ERRORS = Sample.offset("rx_errors")
_AT_STALE = Sample.offset("stale")
_AT_GENERATION = Sample.offset("generation")
_AT_RECEIVED = Sample.offset("received")
_AT_REFUSAL = Sample.offset("refusal")
_T_TIME = Telemetry.offset("time_us")
_T_COUNT = Telemetry.offset("count")
_T_VELOCITY = Telemetry.offset("velocity")
_T_ASKED = Telemetry.offset("asked")
_T_PWM = Telemetry.offset("pwm")
_T_DELAY = Telemetry.offset("delay_us")
_T_FLAGS = Telemetry.offset("flags")
_T_RX_ERRORS = Telemetry.offset("rx_errors")
_T_OVERRUNS = Telemetry.offset("overruns")
_T_GENERATION = Telemetry.offset("generation")
_T_STATE_AT = Telemetry.offset("state_at")
_T_STATE = Telemetry.offset("state")


@compiled
def unsigned(buffer: np.ndarray, at: int, size: int) -> int:
    """Return the whole number of so many bytes at a place."""
    value = 0
    for i in range(size):
        value |= int(buffer[at + i]) << (8 * i)
    return value


@compiled
def signed(buffer: np.ndarray, at: int, size: int) -> int:
    """Return the whole number with a sign of so many bytes at a place."""
    value = unsigned(buffer, at, size)
    half = 1 << (8 * size - 1)
    return value - 2 * half if value >= half else value


@compiled
def float_at(buffer: np.ndarray, at: int) -> float:
    """Return the 32-bit number at a place."""
    return float(np.uint32(unsigned(buffer, at, 4)).view(np.float32))


@compiled
def number(buffer: np.ndarray) -> int:
    """Return the number of a sample, or of the tick that telemetry shows."""
    return unsigned(buffer, AT_SEQ, 2)


@compiled
def time_us(buffer: np.ndarray, kind: int) -> int:
    """Return the board's clock in µs, of 32 bits."""
    return unsigned(buffer, _AT_TIME if kind == SAMPLE else _T_TIME, 4)


@compiled
def read_sample(buffer: np.ndarray, row: np.ndarray) -> None:
    """Fill a row but for time and losses."""
    row[SEQ] = number(buffer)
    row[KIND] = SAMPLE
    row[COUNT] = signed(buffer, _AT_COUNT, 4)
    row[ANSWERED] = unsigned(buffer, _AT_ANSWERED, 2)
    row[DELAY] = unsigned(buffer, _AT_DELAY, 2) * US
    row[FLAGS] = buffer[_AT_FLAGS]
    row[PWM] = signed(buffer, _AT_PWM, 2)
    row[RX_ERRORS] = buffer[_AT_RX_ERRORS]
    row[GENERATION] = buffer[_AT_GENERATION]
    row[STALE] = buffer[_AT_STALE]
    row[RECEIVED] = unsigned(buffer, _AT_RECEIVED, 2)
    row[REFUSAL] = buffer[_AT_REFUSAL]
    row[VELOCITY:] = 0.0


@compiled
def read_telemetry(buffer: np.ndarray, row: np.ndarray) -> None:
    """Fill a row but for time and losses."""
    row[SEQ] = row[ANSWERED] = number(buffer)
    row[KIND] = TELEMETRY
    row[COUNT] = signed(buffer, _T_COUNT, 4)
    row[DELAY] = unsigned(buffer, _T_DELAY, 2) * US
    row[FLAGS] = buffer[_T_FLAGS]
    row[PWM] = signed(buffer, _T_PWM, 2)
    row[RX_ERRORS] = buffer[_T_RX_ERRORS]
    row[VELOCITY] = float_at(buffer, _T_VELOCITY)
    row[ASKED] = float_at(buffer, _T_ASKED)
    row[OVERRUNS] = buffer[_T_OVERRUNS]
    row[GENERATION] = buffer[_T_GENERATION]
    row[STALE] = row[RECEIVED] = row[REFUSAL] = 0.0
    row[STATE_AT] = buffer[_T_STATE_AT]
    row[STATE] = float_at(buffer, _T_STATE)


__all__ = ["ANSWERED", "ASKED", "BOARD_TIME", "COUNT", "DELAY", "FLAGS", "GENERATION", "KIND", "LOST"]
__all__ += ["OVERRUNS", "PWM", "RECEIVED", "REFUSAL", "RX_ERRORS", "SAMPLE", "SAMPLE_WIDTH", "SEQ", "STALE"]
__all__ += ["STATE", "STATE_AT", "TELEMETRY", "VELOCITY"]
__all__ += ["crc_update", "encode_force", "encode_simple", "feed", "new_reader"]

# Places in the state: counters for everybody, then the reader's own.
FRAMES, BAD_FRAMES, OTHER_FRAMES, LOST_FRAMES, SKIPPED = range(5)
_SIZE, _LEFT, _ZERO_DUE, _CRC, _STARTED, _LAST_SEQ, _LAST_TIME, _EPOCH = range(5, 13)
SETTINGS_FRAMES = 13  # counted among the other frames as well
_LAST_KIND = 14
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
FLAG_OVER_SPEED = int(BoardFlag.OVER_SPEED)
FLAG_SENSOR = int(BoardFlag.SENSOR)

STOP = Stop.ID
RELEASE = Release.ID

_SETTINGS_ID = Settings.ID
_SETTINGS_BODY = 1 + Settings.size()
_FORCE_ID, _FORCE_BODY = Force.ID, 1 + Force.size()
_FORCE_BEHIND, _FORCE_FORCE = Force.offset("behind"), Force.offset("force")
_COBS_FULL = 0xFF


def new_reader() -> tuple[np.ndarray, np.ndarray]:
    """Return state and buffer of a reader that has seen nothing."""
    return np.zeros(STATE_WIDTH, np.int64), np.zeros(BUFFER_SIZE, np.uint8)


def rows_for(size: int) -> int:
    """Return how many rows a chunk of size bytes can complete at most."""
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
def _lost_before(state, seq, kind):
    """Return how many numbers are missing since the last row; none where it was of the other kind.

    Of telemetry that is no count of frames: how many ticks lie between two, the rate says.
    """
    follows = state[FRAMES] > 0 and state[_LAST_KIND] == kind
    lost = (seq - state[_LAST_SEQ] - 1) & 0xFFFF if follows else 0
    state[_LAST_SEQ], state[_LAST_KIND] = seq, kind
    return lost


@compiled
def _unwrapped(state, time_us):
    """Return the board's time in s, continued where its 32 bits of microseconds overflow."""
    if time_us < state[_LAST_TIME]:
        state[_EPOCH] += 1 << 32
    state[_LAST_TIME] = time_us
    return (state[_EPOCH] + time_us) * US


@compiled
def _kind(state, buffer):
    """Return what row a whole frame makes, -1 for none; count the others."""
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
    """End a frame at its delimiter; return 1 if it made a row and out had room for it."""
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
    lost = _lost_before(state, number(buffer), kind)
    if kind == SAMPLE:
        read_sample(buffer, row)
        state[LOST_FRAMES] += lost
    else:
        read_telemetry(buffer, row)
    row[LOST] = lost
    row[BOARD_TIME] = _unwrapped(state, time_us(buffer, kind))
    state[FRAMES] += 1
    return 1


@compiled
def feed(state: np.ndarray, buffer: np.ndarray, data: np.ndarray, n: int, out: np.ndarray) -> int:
    """Decode the first n received bytes; return the number of rows of out that were filled.

    out: float64 (rows, SAMPLE_WIDTH), one row per valid Sample or Telemetry in SI units, with rows >=
    rows_for(n).
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
def put_float(out: np.ndarray, at: int, value: float) -> None:
    """Write a number as four bytes at a place."""
    bits = int(np.float32(value).view(np.uint32))
    for i in range(4):
        out[at + i] = (bits >> (8 * i)) & 0xFF


@compiled
def encode_force(out: np.ndarray, seq: int, behind: int, force: float) -> int:
    """Write the frame of Force to out (uint8, FRAME_SIZE); return its length."""
    out[1] = _FORCE_ID
    out[2] = seq & 0xFF
    out[3] = (seq >> 8) & 0xFF
    out[1 + _FORCE_BEHIND] = behind
    put_float(out, 1 + _FORCE_FORCE, force)
    return enclose(out, _FORCE_BODY)


@compiled
def encode_simple(out: np.ndarray, message_id: int) -> int:
    """Write the frame of a message without fields, STOP or RELEASE, to out; return its length."""
    out[1] = message_id
    return enclose(out, 1)
