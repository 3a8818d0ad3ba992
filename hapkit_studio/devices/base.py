"""What a device file declares: the lines it adds to the device list, found by the name ``DEVICE``."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class DeviceEntry:
    """One line of the device list; ``make`` returns the device, not yet opened."""

    key: str
    title: str
    make: Callable[[], object]


@dataclass(frozen=True)
class DeviceKind:
    """A kind of device: its place in the list, what of it is there now, and what a key not listed means."""

    order: int
    entries: Callable[[], Sequence[DeviceEntry]]
    unlisted: Callable[[str], object | None] = lambda key: None
