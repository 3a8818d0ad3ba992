"""Every error of the studio: one line with value, limit, unit and what to do."""


class StudioError(Exception):
    """Base of all errors with a message for the user."""

    exit_code = 2


class Cancelled(StudioError):
    """The work was cancelled; a progress function raises this exception, and it is passed through."""


class ParameterError(StudioError, ValueError):
    """A name is unknown, or a value is out of range or not a number."""


class FileError(ParameterError):
    """A file or a value in it is invalid; the message contains file, place, value and limit."""


class LawError(StudioError):
    """A force law violates the rules of the law language; the message contains the line."""

    def __init__(self, message: str, line: int = 0):
        super().__init__(message if not line else f"Line {line}: {message}")
        self.line = line


class DeviceError(StudioError):
    """A device cannot be used; the message contains reason and remedy.

    brief: short message. step: a next step that a window can offer, "flash" or "update". command: a shell
    command to copy.
    """

    def __init__(self, message: str, *, brief: str = "", step: str = "", command: str = ""):
        super().__init__(message)
        self.brief, self.step, self.command = brief or message, step, command


class PortBusyError(DeviceError):
    """Another program holds the port."""


class PortGoneError(DeviceError):
    """The port does not exist, or disappeared."""


class PortPermissionError(DeviceError):
    """The user has no permission to open the port."""


class NotAHapkitError(DeviceError):
    """The port has no Hapkit firmware: it sent no reply, or an unknown one."""


class NoFirmwareError(DeviceError):
    """A kit's board has no firmware, or a different one."""


class WrongProtocolError(DeviceError):
    """The firmware has a different protocol version."""


class NoDataError(DeviceError):
    """The firmware sent Hello, but no further data."""


class AvrdudeMissingError(DeviceError):
    """The program that writes firmware is not on this computer."""


class FlashError(DeviceError):
    """Writing the firmware failed; it can be retried."""


class FlashInterruptedError(FlashError):
    """The user pressed Ctrl+C while firmware was being written."""

    exit_code = 130
