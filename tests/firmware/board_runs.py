"""Runs of laws in the virtual board, in lockstep: code in, telemetry out, a word in now and then."""

import os
import select
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hapkit_studio.devices.virtual_board import VirtualBoard, truth
from hapkit_studio.environments.base import Environment
from hapkit_studio.haptics.board_rendering import ALIVE_APART
from hapkit_studio.laws import board as code
from hapkit_studio.laws.board import Program
from hapkit_studio.protocol.framing import DELIMITER, Decoder, crc16, encode
from hapkit_studio.protocol.messages import PIECE, Alive, Estimator, Law, Message, Piece, Sample, Telemetry
from tests.waiting import PATIENCE

FREQUENCY = 16e6
SETTLE = 0.05
"""s before the processor's share and skipped ticks are counted: the force has faded in."""
Filter = tuple[Estimator, float, float]
"""How the board estimates velocity, with the two coefficients of Law."""


class Refused(Exception):
    """The board does not run a law."""


@dataclass
class Rendering:
    """What a run told: telemetry, truth log, processor's share 0..1, skipped ticks, counters at the end."""

    telemetry: list[Telemetry]
    truth: np.recarray
    share: float
    skipped: int
    summary: dict


def usual(rate: int) -> Filter:
    """Return a velocity filter that may stand for any."""
    return Estimator.KALMAN, 0.35, 0.06 * rate


def program(environment: Environment, values: Mapping[str, float], rate: int, room: int) -> Program:
    """Return an environment's law as code for so many ticks a second and bytes of arena."""
    return code.compile(environment.force, values, 1.0 / rate, room)


def announced(law: Program, rate: int, filter: Filter, generation: int) -> Law:
    """Return the message that begins to send a law."""
    shape = (law.states, len(law.given), law.slots, len(law.code))
    return Law(generation, rate, *filter, *shape, crc16(law.data))


def piece(law: Program, generation: int, at: int) -> Piece:
    return Piece(generation, at, tuple(law.data[at : at + PIECE].ljust(PIECE, b"\0")))


def frames(board: VirtualBoard, decoder: Decoder) -> Iterator[Message]:
    """Yield what the board says for ever; fail where it falls silent."""
    while True:
        ready, _, _ = select.select([board.fileno()], [], [], PATIENCE)
        assert ready, "the board has gone silent"
        yield from decoder.feed(os.read(board.fileno(), 4096))


def send(
    board: VirtualBoard, law: Program, rate: int, filter: Filter | None = None, generation: int = 1
) -> None:
    """Send a law, a piece a sample, until the board renders it; raise Refused."""
    os.write(board.fileno(), encode(announced(law, rate, filter or usual(rate), generation)))
    for message in frames(board, Decoder()):
        if isinstance(message, Telemetry) and message.generation == generation:
            os.write(board.fileno(), encode(Alive()))
            return
        word = encode(Alive())
        if isinstance(message, Sample) and message.generation == generation:
            if message.refusal:
                raise Refused(message.refusal)
            word = encode(piece(law, generation, message.received))
        os.write(board.fileno(), word)


def listen(board: VirtualBoard, seconds: float) -> list[Telemetry]:
    """Answer telemetry for so many s of board time, as often as the studio; return it."""
    seen, told = [], -1
    for message in frames(board, Decoder()):
        if isinstance(message, Telemetry):
            seen.append(message)
            turn = round(message.time_us * 1e-6 / ALIVE_APART)
            os.write(board.fileno(), encode(Alive()) if turn != told else DELIMITER)
            told = turn
            if (message.time_us - seen[0].time_us) * 1e-6 >= seconds:
                break
    return seen


def render(
    folder: Path,
    law: Program,
    rate: int,
    seconds: float,
    script=(),
    filter: Filter | None = None,
    options=(),
    firmware=None,
) -> Rendering:
    """Render one law from the start of a run, with the usual firmware or another image; raise Refused."""
    (folder / "script.txt").write_text("\n".join(script))
    # a script goes by the board's clock, which must not run on while a busy machine keeps us waiting
    words = ("--await", "0", "--answer-timeout", "60", *options)
    board = VirtualBoard("lockstep", folder / "truth.f64", folder / "script.txt", words, firmware)
    board.open()
    try:
        board.start_stream()
        send(board, law, rate, filter)
        seen = listen(board, SETTLE)
        before = board.status()
        later = listen(board, seconds)
        after = board.status()
    finally:
        board.close()
    cycles = FREQUENCY * (after["time"] - before["time"])
    share = 1.0 - (after["asleep_cycles"] - before["asleep_cycles"]) / cycles
    skipped = (later[-1].overruns - seen[-1].overruns) & 0xFF
    return Rendering(seen + later, truth(folder / "truth.f64"), share, skipped, board.summary)
