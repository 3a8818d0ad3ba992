"""A Hapkit, or anything that speaks like one, on a serial port: opening, settings, samples, closing.

Every serial port is a device that can be chosen; ``probe`` asks who answers on it.
"""

import contextlib
import os
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import serial

from hapkit_studio.devices import DeviceEntry, DeviceKind, messaging, serial_ports
from hapkit_studio.devices.low_latency import Latency, shorten_latency
from hapkit_studio.devices.port_errors import gone, no_answer, settings_refused, unopened
from hapkit_studio.devices.serial_ports import NOWHERE, Identity, Port, Role, at, port_name
from hapkit_studio.errors import DeviceError
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import (
    BAUD,
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


def _claim(line: Any) -> None:
    """Let the system refuse whoever else opens the port, but root; where it cannot, nothing changes.

    A serial monitor would take half of the frames and restart the board; pyserial's own lock is only heeded
    by those who ask for it.
    """
    _set_exclusive(line, "TIOCEXCL")


def _give_back(line: Any) -> None:
    """Let others open the port again; a pseudo-terminal would remember it after the end."""
    _set_exclusive(line, "TIOCNXCL")


def _set_exclusive(line: Any, request: str) -> None:
    if sys.platform == "win32":  # there a port has one owner anyway
        return
    import fcntl
    import termios

    with contextlib.suppress(OSError, AttributeError, ValueError, TypeError):
        fcntl.ioctl(line.fileno(), getattr(termios, request))


HANDSHAKE_TIME = 4.0
"""s to wait for Hello; opening the port resets a real board, whose boot loader takes up to 2 s."""

SAVE_TIME = 2.0
"""s to wait for Save: a byte of the EEPROM takes 3.4 ms to write."""

PACKET = 62
"""Bytes of data in one packet of an FTDI chip: a full one is sent without waiting for its latency timer."""

WRITE_TIME = 1.0

Reply = TypeVar("Reply", bound=Message)


class HapkitBoard:
    """The firmware at the end of a port; every constant comes from the board."""

    mass = 0.044
    """kg at the handle, the kit's usual value."""
    viscous = 0.5
    """N·s/m at the handle, usual value."""
    coulomb_force = 0.10
    """N at the handle, usual value."""
    simulated = False
    padding = 0
    """Bytes to which every frame of a stream is filled up: 0 or PACKET."""

    def __init__(self, port: str | Path, title: str = "", identity: Identity = NOWHERE):
        self.port = os.fspath(port)
        self.title = title or f"Hapkit on {port_name(self.port)}"
        self.identity = identity
        self.latency = Latency()
        self.on_status: Callable[[str], object] = lambda words: None
        """Is told what open waits for; runs in the thread that opens."""
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

    @property
    def name(self) -> str:
        """Return what to call it in a sentence."""
        name = port_name(self.port)
        return f"Hapkit on {name}" if self.title.startswith(name) else self.title

    def open(self, handshake_time: float = HANDSHAKE_TIME) -> None:
        """Open the port and learn who is there; raise the DeviceError that fits. Motor off, samples off."""
        self._find()
        self._serial = _open_port(self.port)
        _claim(self._serial)
        try:
            self.latency = shorten_latency(self._serial, self.port, self.identity)
            self.on_status("Starting board…")
            self._hello = messaging.handshake(self._serial, self.port, handshake_time)
            self._serial.write(encode(Stream(0, 0)) + encode(Release()))
        except (serial.SerialException, OSError) as error:
            self._abandon()
            raise gone(self.port) from error
        except BaseException:
            self._abandon()
            raise

    def _find(self) -> None:
        """Follow the board to the name it has now; without it, raise PortGoneError: another is not it."""
        if self.identity.vendor is None:
            return
        found = serial_ports.find_same_board(self.identity, serial_ports.ports())
        if found is None:
            raise gone(self.port)
        if found.path != self.port:
            self.port, self.title = found.path, found.title

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

    # --- samples, outside the loop
    def start_stream(self, padded: int | None = None) -> None:
        """Switch the samples on, each filled to padded bytes, by default ``padding``; raise PortGoneError."""
        self.send_messages(Stream(1, self.padding if padded is None else padded))

    def stop_stream(self) -> None:
        """Set the force to zero and switch samples and motor off; raise PortGoneError."""
        self.send_messages(Force(0, 0, 0.0), Stream(0, 0))

    def samples(self, silence: float = 1.0) -> Iterator[Sample]:
        """Yield what comes after start_stream; raise NoDataError after that many s of silence."""
        with self._line() as line:
            yield from messaging.samples(line, self.port, silence)

    def send_messages(self, *messages: Message) -> None:
        """Send messages that have no answer; raise PortGoneError."""
        with self._line() as line:
            line.write(b"".join(map(encode, messages)))

    # --- questions, while the samples are off
    def request(self, message: Message, reply: type[Reply], seconds: float = 1.0) -> Reply:
        """Return the board's answer of that type; raise DeviceError."""
        with self._line() as line:
            return messaging.request(line, self.port, message, reply, seconds)

    def settings(self) -> Settings:
        """Return everything the board knows about its kit; raise DeviceError."""
        return self._learn(self.request(SettingsRequest(), Settings))

    def configure(self, board: Board) -> Settings:
        """Put settings in force, not yet saved; raise ParameterError where the board refuses them."""
        fields = {f.name: getattr(board, f.name) for f in Board.layout()}
        answer = self.request(Board(**fields), Settings)
        if answer.refused:
            raise settings_refused(self.port)
        self._hello = self.request(HelloRequest(), Hello)
        return self._learn(answer)

    def _learn(self, settings: Settings) -> Settings:
        """Take over what the board knows of its paddle, which Hello does not say."""
        self.mass, self.viscous, self.coulomb_force = settings.mass, settings.viscous, settings.coulomb
        return settings

    def save(self) -> Settings:
        """Keep the settings in force on the board; raise DeviceError."""
        return self.request(Save(), Settings, SAVE_TIME)

    def close(self) -> None:
        """Set the force to zero and close the port; never fails, may be called twice."""
        if self._serial is None:
            return
        with contextlib.suppress(DeviceError):
            self.stop_stream()
        self._abandon()

    def _abandon(self) -> None:
        with contextlib.suppress(serial.SerialException, OSError):
            _give_back(self._serial)
            self._serial.close()
        self._serial = None
        self._hello = None

    @contextlib.contextmanager
    def _line(self) -> Iterator[Any]:
        """Give the open port; a failure of the system means that it is gone."""
        self.fileno()
        try:
            yield self._serial
        except serial.SerialTimeoutException as error:
            raise no_answer(self.port, "what was sent", WRITE_TIME) from error
        except (serial.SerialException, OSError) as error:
            raise gone(self.port) from error


def _open_port(port: str) -> serial.Serial:
    try:
        return serial.Serial(
            port, BAUD, timeout=messaging.READ_TIME, write_timeout=WRITE_TIME, exclusive=True
        )
    except (serial.SerialException, OSError) as error:
        raise unopened(port, error) from error


def entries() -> list[DeviceEntry]:
    """Return the ports that have hardware behind them: kits first, surely something else last."""
    return [_entry(port) for port in serial_ports.ports()]


def _entry(port: Port) -> DeviceEntry:
    return DeviceEntry(port.path, port.title, partial(HapkitBoard, port.path, port.title, port.identity))


def unlisted(key: str) -> HapkitBoard | None:
    """Take what looks like a port for one, e.g. a pseudo-terminal, which no list holds."""
    return HapkitBoard(key) if "/" in key or key.upper().startswith("COM") else None


DEVICE = DeviceKind(2, entries, unlisted)


_ORIGIN = {
    Origin.DEFAULT: "default settings",
    Origin.STORED: "stored settings",
    Origin.DAMAGED: "stored settings damaged, defaults instead",
    Origin.UNSAVED: "settings not saved",
}


def probe(entry: DeviceEntry) -> dict[str, Any]:
    """Return what a device says of itself: ``text`` in words, ``ok``, and the numbers behind it."""
    port = at(entry.key)
    if port is not None and port.role is Role.OTHER:
        return {"ok": False, "text": "Not asked: not a Hapkit."}
    device = entry.make()
    if not isinstance(device, HapkitBoard):
        return {"ok": True, "text": "Always there: part of the studio."}
    try:
        device.open()
        return _answers(device)
    except DeviceError as error:
        run = f" Run `hapkit-studio flash {entry.key}`." if error.step else ""
        return {"ok": False, "text": f"{error}{run}", "step": error.step, "command": error.command}
    finally:
        device.close()


def _answers(board: HapkitBoard) -> dict[str, Any]:
    hello, latency = board.hello, board.latency
    words = [f"Firmware {hello.build}, version {hello.version}, {hello.arena} bytes for a law"]
    found: dict[str, Any] = {"ok": True, "port": board.port, "build": hello.build, "version": hello.version}
    found |= {"arena": hello.arena, "rate_Hz": board.rate, "latency_timer_s": latency.timer}
    try:
        settings = board.settings()
        kit = f"Kit {settings.label!r}, {_ORIGIN[Origin(settings.origin)]}"
        words.append(f"{kit}, {1e6 * settings.quantum:.1f} µm a count, limit {settings.max_force:.1f} N")
        found["settings"] = {f.name: getattr(settings, f.name) for f in Board.layout()}
        found["settings"]["origin"] = Origin(settings.origin).name.lower()
    except DeviceError as error:
        words.append(str(error).rstrip("."))
    return found | {"text": " ".join(f"{line}." for line in words) + f" {latency.words}".rstrip()}
