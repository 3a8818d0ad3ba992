"""Compiled frames for a board that renders by itself: a law in pieces, its constants, that someone is there.

A law's bytes are packed into int64 words, little endian, as ``packed`` returns them.
"""

import numpy as np

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.protocol import codec
from hapkit_studio.protocol.codec import signed
from hapkit_studio.protocol.framing import CRC_SIZE
from hapkit_studio.protocol.messages import PIECE, TUNED, Alive, Board, HelloRequest, Law, Leave, Piece, Tune

__all__ = ["ALIVE", "HELLO_REQUEST", "LEAVE", "PIECE", "ROOM", "TUNED", "signed"]

ALIVE = Alive.ID
HELLO_REQUEST = HelloRequest.ID
LEAVE = Leave.ID

ROOM = Board.size() + 3 * (Piece.size() + CRC_SIZE + 3) + 2 * codec.FRAME_SIZE
"""Bytes that one answer takes at most: settings, or three pieces, a stop, one word more."""

BOARD_BODY = 1 + Board.size()
AT_ZERO = Board.offset("zero")
AT_SENSE = Board.offset("sense")
AT_DIRECTION = Board.offset("direction")
_LAW_ID, _LAW_BODY = Law.ID, 1 + Law.size()
_LAW_GENERATION, _LAW_RATE, _LAW_ESTIMATOR = (Law.offset(n) for n in ("generation", "rate", "estimator"))
_LAW_FIRST, _LAW_SECOND, _LAW_STATES = (Law.offset(n) for n in ("first", "second", "states"))
_LAW_GIVEN, _LAW_SLOTS, _LAW_CODE, _LAW_CHECK = (Law.offset(n) for n in ("given", "slots", "code", "check"))
_PIECE_ID, _PIECE_BODY = Piece.ID, 1 + Piece.size()
_PIECE_GENERATION, _PIECE_AT, _PIECE_DATA = (Piece.offset(n) for n in ("generation", "at", "data"))
_TUNE_ID, _TUNE_BODY = Tune.ID, 1 + Tune.size()
_TUNE_LAW, _TUNE_GENERATION, _TUNE_COUNT = (Tune.offset(n) for n in ("law", "generation", "count"))
_TUNE_SLOTS, _TUNE_VALUES = Tune.offset("slots"), Tune.offset("values")


def packed(data: bytes, words: int) -> np.ndarray:
    """Return bytes packed into so many int64 words, zeros behind them."""
    return np.frombuffer(data.ljust(8 * words, b"\0"), "<i8").astype(np.int64)


@compiled
def byte_of(words: np.ndarray, i: int) -> int:
    """Return the i-th of packed bytes."""
    return (words[i >> 3] >> (8 * (i & 7))) & 0xFF


@compiled
def constant_of(words: np.ndarray, i: int) -> int:
    """Return the bits of the i-th of packed float32 numbers."""
    return (words[i >> 1] >> (32 * (i & 1))) & 0xFFFFFFFF


@compiled
def put_constant(words: np.ndarray, i: int, bits: int) -> None:
    """Replace the bits of the i-th of packed float32 numbers."""
    shift = 32 * (i & 1)
    words[i >> 1] ^= (constant_of(words, i) ^ bits) << shift


@compiled
def put_whole(body: np.ndarray, at: int, size: int, value: int) -> None:
    """Write a whole number as so many bytes at a place of a body."""
    for i in range(size):
        body[at + i] = (value >> (8 * i)) & 0xFF


@compiled
def encode_law(
    out: np.ndarray,
    generation: int,
    rate: int,
    estimator: int,
    first: float,
    second: float,
    states: int,
    given: int,
    slots: int,
    code: int,
    check: int,
) -> int:
    """Write the frame of Law to out; return its length."""
    out[1] = _LAW_ID
    out[1 + _LAW_GENERATION] = generation
    put_whole(out, 1 + _LAW_RATE, 2, rate)
    out[1 + _LAW_ESTIMATOR] = estimator
    codec.put_float(out, 1 + _LAW_FIRST, first)
    codec.put_float(out, 1 + _LAW_SECOND, second)
    out[1 + _LAW_STATES] = states
    out[1 + _LAW_GIVEN] = given
    out[1 + _LAW_SLOTS] = slots
    put_whole(out, 1 + _LAW_CODE, 2, code)
    put_whole(out, 1 + _LAW_CHECK, 2, check)
    return codec.enclose(out, _LAW_BODY)


@compiled
def encode_piece(out: np.ndarray, generation: int, at: int, program: np.ndarray) -> int:
    """Write the frame of the Piece that begins with byte `at` of a packed law to out; return its length."""
    out[1] = _PIECE_ID
    out[1 + _PIECE_GENERATION] = generation
    put_whole(out, 1 + _PIECE_AT, 2, at)
    for i in range(PIECE):
        inside = at + i < 8 * program.size
        out[1 + _PIECE_DATA + i] = byte_of(program, at + i) if inside else 0
    return codec.enclose(out, _PIECE_BODY)


@compiled
def begin_tune(out: np.ndarray, law: int, generation: int) -> None:
    """Begin a Tune without a constant in out."""
    for i in range(1, 1 + _TUNE_BODY):
        out[i] = 0
    out[1] = _TUNE_ID
    out[1 + _TUNE_LAW] = law
    out[1 + _TUNE_GENERATION] = generation


@compiled
def add_constant(out: np.ndarray, slot: int, bits: int) -> int:
    """Add a constant to the Tune in out, TUNED at most; return how many it has."""
    k = out[1 + _TUNE_COUNT]
    out[1 + _TUNE_SLOTS + k] = slot
    put_whole(out, 1 + _TUNE_VALUES + 4 * k, 4, bits)
    out[1 + _TUNE_COUNT] = k + 1
    return k + 1


@compiled
def end_tune(out: np.ndarray) -> int:
    """Turn the Tune in out into its frame; return its length."""
    return codec.enclose(out, _TUNE_BODY)


@compiled
def encode_body(out: np.ndarray, body: np.ndarray) -> int:
    """Write the frame of a message's id and payload, (n,) bytes, to out; return its length."""
    for i in range(body.size):
        out[1 + i] = body[i]
    return codec.enclose(out, body.size)
