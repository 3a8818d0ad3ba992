"""The available devices: each module with a ``DEVICE``, here or in other packages, defines one kind."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

from hapkit_studio import lab
from hapkit_studio.devices.base import Device
from hapkit_studio.discovery import declared
from hapkit_studio.errors import ParameterError

ENTRY_POINTS = "hapkit_studio.devices"


@dataclass(frozen=True)
class DeviceEntry:
    """A row of the device list; ``make`` returns the device, which is not open yet."""

    key: str
    title: str
    make: Callable[[], Device]


@dataclass(frozen=True)
class DeviceKind:
    """A kind of device: its position in the list, its current entries, and a device for an unlisted key."""

    order: int
    entries: Callable[[], Sequence[DeviceEntry]]
    unlisted: Callable[[str], Device | None] = lambda key: None


@cache
def kinds() -> tuple[DeviceKind, ...]:
    """Return every kind of device in list order."""
    return tuple(
        sorted(declared(__name__, "DEVICE", DeviceKind, group=ENTRY_POINTS), key=lambda kind: kind.order)
    )


def available() -> list[DeviceEntry]:
    """Return the devices available now and allowed here; the simulated Hapkit is the first one."""
    allowed = lab.settings()
    return [entry for kind in kinds() for entry in kind.entries() if allowed.allows(entry.key)]


def check_allowed(key: str) -> None:
    """Raise ParameterError if a device may not be used on this computer."""
    lab.check()
    if not lab.settings().allows(key):
        raise ParameterError(f"{lab.FILE} does not allow the device {key} on this computer.")


def named(key: str) -> Device:
    """Return a new device by its key or an unlisted port's path; raise ParameterError for any other key."""
    check_allowed(key)
    entries = {e.key: e for e in available()}
    if key in entries:
        return entries[key].make()
    for kind in kinds():
        device = kind.unlisted(key)
        if device is not None:
            return device
    raise ParameterError(f"There is no device {key!r}. Available devices: {', '.join(entries)}.")
