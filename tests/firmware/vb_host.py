"""A plain host for the real firmware: answers every sample with a force. Also a program, to be killed."""

import os
import select
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import Force, Sample
from tests.waiting import PATIENCE, write_all


def exchange(fd: int, seconds: float, law: Callable[[Sample], float], halves: int = 0) -> list[Sample]:
    """Answer samples until the board's clock has gone on by so many seconds; return them all.

    halves: how many frames may be damaged, as the first one is where a stream is joined under way.
    """
    decoder, seen = Decoder(), []
    while not seen or (seen[-1].time_us - seen[0].time_us) * 1e-6 < seconds:
        ready, _, _ = select.select([fd], [], [], PATIENCE)
        assert ready, "the board has gone silent"
        new = [m for m in decoder.feed(os.read(fd, 4096)) if isinstance(m, Sample)]
        for sample in new:
            write_all(fd, encode(Force(sample.seq, 0, law(sample))))
        seen += new
    assert decoder.bad_frames <= halves
    return seen


def session(
    folder: Path, seconds: float, law: Callable[[Sample], float], script=(), mode="lockstep", options=()
) -> tuple[list[Sample], np.ndarray, dict]:
    """Run the real firmware with a script and a law; return samples, truth log and counters."""
    from hapkit_studio.devices.virtual_board import truth

    (folder / "script.txt").write_text("\n".join(script))
    board = VirtualBoard(mode, log=folder / "truth.f64", script=folder / "script.txt", options=options)
    board.open()
    try:
        board.start_stream()
        samples = exchange(board.fileno(), seconds, law)
    finally:
        board.close()
    return samples, truth(folder / "truth.f64"), board.summary


def rows_of(samples: list[Sample], truth: np.ndarray) -> np.ndarray:
    """Return the row of the truth log that belongs to each sample; fail where there is none."""
    # the converter holds its input some microseconds after the clock was read
    times = np.array([s.time_us for s in samples]) * 1e-6
    lag = np.median(truth.time[np.searchsorted(truth.time, times)] - times)
    rows = np.searchsorted(truth.time, times + lag - 20e-6)
    assert np.abs(truth.time[rows] - times - lag).max() < 10e-6
    return truth[rows]


if __name__ == "__main__":
    port = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
    exchange(port, 1e9, lambda sample: float(sys.argv[2]))
