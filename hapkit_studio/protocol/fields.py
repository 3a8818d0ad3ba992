"""Where the numbers of samples and telemetry stand in a body and in the decoded row; compiled."""

import numpy as np

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.protocol.messages import Sample, Telemetry

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
def unsigned(buffer, at, size):
    """Return the whole number of so many bytes at a place."""
    value = 0
    for i in range(size):
        value |= int(buffer[at + i]) << (8 * i)
    return value


@compiled
def signed(buffer, at, size):
    """Return the whole number with a sign of so many bytes at a place."""
    value = unsigned(buffer, at, size)
    half = 1 << (8 * size - 1)
    return value - 2 * half if value >= half else value


@compiled
def float_at(buffer, at):
    """Return the 32-bit number at a place."""
    return float(np.uint32(unsigned(buffer, at, 4)).view(np.float32))


@compiled
def number(buffer):
    """Return the number of a sample, or of the tick that telemetry shows."""
    return unsigned(buffer, AT_SEQ, 2)


@compiled
def time_us(buffer, kind):
    """Return the board's clock in µs, of 32 bits."""
    return unsigned(buffer, _AT_TIME if kind == SAMPLE else _T_TIME, 4)


@compiled
def read_sample(buffer, row):
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
def read_telemetry(buffer, row):
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
