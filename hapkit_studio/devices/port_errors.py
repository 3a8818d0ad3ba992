"""Errors of a serial port, each with a message and the next step."""

import errno
import getpass
import os
import stat
import sys
from pathlib import Path

from hapkit_studio.devices import serial_ports
from hapkit_studio.devices.serial_ports import Port, Role, holder, port_name
from hapkit_studio.errors import (
    DeviceError,
    NoDataError,
    NoFirmwareError,
    NotAHapkitError,
    PortBusyError,
    PortGoneError,
    PortPermissionError,
)

RULES = "/etc/udev/rules.d/60-hapkit.rules"


def permission_remedy(path: str, port: Port | None) -> tuple[str, str]:
    """Return the remedy as text, and a shell command for this port and user; the command may be ""."""
    if sys.platform != "linux":
        return "Ask the administrator of this computer for permission.", ""
    group = _group(path)
    if not group:
        # the udev rule gives access to the user at the computer
        vendor = port.identity.vendor if port else None
        which = f', ATTRS{{idVendor}}=="{vendor:04x}"' if vendor else ', KERNEL=="ttyUSB*|ttyACM*"'
        rule = f'SUBSYSTEM=="tty"{which}, MODE="0660", TAG+="uaccess"'
        then = "sudo udevadm control --reload && sudo udevadm trigger"
        return "Then plug the board in again.", f"echo '{rule}' | sudo tee {RULES} && {then}"
    if _needs_new_login(group):
        return f"You were added to the group {group} after your login: log out and in again.", ""
    return "Then log out and in again.", f"sudo usermod -a -G {group} $USER"


def _group(path: str) -> str:
    """Return the group that has access to a port; "" if only root has access."""
    try:
        mode, group = Path(path).stat().st_mode, Path(path).group()
    except (KeyError, OSError, NotImplementedError):
        return ""
    shared = mode & stat.S_IRGRP and mode & stat.S_IWGRP
    return group if shared and group not in ("root", "tty") else ""


def _needs_new_login(group: str) -> bool:
    """Return True if Linux lists this user in a group that the current login does not have yet."""
    import grp

    try:
        entry = grp.getgrnam(group)
        return getpass.getuser() in entry.gr_mem and entry.gr_gid not in os.getgroups()
    except (KeyError, OSError):
        return False


FLASH = "flash"
"""Next steps that a window can offer; they are values of DeviceError.step."""

_BUSY = {errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK}
_GONE = {errno.ENOENT, errno.ENXIO, errno.ENODEV, errno.EIO}
_FORBIDDEN = {errno.EACCES, errno.EPERM}
_TEXT_SHARE = 0.9
_BANNER = 120
"""Number of characters that fit in a banner next to its buttons."""


def gone(port: str) -> PortGoneError:
    """Return the error for a port that disappeared."""
    title = f"Hapkit on {port_name(port)} is disconnected. Force is zero."
    return PortGoneError(
        f"{title} Plug the board in, then try again.",
        # the window, not this function, tries to reconnect
        brief=f"{title} Trying to reconnect every second.",
    )


def not_there(port: str) -> PortGoneError:
    """Return the error for a port that does not exist when it is opened."""
    return PortGoneError(
        f"{port_name(port)} does not exist. Plug the board in, or see `hapkit-studio devices`.",
        brief=gone(port).brief,
    )


def busy(port: str, by: str = "") -> PortBusyError:
    """Return the error for a port that another program uses."""
    by = by or holder(port) or "another program"
    return PortBusyError(f"{port_name(port)} is used by {by}. Close it, then try again.")


def forbidden(port: str) -> PortPermissionError:
    """Return the error for a port without permission, with the command that grants permission."""
    text, command = permission_remedy(port, serial_ports.at(port))
    title = f"You have no permission to open {port_name(port)}."
    if not command:
        return PortPermissionError(f"{title} {text}")
    full = f"{title} Run `{command}`. {text}"
    brief = full if len(full) < _BANNER else f"{title} Copy the command and run it in a terminal. {text}"
    return PortPermissionError(full, brief=brief, command=command)


def not_a_hapkit(port: str, heard: bytes) -> DeviceError:
    """Return the error for a port without a Hapkit, based on the received bytes, if any."""
    name, known = port_name(port), serial_ports.at(port)
    if known is not None and known.role is Role.OTHER:
        return NotAHapkitError(
            f"{name} is a different kind of port: {known.description}. Choose another port."
        )
    if by := holder(port):  # with two readers, each receives only some of the bytes
        return busy(port, by)
    what = f"{name} answers, but is not a Hapkit." if heard else f"{name} does not answer."
    if known is None or known.role is not Role.KIT:
        return NotAHapkitError(f"{what} Flash the firmware, or choose another port.", step=FLASH)
    if sum(byte in b"\r\n\t" or 32 <= byte < 127 for byte in heard) >= _TEXT_SHARE * max(len(heard), 1):
        what = f"{name} sends text instead of Hapkit data."
    why = (
        "The board runs another sketch" if heard else "The board has no firmware yet, or runs another sketch"
    )
    return NoFirmwareError(f"{what} {why}: flash the firmware.", step=FLASH)


def no_answer(port: str, question: str, seconds: float) -> NoDataError:
    """Return the error for a board that did not reply to a request."""
    return NoDataError(
        f"The Hapkit on {port_name(port)} did not answer {question} within {seconds:g} s. "
        "Check the USB cable, then try again."
    )


def no_data(port: str, seconds: float) -> NoDataError:
    """Return the error for a board that sent Hello but no samples."""
    return NoDataError(
        f"The Hapkit on {port_name(port)} identified itself, but sent no sample for {seconds:g} s. "
        "Press the board's reset button, then try again."
    )


def unopened(port: str, error: OSError) -> DeviceError:
    """Return the error for an OSError that occurred when a port was opened."""
    number = error.errno
    if number is None and sys.platform == "win32":  # on Windows pyserial stores only the text
        return busy(port) if "PermissionError" in str(error) else not_there(port)
    if number in _BUSY:
        return busy(port)
    if number in _FORBIDDEN:
        return forbidden(port)
    if number in _GONE:
        return not_there(port)
    return NotAHapkitError(f"{port_name(port)} is not a serial port. Choose another port.")
