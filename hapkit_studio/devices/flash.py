"""Write firmware to the board on a port with avrdude, verify it, and read the new Hello."""

import contextlib
import os
import queue
import subprocess
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
from hapkit_studio.worker import Worker

FLASH_BYTES = 32256
"""Bytes of the ATmega328P's flash without the Arduino Uno's boot loader."""
OLD_FLASH_BYTES = 30720
"""Bytes on boards from before 2010, which have a larger boot loader."""
_HEX_BYTES = 1_000_000
"""Largest size of a .hex file in bytes; that of a full chip has 90,000."""
_DATA, _END, _SEGMENT, _HIGHER = 0, 1, 2, 4
_HARMLESS = (3, 5)  # types of start-address records, which the chip ignores


def read_image(path: Path) -> bytes:
    """Return the bytes of an Intel hex file from address 0 on; gaps are 0xFF, like erased flash.

    Raise ParameterError for an invalid file; the message names the fault.
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
                f"{path.name}, line {number}: a record of kind {kind} is not allowed in a .hex file."
            )
        ended = kind == _END
    if not memory or not ended:
        raise ParameterError(f"{path.name} is an incomplete .hex file. Export it again.")
    size = max(memory) + 1
    if size > FLASH_BYTES:
        raise ParameterError(f"{path.name} has {size:,} bytes; the chip has room for {FLASH_BYTES:,}.")
    return bytes(memory.get(at, 0xFF) for at in range(size))


def _record(path: Path, number: int, line: str) -> tuple[int, int, bytes]:
    """Return address, type and data of one record."""
    try:
        record = bytes.fromhex(line[1:])
    except ValueError:
        record = b""
    if not line.startswith(":") or len(record) < 5 or len(record) != record[0] + 5:
        raise ParameterError(f"{path.name}, line {number}: this is not a line of a .hex file.")
    if sum(record) % 256:
        raise ParameterError(f"{path.name}, line {number}: the check sum is wrong. Export it again.")
    return int.from_bytes(record[1:3], "big"), record[3], record[4:-1]


SPEEDS = (115200, 57600)
"""Bit rates of boot loaders: optiboot, and that of boards from before 2010."""
ROUNDS = 2
"""Attempts at each speed; a busy board may miss the first one."""
SILENCE = 20.0
"""s: avrdude is killed after this time without output; a failed attempt takes 6 s."""
_POLL_SECONDS = 0.2
_PART = "m328p"


@dataclass(frozen=True)
class Flashed:
    """The result of writing: number of bytes, the boot loader's speed, duration in s."""

    size: int
    speed: int
    seconds: float


def shipped() -> Path:
    """Return the path of the firmware shipped with the studio."""
    return resources.path("firmware", "hapkit.hex")


def image_of(given: str | Path | None = None) -> tuple[Path, bytes]:
    """Return path and checked bytes of the image, by default the shipped firmware.

    Raise ParameterError if the image is invalid.
    """
    path = shipped() if given is None else Path(given)
    if given is None and not path.exists():
        name = f"{path.parent.name}/{path.name}"
        raise ParameterError(
            f"The firmware of Hapkit Studio, {name}, is missing. Install Hapkit Studio again."
        )
    return path, read_image(path)


def flash(
    port: str,
    image: str | Path | None = None,
    program: str | Path | None = None,
    progress: Progress = lambda stage, part: None,
    speeds: tuple[int, ...] = SPEEDS,
    patience: float = 0.0,
) -> Flashed:
    """Write an image, by default the shipped firmware, to the board on a port and verify it.

    The port must not be open elsewhere; the function waits up to ``patience`` s for it. Raise ParameterError
    for an invalid image, AvrdudeMissingError, an error of the port, or FlashError if writing fails. A retry
    is always safe: neither the boot loader nor the EEPROM with the kit's settings is written.
    """
    begin = time.monotonic()
    found = avrdude.find(program)
    path, data = image_of(image)
    if len(data) > OLD_FLASH_BYTES:
        # omit the old boot loader's speed: this image would overwrite part of that boot loader
        speeds = tuple(speed for speed in speeds if speed != SPEEDS[1])
    progress(CONNECTING, 0.0)
    _wait_for_port(port, patience, progress)
    for speed in speeds * ROUNDS:
        command = [*found.command, "-p", _PART, "-c", "arduino", "-D", "-P", port, "-b", str(speed)]
        output = Output(progress)
        if _run([*command, "-U", f"flash:w:{path}:i"], port, output) == 0:
            return Flashed(len(data), speed, time.monotonic() - begin)
        if not output.no_sync:
            raise output.error(port)
    raise no_boot_loader(port, speeds)


def read_hello(port: str) -> Hello:
    """Return the Hello of the firmware on a port; raise DeviceError if no Hello arrives."""
    with contextlib.closing(HapkitBoard(port)) as board:
        board.open()
        return board.hello


def _wait_for_port(port: str, patience: float, progress: Progress) -> None:
    """Wait until the port is free; raise DeviceError after a time-out."""
    deadline = time.monotonic() + patience
    while True:
        try:
            return try_port(port)
        except PortBusyError:
            if time.monotonic() > deadline:
                raise
        progress(CONNECTING, 0.0)
        time.sleep(_POLL_SECONDS)


def try_port(port: str) -> None:
    """Open and close the port; raise DeviceError if another program uses it.

    avrdude ignores locks and does not name the other program. A program without a lock, such as cat, would
    receive part of the boot loader's replies.
    """
    if by := holder(port):
        raise port_errors.busy(port, by)
    try:
        serial.Serial(port, BAUD, exclusive=True).close()
    except (serial.SerialException, OSError) as error:
        reason = port_errors.unopened(port, error)
        raise not_there(port) if isinstance(reason, PortGoneError) else reason from error


def _run(command: list[str], port: str, output: Output) -> int:
    """Run avrdude until it ends or an attempt fails; return its exit code."""
    try:
        child = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        )
    except OSError as error:
        raise FlashError(f"avrdude cannot be started: {error.strerror}.") from error
    try:
        for text in _output(child, port):
            output.feed(text)
            if output.failed:
                return 1
        return child.wait()
    finally:
        child.kill()
        child.wait()


def _output(child: subprocess.Popen[bytes], port: str) -> Iterator[str]:
    """Yield avrdude's output as it arrives, or "" while waiting; raise DeviceError after a time-out.

    Without the time-out, avrdude would read for ever from a port that has disappeared.
    """
    chunks: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    assert child.stdout is not None
    pipe = child.stdout

    def pump() -> None:
        with pipe:
            while chunk := os.read(pipe.fileno(), 4096):
                chunks.put(chunk)
        chunks.put(b"")

    Worker("avrdude").submit(pump)
    heard = time.monotonic()
    while True:
        try:
            chunk = chunks.get(timeout=_POLL_SECONDS)
        except queue.Empty:
            if os.name == "posix" and not os.path.exists(port):
                name = port_errors.port_name(port)
                raise FlashError(
                    f"{name} was disconnected before the firmware was complete. "
                    "Plug the board in, then flash again."
                ) from None
            if time.monotonic() - heard > SILENCE:
                raise FlashError(f"avrdude has printed nothing for {SILENCE:g} s. Flash again.") from None
            yield ""
            continue
        if not chunk:
            return
        heard = time.monotonic()
        yield chunk.decode("utf-8", "replace")
