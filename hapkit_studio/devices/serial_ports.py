"""The serial ports of this computer: their chips, which ports may be a Hapkit, their users and latencies."""

import contextlib
import os
import struct
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any, NamedTuple

from serial.tools import list_ports


class Role(IntEnum):
    """Likelihood that a port is a Hapkit; also the order of the list."""

    KIT = 0
    """A chip of known kits."""
    UNKNOWN = 1
    OTHER = 2
    """A device that is certainly not a Hapkit."""


class Chip(NamedTuple):
    """The description of a USB product; a product number of None means all other products of the vendor."""

    description: str
    role: Role
    numbers: tuple[tuple[int, int | None], ...]


# the Hapkit board has an FT232RL; students also use an Arduino Uno or clones, many with a CH340
_UNO = ((0x2341, 0x0043), (0x2341, 0x0001), (0x2341, 0x0243), (0x2A03, 0x0043), (0x2A03, 0x0001))
_MODEMS = ((0x12D1, None), (0x1199, None), (0x2C7C, None), (0x19D2, None), (0x1BC7, None))
CHIPS = (
    Chip("Hapkit board (FT232)", Role.KIT, ((0x0403, 0x6001),)),
    Chip("board with FT231X", Role.KIT, ((0x0403, 0x6015),)),
    Chip("Arduino Uno", Role.KIT, _UNO),
    Chip("Uno-like board (CH340)", Role.KIT, ((0x1A86, 0x7523), (0x1A86, 0x7522))),
    Chip("Uno-like board (CH341)", Role.KIT, ((0x1A86, 0x5523),)),
    Chip("Uno-like board (CH9102)", Role.KIT, ((0x1A86, 0x55D4),)),
    Chip("Uno-like board (CP210x)", Role.KIT, ((0x10C4, 0xEA60),)),
    Chip("Uno-like board (PL2303)", Role.KIT, ((0x067B, 0x2303),)),
    Chip("FTDI adapter", Role.UNKNOWN, ((0x0403, None),)),
    Chip("Arduino, but not an Uno", Role.UNKNOWN, ((0x2341, None), (0x2A03, None))),
    Chip("Teensy", Role.OTHER, ((0x16C0, 0x0483),)),
    Chip("Raspberry Pi Pico", Role.OTHER, ((0x2E8A, None),)),
    Chip("Espressif board", Role.OTHER, ((0x303A, None),)),
    Chip("STM32 board", Role.OTHER, ((0x0483, None),)),
    Chip("mobile modem", Role.OTHER, _MODEMS),
    Chip("GPS receiver", Role.OTHER, ((0x1546, None),)),
)
_BY_NUMBERS = {numbers: chip for chip in CHIPS for numbers in chip.numbers}
_NAMES = {
    "bluetooth": "Bluetooth",
    "rfcomm": "Bluetooth",
    "modem": "modem",
    "debug-console": "console",
    "wlan-debug": "console",
}


class Identity(NamedTuple):
    """The identity of a board, independent of its port; ``vendor`` is None if the port is not USB."""

    vendor: int | None = None
    product: int | None = None
    serial: str = ""
    place: str = ""


NOWHERE = Identity()


@dataclass(frozen=True)
class Port:
    """One serial port of this computer."""

    path: str
    description: str
    role: Role
    identity: Identity = NOWHERE

    @property
    def title(self) -> str:
        """Return the port's title in the device list."""
        remark = ", not a Hapkit" if self.role is Role.OTHER else ""
        return f"{port_name(self.path)}: {self.description}{remark}".rstrip(": ")


def port_name(path: str) -> str:
    """Return the short name of a port, such as ttyUSB0 or COM3."""
    return path.removeprefix("/dev/")


def is_path(key: str) -> bool:
    """Return True if a key looks like the path of a port, whether the port is listed or not."""
    return "/" in key or key.upper().startswith("COM")


def ports() -> list[Port]:
    """Return the ports with hardware: likely kits first, then by path."""
    found = [_port(p) for p in list_ports.comports() if p.hwid and p.hwid != "n/a"]
    return sorted(found, key=lambda port: (port.role, port.path))


def at(path: str) -> Port | None:
    """Return the listed port at a path; None for an unlisted path, such as a pseudo-terminal."""
    return next((port for port in ports() if port.path == path), None)


def find_same_board(wanted: Identity, among: Iterable[Port]) -> Port | None:
    """Return the same board on any path: by serial number, else USB location, else the only candidate."""
    alike = [port for port in among if port.identity[:3] == wanted[:3]]
    here = [port for port in alike if port.identity.place == wanted.place]
    if wanted.serial:
        return alike[0] if alike else None
    return here[0] if here else alike[0] if len(alike) == 1 else None


def _port(info: Any) -> Port:
    identity = Identity(info.vid, info.pid, info.serial_number or "", info.location or "")
    product = info.product or (info.description or "").replace("n/a", "")
    text = f"{info.device} {product}".lower()
    named = next((label for part, label in _NAMES.items() if part in text), None)
    chip = _BY_NUMBERS.get((info.vid, info.pid)) or _BY_NUMBERS.get((info.vid, None))
    if named is not None and not (chip and chip.role is Role.KIT):
        return Port(info.device, named, Role.OTHER, identity)
    if chip is not None:
        return Port(info.device, chip.description, chip.role, identity)
    return Port(info.device, product or "serial port", Role.UNKNOWN, identity)


