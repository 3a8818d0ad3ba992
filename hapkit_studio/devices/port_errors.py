"""What can be wrong with a serial port, in the words that a person reads, and the next step."""

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
    ParameterError,
    PortBusyError,
    PortGoneError,
    PortPermissionError,
    WrongProtocolError,
)

RULES = "/etc/udev/rules.d/60-hapkit.rules"


def permission_remedy(path: str, port: Port | None) -> tuple[str, str]:
    """Return what to do in words, and the line to run for this port and person, which may be none."""
    if sys.platform != "linux":
        return "Ask for the right to use it.", ""
    group = _group(path)
    if not group:
        return "Then plug the board in again.", _rule(port)
    if _joined(group):
        return f"You are in the group {group} since you logged in: log out and in again.", ""
    return "Then log out and in again.", f"sudo usermod -a -G {group} $USER"


def _rule(port: Port | None) -> str:
    """Return the line that lets whoever sits at the computer open this kind of port."""
    vendor = port.identity.vendor if port else None
    which = f', ATTRS{{idVendor}}=="{vendor:04x}"' if vendor else ', KERNEL=="ttyUSB*|ttyACM*"'
    rule = f'SUBSYSTEM=="tty"{which}, MODE="0660", TAG+="uaccess"'
    return f"echo '{rule}' | sudo tee {RULES} && sudo udevadm control --reload && sudo udevadm trigger"


def _group(path: str) -> str:
    """Return the group whose members may use a port; nothing where no group but root's may."""
    try:
        mode, group = Path(path).stat().st_mode, Path(path).group()
    except (KeyError, OSError, NotImplementedError):
        return ""
    shared = mode & stat.S_IRGRP and mode & stat.S_IWGRP
    return group if shared and group not in ("root", "tty") else ""


def _joined(group: str) -> bool:
    """Tell whether the system lists this person in a group that this login does not have yet."""
    if sys.platform == "win32":
        return False
    import grp

    try:
        entry = grp.getgrnam(group)
        return getpass.getuser() in entry.gr_mem and entry.gr_gid not in os.getgroups()
    except (KeyError, OSError):
        return False


FLASH, UPDATE = "flash", "update"
"""Next steps that a window can offer, see DeviceError.step."""

_BUSY = {errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK}
_GONE = {errno.ENOENT, errno.ENXIO, errno.ENODEV, errno.EIO}
_FORBIDDEN = {errno.EACCES, errno.EPERM}
_TEXT_SHARE = 0.9
_BANNER = 120
"""Characters that a banner has room for beside its buttons."""


def gone(port: str) -> PortGoneError:
    """Return the error of a port that is not there, or no longer."""
    title = f"Hapkit on {port_name(port)} is gone. Force is zero."
    return PortGoneError(
        f"{title} Plug it in, then try again.",
        brief=f"{title} Looking again every second.",  # a window does
    )


def not_there(port: str) -> PortGoneError:
    """Return the error of a port that does not exist when it is to be opened."""
    return PortGoneError(
        f"{port_name(port)} is not there. Plug the board in, or see `hapkit-studio devices`.",
        brief=gone(port).brief,
    )


def busy(port: str, by: str = "") -> PortBusyError:
    """Return the error of a port that another program has opened."""
    by = by or holder(port) or "another program"
    return PortBusyError(f"{port_name(port)} is used by {by}. Close it, then try again.")


def forbidden(port: str) -> PortPermissionError:
    """Return the error of a port that this user may not open, with the line that mends it."""
    words, command = permission_remedy(port, serial_ports.at(port))
    title = f"You may not open {port_name(port)}."
    if not command:
        return PortPermissionError(f"{title} {words}")
    full = f"{title} Run `{command}`. {words}"
    brief = full if len(full) < _BANNER else f"{title} Copy the line, run it in a terminal. {words}"
    return PortPermissionError(full, brief=brief, command=command)


def not_a_hapkit(port: str, heard: bytes) -> DeviceError:
    """Return the error of a port on which no Hapkit said hello, from what was heard instead, if anything."""
    name, known = port_name(port), serial_ports.at(port)
    if known is not None and known.role is Role.OTHER:
        return NotAHapkitError(f"{name} is a port of another kind: {known.words}. Choose another port.")
    if by := holder(port):  # two readers share what comes: neither gets it whole
        return busy(port, by)
    if known is not None and known.role is Role.KIT:
        return _no_firmware(name, heard)
    what = "answers, but not as a Hapkit" if heard else "does not answer"
    return NotAHapkitError(f"{name} {what}. Flash the firmware, or choose another port.", step=FLASH)


def _no_firmware(name: str, heard: bytes) -> NoFirmwareError:
    """Return the error of a kit's board that runs something else, or nothing."""
    if not heard:
        why = f"{name} does not answer. The board has no firmware yet, or another sketch"
    elif _is_text(heard):
        why = f"{name} sends text, not frames. Another sketch is on the board"
    else:
        why = f"{name} answers, but not as a Hapkit. Another sketch is on the board"
    return NoFirmwareError(f"{why}: flash the firmware.", step=FLASH)


def _is_text(heard: bytes) -> bool:
    printable = sum(byte in b"\r\n\t" or 32 <= byte < 127 for byte in heard)
    return printable >= _TEXT_SHARE * len(heard)


def wrong_version(firmware: int, studio: int) -> WrongProtocolError:
    """Return the error of firmware that is older or newer than the studio."""
    old = firmware < studio
    remedy = "Update firmware" if old else "Update the studio"
    return WrongProtocolError(
        f"Firmware speaks version {firmware}; this studio needs {studio}. {remedy}.",
        step=UPDATE if old else "",
    )


def impossible(port: str, what: str, value: float, limits: tuple[float, float], unit: str) -> NotAHapkitError:
    """Return the error of a board that says a number of itself which no Hapkit has."""
    possible = " ".join(f"{limits[0]:g} to {limits[1]:g} {unit}".split())
    return NotAHapkitError(
        f"{port_name(port)} says {value:g} for {what}; a Hapkit has {possible}. Flash the firmware.",
        step=FLASH,
    )


def no_answer(port: str, question: str, seconds: float) -> NoDataError:
    """Return the error of a board that did not answer a question, or did not even take it."""
    return NoDataError(
        f"The Hapkit on {port_name(port)} did not answer {question} within {seconds:g} s. "
        "Check the USB cable, then try again."
    )


def no_data(port: str, seconds: float) -> NoDataError:
    """Return the error of a board that said hello and then sent no samples."""
    return NoDataError(
        f"The Hapkit on {port_name(port)} says hello, but no sample came for {seconds:g} s. "
        "Press the board's reset button, then try again."
    )


def settings_refused(port: str) -> ParameterError:
    """Return the error of settings that the board does not take."""
    return ParameterError(
        f"The Hapkit on {port_name(port)} refused these settings: a number in them is one that no kit has. "
        "Nothing was changed. Check geometry, motor constant and force limit."
    )


def unopened(port: str, error: OSError) -> DeviceError:
    """Return the error that fits an operating system's refusal to open a port."""
    number = error.errno
    if number is None and sys.platform == "win32":  # pyserial keeps only the text there
        return busy(port) if "PermissionError" in str(error) else not_there(port)
    if number in _BUSY:
        return busy(port)
    if number in _FORBIDDEN:
        return forbidden(port)
    if number in _GONE:
        return not_there(port)
    return NotAHapkitError(f"{port_name(port)} is not a serial port. Choose another port.")
