"""A Hapkit, or any device with its protocol, on a serial port: opening, settings, samples, closing.

Every serial port is listed as a device; ``HapkitBoard.probe`` identifies it.
"""

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import serial

from hapkit_studio.devices import DeviceEntry, DeviceKind, serial_ports
from hapkit_studio.devices.base import SERIAL, Device
from hapkit_studio.devices.calibration_file import ORIGINS
from hapkit_studio.devices.port_errors import FLASH, gone, no_answer, no_data, not_a_hapkit, unopened
from hapkit_studio.devices.profiles import full_force, of_settings
from hapkit_studio.devices.serial_ports import NOWHERE, Identity, Latency, Role, port_name, shorten_latency
from hapkit_studio.dynamics import nominal
from hapkit_studio.errors import DeviceError, NotAHapkitError, ParameterError, WrongProtocolError
from hapkit_studio.protocol.framing import DELIMITER, Decoder, encode
from hapkit_studio.protocol.messages import (
    BAUD,
    PROTOCOL_VERSION,
    Board,
    Force,
    Hello,
    HelloRequest,
    Message,
    Origin,
    Release,
    Sample,
    Save,
    Settings,
    SettingsRequest,
    Stream,
)

HANDSHAKE_TIME = 4.0
"""s: longest wait for Hello; opening the port resets a real board, whose boot loader takes up to 2 s."""

SAVE_TIME = 2.0
"""s: time-out of the reply to Save, because the chip takes 3.4 ms to write a byte of the EEPROM."""

PACKET = 62
"""Data bytes in a packet of an FTDI chip, which sends a full packet without waiting for the latency timer."""

WRITE_TIME = 1.0
READ_TIME = 0.05
"""Time-out in s of one read."""
HELLO_PERIOD = 0.2
_SILENCE = 0.1
_LONGEST_UNREAD = 1000
_ASKED: dict[type[Message], str] = {
    SettingsRequest: "when asked for its settings",
    Board: "when it was sent new settings",
    Save: "when told to keep its settings",
}
_VERSION = slice(1, 3)
_POSSIBLE: dict[str, tuple[float, float]] = {
    "quantum": (1e-7, 2e-3),
    "max_force": (0.0, 5.0),
    "motor_constant": (1e-4, 0.2),
    "handle_radius": (0.02, 0.3),
    "pulley_radius": (0.001, 0.02),
    "sector_radius": (0.02, 0.3),
    "tick_us": (1e-3, 1e3),
    "counts_per_flip": (4, 65_535),
    "sample_rate": (1, 20_000),
    "watchdog_ms": (1, 1_000),
    "pwm_top": (1, 65_535),
}
"""Possible range of each setting that determines the forces; recordings contain these settings."""


Reply = TypeVar("Reply", bound=Message)


