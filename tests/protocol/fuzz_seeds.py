"""Initial inputs of the fuzzers: every message to the board (as body and line), laws, kits, and code."""

import argparse
import struct
from pathlib import Path

import numpy as np

from hapkit_studio.devices import profiles
from hapkit_studio.laws.machine import MOST_CALLS
from hapkit_studio.protocol.framing import crc16, frame
from hapkit_studio.protocol.messages import (
    MESSAGES,
    PIECE,
    Estimator,
    Force,
    Law,
    Leave,
    Message,
    Piece,
    Save,
    Tune,
)
from tests.laws.random_code import RandomCode, code, random_code

FRAMED = 0x80
LONGEST = 200
SPRING = RandomCode(0, (-300.0,), 3, code("MAIN", "MULTIPLY", 2, "RETURN"))


def inputs() -> dict[str, bytes]:
    """Return file names and contents; the head of target.cpp describes their form."""
    rng, found = np.random.default_rng(5), {}
    stream_on = b"\x03\x05\x01\x00"
    for kind in (m for m in MESSAGES if not m.from_board()):
        body = bytes([kind.ID]) + rng.bytes(kind.size())
        found[f"framed-{kind.__name__}"] = bytes([FRAMED]) + stream_on + bytes([len(body)]) + body
        found[f"line-{kind.__name__}"] = b"\x0c" + frame(b"\x05\x01\x00") + frame(body)
    laws = [SPRING, *(random_code(rng) for _ in range(200))]
    for k, law in enumerate(law for law in laws if len(law.code) + 4 * len(law.given) <= 3 * PIECE):
        sent = _bodies(*_messages(law)) + b"\x01\x09" * 2
        found[f"law-{k}"] = bytes([FRAMED]) + stream_on + sent
    for kit in profiles.KITS:
        found[f"kit-{kit.key}"] = bytes([FRAMED]) + stream_on + _bodies(kit.board, Force(1, 0, -9.0), Save())
    for kind in Estimator:
        kit = profiles.named("hapkit-encoder").board  # the sensor of this kit accepts every reading
        loop = _messages(SPRING, kind, 0.35, 120.0)
        found[f"estimator-{kind.name.lower()}"] = bytes([FRAMED]) + stream_on + _bodies(kit, *loop)
    tune = Tune(1, 2, 1, (2, 0, 0, 0, 0, 0), (-500.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    found["tune"] = bytes([FRAMED]) + stream_on + _bodies(*_messages(SPRING), tune, Leave())
    return {name: data for name, data in found.items() if len(data) <= LONGEST}


def machine_inputs() -> dict[str, bytes]:
    """Return code, most of which is valid; the head of machine_target.cpp describes its form."""
    rng, found = np.random.default_rng(6), {}
    for k in range(800):
        law = random_code(rng, wild=0.2)
        given = len(law.given)
        shape = bytes([law.states, given - law.states, law.slots - 2 - given])
        data = shape + rng.bytes(given) + law.code
        if len(data) <= LONGEST:
            found[f"code-{k}"] = data
    chain = code("SUBROUTINE", "RETURN", *(("SUBROUTINE", "CALL", 0, 0, "RETURN")))
    for depth in range(1, MOST_CALLS + 2):
        chain += code("SUBROUTINE", "CALL", 2 + 5 * (depth - 1), 0, "RETURN")
        main = code("MAIN", "CALL", 2 + 5 * depth, 0, "RETURN")
        found[f"chain-{depth}"] = bytes(3) + chain + main
    return found


def _messages(law: RandomCode, estimator=Estimator.DIFFERENCE, first=0.0, second=0.0) -> list[Message]:
    """Return the messages that send a law."""
    data = struct.pack(f"<{len(law.given)}f", *law.given) + law.code
    shape = (law.states, len(law.given), law.slots, len(law.code), crc16(data))
    pieces = [data[at : at + PIECE].ljust(PIECE, b"\0") for at in range(0, len(data), PIECE)]
    head = Law(1, 1000, estimator, first, second, *shape)
    return [head, *(Piece(1, PIECE * k, tuple(piece)) for k, piece in enumerate(pieces))]


def _bodies(*messages: Message) -> bytes:
    """Return messages in the form of the fuzzer's framed inputs, each after its length."""
    bodies = [message.pack() for message in messages]
    return b"".join(bytes([len(body)]) + body for body in bodies)


def write(inputs_of: dict[str, bytes], folder: Path) -> None:
    """Write inputs as files."""
    for name, data in inputs_of.items():
        (folder / name).write_bytes(data)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    write(inputs(), parser.parse_args().folder)


if __name__ == "__main__":
    main()
