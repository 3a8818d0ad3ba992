"""The command that writes the firmware to a board."""

import argparse
import sys

from hapkit_studio import devices, lab
from hapkit_studio.commands.base import Command, Result, option
from hapkit_studio.devices import flash, serial_ports
from hapkit_studio.devices.avrdude import CONNECTING, VERIFYING, WRITING
from hapkit_studio.errors import DeviceError, FlashInterruptedError

_STARTING = "starting"
_WORDS = {
    CONNECTING: "Looking for the boot loader",
    WRITING: "Writing",
    VERIFYING: "Verifying",
    _STARTING: "Starting the firmware",
}
_BAR = 40
_HALF = "The firmware on the board may be incomplete: flash it again before you use it."


OPTIONS = (
    option("port", nargs="?", help="e.g. /dev/ttyUSB0 or COM3; by default the only port"),
    option("--hex", metavar="PATH", help="another firmware than the included one"),
    option("--avrdude", metavar="PATH", help="path of avrdude, if it is not found automatically"),
)


def run(options: argparse.Namespace) -> Result:
    """Write the firmware, verify it and read the board's Hello."""
    lab.check()
    port = _only_port() if options.port is None else options.port
    devices.check_allowed(port)
    for entry in devices.available():
        if entry.key == port and not serial_ports.is_path(port):
            raise DeviceError(f"{entry.title} needs no flashing. Name a port: hapkit-studio flash PORT.")
    name = serial_ports.port_name(port)
    try:
        done = flash.flash(port, options.hex, options.avrdude, show)
        show(_STARTING, 0.0)
        hello = flash.read_hello(port)
    except KeyboardInterrupt:
        raise FlashInterruptedError(f"{name}: interrupted. {_HALF}") from None
    finally:
        if sys.stderr.isatty():
            print(f"\r{'':<72}\r", end="", file=sys.stderr, flush=True)
    text = (
        f"{name}: {done.size:,} bytes written and verified in {done.seconds:.1f} s at {done.speed:,} baud.\n"
        f"The board says: firmware build {hello.build}, protocol version {hello.version}, "
        f"{hello.arena} bytes for a law."
    )
    found = {"port": port, "bytes": done.size, "baud": done.speed, "seconds": done.seconds}
    return Result(text, {**found, "build": hello.build, "version": hello.version, "arena": hello.arena})


def show(stage: str, part: float) -> None:
    """Update a line with a progress bar on a terminal."""
    if sys.stderr.isatty():
        bar = f" {'█' * round(part * _BAR):·<{_BAR}} {part:4.0%}" if stage in (WRITING, VERIFYING) else " …"
        print(f"\r{_WORDS[stage] + bar:<72}", end="", file=sys.stderr, flush=True)


def _only_port() -> str:
    """Return the port of a kit if there is exactly one; otherwise raise DeviceError."""
    ports = [port for port in serial_ports.ports() if port.role is not serial_ports.Role.OTHER]
    kits = [port for port in ports if port.role is serial_ports.Role.KIT] or ports
    if len(kits) != 1:
        there = ", ".join(port.path for port in ports) or "none"
        raise DeviceError(f"Name the board's port: hapkit-studio flash PORT. Available ports: {there}.")
    return kits[0].path


COMMAND = Command("flash", "write the firmware to a board", run, OPTIONS, 35)
