"""All errors of the studio. A message is one line with value, limit, unit and remedy."""


class StudioError(Exception):
    """The base class of all errors with a message for the user."""

    exit_code = 2


class Cancelled(StudioError):
    """The work was cancelled; a progress function raises this exception, and other code does not catch it."""


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
    """A device cannot be used; the message contains the reason and the remedy.

    ``brief`` is a short message. ``step`` is a next step that a window can offer, "flash" or "update".
    ``command`` is a shell command that the user can copy.
    """

    def __init__(self, message: str, *, brief: str = "", step: str = "", command: str = ""):
        super().__init__(message)
        self.brief, self.step, self.command = brief or message, step, command


class PortBusyError(DeviceError):
    """Another program uses the port."""


class PortGoneError(DeviceError):
    """The port does not exist or has disappeared."""


class PortPermissionError(DeviceError):
    """The user has no permission to open the port."""


class NotAHapkitError(DeviceError):
    """The port has no Hapkit firmware: it sent no reply or an unknown reply."""


class NoFirmwareError(DeviceError):
    """A kit's board has no firmware, or firmware of another kind."""


class WrongProtocolError(DeviceError):
    """The firmware has a different protocol version."""


class NoDataError(DeviceError):
    """The firmware sent its Hello message, but no further data."""


class AvrdudeMissingError(DeviceError):
    """The program that writes firmware is not on this computer."""


class FlashError(DeviceError):
    """Writing the firmware has failed; the user can try again."""


class FlashInterruptedError(FlashError):
    """The user pressed Ctrl+C while firmware was being written."""

    exit_code = 130
