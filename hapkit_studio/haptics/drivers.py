"""Drivers run the loop: there is one for each kind of connection, and all use the same tick."""

import sys
from typing import Any

import numpy as np

from hapkit_studio.devices.base import SERIAL, SIMULATED, Device
from hapkit_studio.errors import DeviceError
from hapkit_studio.haptics import board_plan, link, serial_loop, simulated_loop
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.board_plan import BoardPlan, BoardPlanner
from hapkit_studio.haptics.health import silent
from hapkit_studio.haptics.link import Link
from hapkit_studio.haptics.rows import Ring

# s: duration of zero force after connecting, during which the delay of the line is measured
ZERO_FORCE_SECONDS = 0.5


class Driver:
    """The owner of one connection; ``run`` returns when the control word ``quit`` is set.

    ``zero_force_seconds`` is the duration of zero force after the start, in s. ``rate`` is the rate of the
    device's clock in Hz, or None if the device has no clock. ``planner`` plans how the board renders laws.
    Without a board, it is None, and ``no_planner`` states the reason in one line.
    """

    zero_force_seconds = 0.0
    rate: float | None = None
    planner: BoardPlanner | None = None
    no_planner = ""

    def __init__(self, conn: Link):
        self.conn = conn

    def run(self, r: LoopArrays, out: Ring, late: np.ndarray) -> None:
        """Render until ``quit`` is set; always send a zero force as the last message."""
        raise NotImplementedError

    def refusal(self, plan: BoardPlan) -> str:
        """Return one line that says why the board refused a plan; "" if the board did not refuse it."""
        state = self.conn.state
        refused = state.refused == plan.code_id
        return board_plan.refusal_text(int(state.refusal)) if refused else ""

    def move_hand(self, target: float | None, grip: str) -> None:
        """Move the simulated hand on the handle, if the device has one."""

    def close(self) -> None:
        """Disconnect the device."""


class SimulatedDriver(Driver):
    """Runs the loop on a simulated device; the parameter block contains the motion of the hand."""

    def __init__(self, device: Device):
        super().__init__(link.new_link(device.quantum))
        self.rate, self.no_planner = device.rate, no_board(device)
        self.body = simulated_loop.new_plant(device.model)

    def run(self, r: LoopArrays, out: Ring, late: np.ndarray) -> None:
        simulated_loop.run(r, self.body, out, late)


class SerialDriver(Driver):
    """Runs the loop on a board at a serial port, synchronised to the board's samples."""

    zero_force_seconds = ZERO_FORCE_SECONDS

    def __init__(self, device: Any):
        device.open()
        super().__init__(link.new_link(device.quantum, 1e-3 * device.hello.watchdog_ms))
        self.device = device
        self.rate = device.rate
        if device.hello.arena == 0:
            self.no_planner = "The firmware on this board cannot render laws. Update the firmware."
            return
        try:
            settings = device.settings()
        except DeviceError as error:
            self.no_planner = str(error)
            return
        self.planner = BoardPlanner(device.hello.arena, settings)
        board_plan.configure_link(self.conn, settings, device.hello.pwm_top)

    def run(self, r: LoopArrays, out: Ring, late: np.ndarray) -> None:
        if not r.control.quit[0]:
            self.device.start_stream()
        self._loop(r, out, late)
        if self.conn.state.quiet >= link.GONE_AFTER:
            text = silent(self.device.name, link.GONE_AFTER)
            raise DeviceError(f"{text} The force is zero. Trying to reconnect every second.")

    def _loop(self, r: LoopArrays, out: Ring, late: np.ndarray) -> None:
        serial_loop.run(r, self.conn, out, late, self.device.fileno())

    def move_hand(self, target: float | None, grip: str) -> None:
        self.device.set_grip(grip)
        self.device.move_hand(target)

    def close(self) -> None:
        self.device.close()


class PortableDriver(SerialDriver):
    """Runs the loop in a plain Python thread, for systems whose ports are not file descriptors."""

    def _loop(self, r: LoopArrays, out: Ring, late: np.ndarray) -> None:
        if r.control.quit[0]:
            serial_loop.warm_up()
        else:
            serial_loop.run_portable(r, self.conn, out, late, self.device.read, self.device.write)


_DRIVERS: dict[str, type[SimulatedDriver] | type[SerialDriver]] = {
    SIMULATED: SimulatedDriver,
    SERIAL: PortableDriver if sys.platform == "win32" else SerialDriver,
}


def driver_for(device: Device) -> Driver:
    """Open a device and return its driver; raise DeviceError if this fails."""
    if device.driver not in _DRIVERS:
        drivers = ", ".join(_DRIVERS)
        raise DeviceError(f"{device.title}: its driver must be one of {drivers}, not {device.driver!r}.")
    return _DRIVERS[device.driver](device)


def no_board(device: Device) -> str:
    """Return one line that says why a device without a board cannot render laws itself."""
    return f"{device.title} has no board, so only the computer can render."
