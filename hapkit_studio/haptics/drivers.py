"""What moves the loop: one driver a kind of device, all with the same tick."""

import sys
from typing import Protocol

import numpy as np

from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.errors import DeviceError
from hapkit_studio.haptics import block, board_offer, delays, line, plant, rig, serial_loop, simulated_loop
from hapkit_studio.haptics import way as ways
from hapkit_studio.haptics.board_offer import Offer
from hapkit_studio.haptics.delays import Measured
from hapkit_studio.haptics.faults import silent
from hapkit_studio.haptics.fences import store_release
from hapkit_studio.haptics.portable_loop import PortableLoop, warm_up
from hapkit_studio.haptics.rig import Rig
from hapkit_studio.haptics.ring import Ring, new_ring
from hapkit_studio.haptics.settings_writer import BoardWay

# After connecting, force stays zero that long while the delay of the line is measured.
HOLD_SECONDS = 0.5
LATELY = 2000
"""Measured delays that count, a second or two of them."""


class Driver(Protocol):
    """Owns one connection; ``run`` keeps its thread until the rig is told to quit."""

    hold_seconds: float
    offer: Offer | None
    """What the device can render by itself."""
    no_offer: str
    """Why that is nothing, in one line."""

    @property
    def rate(self) -> float | None:
        """Return the rate in Hz that the device itself sets, None where the loop does."""

    def run(self, r: Rig, out: Ring, late: np.ndarray) -> None:
        """Render until told to quit; whatever ends it, the last act is a zero command."""

    def delay(self, r: Rig) -> float:
        """Return the measured delay in s from a sample to its force, of whoever renders."""

    def measured(self, board: bool) -> Measured | None:
        """Return the delay of one way as measured lately; None where it was not yet, or cannot be."""

    def refusal(self, way: BoardWay) -> str:
        """Return in one line why the device has refused to render what it was sent, "" if it has not."""

    def on_board(self) -> bool:
        """Say whether the device renders by itself at this moment."""

    def overruns(self) -> int:
        """Return how many ticks the device has skipped when it rendered by itself."""

    def move_hand(self, target: float | None, grip: str) -> None:
        """Move the hand on the handle, where the device has one."""

    def close(self) -> None:
        """Let go of the device."""


class SimulatedDriver:
    """The embedded device: nothing to open, nothing to lose; its hand comes with the parameter block."""

    hold_seconds = 0.0
    rate = None
    offer: Offer | None = None
    no_offer = "The simulated Hapkit has no board: the computer renders."

    def __init__(self, device: SimulatedHapkit):
        self.body = plant.new_plant(device)

    def run(self, r: Rig, out: Ring, late: np.ndarray) -> None:
        simulated_loop.run(r, self.body, out, late)

    def delay(self, r: Rig) -> float:
        return float(r.values[block.DELAY])

    def measured(self, board: bool) -> Measured | None:
        return None

    def refusal(self, way: BoardWay) -> str:
        return ""

    def on_board(self) -> bool:
        return False

    def overruns(self) -> int:
        return 0

    def move_hand(self, target: float | None, grip: str) -> None:
        pass

    def close(self) -> None:
        pass


class SerialDriver:
    """A board at the end of a port, paced by its samples."""

    hold_seconds = HOLD_SECONDS

    def __init__(self, device: HapkitBoard):
        device.open()
        self.device = device
        self.rate = device.rate
        self.conn = line.new_line(device.quantum, 1e-3 * device.hello.watchdog_ms)
        found = board_offer.offered(device)
        self.offer: Offer | None = None if isinstance(found, str) else found
        self.no_offer = found if isinstance(found, str) else ""
        if self.offer is not None and self.offer.settings is not None:
            board_offer.tell(self.conn, self.offer.settings, device.hello.pwm_top)
        self._spec = serial_loop.new_spec()

    def run(self, r: Rig, out: Ring, late: np.ndarray) -> None:
        if not r.control[rig.QUIT]:
            self.device.start_stream()
        serial_loop.run(r, self.conn, out, late, self.device.fileno(), self._spec)
        self._complain()

    def _complain(self) -> None:
        """Raise DeviceError where the loop ended because the board fell silent."""
        if self.conn.numbers[line.QUIET] >= line.GONE_AFTER:
            words = silent(self.device.name, line.GONE_AFTER)
            raise DeviceError(f"{words} Force is zero. Looking again every second.")

    def delay(self, r: Rig) -> float:
        found = self.measured(self.on_board())
        return 0.0 if found is None else found.mean

    def measured(self, board: bool) -> Measured | None:
        return delays.measured(self.conn.delays, delays.BOARD if board else delays.COMPUTER, LATELY)

    def refusal(self, way: BoardWay) -> str:
        words = self.conn.words
        return board_offer.refused(int(words[ways.REFUSAL])) if words[ways.REFUSED] == way.form else ""

    def on_board(self) -> bool:
        return int(self.conn.words[ways.WAY]) == ways.THERE

    def overruns(self) -> int:
        return int(self.conn.words[ways.SKIPPED])

    def move_hand(self, target: float | None, grip: str) -> None:
        if isinstance(self.device, VirtualBoard):
            self.device.set_grip(grip)
            self.device.move_hand(target)

    def close(self) -> None:
        self.device.close()


class PortableDriver(SerialDriver):
    """The same in a plain Python thread, for systems whose ports are no file descriptors."""

    def run(self, r: Rig, out: Ring, late: np.ndarray) -> None:
        if r.control[rig.QUIT]:
            warm_up()
            return
        self.device.start_stream()
        PortableLoop(self.conn, self.device.read, self.device.write).run(r, out, late)
        self._complain()


def compile_ahead(driver: Driver, r: Rig, late: np.ndarray) -> None:
    """Compile or load the driver's loop by running it with the quit word set: no sample is rendered."""
    store_release(r.control, rig.QUIT, 1)
    driver.run(r, new_ring(r.control, 2), late)
    store_release(r.control, rig.QUIT, 0)


def driver_for(device) -> Driver:
    """Return the driver of a device, opened; raise DeviceError."""
    if isinstance(device, SimulatedHapkit):
        return SimulatedDriver(device)
    if isinstance(device, HapkitBoard):
        return PortableDriver(device) if sys.platform == "win32" else SerialDriver(device)
    raise DeviceError(f"{device!r} is not a device that the studio can drive.")
