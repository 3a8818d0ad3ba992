"""Helpers for tests of the virtual board: programs for its chip, boards, hosts at its port, and logs."""

import contextlib
import json
import os
import select
import shutil
import subprocess
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from hapkit_studio.devices import virtual_board
from hapkit_studio.devices.virtual_board import BoardProgram, VirtualBoard, truth
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import Force, Message, Sample
from tests.waiting import PATIENCE, write_all

CHIPS = Path(__file__).with_name("chips")
FULL_FORCE = 0.0183 * 0.074 / (0.090 * 0.005)
"""Force in N at full duty, which is torque * sector radius / (handle radius * pulley radius)."""
QUANTUM = np.pi * 0.090 * 0.005 / (921 * 0.074)
"""Handle travel in m per sensor count; half a turn of the motor has 921 counts."""
LONGEST_INTERRUPT = 250
"""Cycles for which interrupts may be disabled, because the port buffers two bytes of 160 cycles."""

needs_board = pytest.mark.skipif(not virtual_board.built(), reason="the virtual board is not built")
needs_compiler = pytest.mark.skipif(
    not virtual_board.built() or shutil.which("avr-gcc") is None, reason="no virtual board or no avr-gcc"
)


def chip(name: str, folder: Path, **defined: int) -> Path:
    """Compile one of the small test programs for the chip; return its .elf."""
    elf = folder / f"{name}.elf"
    flags = [f"-D{key}={value}" for key, value in defined.items()]
    command = ["avr-gcc", "-mmcu=atmega328p", "-DF_CPU=16000000UL", "-Os", "-std=gnu11", *flags]
    subprocess.run([*command, "-o", elf, CHIPS / f"{name}.c"], check=True)
    return elf


def duty_step(duty: np.ndarray) -> np.ndarray:
    """Return half a duty step in N (n,) with a margin; a step at duty d is (2 d + 1) / 255² of full force."""
    return FULL_FORCE * (np.abs(duty) + 1.0) / 255.0**2


@dataclass
class Outcome:
    """The result of a run: exit code, truth log, counters, and error output."""

    code: int
    truth: np.recarray
    summary: dict
    errors: str


def run(firmware: Path, folder: Path, *options: str, script: Sequence[str] = ()) -> Outcome:
    """Run a firmware at full speed with a script until its time is over."""
    log, commands = folder / "truth.f64", folder / "script.txt"
    log.touch()
    commands.write_text("\n".join(script))
    command = [virtual_board.program(), firmware, "--fast", "--log", log, "--script", commands, *options]
    done = subprocess.run([str(w) for w in command], capture_output=True, text=True, timeout=PATIENCE)
    last = done.stdout.strip().split("\n")[-1]
    summary = json.loads(last) if last.startswith("{") else {}
    return Outcome(done.returncode, truth(log), summary, done.stderr)


class Host:
    """The computer's end of the cable, which reads raw bytes with a time-out."""

    def __init__(self, port: str):
        self.fd = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)

    def write(self, data: bytes) -> None:
        write_all(self.fd, data)

    def read(self, size: int) -> bytes:
        """Return exactly ``size`` bytes; fail on a time-out."""
        data = b""
        while len(data) < size:
            ready, _, _ = select.select([self.fd], [], [], PATIENCE)
            assert ready, f"{len(data)} of {size} bytes came"
            data += os.read(self.fd, size - len(data))
        return data

    def close(self) -> None:
        os.close(self.fd)


@contextlib.contextmanager
def started(firmware: Path, folder: Path, *options: str) -> Iterator[tuple[BoardProgram, Host]]:
    """Start a board with a firmware, and a host at its port from the first cycle on; end both."""
    still = folder / "still.txt"
    if "--script" not in options:
        still.write_text("0 freeze")
        options = ("--control", "--script", str(still), *options)
    board = BoardProgram([str(w) for w in (virtual_board.program(), firmware, *options)])
    host = Host(board.reply("port"))
    board.send("resume")
    try:
        yield board, host
    finally:
        board.end()
        host.close()


@contextlib.contextmanager
def opened(mode: str = "lockstep", **more) -> Iterator[VirtualBoard]:
    """Open a virtual board, and close it at the end."""
    board = VirtualBoard(mode, **more)
    board.open()
    try:
        yield board
    finally:
        board.close()


def heard(fd: int, decoder: Decoder) -> list[Message]:
    """Return the next messages from a port; fail on silence."""
    ready, _, _ = select.select([fd], [], [], PATIENCE)
    assert ready, "the board has gone silent"
    return decoder.feed(os.read(fd, 4096))


def exchange(fd: int, seconds: float, law: Callable[[Sample], float]) -> list[Sample]:
    """Answer every sample with the law's force for ``seconds`` of board time; return the samples."""
    decoder, seen = Decoder(), []
    while not seen or (seen[-1].time_us - seen[0].time_us) * 1e-6 < seconds:
        new = [m for m in heard(fd, decoder) if isinstance(m, Sample)]
        for sample in new:
            write_all(fd, encode(Force(sample.seq, 0, law(sample))))
        seen += new
    assert decoder.bad_frames == 0
    return seen


def session(
    folder: Path, seconds: float, law: Callable[[Sample], float], script=(), options=(), firmware=None
) -> tuple[list[Sample], np.recarray, dict]:
    """Run the firmware with a script and a law in lockstep; return samples, truth log and counters."""
    log, commands = folder / "truth.f64", folder / "script.txt"
    commands.write_text("\n".join(script))
    with opened(log=log, script=commands, options=options, firmware=firmware) as board:
        board.start_stream()
        samples = exchange(board.fileno(), seconds, law)
    return samples, truth(log), board.summary


def rows_of(samples: list[Sample], truth: np.recarray) -> np.recarray:
    """Return the truth log's row of each sample; fail if a row is missing."""
    # the converter samples its input some microseconds after the clock was read
    times = np.array([s.time_us for s in samples]) * 1e-6
    lag = np.median(truth.time[np.searchsorted(truth.time, times)] - times)
    rows = np.searchsorted(truth.time, times + lag - 20e-6)
    assert np.abs(truth.time[rows] - times - lag).max() < 10e-6
    return truth[rows]
