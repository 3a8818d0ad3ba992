"""The serial ports of this computer, each a Hapkit that can be chosen."""

from functools import partial

from serial.tools import list_ports

from hapkit_studio.devices.base import DeviceEntry, DeviceKind
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.devices.port_errors import port_name


def entries() -> list[DeviceEntry]:
    """Return the ports that have hardware behind them, with their names, in the order of their paths."""
    found = [p for p in list_ports.comports() if p.hwid and p.hwid != "n/a"]
    names = {p.device: p.product or p.description.replace("n/a", "") for p in found}
    titles = {path: f"{port_name(path)}: {names[path]}".rstrip(": ") for path in sorted(names)}
    return [DeviceEntry(path, title, partial(HapkitBoard, path, title)) for path, title in titles.items()]


def unlisted(key: str) -> HapkitBoard | None:
    """Take what looks like a port for one, e.g. a pseudo-terminal, which no list holds."""
    return HapkitBoard(key) if "/" in key or key.upper().startswith("COM") else None


DEVICE = DeviceKind(2, entries, unlisted)
