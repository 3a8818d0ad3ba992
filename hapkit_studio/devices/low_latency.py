"""How long the USB chip holds bytes back: asked down to 1 ms without root where the system allows, and said.

An FTDI chip sends a packet when 62 bytes are there or its latency timer ends: 16 ms unless told otherwise
(FTDI AN232B-04).
"""

import contextlib
import struct
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hapkit_studio.devices.serial_ports import Identity

FTDI = 0x0403
USUAL = 0.016
"""s: the timer of a chip that nobody told otherwise."""
SHORT = 0.002
"""s: from here on it is no longer worth a word."""

_SYS = Path("/sys/bus/usb-serial/devices")
_IOSSDATALAT = 0x80085400
_REGISTRY = r"SYSTEM\CurrentControlSet\Enum\FTDIBUS\VID_{0:04X}+PID_{1:04X}+{2}A\0000\Device Parameters"


@dataclass(frozen=True)
class Latency:
    """What is known of a port's timer: seconds, None without one; known: read, not assumed."""

    timer: float | None = None
    known: bool = True
    port: str = ""

    @property
    def long(self) -> bool:
        """Tell whether it is worth a remedy."""
        return self.timer is not None and self.timer > SHORT

    @property
    def words(self) -> str:
        """Return it in words, with the remedy where there is one; nothing without a timer."""
        if self.timer is None:
            return ""
        said = f"USB latency timer {1e3 * self.timer:.0f} ms"
        if not self.long:
            return f"{said}."
        return f"{said}{'' if self.known else ', as far as known'}. {remedy(self.port)}"


def remedy(port: str) -> str:
    """Return what shortens the timer on this system, and what does without."""
    here = {
        "win32": "Set it to 1 ms in the Device Manager (port, Port Settings, Advanced)",
        "darwin": "Set it to 1 ms with FTDI's own driver",
    }.get(sys.platform, f"Run `echo 1 | sudo tee {_SYS / Path(port).name / 'latency_timer'}`")
    return f"{here}, fill frames to whole USB packets, or render on the board."


def shorten_latency(line: Any, port: str, identity: Identity) -> Latency:
    """Ask for the shortest latency of an open port; return what holds then. Never fails."""
    with contextlib.suppress(Exception):  # each system and driver refuses in its own way, all harmless
        line.set_low_latency_mode(True)
    if sys.platform == "darwin":
        _shorten_on_mac(line)
    if identity.vendor != FTDI:
        return Latency()
    timer = _read(port, identity)
    return Latency(USUAL, False, port) if timer is None else Latency(timer, True, port)


def _read(port: str, identity: Identity) -> float | None:
    """Return the timer in s where the system shows it."""
    try:
        if sys.platform == "win32":
            return 1e-3 * _registry_value(identity)
        return 1e-3 * int((_SYS / Path(port).name / "latency_timer").read_text())
    except (OSError, ValueError):
        return None


def _registry_value(identity: Identity) -> int:
    import winreg

    path = _REGISTRY.format(identity.vendor or 0, identity.product or 0, identity.serial)
    with winreg.OpenKey(winreg.HKEY_LOCAL_MACHINE, path) as key:  # type: ignore[attr-defined,unused-ignore]
        return int(winreg.QueryValueEx(key, "LatencyTimer")[0])  # type: ignore[attr-defined,unused-ignore]


def _shorten_on_mac(line: Any) -> None:
    """Set the receive latency of the driver in us (IOKit's IOSSDATALAT); it cannot be read back."""
    import fcntl

    with contextlib.suppress(OSError, AttributeError):
        fcntl.ioctl(line.fileno(), _IOSSDATALAT, struct.pack("L", 1000))