class HapkitBoard(Device):
    """A board with the firmware on a serial port; the board provides all constants."""

    mass = nominal.MASS
    """Mass at the handle in kg; the kit's nominal value."""
    viscous = nominal.VISCOUS
    """Damping at the handle in N·s/m; nominal value."""
    coulomb_force = nominal.COULOMB_FORCE
    """Coulomb friction at the handle in N; nominal value."""
    driver = SERIAL
    own_clock = has_board = calibration = usb_chip = True
    patience = 0.0
    """Additional time-out in s for a simulated board, which may be slow on a busy machine."""

    def __init__(self, port: str | Path, title: str = "", identity: Identity = NOWHERE):
        self.port = os.fspath(port)
        self.title = title or f"Hapkit on {port_name(self.port)}"
        self.identity = identity
        self.latency = Latency()
        self._report: Callable[[str], object] = lambda text: None
        self._serial: Any = None
        self._hello: Hello | None = None

    @property
    def hello(self) -> Hello:
        """The board's Hello; raise DeviceError before open."""
        if self._hello is None:
            raise DeviceError(f"{self.title} is not connected.")
        return self._hello

    @property
    def max_force(self) -> float:  # type: ignore[override]
        return self.hello.max_force

    @property
    def quantum(self) -> float:  # type: ignore[override]
        return self.hello.quantum

    @property
    def rate(self) -> float:
        """Samples per second, which the board's clock determines."""
        return float(self.hello.sample_rate)

    @property
    def full_force(self) -> float:
        """Force at full duty in N; at duty d the force is full_force * d² (torque = C * duty²)."""
        return full_force(self.hello)

    @property
    def flash_port(self) -> str:
        return self.port

    @property
    def name(self) -> str:
        name = port_name(self.port)
        return f"Hapkit on {name}" if self.title.startswith(name) else self.title

    def about(self) -> dict[str, Any]:
        return {"firmware": self.hello.build, "protocol": self.hello.version}

    def probe(self) -> dict[str, Any]:
        port = serial_ports.at(self.port)
        if port is not None and port.role is Role.OTHER:
            return {"ok": False, "text": "This port was not tested, because its device is not a Hapkit."}
        try:
            self.open()
            return _answers(self)
        except DeviceError as error:
            run = f" Run `hapkit-studio flash {self.port}`." if error.step else ""
            return {"ok": False, "text": f"{error}{run}", "step": error.step, "command": error.command}
        finally:
            self.close()

    def report_opening(self, report: Callable[[str], object]) -> None:
        self._report = report

    def pad_frames(self, size: int) -> None:
        self.padding = size
        if self._serial is not None:
            self.start_stream()

    def open(self, handshake_time: float = HANDSHAKE_TIME) -> None:
        """Open the port and read Hello; raise DeviceError if this fails.

        The motor stays off, and the board sends no samples yet.
        """
        if self.identity.vendor is not None:  # a USB board may have moved to a different port
            found = serial_ports.find_same_board(self.identity, serial_ports.ports())
            if found is None:
                raise gone(self.port)
            if found.path != self.port:
                self.port, self.title = found.path, found.title
        try:
            self._serial = serial.Serial(
                self.port,
                BAUD,
                timeout=READ_TIME,
                write_timeout=max(WRITE_TIME, self.patience),
                exclusive=True,
            )
        except (serial.SerialException, OSError) as error:
            raise unopened(self.port, error) from error
        # Request exclusive access: another reader would take half of the frames and reset the board.
        # pyserial's lock is only advisory.
        self._set_exclusive("TIOCEXCL")
        try:
            self.latency = shorten_latency(self._serial, self.port, self.identity)
            self._report("Starting board…")
            self._hello = self._shake_hands(handshake_time)
            self._serial.write(encode(Stream(0, 0)) + encode(Release()))
        except (serial.SerialException, OSError) as error:
            self._release_port()
            raise gone(self.port) from error
        except BaseException:
            self._release_port()
            raise

    def _shake_hands(self, seconds: float) -> Hello:
        """Request Hello until it arrives; raise DeviceError after a time-out, OSError if the port fails."""
        decoder = Decoder()
        deadline, next_request, heard = time.monotonic() + seconds, 0.0, b""
        while (now := time.monotonic()) < deadline:
            if now >= next_request:
                self._send_after_delimiter(HelloRequest())
                next_request = now + HELLO_PERIOD
            data = self._received()
            heard = (heard + data)[-_LONGEST_UNREAD:]
            for body in decoder.bodies(data):
                if body[0] == Hello.ID and len(body) >= _VERSION.stop:
                    return _checked(body, self.port)
        raise not_a_hapkit(self.port, heard)

    def _received(self) -> bytes:
        """Return the received bytes, waiting up to READ_TIME for the first one."""
        return self._serial.read(max(1, self._serial.in_waiting))

    def _send_after_delimiter(self, message: Message) -> None:
        """Send a message after a delimiter, which ends any partial frame; drop it if the buffer is full."""
        with contextlib.suppress(serial.SerialTimeoutException):
            self._serial.write(DELIMITER + encode(message))

    def _drain(self, seconds: float) -> None:
        """Discard input until the line is quiet, at most for ``seconds``, because a stream may be running."""
        quiet, end = time.monotonic() + _SILENCE, time.monotonic() + seconds
        while (now := time.monotonic()) < min(quiet, end):
            if self._received():
                quiet = now + _SILENCE

    def fileno(self) -> int:
        """Return the descriptor of the open port."""
        if self._serial is None:
            raise DeviceError(f"{self.title} is not connected.")
        return self._serial.fileno()

    def read(self, seconds: float) -> bytes:
        """Return the received bytes; wait up to ``seconds`` for the first one. Raise OSError on failure."""
        if self._serial.timeout != seconds:
            self._serial.timeout = seconds
        first = self._serial.read(1)
        return first + self._serial.read(self._serial.in_waiting) if first else b""

    def write(self, data: bytes) -> None:
        """Send raw bytes; raise OSError if the port fails."""
        self._serial.write(data)

    # --- samples, outside the loop
    def start_stream(self, padded: int | None = None) -> None:
        """Start samples of ``padded`` bytes each, by default ``padding``; raise PortGoneError on failure."""
        self.send_messages(Stream(1, self.padding if padded is None else padded))

    def stop_stream(self) -> None:
        """Set the force to zero, and stop the samples and the motor; raise PortGoneError on failure."""
        self.send_messages(Force(0, 0, 0.0), Stream(0, 0))

    def samples(self, silence: float = 1.0) -> Iterator[Sample]:
        """Yield samples after start_stream; raise NoDataError after ``silence`` s without samples."""
        silence = max(silence, self.patience)
        decoder, deadline = Decoder(), time.monotonic() + silence
        with self._port_guard():
            while True:
                for message in decoder.feed(self._received()):
                    if isinstance(message, Sample):
                        yield message
                        deadline = time.monotonic() + silence
                if time.monotonic() >= deadline:
                    raise no_data(self.port, silence)

    def send_messages(self, *messages: Message) -> None:
        """Send messages without a reply; raise PortGoneError if the port has disappeared."""
        with self._port_guard() as line:
            line.write(b"".join(map(encode, messages)))

    # --- requests, while the samples are off
    def request(self, message: Message, reply: type[Reply], seconds: float = 1.0) -> Reply:
        """Return the board's reply of this type, repeating the request once; else raise DeviceError.

        A second reply to a repeated request is discarded, so that it is not mistaken for a later reply.
        """
        decoder, seconds = Decoder(), max(seconds, self.patience)
        with self._port_guard() as line:
            line.reset_input_buffer()
            for times in (1, 2):
                self._send_after_delimiter(message)
                deadline = time.monotonic() + seconds / 2
                while time.monotonic() < deadline:
                    for found in decoder.feed(self._received()):
                        if isinstance(found, reply):
                            if times == 2:
                                self._drain(seconds)
                            return found
        raise no_answer(self.port, _ASKED.get(type(message), "a question"), seconds)

    def settings(self) -> Settings:
        """Return all settings of the board; raise DeviceError without a reply."""
        return self._store_paddle(self.request(SettingsRequest(), Settings))

    def configure(self, board: Board) -> Settings:
        """Apply settings without saving them; raise ParameterError if the board rejects them."""
        answer = self.request(of_settings(board), Settings)
        if answer.refused:
            raise ParameterError(
                f"The Hapkit on {port_name(self.port)} refused these settings, because one of their "
                "numbers is impossible. Nothing was changed. Check geometry, motor constant and force limit."
            )
        self._hello = self.request(HelloRequest(), Hello)
        return self._store_paddle(answer)

    def _store_paddle(self, settings: Settings) -> Settings:
        """Store the paddle's properties, which Hello does not contain."""
        self.mass, self.viscous, self.coulomb_force = settings.mass, settings.viscous, settings.coulomb
        return settings

    def save(self) -> Settings:
        """Save the board's current settings in its EEPROM; raise DeviceError without a reply."""
        return self.request(Save(), Settings, SAVE_TIME)

    def close(self) -> None:
        """Set the force to zero and close the port; this never fails and may be repeated."""
        if self._serial is None:
            return
        with contextlib.suppress(DeviceError):
            self.stop_stream()
        self._release_port()

    def _set_exclusive(self, request: str) -> None:
        """Claim or release exclusive access to the port if the system supports it; root is exempt."""
        if sys.platform == "win32":  # Windows ports are always exclusive
            return
        import fcntl
        import termios

        with contextlib.suppress(OSError, AttributeError, ValueError, TypeError):
            fcntl.ioctl(self._serial.fileno(), getattr(termios, request))

    def _release_port(self) -> None:
        with contextlib.suppress(serial.SerialException, OSError):
            self._set_exclusive("TIOCNXCL")  # otherwise a pseudo-terminal would stay exclusive
            self._serial.close()
        self._serial = None
        self._hello = None

    @contextlib.contextmanager
    def _port_guard(self) -> Iterator[Any]:
        """Yield the open port; convert OSError to PortGoneError."""
        self.fileno()
        try:
            yield self._serial
        except serial.SerialTimeoutException as error:
            raise no_answer(self.port, "what was sent", self._serial.write_timeout) from error
        except (serial.SerialException, OSError) as error:
            raise gone(self.port) from error