PROCESSES = Path("/proc")
STUDIO = "Hapkit Studio"
"""Name shown for the studio, because its process is called python."""


def holder(port: str) -> str:
    """Return name and process id of another program that has the port open; "" if unknown.

    Linux lists only the open files of the user's programs.
    """
    real, own = os.path.realpath(port), str(os.getpid())
    for process in _listed(PROCESSES):
        if process.name.isdigit() and process.name != own and _has_open(process, real):
            return _program_name(process)
    return ""


def _listed(folder: Path) -> list[Path]:
    """Return a folder's entries; the list is empty if the folder belongs to another user."""
    try:
        return list(folder.iterdir())
    except OSError:
        return []


def _has_open(process: Path, real: str) -> bool:
    for file in _listed(process / "fd"):
        with contextlib.suppress(OSError):
            if os.readlink(file) == real:
                return True
    return False


def _program_name(process: Path) -> str:
    """Return a program's name without its folder, and the process id."""
    try:
        line = (process / "cmdline").read_bytes().decode("utf-8", "replace").split("\0")
        name = Path(line[0]).name or (process / "comm").read_text().strip()
        # the studio was started as ``-m hapkit_studio`` or by its script
        if "hapkit_studio" in line or {Path(word).name for word in line} & {
            "hapkit-studio",
            "hapkit-studio.exe",
        }:
            name = STUDIO
    except OSError:
        name = "a program"
    return f"{name} (process {process.name})"


# An FTDI chip sends a packet after 62 bytes or when its latency timer ends: 16 ms by default (FTDI
# AN232B-04). The timer is set to 1 ms, without root if the system allows this.
FTDI = 0x0403
USUAL_TIMER, SHORT_TIMER = 0.016, 0.002
"""s: default of an FTDI chip; largest value that causes no warning."""

TIMERS = Path("/sys/bus/usb-serial/devices")
_IOSSDATALAT = 0x80085400  # macOS IOKit
_REGISTRY = r"SYSTEM\CurrentControlSet\Enum\FTDIBUS\VID_{0:04X}+PID_{1:04X}+{2}A\0000\Device Parameters"


@dataclass(frozen=True)
class Latency:
    """The latency timer of a port in s, None without a timer; ``known`` is True if the system reported it."""

    timer: float | None = None
    known: bool = True
    port: str = ""

    @property
    def long(self) -> bool:
        """Return True if the latency is too long."""
        return self.timer is not None and self.timer > SHORT_TIMER

    @property
    def text(self) -> str:
        """Return the latency as text with a remedy if needed; "" without a timer."""
        if self.timer is None:
            return ""
        ms = f"{1e3 * self.timer:.0f} ms"
        if not self.long:
            return f"The USB chip delays data by up to {ms}."
        remedy = {
            "win32": "Set the latency timer to 1 ms in the Device Manager (port, Port Settings, Advanced)",
            "darwin": "Set the latency timer to 1 ms with FTDI's own driver",
        }.get(sys.platform, f"Run `echo 1 | sudo tee {TIMERS / Path(self.port).name / 'latency_timer'}`")
        known = "" if self.known else " (the usual value)"
        return (
            f"The USB chip delays data by up to {ms}{known}. {remedy}. Or run Set up my Hapkit, which can "
            "fill each USB packet so that it is sent at once. Or let the board compute the force."
        )


def shorten_latency(line: Any, port: str, identity: Identity) -> Latency:
    """Set the shortest latency of an open port; return the resulting latency. This never fails."""
    with contextlib.suppress(Exception):  # systems and drivers raise various errors, which are all harmless
        line.set_low_latency_mode(True)
    if sys.platform == "darwin":  # receive latency of the driver in µs, which cannot be read back
        import fcntl

        with contextlib.suppress(OSError, AttributeError):
            fcntl.ioctl(line.fileno(), _IOSSDATALAT, struct.pack("L", 1000))
    if identity.vendor != FTDI:
        return Latency()
    timer = _timer(port, identity)
    return Latency(USUAL_TIMER, False, port) if timer is None else Latency(timer, True, port)


def _timer(port: str, identity: Identity) -> float | None:
    """Return the latency timer in s; None if the system does not report it."""
    try:
        if sys.platform == "win32":
            import winreg

            path = _REGISTRY.format(identity.vendor or 0, identity.product or 0, identity.serial)
            with winreg.OpenKey(winreg.HKEY_LOCAL_MACHINE, path) as key:  # type: ignore[attr-defined,unused-ignore]
                return 1e-3 * int(winreg.QueryValueEx(key, "LatencyTimer")[0])  # type: ignore[attr-defined,unused-ignore]
        return 1e-3 * int((TIMERS / Path(port).name / "latency_timer").read_text())
    except (OSError, ValueError):
        return None
