"""Write first inputs for the fuzzer: every message to the board, as body and as line; laws and kits."""

import argparse
from pathlib import Path

import numpy as np

from hapkit_studio import environments
from hapkit_studio.devices import profiles
from hapkit_studio.environments.base import Environment
from hapkit_studio.protocol.declare import Message
from hapkit_studio.protocol.framing import frame
from hapkit_studio.protocol.messages import MESSAGES, VALUES, Estimator, Force, Loop, Save, Scene

FRAMED = 0x80


def inputs() -> dict[str, bytes]:
    """Return file names and contents; see the head of target.cpp for the form."""
    rng, found = np.random.default_rng(5), {}
    stream_on = b"\x03\x05\x01\x00"
    for kind in (m for m in MESSAGES if not m.from_board()):
        body = bytes([kind.ID]) + rng.bytes(kind.size())
        found[f"framed-{kind.__name__}"] = bytes([FRAMED]) + stream_on + bytes([len(body)]) + body
        found[f"line-{kind.__name__}"] = b"\x0c" + frame(b"\x05\x01\x00") + frame(body)
    for law, key in enumerate(environments.discover()):
        scene = _scene(law, environments.named(key)).pack()
        found[f"scene-{key}"] = bytes([FRAMED]) + stream_on + (bytes([len(scene)]) + scene + b"\x01\x09") * 2
    for kit in profiles.KITS:
        found[f"kit-{kit.key}"] = bytes([FRAMED]) + stream_on + _bodies(kit.board, Force(1, -9.0), Save())
    for kind in Estimator:
        loop, wall = Loop(2000, kind, 0.35, 120.0), _scene(2, environments.named("wall"))
        kit = profiles.named("hapkit-encoder").board  # the one that believes every reading
        found[f"loop-{kind.name.lower()}"] = bytes([FRAMED]) + stream_on + _bodies(kit, loop, wall)
    return found


def _bodies(*messages: Message) -> bytes:
    """Return messages as the fuzzer's framed inputs have them, each after its length."""
    bodies = [message.pack() for message in messages]
    return b"".join(bytes([len(body)]) + body for body in bodies)


def _scene(law: int, environment: Environment) -> Scene:
    """Return a scene with the usual numbers, in the order of the board's laws."""
    numbers = [float(environment.values()[p.key]) for p in environment.parameters]
    return Scene(law, 1, tuple(numbers + [0.0] * (VALUES - len(numbers))))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    for name, data in inputs().items():
        (folder / name).write_bytes(data)


if __name__ == "__main__":
    main()
