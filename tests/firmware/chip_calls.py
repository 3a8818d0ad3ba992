"""The machine's program in simavr: its functions called one by one, their cycles counted."""

import struct
import subprocess
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parents[2] / "firmware" / "tests" / "chip"


def build(folder: Path) -> None:
    """Build the caller and the machine's program into a folder."""
    subprocess.run(["make", "-s", "-C", FOLDER, f"BUILD={folder}", "all"], check=True)


class Chip:
    """A program for the chip whose functions are called; a context that ends simavr."""

    def __init__(self, folder: Path, program: str = "machine.elf"):
        elf = folder / program
        self._process = subprocess.Popen([folder / "chip", elf], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
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
        """Call a function of one or two words (n,) of 4 bytes each: results (n,) of the same kind, cycles (n,)."""
        first = np.atleast_1d(first)
        second = np.zeros_like(first) if second is None else np.broadcast_to(second, first.shape)
        given = np.empty((len(first), 2), np.uint32)
        given[:, 0], given[:, 1] = np.ascontiguousarray(second).view(np.uint32), first.view(np.uint32)
        found = []
        for part in np.array_split(given, -(-len(given) // 4096)):  # what fits into the pipes
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

    def _say(self, words: bytes) -> None:
        self._process.stdin.write(words)
        self._process.stdin.flush()

    def _hear(self, size: int) -> bytes:
        found = self._process.stdout.read(size)
        assert len(found) == size, "the call failed"
        return found
