"""A Hapkit, or anything that speaks like one, on a serial port: opening, handshake, closing."""

import contextlib
import os
import time
from pathlib import Path
from typing import Any

import serial

from hapkit_studio.devices.port_errors import gone, not_a_hapkit, port_name, unopened, wrong_version
from hapkit_studio.errors import DeviceError
from hapkit_studio.protocol.declare import Message
from hapkit_studio.protocol.framing import DELIMITER, Decoder, encode
from hapkit_studio.protocol.messages import (
    BAUD,
    PROTOCOL_VERSION,
    Force,
    Hello,
    HelloRequest,
    Release,
    Stream,
)

HANDSHAKE_TIME = 4.0
"""s to wait for Hello; opening the port resets a real board, whose boot loader takes up to 2 s."""

HELLO_PERIOD = 0.2
READ_TIME = 0.05
WRITE_TIME = 0.2
_VERSION = slice(1, 3)


class HapkitBoard:
    """The firmware at the end of a port; every constant comes from its Hello."""

    simulated = False
    mass = 0.044
    """kg at the handle; the board cannot know it, this is the kit's usual value."""
    viscous = 0.5
    """N·s/m at the handle, usual value."""

    def __init__(self, port: str | Path, title: str = ""):
        self.port = os.fspath(port)
        self.title = title or f"Hapkit on {port_name(self.port)}"
        self._serial: Any = None
        self._hello: Hello | None = None

    @property
    def hello(self) -> Hello:
        """What the board said about itself; DeviceError before open."""
        if self._hello is None:
            raise DeviceError(f"{self.title} is not open.")
        return self._hello

    @property
    def max_force(self) -> float:
        return self.hello.max_force

    @property
    def quantum(self) -> float:
        return self.hello.quantum

    @property
    def rate(self) -> float:
        """Samples per second, set by the board's clock."""
        return float(self.hello.sample_rate)

    @property
    def full_force(self) -> float:
        """Force at full duty [N]; at duty d it is full_force * d^2 (reference: torque = C * duty^2)."""
        h = self.hello
        return h.motor_constant * h.sector_radius / (h.handle_radius * h.pulley_radius)

    def open(self, handshake_time: float = HANDSHAKE_TIME) -> None:
        """Open the port and learn who is there; raise the DeviceError that fits. Motor off, samples off."""
        self._serial = _open_port(self.port)
        try:
            with contextlib.suppress(OSError, ValueError, AttributeError):  # not every port and system has it
                self._serial.set_low_latency_mode(True)
            self._hello = self._handshake(time.monotonic() + handshake_time)
            self._send(Stream(0, 0), Release())
        except (serial.SerialException, OSError) as error:
            self._abandon()
            raise gone(self.port) from error
        except BaseException:
            self._abandon()
            raise

    def fileno(self) -> int:
        """Return the descriptor of the open port."""
        if self._serial is None:
            raise DeviceError(f"{self.title} is not open.")
        return self._serial.fileno()

    def read(self, seconds: float) -> bytes:
        """Return what has arrived, waiting up to seconds for the first byte; raise OSError."""
        if self._serial.timeout != seconds:
            self._serial.timeout = seconds
        first = self._serial.read(1)
        return first + self._serial.read(self._serial.in_waiting) if first else b""

    def write(self, data: bytes) -> None:
        """Send bytes as they are; raise OSError."""
        self._serial.write(data)

    def start_stream(self) -> None:
        """Switch the samples on; raise PortGoneError."""
        self._send_or_gone(Stream(1, 0))

    def stop_stream(self) -> None:
        """Set the force to zero and switch samples and motor off; raise PortGoneError."""
        self._send_or_gone(Force(0, 0.0), Stream(0, 0))

    def close(self) -> None:
        """Set the force to zero and close the port; never fails, may be called twice."""
        if self._serial is None:
            return
        with contextlib.suppress(DeviceError):
            self.stop_stream()
        self._abandon()

    def _abandon(self) -> None:
        with contextlib.suppress(serial.SerialException, OSError):
            self._serial.close()
        self._serial = None
        self._hello = None

    def _send(self, *messages: Message) -> None:
        self._serial.write(b"".join(map(encode, messages)))

    def _send_or_gone(self, *messages: Message) -> None:
        self.fileno()
        try:
            self._send(*messages)
        except (serial.SerialException, OSError) as error:
            raise gone(self.port) from error

    def _ask(self) -> None:
        """Ask for Hello; the delimiter in front ends whatever was half sent before."""
        with contextlib.suppress(serial.SerialTimeoutException):
            self._serial.write(DELIMITER + encode(HelloRequest()))

    def _handshake(self, deadline: float) -> Hello:
        """Ask until Hello comes; raise NotAHapkitError or WrongProtocolError."""
        decoder = Decoder()
        next_ask = 0.0
        heard = False
        while (now := time.monotonic()) < deadline:
            if now >= next_ask:
                self._ask()
                next_ask = now + HELLO_PERIOD
            data = self._serial.read(max(1, self._serial.in_waiting))
            heard = heard or bool(data)
            for body in decoder.bodies(data):
                if body[0] == Hello.ID and len(body) >= _VERSION.stop:
                    return self._checked(body)
        raise not_a_hapkit(self.port, heard)

    def _checked(self, body: bytes) -> Hello:
        """Return the Hello in a body whose version and size are ours."""
        version = int.from_bytes(body[_VERSION], "little")
        if version != PROTOCOL_VERSION:
            raise wrong_version(version, PROTOCOL_VERSION)
        try:
            return Hello.unpack(body)
        except ValueError as error:
            raise not_a_hapkit(self.port, heard=True) from error


def _open_port(port: str) -> serial.Serial:
    try:
        return serial.Serial(port, BAUD, timeout=READ_TIME, write_timeout=WRITE_TIME, exclusive=True)
    except (serial.SerialException, OSError) as error:
        raise unopened(port, error) from error
