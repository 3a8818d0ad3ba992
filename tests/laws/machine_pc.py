"""The board's virtual machine on this computer loads code, reports the verifier's result, and runs it."""

import shutil
import struct
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from hapkit_studio.laws.machine import Refusal

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "firmware" / "tests" / "laws"
ARENA = 16384  # bytes; other tests check the size of the board's own arena

needs_compiler = pytest.mark.skipif(
    shutil.which("g++") is None or shutil.which("make") is None, reason="no g++ or no make"
)


def build(*, watched: bool = False) -> Path:
    """Return the program, rebuilt if its sources are newer; if ``watched``, it has sanitizers."""
    folder = ROOT / "build" / "machine"
    made = folder / ("machine_watched" if watched else "machine")
    subprocess.run(["make", "-s", "-C", SOURCES, f"BUILD={folder}", f"ARENA={ARENA}", made], check=True)
    return made


@dataclass(frozen=True)
class Loaded:
    """The verifier's result: the reason of rejection, or the worst-case cycles of a call."""

    refusal: Refusal
    cycles: int


class Machine:
    """The process of a machine, which the context manager ends.

    >>> with Machine(build()) as machine:
    ...     assert machine.load(states=0, numbers=[100.0], slots=3, code=code).refusal == Refusal.NONE
    ...     force, state = machine.run([[0.01, 0.0]])
    """

    def __init__(self, program: Path):
        self._process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self._states = 0
        self.counted = 0
        """Cycles of the last run by the table, summed over all rows."""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.stdin.close()
        self._process.stdout.close()
        assert self._process.wait() == 0

    def load(self, states: int, numbers, slots: int, code: bytes) -> Loaded:
        """Load and verify a law; ``numbers`` are the states' initial values, then the constants."""
        self._states = states
        given = np.asarray(numbers, np.float32)
        self._ask(struct.pack("<cBBBH", b"L", states, len(given), slots, len(code)) + given.tobytes() + code)
        refusal, cycles = struct.unpack("<BI", self._answer(5))
        return Loaded(Refusal(refusal), cycles)

    def set(self, slot: int, value: float) -> None:
        """Write one slot."""
        self._ask(struct.pack("<cBf", b"S", slot, value))

    def run(self, rows) -> tuple[np.ndarray, np.ndarray]:
        """Call the law with rows (n, 2) of position and velocity; return force (n,) and state (n, states)."""
        rows = np.asarray(rows, np.float32).reshape(-1, 2)
        self._ask(struct.pack("<cI", b"R", len(rows)) + rows.tobytes())
        width = 1 + self._states
        out = np.frombuffer(self._answer(4 * width * len(rows)), np.float32).reshape(-1, width)
        (self.counted,) = struct.unpack("<I", self._answer(4))
        return out[:, 0], out[:, 1:]

    def _ask(self, data: bytes) -> None:
        self._process.stdin.write(data)
        self._process.stdin.flush()

    def _answer(self, size: int) -> bytes:
        found = self._process.stdout.read(size)
        assert len(found) == size, "the machine's program ended"
        return found
