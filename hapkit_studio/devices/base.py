"""The interface of a device: its capabilities and the loop that drives it."""

from collections.abc import Callable
from typing import Any

from hapkit_studio.dynamics.hand import Grip

SIMULATED, SERIAL = "simulated", "serial"
"""SIMULATED: the loop simulates the device's ``model``. SERIAL: samples and forces go through a port."""


class Device:
    """A device on which the loop can run. Subclasses override the parts that differ.

    Everything is known before ``open``, except for the properties of the handle and ``rate``, which a board
    reports when it is opened. The defaults are the safe values: the device has a motor, and its delay
    must be measured.
    """

    title: str
    """Name in lists and in recordings."""
    driver: str
    """SIMULATED or SERIAL."""

    # --- the handle
    mass: float
    """Mass at the handle in kg."""
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
    """True if a real motor moves the handle: restored settings then wait for *Render*."""
    simulated_hand = False
    """True if mouse, keys and scripts move a simulated hand; otherwise a person holds the handle."""
    measures_delay = True
    """True if the device reports when a force took effect; otherwise the delay is exactly the added delay."""
    own_clock = False
    """True if the device samples at its own ``rate``; otherwise the user chooses the loop's rate."""
    has_board = False
    """True if the device's processor can render laws."""
    calibration = False
    """True if the device has settings and a zero that can be calibrated and tested."""
    usb_chip = False
    """True if a USB chip may delay frames, so that its latency timer and padding matter."""
    port = ""
    """Path of the serial port in use, "" if no port is used."""
    latency: Any = None
    """The ``serial_ports.Latency`` of the port; None if no port is used."""
    padding = 0
    """Bytes to which every frame is padded."""

    @property
    def model(self) -> Any:
        """Return the SimulatedHapkit that the loop moves, which provides true motion and hand force.

        Return None for hardware.
        """
        return None

    @property
    def rate(self) -> float | None:
        """Return the rate in Hz of the device's own clock; None if the device has no clock."""
        return None

    @property
    def name(self) -> str:
        """Return the device's name for use within a sentence."""
        return self.title

    @property
    def flash_port(self) -> str:
        """Return the port for writing firmware; "" for a device without firmware."""
        return ""

    def about(self) -> dict[str, Any]:
        """Return further entries for a recording's settings, e.g. the firmware."""
        return {}

    def probe(self) -> dict[str, Any]:
        """Open, query and close the device; return a ``text`` for a person, ``ok``, and the numbers."""
        return {"ok": True, "text": "This device is part of Hapkit Studio and always available."}

    # --- commands; a device that lacks the capability ignores them
    def report_opening(self, report: Callable[[str], object]) -> None:
        """Call ``report`` with the reason for a wait in ``open``, in the thread that opens the device."""

    def pad_frames(self, size: int) -> None:
        """Pad every frame from now on to ``size`` bytes; 0 means no padding."""

    def set_grip(self, grip: Grip | str | None) -> None:
        """Choose the grip of a simulated hand; raise ParameterError for an unknown name."""

    def move_hand(self, target: float | None) -> None:
        """Move a simulated hand to a position in m; None lets go."""

    def hook_spring(self, stiffness: float | None) -> None:
        """Replace a simulated hand by a spring in N/m between handle and middle; None removes the spring."""

    def unpaced(self) -> "Device":
        """Return a device without real-time pacing, or this device if its time cannot be accelerated."""
        return self
