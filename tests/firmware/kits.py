"""Kits for tests of the firmware: settings, contents of the EEPROM, motions of the handle."""

import math
import struct
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from hapkit_studio.devices import profiles
from hapkit_studio.protocol.messages import Board, Sensor

PLACES = (16, 272)
MARK = 1
SIZE = 1024
COUNTS = {Sensor.MAGNETORESISTIVE: 921, Sensor.AS5048A: 16384, Sensor.QUADRATURE: 48}
NAMES = {Sensor.MAGNETORESISTIVE: "mr", Sensor.AS5048A: "as5048a", Sensor.QUADRATURE: "quadrature"}


def board(**changes) -> Board:
    """Return the usual kit with changes; counts and quantum are those of its sensor."""
    made = replace(profiles.default().board, **{"label": "Test", **changes})
    if "counts_per_flip" not in changes:
        made = replace(made, counts_per_flip=COUNTS[Sensor(made.sensor)])
    return replace(made, quantum=profiles.quantum_of(made))


def crc(data: bytes) -> int:
    """Return the CRC-16/CCITT-FALSE, computed bit by bit from its definition."""
    value = 0xFFFF
    for bit in np.unpackbits(np.frombuffer(data, np.uint8)):
        value = (value << 1 ^ 0x1021 * ((value >> 15) ^ int(bit))) & 0xFFFF
    return value


def block(kit: Board, sequence: int = 1) -> bytes:
    """Return the contents of one EEPROM slot: mark, sequence number, settings, CRC."""
    body = struct.pack("BB", MARK, sequence) + kit.pack()[1:]
    return body + struct.pack(">H", crc(body))


def eeprom(kit: Board, place: int = 0) -> bytes:
    """Return the contents of a whole EEPROM that has a kit in one slot."""
    memory = bytearray(b"\xff" * SIZE)
    memory[PLACES[place] : PLACES[place] + len(block(kit))] = block(kit)
    return bytes(memory)


def options(kit: Board, memory, **more) -> tuple[str, ...]:
    """Return the options of a virtual board with this kit, whose EEPROM is a file."""
    values = {
        "eeprom": memory, "sensor": NAMES[Sensor(kit.sensor)], "counts": kit.counts_per_flip,
        "pins": 3 if kit.pins else 5, "direction": kit.direction, "sensor-sign": kit.sense,
        "torque": kit.motor_constant, "dead-band": kit.dead_band, **more,
    }  # fmt: skip
    return tuple(str(word) for name, value in values.items() for word in (f"--{name}", value))


def motion(start: float, pieces: Iterable[tuple[float, float, float]], step: float = 2e-3) -> list[str]:
    """Return a script of consecutive sines of the handle (amplitude in m, frequency in Hz, seconds)."""
    lines, now = [], start
    for amplitude, frequency, seconds in pieces:
        for k in range(1, round(seconds / step) + 1):
            to = amplitude * math.sin(2.0 * math.pi * frequency * k * step)
            lines.append(f"{now + (k - 1) * step:.6f} position {to:.9f} {step}")
        now += seconds
    return lines
