"""What the window's tests share: the simulated device, an engine that leaves the machine alone."""

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics.engine import Engine

PATIENCE_MS = 180_000
"""What anything may take: the first loop is compiled, which takes a busy machine more than a minute."""
SIMULATED = DeviceEntry("simulated", "Simulated Hapkit", SimulatedHapkit)


def build_engine(entry: DeviceEntry) -> Engine:
    """Make an engine at normal priority."""
    return Engine(entry.make(), realtime=False)