def _checked(body: bytes, port: str) -> Hello:
    """Return the Hello in a body if version, size and numbers are valid; otherwise raise DeviceError."""
    version = int.from_bytes(body[_VERSION], "little")
    if version != PROTOCOL_VERSION:
        text = (
            f"The firmware has protocol version {version}, but this studio needs version {PROTOCOL_VERSION}."
        )
        if version < PROTOCOL_VERSION:
            raise WrongProtocolError(f"{text} Update the firmware.", step="update")
        raise WrongProtocolError(f"{text} Update Hapkit Studio.")
    try:
        hello = Hello.unpack(body)
    except ValueError as error:
        raise not_a_hapkit(port, body) from error
    for wire in Hello.layout():
        low, high = _POSSIBLE.get(wire.name, (-np.inf, np.inf))
        value = getattr(hello, wire.name)
        if wire.name in _POSSIBLE and not np.float32(low) <= value <= np.float32(high):
            possible = f"a Hapkit has {low:,g} to {high:,g} {wire.unit}".rstrip()
            text = f"{port_name(port)} reports {value:,g} for {wire.help}, but {possible}."
            raise NotAHapkitError(f"{text} Flash the firmware.", step=FLASH)
    return hello


def entries() -> list[DeviceEntry]:
    """Return the ports with hardware: kits first, other devices last."""
    return [
        DeviceEntry(p.path, p.title, partial(HapkitBoard, p.path, p.title, p.identity))
        for p in serial_ports.ports()
    ]


