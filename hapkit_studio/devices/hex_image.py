"""An Intel hex file: what is to be written to the chip, read and checked before anything is touched."""

from dataclasses import dataclass
from pathlib import Path

from hapkit_studio.errors import ParameterError

FLASH_BYTES = 32256
"""Of the ATmega328P beside the Arduino Uno's boot loader."""
OLD_FLASH_BYTES = 30720
"""Beside the boot loader of boards from before 2010, which is larger."""
_DATA, _END, _SEGMENT, _HIGHER = 0, 1, 2, 4
_HARMLESS = (3, 5)  # where to start, which a chip knows by itself


@dataclass(frozen=True)
class HexImage:
    """A file and its bytes by address, from 0 on; gaps hold 0xFF as erased flash does."""

    path: Path
    data: bytes


def read(path: str | Path) -> HexImage:
    """Return the image in a file; raise ParameterError that names what is wrong with it, OSError."""
    path = Path(path)
    memory: dict[int, int] = {}
    base, ended = 0, False
    for number, line in enumerate(path.read_text("ascii", "replace").split(), 1):
        address, kind, data = _record(path, number, line)
        if kind == _DATA:
            memory.update((base + address + at, byte) for at, byte in enumerate(data))
        elif kind in (_SEGMENT, _HIGHER):
            base = int.from_bytes(data, "big") << (4 if kind == _SEGMENT else 16)
        elif kind not in (_END, *_HARMLESS):
            raise ParameterError(
                f"{path.name}, line {number}: a record of kind {kind} has no place in a .hex."
            )
        ended = kind == _END
    if not memory or not ended:
        raise ParameterError(f"{path.name} is no whole .hex file. Export it again.")
    return _fitting(path, memory)


def _fitting(path: Path, memory: dict[int, int]) -> HexImage:
    size = max(memory) + 1
    if size > FLASH_BYTES:
        raise ParameterError(f"{path.name} takes {size:,} bytes; the chip has room for {FLASH_BYTES:,}.")
    return HexImage(path, bytes(memory.get(at, 0xFF) for at in range(size)))


def _record(path: Path, number: int, line: str) -> tuple[int, int, bytes]:
    """Return address, kind and data of one line."""
    try:
        record = bytes.fromhex(line[1:])
    except ValueError:
        record = b""
    if not line.startswith(":") or len(record) < 5 or len(record) != record[0] + 5:
        raise ParameterError(f"{path.name}, line {number}: this is no line of a .hex file.")
    if sum(record) % 256:
        raise ParameterError(f"{path.name}, line {number}: the check sum is wrong. Export it again.")
    return int.from_bytes(record[1:3], "big"), record[3], record[4:-1]
