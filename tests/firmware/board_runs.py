"""Runs of laws in the virtual board in lockstep: code goes in, telemetry comes out."""

import os
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
from tests.firmware.vb import heard, opened

FREQUENCY = 16e6
SETTLE = 0.05
"""Time in s from which processor load and skipped ticks are counted; the force has faded in by then."""
Filter = tuple[Estimator, float, float]
"""The board's velocity estimator, with the two coefficients of a Law message."""


class Refused(Exception):
    """Raised if the board rejects a law."""


@dataclass
class Rendering:
    """The result of a run: telemetry, truth log, processor load 0..1, skipped ticks, final counters."""

    telemetry: list[Telemetry]
    truth: np.recarray
    share: float
    skipped: int
    summary: dict


def usual(rate: int) -> Filter:
    """Return a typical velocity filter."""
    return Estimator.KALMAN, 0.35, 0.06 * rate


def program(environment: Environment, values: Mapping[str, float], rate: int, room: int) -> Program:
    """Return an environment's law as code for a rate in Hz and an arena in bytes."""
    return code.compile(environment.force, values, 1.0 / rate, room)


def announced(law: Program, rate: int, filter: Filter, generation: int) -> Law:
    """Return the message that announces a law, before its pieces are sent."""
    shape = (law.states, len(law.given), law.slots, len(law.code))
    return Law(generation, round(2e6 / rate), *filter, *shape, crc16(law.data))


def piece(law: Program, generation: int, at: int) -> Piece:
    return Piece(generation, at, tuple(law.data[at : at + PIECE].ljust(PIECE, b"\0")))


def frames(board: VirtualBoard) -> Iterator[Message]:
    """Yield the board's messages; fail on silence."""
    decoder = Decoder()
    while True:
        yield from heard(board.fileno(), decoder)


def send(
    board: VirtualBoard,
    law: Program,
    rate: int,
    filter: Filter | None = None,
    stream: Iterator[Message] | None = None,
) -> Telemetry:
    """Send a law, one piece per sample, until the board renders it.

    Return its first frame, or raise Refused if the board rejects the law.
    """
    os.write(board.fileno(), encode(announced(law, rate, filter or usual(rate), 1)))
    for message in stream or frames(board):
        word = encode(Alive())
        if isinstance(message, Telemetry) and message.generation == 1:
            os.write(board.fileno(), word)
            return message
        if isinstance(message, Sample) and message.generation == 1:
            if message.refusal:
                raise Refused(message.refusal)
            word = encode(piece(law, 1, message.received))
        os.write(board.fileno(), word)
    raise AssertionError("the board has ended")


def listen(board: VirtualBoard, seconds: float, stream: Iterator[Message]) -> list[Telemetry]:
    """Answer telemetry as the studio does; return the frames of ``seconds`` of board time."""
    seen, alive_turn = [], -1
    for message in stream:
        if not isinstance(message, Telemetry):
            break
        seen.append(message)
        turn = round(message.time_us * 1e-6 / ALIVE_APART)
        os.write(board.fileno(), encode(Alive()) if turn != alive_turn else DELIMITER)
        alive_turn = turn
        if (message.time_us - seen[0].time_us) * 1e-6 >= seconds:
            break
    return seen


# a script runs in board time, which must not advance while a busy machine delays the test
WAITING = ("--await", "0", "--answer-timeout", "60")


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
    """Render one law from the start of a run, with the usual or another firmware.

    Raise Refused if the board rejects the law.
    """
    log, commands = folder / "truth.f64", folder / "script.txt"
    commands.write_text("\n".join(script))
    with opened(log=log, script=commands, options=(*WAITING, *options), firmware=firmware) as board:
        board.start_stream()
        stream = frames(board)
        send(board, law, rate, filter, stream)
        seen = listen(board, SETTLE, stream)
        before = board.status()
        later = listen(board, seconds, stream)
        after = board.status()
    cycles = FREQUENCY * (after["time"] - before["time"])
    share = 1.0 - (after["asleep_cycles"] - before["asleep_cycles"]) / cycles
    skipped = (later[-1].overruns - seen[-1].overruns) & 0xFF
    return Rendering(seen + later, truth(log), share, skipped, board.summary)
