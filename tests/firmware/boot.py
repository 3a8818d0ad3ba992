"""Boot loaders for the virtual board, both intact and broken, and a board that starts with one."""

import shutil
import subprocess
from pathlib import Path

import pytest

from hapkit_studio.devices import flash, virtual_board
from hapkit_studio.devices.virtual_board import BoardProgram
from tests.firmware.vb import chip

BOOT_LOADERS = Path("/usr/share/arduino/hardware/arduino/avr/bootloaders")
OLD = BOOT_LOADERS / "atmega" / "ATmegaBOOT_168_atmega328.hex"
"""The boot loader of boards from before 2010, with 57,600 baud and 2 KB."""
START = 0x7E00

needs_avrdude = pytest.mark.skipif(
    not virtual_board.built() or not shutil.which("avrdude") or not OLD.is_file(),
    reason="no virtual board, no avrdude or no boot loaders",
)

_NO_SPM = (0x95E8, 0x0000)
_OTHER_SIGNATURE = (0xE985, 0xE984)  # the instruction ldi r24, 0x95 becomes ldi r24, 0x94


def optiboot(folder: Path, baud: int = 115200) -> Path:
    """Compile the Arduino Uno's boot loader without its LED code, which would not fit with this compiler."""
    sources, elf, image = BOOT_LOADERS / "optiboot", folder / "optiboot.elf", folder / "optiboot.hex"
    flags = ["-Os", "-fno-inline-small-functions", "-fno-split-wide-types", "-mshort-calls", "-w"]
    flags += ["-mmcu=atmega328p", "-DF_CPU=16000000L", "-DLED_START_FLASHES=0", f"-DBAUD_RATE={baud}"]
    place = [f"-Wl,--section-start=.text={START:#x},--section-start=.version=0x7ffe", "-Wl,--relax"]
    command = ["avr-gcc", *flags, *place, "-nostartfiles", "-nostdlib", "-o", elf, sources / "optiboot.c"]
    subprocess.run(command, check=True)
    subprocess.run(["avr-objcopy", "-j", ".text", "-O", "ihex", elf, image], check=True)
    return image


def that_writes_nothing(folder: Path) -> Path:
    """Return a boot loader that replies to everything and leaves the flash unchanged."""
    return _changed(optiboot(folder), *_NO_SPM)


def of_another_chip(folder: Path) -> Path:
    """Return the boot loader of a chip with another signature."""
    return _changed(optiboot(folder), *_OTHER_SIGNATURE)


def _changed(image: Path, old: int, new: int) -> Path:
    elf, raw = image.with_suffix(".elf"), image.with_suffix(".bin")
    subprocess.run(["avr-objcopy", "-j", ".text", "-O", "binary", elf, raw], check=True)
    words = [raw.read_bytes()[at : at + 2] for at in range(0, raw.stat().st_size, 2)]
    assert old.to_bytes(2, "little") in words
    raw.write_bytes(
        b"".join(new.to_bytes(2, "little") if w == old.to_bytes(2, "little") else w for w in words)
    )
    shift = f"--change-addresses={START:#x}"
    subprocess.run(["avr-objcopy", "-I", "binary", "-O", "ihex", shift, raw, image], check=True)
    return image


def small_image(folder: Path, name: str = "chatter") -> Path:
    """Return one of the small test programs as a .hex file."""
    image = folder / f"{name}.hex"
    subprocess.run(["avr-objcopy", "-O", "ihex", chip(name, folder), image], check=True)
    assert flash.read_image(image)
    return image


class Board:
    """A virtual board with a boot loader; its port behaves like a real cable.

    The port keeps its path, and opening the port resets the board.
    """

    def __init__(self, folder: Path, boot_loader: Path, firmware: Path | None = None):
        self.port = str(folder / "port")
        command = [virtual_board.program(), firmware or chip("asleep", folder), "--paced", "--control"]
        command += ["--link", self.port, "--bootloader", boot_loader]
        self._program = BoardProgram([str(w) for w in command])
        self._program.reply("port")

    def send(self, command: str) -> None:
        assert self._program.send(command)

    def plug(self) -> None:
        self.send("plug")
        self._program.reply("port")

    def end(self) -> None:
        self._program.end()
