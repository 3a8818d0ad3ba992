"""Questions to a board and its answers in plain Python: the handshake, requests, samples outside the loop."""

import contextlib
import time
from collections.abc import Iterator
from typing import Any, TypeVar

import numpy as np
import serial

from hapkit_studio.devices.port_errors import impossible, no_answer, no_data, not_a_hapkit, wrong_version
from hapkit_studio.protocol.framing import DELIMITER, Decoder, encode
from hapkit_studio.protocol.messages import (
    PROTOCOL_VERSION,
    Board,
    Hello,
    HelloRequest,
    Message,
    Sample,
    Save,
    SettingsRequest,
)

READ_TIME = 0.05
"""s that one read of an open port waits at most."""
HELLO_PERIOD = 0.2
_SILENCE = 0.1
_KEPT = 1000
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
"""What a Hapkit can say of itself, as the firmware holds it: forces are computed from these numbers."""

Reply = TypeVar("Reply", bound=Message)


def handshake(line: Any, port: str, seconds: float) -> Hello:
    """Ask for Hello until it comes; raise NotAHapkitError, WrongProtocolError or OSError."""
    decoder = Decoder()
    deadline, next_ask, heard = time.monotonic() + seconds, 0.0, b""
    while (now := time.monotonic()) < deadline:
        if now >= next_ask:
            send(line, HelloRequest())
            next_ask = now + HELLO_PERIOD
        data = line.read(max(1, line.in_waiting))
        heard = (heard + data)[-_KEPT:]
        for body in decoder.bodies(data):
            if body[0] == Hello.ID and len(body) >= _VERSION.stop:
                return _checked(body, port)
    raise not_a_hapkit(port, heard)


def _checked(body: bytes, port: str) -> Hello:
    """Return the Hello in a body whose version and size are ours, and whose numbers a Hapkit can have."""
    version = int.from_bytes(body[_VERSION], "little")
    if version != PROTOCOL_VERSION:
        raise wrong_version(version, PROTOCOL_VERSION)
    try:
        hello = Hello.unpack(body)
    except ValueError as error:
        raise not_a_hapkit(port, body) from error
    words = {w.name: w for w in Hello.layout()}
    for name, (low, high) in _POSSIBLE.items():
        if not np.float32(low) <= (value := getattr(hello, name)) <= np.float32(high):
            raise impossible(port, words[name].help, value, (low, high), words[name].unit)
    return hello


def send(line: Any, *messages: Message) -> None:
    """Send messages; the delimiter in front ends whatever was half sent before. A full line drops them."""
    with contextlib.suppress(serial.SerialTimeoutException):
        line.write(DELIMITER + b"".join(map(encode, messages)))


def request(line: Any, port: str, message: Message, reply: type[Reply], seconds: float) -> Reply:
    """Return the board's answer, asking twice if it must be; raise DeviceError or OSError.

    A second ask brings a second answer, which nobody may take for the next one's.
    """
    line.reset_input_buffer()
    decoder = Decoder()
    for times in (1, 2):
        send(line, message)
        found = _wait(line, decoder, reply, seconds / 2)
        if found is not None:
            if times == 2:
                _drain(line, seconds)
            return found
    raise no_answer(port, _ASKED.get(type(message), "a question"), seconds)


def _wait(line: Any, decoder: Decoder, reply: type[Reply], seconds: float) -> Reply | None:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        for message in decoder.feed(line.read(max(1, line.in_waiting))):
            if isinstance(message, reply):
                return message
    return None


def _drain(line: Any, seconds: float) -> None:
    """Read until nothing has come for a while, at most for so many s: a stream may be on."""
    quiet = time.monotonic() + _SILENCE
    end = time.monotonic() + seconds
    while (now := time.monotonic()) < min(quiet, end):
        if line.read(max(1, line.in_waiting)):
            quiet = now + _SILENCE


def samples(line: Any, port: str, silence: float) -> Iterator[Sample]:
    """Yield the samples that arrive; raise NoDataError after that many s without one, or OSError."""
    decoder = Decoder()
    deadline = time.monotonic() + silence
    while True:
        for message in decoder.feed(line.read(max(1, line.in_waiting))):
            if isinstance(message, Sample):
                yield message
                deadline = time.monotonic() + silence
        if time.monotonic() >= deadline:
            raise no_data(port, silence)
