"""What moves the loop: one driver a kind of device, all with the same tick."""

from typing import Protocol

import numpy as np

from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.errors import DeviceError
from hapkit_studio.haptics import block, plant, rig, simulated_loop
from hapkit_studio.haptics.rig import Rig
from hapkit_studio.haptics.ring import Ring, new_ring


class Driver(Protocol):
    """Owns one connection; ``run`` keeps its thread until the rig is told to quit."""

    hold_seconds: float

    def run(self, r: Rig, out: Ring, late: np.ndarray) -> None:
        """Render until told to quit; whatever ends it, the last act is a zero command."""

    def delay(self, r: Rig) -> float:
        """Return the measured delay in s from a sample to its force."""

    def close(self) -> None:
        """Let go of the device."""


class SimulatedDriver:
    """The embedded device: nothing to open, nothing to lose."""

    hold_seconds = 0.0

    def __init__(self, device: SimulatedHapkit):
        self.body = plant.new_plant(device)

    def run(self, r: Rig, out: Ring, late: np.ndarray) -> None:
        simulated_loop.run(r, self.body, out, late)

    def delay(self, r: Rig) -> float:
        return float(r.values[block.DELAY])

    def close(self) -> None:
        pass


def compile_ahead(driver: Driver, r: Rig, late: np.ndarray) -> None:
    """Compile or load the driver's loop by running it with the quit word set: no sample is rendered."""
    r.control[rig.QUIT] = 1
    spare = new_ring(r.control, 2)
    driver.run(r, spare, late)
    r.control[rig.QUIT] = 0
    r.control[rig.DONE] = 0


def driver_for(device) -> Driver:
    """Return an open driver for a device; raise DeviceError."""
    if isinstance(device, SimulatedHapkit):
        return SimulatedDriver(device)
    raise DeviceError(f"{device!r} is not a device that the studio can drive.")
