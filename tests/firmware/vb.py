"""What the tests of the virtual board share: small programs for its chip, running it, reading its logs."""

import json
import os
import select
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from hapkit_studio.devices import virtual_board
from tests.waiting import PATIENCE, write_all

CHIPS = Path(__file__).with_name("chips")
FULL_FORCE = 0.0183 * 0.074 / (0.090 * 0.005)
"""N at full duty: torque * sector radius / (handle radius * pulley radius)."""
QUANTUM = np.pi * 0.090 * 0.005 / (921 * 0.074)
"""m per sensor count: half a turn of the motor in 921 counts."""

needs_board = pytest.mark.skipif(not virtual_board.built(), reason="the virtual board is not built")
needs_compiler = pytest.mark.skipif(
    not virtual_board.built() or shutil.which("avr-gcc") is None, reason="no virtual board or no avr-gcc"
)


def chip(name: str, folder: Path, said: bytes = b"", **defined: int) -> Path:
    """Compile one of the small programs, the talkative one with what it says; return its .elf."""
    elf = folder / f"{name}.elf"
    flags = [f"-D{key}={value}" for key, value in defined.items()]
    if said:
        (folder / "said.h").write_text(", ".join(map(str, said)))
        flags.append(f"-I{folder}")
    words = ["avr-gcc", "-mmcu=atmega328p", "-DF_CPU=16000000UL", "-Os", "-std=gnu11", *flags]
    subprocess.run([*words, "-o", elf, CHIPS / f"{name}.c"], check=True)
    return elf


@dataclass
class Outcome:
    """How a run ended: exit code, truth log, counters, complaints."""

    code: int
    truth: np.ndarray
    summary: dict
    errors: str


def run(firmware: Path, folder: Path, *options: str, script: Sequence[str] = ()) -> Outcome:
    """Run a firmware as fast as it goes, with a script, until its time is over."""
    log, commands = folder / "truth.f64", folder / "script.txt"
    log.touch()
    commands.write_text("\n".join(script))
    words = [virtual_board.program(), firmware, "--fast", "--log", log, "--script", commands, *options]
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=PATIENCE)
    last = done.stdout.strip().split("\n")[-1]
    summary = json.loads(last) if last.startswith("{") else {}
    return Outcome(done.returncode, virtual_board.truth(log), summary, done.stderr)


class Host:
    """The computer's end of the cable: raw bytes, without blocking for ever."""

    def __init__(self, port: str):
        self.fd = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)

    def write(self, data: bytes) -> None:
        write_all(self.fd, data)

    def read(self, size: int) -> bytes:
        """Return exactly size bytes; fail if they do not come."""
        data = b""
        while len(data) < size:
            ready, _, _ = select.select([self.fd], [], [], PATIENCE)
            assert ready, f"{len(data)} of {size} bytes came"
            data += os.read(self.fd, size - len(data))
        return data

    def close(self) -> None:
        os.close(self.fd)
