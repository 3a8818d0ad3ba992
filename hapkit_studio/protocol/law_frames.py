"""Compiled frames for a board that renders by itself: what to render, how fast, that someone is there."""

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.protocol import codec
from hapkit_studio.protocol.fields import signed
from hapkit_studio.protocol.framing import CRC_SIZE
from hapkit_studio.protocol.messages import NO_LAW, VALUES, Alive, Board, HelloRequest, Loop, Scene

__all__ = ["ALIVE", "HELLO_REQUEST", "NO_LAW", "ROOM", "VALUES", "signed"]

ALIVE = Alive.ID
HELLO_REQUEST = HelloRequest.ID

ROOM = 3 * (CRC_SIZE + 3) + Board.size() + 2 * Scene.size() + 2 * codec.FRAME_SIZE
"""Bytes that one answer takes at most: settings, loop and scene, a stop, one word more."""

BOARD_BODY = 1 + Board.size()
AT_ZERO = Board.offset("zero")
AT_SENSE = Board.offset("sense")
AT_DIRECTION = Board.offset("direction")
_LOOP_ID, _LOOP_BODY = Loop.ID, 1 + Loop.size()
_SCENE_ID, _SCENE_BODY = Scene.ID, 1 + Scene.size()
_LOOP_FIRST, _LOOP_SECOND = Loop.offset("first"), Loop.offset("second")
_SCENE_VALUES = Scene.offset("values")


@compiled
def put_signed(body, at, size, value):
    """Write a whole number as so many bytes at a place of a body."""
    for i in range(size):
        body[at + i] = (value >> (8 * i)) & 0xFF


@compiled
def encode_scene(out, law, generation, values):
    """Write the frame of Scene to out; return its length. values: (VALUES,) or more, the first count."""
    out[1] = _SCENE_ID
    out[2] = law
    out[3] = generation & 0xFF
    for i in range(VALUES):
        codec.put_float(out, 1 + _SCENE_VALUES + 4 * i, values[i])
    return codec.enclose(out, _SCENE_BODY)


@compiled
def encode_loop(out, rate, estimator, first, second):
    """Write the frame of Loop to out; return its length."""
    out[1] = _LOOP_ID
    put_signed(out, 2, 2, rate)
    out[4] = estimator
    codec.put_float(out, 1 + _LOOP_FIRST, first)
    codec.put_float(out, 1 + _LOOP_SECOND, second)
    return codec.enclose(out, _LOOP_BODY)


@compiled
def encode_body(out, body):
    """Write the frame of a message's id and payload, (n,) bytes, to out; return its length."""
    for i in range(body.size):
        out[1 + i] = body[i]
    return codec.enclose(out, body.size)
