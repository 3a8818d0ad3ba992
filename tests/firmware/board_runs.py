"""Runs of the board's own laws in the virtual board, in lockstep: telemetry in, a word out now and then."""

import os
import select
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hapkit_studio.devices.virtual_board import VirtualBoard, truth
from hapkit_studio.haptics.board_words import ALIVE_APART
from hapkit_studio.protocol.framing import DELIMITER, Decoder, encode
from hapkit_studio.protocol.messages import (
    VALUES,
    Alive,
    Estimator,
    LawName,
    LawRequest,
    Loop,
    Scene,
    Telemetry,
)
from tests.firmware.vb_host import SILENCE

FREQUENCY = 16e6
SETTLE = 0.05
"""s before the processor's share and skipped ticks are counted: the force has faded in."""


@dataclass
class Rendering:
    """What a run told: telemetry, truth log, processor's share 0..1, skipped ticks, counters at the end."""

    telemetry: list[Telemetry]
    truth: np.recarray
    share: float
    skipped: int
    summary: dict


def numbers(board: VirtualBoard) -> dict[str, int]:
    """Return the number of each law by its key."""
    names = (board.request(LawRequest(n), LawName) for n in range(board.hello.laws))
    return {name.key: name.law for name in names}


def scene(law: int, values: Sequence[float], generation: int = 1) -> Scene:
    return Scene(law, generation, tuple(values) + (0.0,) * (VALUES - len(values)))


def listen(board: VirtualBoard, seconds: float) -> list[Telemetry]:
    """Answer telemetry for so many s of board time, as often as the studio; return it."""
    decoder, seen, told = Decoder(), [], -1
    while not seen or (seen[-1].time_us - seen[0].time_us) * 1e-6 < seconds:
        ready, _, _ = select.select([board.fileno()], [], [], SILENCE)
        assert ready, "the board has gone silent"
        for message in decoder.feed(os.read(board.fileno(), 4096)):
            if isinstance(message, Telemetry):
                seen.append(message)
                turn = round(message.time_us * 1e-6 / ALIVE_APART)
                os.write(board.fileno(), encode(Alive()) if turn != told else DELIMITER)
                told = turn
    return seen


def render(
    folder: Path,
    key: str,
    values: Sequence[float],
    rate: int,
    seconds: float,
    script=(),
    loop: Loop | None = None,
    options=(),
    firmware=None,
) -> Rendering:
    """Render one law from the start of a run, with the usual firmware or another image."""
    (folder / "script.txt").write_text("\n".join(script))
    # a script goes by the board's clock, which must not run on while a busy machine keeps us waiting
    words = ("--await", "0x83", "--answer-timeout", "60", *options)
    board = VirtualBoard("lockstep", folder / "truth.f64", folder / "script.txt", words, firmware)
    board.open()
    try:
        law = numbers(board)[key]
        board.start_stream()
        board.tell(loop or Loop(rate, Estimator.KALMAN, 0.35, 0.06 * rate), scene(law, values))
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
