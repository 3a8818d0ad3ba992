"""What can be wrong with a serial port, in the words that a person reads."""

import errno
import sys
from pathlib import Path

from hapkit_studio.errors import (
    DeviceError,
    NoDataError,
    NotAHapkitError,
    ParameterError,
    PortBusyError,
    PortGoneError,
    PortPermissionError,
    WrongProtocolError,
)

_BUSY = {errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK}
_GONE = {errno.ENOENT, errno.ENXIO, errno.ENODEV, errno.EIO}
_FORBIDDEN = {errno.EACCES, errno.EPERM}


def port_name(port: str) -> str:
    """Return the short name of a port: ttyUSB0, COM3."""
    return port.removeprefix("/dev/")


def gone(port: str) -> PortGoneError:
    """Return the error of a port that is not there, or no longer."""
    return PortGoneError(f"Hapkit on {port_name(port)} is gone. Force is zero. Looking again every second.")


def busy(port: str) -> PortBusyError:
    """Return the error of a port that another program has opened."""
    return PortBusyError(f"{port_name(port)} is used by another program. Close it, then try again.")


def forbidden(port: str) -> PortPermissionError:
    """Return the error of a port that this user may not open."""
    group = _group(port)
    remedy = f"Join the group {group}, then log in again" if group else "Ask for the right to use it"
    return PortPermissionError(f"You may not open {port_name(port)}. {remedy}.")


def not_a_hapkit(port: str, heard: bool) -> NotAHapkitError:
    """Return the error of a port on which no Hapkit said hello; heard: something else was received."""
    what = "answers, but not as a Hapkit" if heard else "does not answer"
    return NotAHapkitError(f"{port_name(port)} {what}. Flash the firmware, or choose another port.")


def wrong_version(firmware: int, studio: int) -> WrongProtocolError:
    """Return the error of firmware that is older or newer than the studio."""
    remedy = "Update firmware" if firmware < studio else "Update the studio"
    return WrongProtocolError(f"Firmware speaks version {firmware}; this studio needs {studio}. {remedy}.")


def no_answer(port: str, question: str, seconds: float) -> NoDataError:
    """Return the error of a board that did not answer a question."""
    return NoDataError(
        f"The Hapkit on {port_name(port)} did not answer {question} within {seconds:g} s. "
        "Check the USB cable, then try again."
    )


def no_data(port: str, seconds: float) -> NoDataError:
    """Return the error of a board that said hello and then sent no samples."""
    return NoDataError(
        f"The Hapkit on {port_name(port)} says hello, but no sample came for {seconds:g} s. "
        "Check the USB cable, then press the board's reset button."
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
        return busy(port) if "PermissionError" in str(error) else gone(port)
    if number in _BUSY:
        return busy(port)
    if number in _FORBIDDEN:
        return forbidden(port)
    if number in _GONE:
        return gone(port)
    return NotAHapkitError(f"{port_name(port)} is not a serial port. Choose another port.")


def _group(port: str) -> str:
    """Return the group that owns a port, or nothing where there is no such thing."""
    try:
        return Path(port).group()
    except (KeyError, OSError, NotImplementedError):
        return ""
