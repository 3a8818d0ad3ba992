"""The window's stored settings. Invalid settings are replaced by their defaults and named in one banner."""

from collections.abc import Callable, Collection
from typing import Any, TypeVar

from PySide6.QtCore import QByteArray, QSettings

from hapkit_studio.errors import FileError, ParameterError
from hapkit_studio.files import checked_number, checked_table, parse_json
from hapkit_studio.formatting import quoted

T = TypeVar("T")
LESSONS_FOLDER = "lessons_folder"
"""Name of the setting with the folder of the instructor's lessons; "" means that there is no folder."""
# name of the entry with the last shown notice, so that a notice is not repeated at every start
_LAST_NOTICE = "rejected"
_LONGEST = 160  # maximum number of characters of a notice
_MOST_PX = 10_000.0  # px: maximum of a stored width or height


class StoredSettings(QSettings):
    """Stored settings; ``rejected`` has the reason for each setting that is not used."""

    def __init__(self) -> None:
        super().__init__("hapkit-studio", "hapkit-studio")
        self.rejected: dict[str, str] = {}

    def read(self, name: str, default: T, check: Callable[[object], T]) -> T:
        """Return the stored value, converted by ``check``; if it is missing or invalid, return the default.

        ``check`` raises ParameterError to reject a value.
        """
        if not self.contains(name):
            return default
        try:
            return check(self.value(name))
        except ParameterError as error:
            self.reject(name, error)
            return default

    def reject(self, name: str, reason: object) -> None:
        """Store the reason why a setting or one of its parts is not used."""
        self.rejected.setdefault(name, str(reason))

    def flag(self, name: str, default: bool) -> bool:
        """Return a stored boolean; INI files store it as text."""
        return self.read(name, default, lambda value: _one_of(value, name, (False, True)))

    def choice(self, name: str, default: T, options: Collection[T]) -> T:
        """Return a stored value that must be one of the options."""
        return self.read(name, default, lambda value: _one_of(value, name, options))

    def pixels(self, name: str, default: float) -> float:
        """Return a stored length in px at scale 1."""
        return self.read(name, default, lambda value: checked_number(_parsed(value), name, 0, _MOST_PX, "px"))

    def table(self, name: str) -> dict[str, Any]:
        """Return the object in a stored JSON text; the default is {}."""
        return self.read(name, {}, lambda value: checked_table(parse_json(str(value), name), name))

    def geometry(self, name: str, restore: Callable[[QByteArray], bool]) -> bool:
        """Pass a stored geometry to ``restore``; return whether it was applied."""

        def check(value: object) -> bool:
            if not isinstance(value, QByteArray) or not restore(value):
                raise FileError(f"The stored size of the window ({name}) is damaged.")
            return True

        return self.read(name, False, check)

    def new_notice(self) -> str:
        """Return a line about all rejected settings; "" without any, or if this line was shown before."""
        reasons = list(self.rejected.values())
        text = (
            reasons[0]
            if len(reasons) == 1
            else f"These settings are invalid and not used: {', '.join(self.rejected)}."
            if reasons
            else ""
        )
        text = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
        if text == self.value(_LAST_NOTICE, ""):
            return ""
        self.setValue(_LAST_NOTICE, text)
        return text


def _one_of(value: object, name: str, options: Collection[T]) -> T:
    """Return the option that a stored value or text represents; raise FileError if no option matches."""
    for option in options:
        if (type(value) is type(option) and value == option) or value == str(option).lower():
            return option
    wanted = ", ".join(str(option).lower() for option in options)
    raise FileError(f"{name} is {quoted(value)}; it must be one of {wanted}.")


def _parsed(value: object) -> object:
    """Return the number in a text, because INI files store numbers as text; return other values unchanged."""
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value