def unlisted(key: str) -> HapkitBoard | None:
    """Return a board at an unlisted path, such as a pseudo-terminal; None if the key is not a path."""
    return HapkitBoard(key) if serial_ports.is_path(key) else None


DEVICE = DeviceKind(2, entries, unlisted)


def _answers(board: HapkitBoard) -> dict[str, Any]:
    hello, latency = board.hello, board.latency
    parts = [f"Firmware {hello.build}, version {hello.version}, {hello.arena} bytes of memory for a law"]
    found: dict[str, Any] = {"ok": True, "port": board.port, "build": hello.build, "version": hello.version}
    found |= {"arena": hello.arena, "rate_Hz": board.rate, "latency_timer_s": latency.timer}
    try:
        settings = board.settings()
        kit = f"Kit {settings.label!r}, {1e6 * settings.quantum:.1f} µm of travel per count"
        parts.append(f"{kit}, force limit {settings.max_force:.1f} N")
        parts.append(f"Settings are {ORIGINS[Origin(settings.origin)]}")
        found["settings"] = {f.name: getattr(settings, f.name) for f in Board.layout()}
        found["settings"]["origin"] = Origin(settings.origin).name.lower()
    except DeviceError as error:
        parts.append(str(error).rstrip("."))
    return found | {"text": " ".join(f"{line}." for line in parts) + f" {latency.text}".rstrip()}
