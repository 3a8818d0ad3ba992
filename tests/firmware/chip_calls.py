"""Call single functions of the board's virtual machine in simavr, and count their cycles."""

import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest

from hapkit_studio.laws.machine import Refusal
from tests.laws.machine_pc import Loaded

FOLDER = Path(__file__).resolve().parents[2] / "firmware" / "tests" / "chip"

needs_compiler = pytest.mark.skipif(
    not all(map(shutil.which, ("avr-g++", "gcc", "make", "simavr"))), reason="no avr-gcc, gcc or simavr"
)


def build(folder: Path) -> None:
    """Build the caller and the machine's program into a folder."""
    subprocess.run(["make", "-s", "-C", FOLDER, f"BUILD={folder}", "all"], check=True)


class Chip:
    """A program for the chip whose functions can be called; the context manager ends simavr."""

    def __init__(self, folder: Path, program: str = "machine.elf"):
        elf = folder / program
        self._process = subprocess.Popen(
            [folder / "chip", elf], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        lines = subprocess.run(["avr-nm", "-C", elf], capture_output=True, text=True, check=True).stdout
        self._symbols = {}
        for line in lines.splitlines():
            place, _, name = line.split(" ", 2)
            self._symbols[name] = int(place, 16)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.stdin.close()
        self._process.stdout.close()
        assert self._process.wait() == 0

    def place(self, symbol: str) -> int:
        """Return the address of a function, or of a variable in memory."""
        return self._symbols[symbol] & 0xFFFF

    def call(self, symbol: str, first, second=None) -> tuple[np.ndarray, np.ndarray]:
        """Call a function of one or two 4-byte words, n times; return results (n,) and cycles (n,)."""
        first = np.atleast_1d(first)
        second = np.zeros_like(first) if second is None else np.broadcast_to(second, first.shape)
        given = np.empty((len(first), 2), np.uint32)
        given[:, 0], given[:, 1] = np.ascontiguousarray(second).view(np.uint32), first.view(np.uint32)
        found = []
        # the pipes' buffers limit the size of a part
        for part in np.array_split(given, -(-len(given) // 4096)):
            self._say(struct.pack("<cHI", b"C", self.place(symbol), len(part)) + part.tobytes())
            found.append(self._hear(8 * len(part)))
        out = np.frombuffer(b"".join(found), np.uint32).reshape(-1, 2)
        return np.ascontiguousarray(out[:, 0]).view(first.dtype), out[:, 1].astype(int)

    def write(self, place: int, data: bytes) -> None:
        """Write memory."""
        self._say(struct.pack("<cHH", b"W", place, len(data)) + data)

    def read(self, place: int, size: int) -> bytes:
        """Read memory."""
        self._say(struct.pack("<cHH", b"R", place, size))
        return self._hear(size)

    def _say(self, data: bytes) -> None:
        self._process.stdin.write(data)
        self._process.stdin.flush()

    def _hear(self, size: int) -> bytes:
        found = self._process.stdout.read(size)
        assert len(found) == size, "the call failed"
        return found


class ChipMachine:
    """The machine in simavr, with the interface of tests/laws/machine_pc.py."""

    VERIFY = "machine::verify(machine::Shape const&, unsigned long*)"
    RUN = "machine::run(float, float)"
    RUN_PLAINLY = "machine::run_plainly(float, float)"
    SHAPE, CYCLES = 0x700, 0x708
    """Addresses that neither variables nor, at the required depth, the stack use."""

    def __init__(self, chip: Chip):
        self._chip = chip
        self._states = self._slots = 0
        self.cycles = np.zeros(0, int)
        """Number of cycles of each row of the last run, from run()'s first instruction to its return."""

    def load(self, states: int, numbers, slots: int, code: bytes) -> Loaded:
        """Load and verify a law; ``numbers`` are the states' initial values, then the constants."""
        given = np.asarray(numbers, np.float32)
        self._states, self._slots = states, slots
        self._chip.write(self._arena, bytes(4 * slots))
        self._chip.write(self._arena + 8, given.tobytes())
        self._chip.write(self._arena + 4 * slots, code)
        self._chip.write(self.SHAPE, struct.pack("<BBBH", states, len(given), slots, len(code)))
        found, _ = self._chip.call(self.VERIFY, np.array([self.CYCLES | self.SHAPE << 16], np.uint32))
        (cycles,) = struct.unpack("<I", self._chip.read(self.CYCLES, 4))
        return Loaded(Refusal(int(found[0]) >> 16 & 255), cycles)

    def set(self, slot: int, value: float) -> None:
        """Write one slot."""
        self._chip.write(self._arena + 4 * slot, np.float32(value).tobytes())

    def run(self, rows, plainly: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """Call the law with rows (n, 2) of position and velocity; return forces (n,) and states (n, states).

        ``plainly`` runs the C++ code, as on computers.
        """
        rows = np.asarray(rows, np.float32).reshape(-1, 2)
        which = self.RUN_PLAINLY if plainly else self.RUN
        if not self._states:
            force, self.cycles = self._chip.call(which, rows[:, 0].copy(), rows[:, 1].copy())
            return force, np.zeros((len(rows), 0), np.float32)
        forces, states, cycles = [], [], []
        for x, v in rows:
            force, taken = self._chip.call(which, x, v)
            forces.append(force[0])
            cycles.append(taken[0])
            states.append(self.slots()[2 : 2 + self._states])
        self.cycles = np.array(cycles)
        return np.array(forces), np.array(states)

    def slots(self) -> np.ndarray:
        """Return the contents of all slots."""
        return np.frombuffer(self._chip.read(self._arena, 4 * self._slots), np.float32)

    @property
    def _arena(self) -> int:
        return self._chip.place("machine::arena")
