"""Compiled encoders of the frames for a board that renders: a law's pieces, constants and keep-alive.

The bytes of a law are packed into int64 words, little endian, as ``packed`` returns them.
"""

import numpy as np

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.protocol import codec
from hapkit_studio.protocol.codec import put_integer, signed
from hapkit_studio.protocol.framing import CRC_SIZE
from hapkit_studio.protocol.messages import PIECE, TUNED, Alive, Board, HelloRequest, Law, Leave, Piece, Tune

__all__ = ["ALIVE", "HELLO_REQUEST", "LEAVE", "PIECE", "ROOM", "TUNED", "put_integer", "signed"]

ALIVE = Alive.ID
HELLO_REQUEST = HelloRequest.ID
LEAVE = Leave.ID

ROOM = Board.size() + 3 * (Piece.size() + CRC_SIZE + 3) + 2 * codec.FRAME_SIZE
"""Size of the largest reply in bytes: settings, or three pieces, a stop and one more command."""

BOARD_BODY = 1 + Board.size()
AT_ZERO, AT_SENSE, AT_DIRECTION = (Board.offset(name) for name in ("zero", "sense", "direction"))
_LAW_ID, _LAW = Law.ID, codec.layout_of(Law)
_PIECE_ID, _PIECE, _PIECE_BODY = Piece.ID, codec.layout_of(Piece), 1 + Piece.size()
_TUNE_ID, _TUNE, _TUNE_BODY = Tune.ID, codec.layout_of(Tune), 1 + Tune.size()
_TUNE_COUNT, _TUNE_SLOTS, _TUNE_VALUES = (1 + Tune.offset(name) for name in ("count", "slots", "values"))


def packed(data: bytes, words: int) -> np.ndarray:
    """Return bytes packed into ``words`` int64 words, padded with zeros."""
    return np.frombuffer(data.ljust(8 * words, b"\0"), "<i8").astype(np.int64)


@compiled
def byte_of(words: np.ndarray, i: int) -> int:
    """Return the i-th packed byte."""
    return (words[i >> 3] >> (8 * (i & 7))) & 0xFF


@compiled
def constant_of(words: np.ndarray, i: int) -> int:
    """Return the bits of the i-th packed float32."""
    return (words[i >> 1] >> (32 * (i & 1))) & 0xFFFFFFFF


@compiled
def put_constant(words: np.ndarray, i: int, bits: int) -> None:
    """Replace the bits of the i-th packed float32."""
    shift = 32 * (i & 1)
    words[i >> 1] ^= (constant_of(words, i) ^ bits) << shift


@compiled
def encode_law(
    out: np.ndarray,
    generation: int,
    period: int,
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
    shape = (float(states), float(given), float(slots), float(code), float(check))
    head = (float(generation), float(period), float(estimator), float(first), float(second))
    return codec.enclose(out, codec.put_fields(out, _LAW_ID, _LAW, head + shape))


@compiled
def encode_piece(out: np.ndarray, generation: int, at: int, program: np.ndarray) -> int:
    """Write the frame of the Piece at byte ``at`` of a packed law to out; return its length."""
    size = codec.put_fields(out, _PIECE_ID, _PIECE, (float(generation), float(at)))
    for i in range(PIECE):
        inside = at + i < 8 * program.size
        out[1 + size + i] = byte_of(program, at + i) if inside else 0
    return codec.enclose(out, _PIECE_BODY)


@compiled
def begin_tune(out: np.ndarray, law: int, generation: int) -> None:
    """Write an empty Tune to out."""
    out[1 : 1 + _TUNE_BODY] = 0
    codec.put_fields(out, _TUNE_ID, _TUNE, (float(law), float(generation)))


@compiled
def add_constant(out: np.ndarray, slot: int, bits: int) -> int:
    """Add a constant to the Tune in out, up to TUNED constants; return their number."""
    k = out[_TUNE_COUNT]
    out[_TUNE_SLOTS + k] = slot
    put_integer(out, _TUNE_VALUES + 4 * k, 4, bits)
    out[_TUNE_COUNT] = k + 1
    return k + 1


@compiled
def end_tune(out: np.ndarray) -> int:
    """Frame the Tune in out; return its length."""
    return codec.enclose(out, _TUNE_BODY)


@compiled
def encode_body(out: np.ndarray, body: np.ndarray) -> int:
    """Write the frame of a message's id and payload, (n,) bytes, to out; return its length."""
    for i in range(body.size):
        out[1 + i] = body[i]
    return codec.enclose(out, body.size)
