"""What a device says of itself: its capabilities, and which loop runs it."""

from collections.abc import Callable
from typing import Any

from hapkit_studio.dynamics.hand import Grip

SIMULATED, SERIAL = "simulated", "serial"
"""Drivers: the loop moves the device's ``model`` itself; samples and forces go through a port."""


class Device:
    """A device that the loop can run on. Subclasses override what differs.

    Everything is known before ``open``, except for the properties of the handle and ``rate``, which a board
    tells when it is opened. The defaults are those that are safe: with a motor, and with a delay to measure.
    """

    title: str
    """Name in lists and in recordings."""
    driver: str
    """SIMULATED or SERIAL."""

    # --- the handle
    mass: float
    """kg at the handle."""
    viscous: float
    """Damping in N·s/m."""
    coulomb_force: float
    """Coulomb friction in N."""
    quantum: float
    """Travel per count of the sensor in m."""
    max_force: float
    """Force limit in N."""

    # --- capabilities
    motor = True
    """A motor moves: settings that no person has chosen wait for *Render*."""
    simulated_hand = False
    """Mouse, keys and scripts move the hand on the handle; else a person holds it."""
    measures_delay = True
    """The device reports when a force took effect; else the delay is exactly the added delay."""
    own_clock = False
    """The device samples at its own ``rate``; else a person chooses the loop's rate."""
    has_board = False
    """A processor of its own can render laws."""
    calibration = False
    """It has settings and a zero that can be set up and tested."""
    usb_chip = False
    """A USB chip may hold frames back: its latency timer and the padding of frames matter."""
    port = ""
    """Path of the serial port in use, "" without one."""
    latency: Any = None
    """The ``serial_ports.Latency`` of the port, None without a port."""
    padding = 0
    """Bytes to which every frame is filled."""

    @property
    def model(self) -> Any:
        """Return the SimulatedHapkit that the loop moves, so that true motion and hand force are known.

        None for hardware.
        """
        return None

    @property
    def rate(self) -> float | None:
        """Return the rate in Hz of the device's own clock, None without one."""
        return None

    @property
    def name(self) -> str:
        """Return the name in a sentence."""
        return self.title

    @property
    def flash_port(self) -> str:
        """Return the port through which firmware is written, "" without one."""
        return ""

    def about(self) -> dict[str, Any]:
        """Return what a recording notes besides title and sensor, e.g. the firmware."""
        return {}

    def probe(self) -> dict[str, Any]:
        """Open the device, ask what it is, close it: ``text`` for a person, ``ok``, and the numbers."""
        return {"ok": True, "text": "Always there: part of the studio."}

    # --- commands, no-ops where the capability is missing
    def report_opening(self, say: Callable[[str], object]) -> None:
        """Call ``say`` with what ``open`` waits for, in the thread that opens."""

    def pad_frames(self, size: int) -> None:
        """Fill every frame to so many bytes, 0 not at all; takes effect at once."""

    def set_grip(self, grip: Grip | str | None) -> None:
        """Choose how firmly the hand holds where the device simulates it; raise ParameterError."""

    def move_hand(self, target: float | None) -> None:
        """Move that hand to a position in m; None lets go."""

    def hook_spring(self, stiffness: float | None) -> None:
        """Put a spring in N/m between handle and middle in place of that hand; None removes it."""

    def unpaced(self) -> "Device":
        """Return a device that does the same as fast as it can; itself where time cannot be sped up."""
        return self
