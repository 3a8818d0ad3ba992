"""The devices one can choose: the simulated Hapkit, the virtual board, each serial port."""

from collections.abc import Callable
from dataclasses import dataclass

from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.errors import ParameterError


@dataclass(frozen=True)
class DeviceEntry:
    """One line of the device list; ``make`` returns the device, not yet opened."""

    key: str
    title: str
    make: Callable[[], object]


def available() -> list[DeviceEntry]:
    """Return what can be chosen now, the embedded device first."""
    from hapkit_studio.devices import hapkit, virtual_board

    found = [DeviceEntry("simulated", SimulatedHapkit.title, SimulatedHapkit)]
    if virtual_board.built():
        found.append(DeviceEntry("virtual-board", "Virtual board", virtual_board.VirtualBoard))
    for port in hapkit.serial_ports():
        found.append(DeviceEntry(port.path, port.title, _maker(port.path, port.title)))
    return found


def _maker(port: str, title: str) -> Callable[[], object]:
    from hapkit_studio.devices import hapkit

    return lambda: hapkit.HapkitBoard(port, title)


def named(key: str) -> object:
    """Return a new device by its key, or for any other port name; raise ParameterError."""
    entries = {e.key: e for e in available()}
    if key in entries:
        return entries[key].make()
    if "/" in key or key.upper().startswith("COM"):
        return _maker(key, "")()
    raise ParameterError(f"There is no device {key!r}; there are: {', '.join(entries)}.")
