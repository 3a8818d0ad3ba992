"""The serial ports of this computer, each a Hapkit that can be chosen."""

from functools import partial

from hapkit_studio.devices import discovery
from hapkit_studio.devices.base import DeviceEntry, DeviceKind
from hapkit_studio.devices.discovery import Port
from hapkit_studio.devices.hapkit import HapkitBoard


def entries() -> list[DeviceEntry]:
    """Return the ports that have hardware behind them: kits first, surely something else last."""
    return [_entry(port) for port in discovery.ports()]


def _entry(port: Port) -> DeviceEntry:
    return DeviceEntry(port.path, port.title, partial(HapkitBoard, port.path, port.title, port.identity))


def unlisted(key: str) -> HapkitBoard | None:
    """Take what looks like a port for one, e.g. a pseudo-terminal, which no list holds."""
    return HapkitBoard(key) if "/" in key or key.upper().startswith("COM") else None


DEVICE = DeviceKind(2, entries, unlisted)
