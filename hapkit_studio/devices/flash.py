"""Write a firmware to the board on a port through avrdude, verify it, and hear what it then says."""

import contextlib
import os
import queue
import subprocess
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import serial

from hapkit_studio import resources
from hapkit_studio.devices import avrdude, port_errors
from hapkit_studio.devices.avrdude import CONNECTING, Output, Progress, no_boot_loader, not_there
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.devices.serial_ports import holder
from hapkit_studio.errors import FlashError, ParameterError, PortBusyError, PortGoneError
from hapkit_studio.files import read_bytes
from hapkit_studio.protocol.messages import BAUD, Hello

FLASH_BYTES = 32256
"""Of the ATmega328P beside the Arduino Uno's boot loader."""
OLD_FLASH_BYTES = 30720
"""Beside the boot loader of boards from before 2010, which is larger."""
_HEX_BYTES = 1_000_000
"""Most bytes of a .hex file; one that fills the chip has 90,000."""
_DATA, _END, _SEGMENT, _HIGHER = 0, 1, 2, 4
_HARMLESS = (3, 5)  # where to start, which a chip knows by itself


def read_image(path: Path) -> bytes:
    """Return the bytes by address in an Intel hex file, from 0 on; gaps hold 0xFF as erased flash does.

    Raise ParameterError that names what is wrong with it.
    """
    memory: dict[int, int] = {}
    base, ended = 0, False
    for number, line in enumerate(read_bytes(path, _HEX_BYTES).decode("ascii", "replace").split(), 1):
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
    size = max(memory) + 1
    if size > FLASH_BYTES:
        raise ParameterError(f"{path.name} takes {size:,} bytes; the chip has room for {FLASH_BYTES:,}.")
    return bytes(memory.get(at, 0xFF) for at in range(size))


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


SPEEDS = (115200, 57600)
"""bit/s of the boot loaders that kits have: optiboot's, and the one of boards from before 2010."""
ROUNDS = 2
"""How often each speed is tried; a board that is busy may not hear the first call."""
SILENCE = 20.0
"""s without a word from avrdude after which it is given up; one call in vain takes it 6 s."""
_LOOK = 0.2
_PART = "m328p"


@dataclass(frozen=True)
class Flashed:
    """What was written: bytes, the boot loader's speed, and how long it took in s."""

    size: int
    speed: int
    seconds: float


def shipped() -> Path:
    """Return the firmware that ships with the studio."""
    return resources.path("firmware", "hapkit.hex")


def image_of(given: str | Path | None = None) -> tuple[Path, bytes]:
    """Return what is to be written, the shipped firmware by default, checked; raise ParameterError."""
    path = shipped() if given is None else Path(given)
    if given is None and not path.exists():
        what = f"The studio's own firmware, {path.parent.name}/{path.name}, is missing."
        raise ParameterError(f"{what} Install Hapkit Studio again.")
    return path, read_image(path)


def flash(
    port: str,
    image: str | Path | None = None,
    program: str | Path | None = None,
    progress: Progress = lambda stage, part: None,
    speeds: tuple[int, ...] = SPEEDS,
    patience: float = 0.0,
) -> Flashed:
    """Write an image, the shipped one by default, to the board on a port and verify it.

    Nothing else may have the port open; for patience s it is waited for. Raise ParameterError (image),
    AvrdudeMissingError, the port's own errors or FlashError; whatever it was, it can be tried again: the
    boot loader is never written to, nor is the EEPROM with the kit's settings.
    """
    begin = time.monotonic()
    found = avrdude.find(program)
    path, data = image_of(image)
    if len(data) > OLD_FLASH_BYTES:
        speeds = tuple(speed for speed in speeds if speed != SPEEDS[1])  # the old boot loader is in its way
    progress(CONNECTING, 0.0)
    _wait_for_port(port, patience, progress)
    for speed in speeds * ROUNDS:
        words = [*found.words, "-p", _PART, "-c", "arduino", "-D", "-P", port, "-b", str(speed)]
        said = Output(progress)
        if _run([*words, "-U", f"flash:w:{path}:i"], port, said) == 0:
            return Flashed(len(data), speed, time.monotonic() - begin)
        if not said.no_sync:
            raise said.error(port)
    raise no_boot_loader(port, speeds)


def read_hello(port: str) -> Hello:
    """Return what the firmware on a port says about itself; raise DeviceError."""
    with contextlib.closing(HapkitBoard(port)) as board:
        board.open()
        return board.hello


def _wait_for_port(port: str, patience: float, progress: Progress) -> None:
    """Return once the port is free; raise DeviceError."""
    deadline = time.monotonic() + patience
    while True:
        try:
            return try_port(port)
        except PortBusyError:
            if time.monotonic() > deadline:
                raise
        progress(CONNECTING, 0.0)
        time.sleep(_LOOK)


def try_port(port: str) -> None:
    """Open and close the port, as avrdude neither says who holds it nor minds a lock; raise DeviceError.

    A program that has it open and locks nothing, like cat, would take part of what the boot loader says.
    """
    if by := holder(port):
        raise port_errors.busy(port, by)
    try:
        serial.Serial(port, BAUD, exclusive=True).close()
    except (serial.SerialException, OSError) as error:
        reason = port_errors.unopened(port, error)
        raise not_there(port) if isinstance(reason, PortGoneError) else reason from error


def _run(words: list[str], port: str, said: Output) -> int:
    """Run avrdude until it ends or has called once in vain; return its exit code."""
    try:
        child = subprocess.Popen(
            words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
    except OSError as error:
        raise FlashError(f"avrdude does not start: {error.strerror}.") from error
    try:
        for text in _output(child, port):
            said.feed(text)
            if said.failed:
                return 1
        return child.wait()
    finally:
        child.kill()
        child.wait()


def _output(child: subprocess.Popen[bytes], port: str) -> Iterator[str]:
    """Yield what avrdude writes, as it comes, or nothing; raise DeviceError if port or program go silent.

    avrdude reads on for ever from a port that has gone.
    """
    chunks: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    assert child.stdout is not None
    pipe = child.stdout

    def pump() -> None:
        with pipe:
            while chunk := os.read(pipe.fileno(), 4096):
                chunks.put(chunk)
        chunks.put(b"")

    threading.Thread(target=pump, name="avrdude", daemon=True).start()
    heard = time.monotonic()
    while True:
        try:
            chunk = chunks.get(timeout=_LOOK)
        except queue.Empty:
            if os.name == "posix" and not os.path.exists(port):
                words = f"{port_errors.port_name(port)} went away before the firmware was whole."
                raise FlashError(f"{words} Plug it in, then flash again.") from None
            if time.monotonic() - heard > SILENCE:
                raise FlashError(f"avrdude has said nothing for {SILENCE:g} s. Flash again.") from None
            yield ""
            continue
        if not chunk:
            return
        heard = time.monotonic()
        yield chunk.decode("utf-8", "replace")
