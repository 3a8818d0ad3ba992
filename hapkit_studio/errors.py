"""Every error of the studio: one line with value, limit, unit and what to do."""


class StudioError(Exception):
    """Base of all errors that are meant for a person to read."""

    exit_code = 2


class ParameterError(StudioError, ValueError):
    """A name is unknown, or a value is out of range or not a number."""


class FileError(ParameterError):
    """A file cannot be read, or a value in it cannot be used; the text names file, place, value and limit."""


class LawError(StudioError):
    """A force law leaves the law language; carries the line it stands on."""

    def __init__(self, message: str, line: int = 0):
        super().__init__(message if not line else f"Line {line}: {message}")
        self.line = line


class DeviceError(StudioError):
    """A device cannot be used; the text says why and what to do.

    brief: the text where there is less room. step: a next step that a window can offer, "flash" or "update".
    command: a line for a terminal, to copy.
    """

    def __init__(self, message: str, *, brief: str = "", step: str = "", command: str = ""):
        super().__init__(message)
        self.brief, self.step, self.command = brief or message, step, command


class PortBusyError(DeviceError):
    """Another program holds the port."""


class PortGoneError(DeviceError):
    """The port does not exist, or went away."""


class PortPermissionError(DeviceError):
    """The user may not open the port."""


class NotAHapkitError(DeviceError):
    """Something answers on the port, or nothing does, but not the firmware."""


class NoFirmwareError(DeviceError):
    """A board that kits have is there, but runs something else, or nothing."""


class WrongProtocolError(DeviceError):
    """The firmware speaks another version of the protocol."""


class NoDataError(DeviceError):
    """The firmware said hello, but what should follow does not come."""


class AvrdudeMissingError(DeviceError):
    """The program that writes firmware is not on this computer."""


class FlashError(DeviceError):
    """The firmware could not be written; the board takes another try."""


class FlashInterruptedError(FlashError):
    """A person pressed Ctrl+C while firmware was being written."""

    exit_code = 130
