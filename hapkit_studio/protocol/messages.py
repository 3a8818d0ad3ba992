"""Every message between computer and board, declared once; the firmware's header is generated from here.

A message is a frozen dataclass whose fields carry their type on the wire: little-endian packed structs.
"""

import struct
from dataclasses import dataclass, field, fields
from enum import IntEnum, IntFlag
from typing import Any, ClassVar, NamedTuple, Self

FROM_BOARD = 0x80
FLOAT_MAX = (2.0 - 2.0**-23) * 2.0**127  # greatest finite float32


class Wire(NamedTuple):
    """One field on the wire: name, struct code, unit and explanation."""

    name: str
    code: str
    unit: str
    help: str

    @property
    def size(self) -> int:
        return struct.calcsize("<" + self.code)

    @property
    def numbers(self) -> int:
        """How many numbers the field holds; text is one value."""
        return 1 if self.code.endswith("s") else int(self.code[:-1] or 1)

    @property
    def limits(self) -> tuple[float, float]:
        """Least and greatest value of each of its numbers."""
        kind = self.code[-1]
        if kind == "f":
            return -FLOAT_MAX, FLOAT_MAX
        bits = 8 * struct.calcsize("<" + kind)
        return (-(1 << bits - 1), (1 << bits - 1) - 1) if kind.islower() else (0, (1 << bits) - 1)


def wire(code: str, help: str, unit: str = "") -> Any:
    """Declare a field by its struct code: ``"H"``, ``"16s"`` for text, ``"8B"`` for a tuple of numbers."""
    return field(metadata={"code": code, "unit": unit, "help": help})


@dataclass(frozen=True)
class Message:
    """Base of all messages; a subclass names its id, whose top bit says that it comes from the board."""

    ID: ClassVar[int]

    def __init_subclass__(cls, id: int) -> None:
        cls.ID = id

    @classmethod
    def from_board(cls) -> bool:
        """Return True if the board sends this message."""
        return bool(cls.ID & FROM_BOARD)

    @classmethod
    def layout(cls) -> tuple[Wire, ...]:
        """Return the fields in wire order, without gaps."""
        return tuple(
            Wire(f.name, f.metadata["code"], f.metadata["unit"], f.metadata["help"]) for f in fields(cls)
        )

    @classmethod
    def size(cls) -> int:
        """Return the number of payload bytes, without the id."""
        return sum(f.size for f in cls.layout())

    @classmethod
    def offset(cls, name: str) -> int:
        """Return the offset of a field in id plus payload."""
        names = [f.name for f in cls.layout()]
        return 1 + sum(f.size for f in cls.layout()[: names.index(name)])

    @classmethod
    def _format(cls) -> str:
        return "<B" + "".join(f.code for f in cls.layout())

    def pack(self) -> bytes:
        """Return id and payload, little endian; raise struct.error if a value does not fit."""
        values: list[Any] = []
        for f in self.layout():
            value = getattr(self, f.name)
            if f.code.endswith("s"):
                values.append(value.encode("ascii"))
            else:
                values += value if f.numbers > 1 else [value]
        return struct.pack(self._format(), self.ID, *values)

    @classmethod
    def unpack(cls, body: bytes) -> Self:
        """Return the message in id plus payload; raise ValueError for a wrong size or id."""
        if len(body) != 1 + cls.size() or body[0] != cls.ID:
            raise ValueError(
                f"{cls.__name__} is {1 + cls.size()} bytes starting with {cls.ID}, not {body!r}."
            )
        _, *raw = struct.unpack(cls._format(), body)
        values: list[Any] = []
        for f in cls.layout():
            several, raw = raw[: f.numbers], raw[f.numbers :]
            if f.code.endswith("s"):
                values.append(several[0].rstrip(b"\0").decode("ascii", "replace"))
            else:
                values.append(tuple(several) if f.numbers > 1 else several[0])
        return cls(*values)


PROTOCOL_VERSION = 4
BAUD = 1_000_000

PIECE = 32
"""Bytes of a law per message."""

TUNED = 6
"""Constants of a law per message."""


class Estimator(IntEnum):
    """How the board estimates velocity; the coefficients of Law are first and second."""

    DIFFERENCE = 0
    """v = (x - before) / T."""
    IIR = 1
    """v += first ((x - before) / T - v)."""
    KALMAN = 2
    """The steady filter: r = x - (at + T v); at += T v + first r; v += second r."""


class Pins(IntEnum):
    """Where motor 1 is connected."""

    D5_D8 = 0
    """PWM on D5, direction on D8: every board since 2013's second."""
    D3_D12 = 1
    """PWM on D3, direction on D12: board 1.0."""


class Sensor(IntEnum):
    """What reads the motor's angle."""

    MAGNETORESISTIVE = 0
    """Analog on A2, repeats every half turn."""
    AS5048A = 1
    """14 bits over SPI, selected by D10, repeats every turn."""
    QUADRATURE = 2
    """Two channels on D2 and D3, counted without repeating."""


class MotorMap(IntEnum):
    """How the motor's torque follows from its duty."""

    SQUARE = 0
    """torque = constant * duty^2."""
    LINEAR = 1
    """torque = constant * duty."""
    TABLE = 2
    """torque = constant * table / 255, straight between eight duties."""


class Origin(IntEnum):
    """Where the settings in force come from."""

    DEFAULT = 0
    STORED = 1
    """From the EEPROM, or saved to it since."""
    DAMAGED = 2
    """The EEPROM's check failed: defaults."""
    UNSAVED = 3
    """Changed since the start, not saved."""


class BoardFlag(IntFlag):
    """What a sample says about the motor and the loop of the board."""

    WATCHDOG = 1
    """No valid force command within the watchdog's time: motor off until the next one."""
    STOPPED = 2
    """Emergency stop: motor off until Release."""
    CLAMPED = 4
    """The last force command exceeded the force limit and was cut to it."""
    OVERRUN = 8
    """A sample was skipped or its frame did not fit the send buffer since the last frame."""
    REFUSED = 16
    """The last force was not a finite number: motor off until the next command, or the next law."""
    OVER_SPEED = 32
    """The handle was faster than the board's limit: motor off until Release."""
    SENSOR = 64
    """Readings that cannot be right were bridged since the last frame; after several in a row: motor off."""


@dataclass(frozen=True)
class HelloRequest(Message, id=0x01):
    """Ask the board who it is; it answers with Hello."""


@dataclass(frozen=True)
class Force(Message, id=0x02):
    """Command the force on the handle. One that left the computer too long ago is refused, unless it is 0."""

    seq: int = wire("H", "number of the newest sample that the computer had heard")
    behind: int = wire("B", "how many samples before that one is answered")
    force: float = wire("f", "force on the handle, positive to the right", "N")


@dataclass(frozen=True)
class Stop(Message, id=0x03):
    """Emergency stop: motor off at once, and off until Release."""


@dataclass(frozen=True)
class Release(Message, id=0x04):
    """End the emergency stop; the motor stays off until the next Force."""


@dataclass(frozen=True)
class Stream(Message, id=0x05):
    """Switch the samples on or off; off also switches the motor off."""

    on: int = wire("B", "1 on, 0 off")
    padded: int = wire("B", "every frame is filled with delimiters to a multiple of so many bytes; 0 not")


@dataclass(frozen=True)
class Law(Message, id=0x06):
    """Begin to send a law. The one in force fades out over 30 ms, then its memory takes the new one's pieces.

    Once the last byte is there and nothing is refused, it fades in over 30 ms. Its bytes are `given` float32,
    the state's start values and the constants, then the code. The same generation again changes nothing.
    """

    generation: int = wire("B", "any number but the last law's; samples and telemetry repeat it")
    period: int = wire("H", "half microseconds from one tick to the next, 500 to 4000: 4 kHz to 500 Hz")
    estimator: int = wire("B", "Estimator")
    first: float = wire("f", "its first coefficient")
    second: float = wire("f", "its second coefficient", "1/s")
    states: int = wire("B", "values of state, the slots from 2 on")
    given: int = wire("B", "slots from 2 on whose first values are sent: state, then constants")
    slots: int = wire("B", "slots in all; those behind the given ones begin as 0")
    code: int = wire("H", "bytes of code")
    check: int = wire("H", "CRC-16 of all bytes that are sent in pieces")


@dataclass(frozen=True)
class Piece(Message, id=0x07):
    """One piece of a law; taken only in order, so what got lost is sent again from where samples say."""

    generation: int = wire("B", "the law's")
    at: int = wire("H", "place of the first byte; the pieces lie side by side")
    data: tuple[int, ...] = wire(f"{PIECE}B", "the bytes, then zeros behind the last")


@dataclass(frozen=True)
class Tune(Message, id=0x08):
    """Give constants of the law in force other values; they move there over 30 ms."""

    law: int = wire("B", "generation of the law")
    generation: int = wire("B", "of this change; Telemetry repeats the last one taken")
    count: int = wire("B", "how many constants")
    slots: tuple[int, ...] = wire(f"{TUNED}B", "their slots, then zeros")
    values: tuple[float, ...] = wire(f"{TUNED}f", "their values, then zeros")


@dataclass(frozen=True)
class Leave(Message, id=0x0D):
    """Let the computer render: the law's force fades out over 30 ms, then come samples. Twice: at once."""


@dataclass(frozen=True)
class Alive(Message, id=0x09):
    """Say that the computer is there while the board renders; without it for watchdog_ms: motor off."""


@dataclass(frozen=True)
class SettingsRequest(Message, id=0x0A):
    """Ask for the settings in force; the board answers with Settings."""


@dataclass(frozen=True)
class Save(Message, id=0x0B):
    """Keep the settings in force in the EEPROM; the board answers with Settings."""


@dataclass(frozen=True)
class Board(Message, id=0x0C):
    """Everything about one kit: pins, sensor, geometry, motor. Motor off, in force at once, not saved.

    The board answers with Settings; numbers that no kit has are refused as a whole.
    """

    profile: int = wire("B", "number of the kit's profile, for the computer")
    pins: int = wire("B", "Pins")
    sensor: int = wire("B", "Sensor")
    motor_map: int = wire("B", "MotorMap")
    direction: int = wire("b", "1: the direction pin is high to push to the right, -1: low")
    sense: int = wire("b", "1: counts grow to the right, -1: to the left")
    counts_per_flip: int = wire("H", "sensor counts from one repeat to the next")
    zero: int = wire("i", "count, before sense, at the handle's zero; after a start its nearest repeat")
    quantum: float = wire("f", "handle travel per sensor count", "m")
    max_force: float = wire("f", "force limit", "N")
    motor_constant: float = wire("f", "motor torque at full duty", "N*m")
    handle_radius: float = wire("f", "sector axis to handle", "m")
    pulley_radius: float = wire("f", "motor pulley", "m")
    sector_radius: float = wire("f", "sector drum", "m")
    mass: float = wire("f", "of the paddle at the handle", "kg")
    viscous: float = wire("f", "friction of the paddle at the handle", "N*s/m")
    coulomb: float = wire("f", "dry friction of the paddle at the handle", "N")
    dead_band: int = wire("B", "pwm below which the motor does not turn; what is asked starts above it")
    table: tuple[int, ...] = wire("8B", "torque in 255ths at 1/8, 2/8 ... 8/8 of full duty, never falling")
    label: str = wire("12s", "the kit's name")


@dataclass(frozen=True)
class Hello(Message, id=0x81):
    """Who the board is: version, build and every constant the computer needs."""

    version: int = wire("H", "version of the protocol; stays the first field in every version")
    quantum: float = wire("f", "handle travel per sensor count", "m")
    max_force: float = wire("f", "force limit of the board", "N")
    motor_constant: float = wire("f", "motor torque at full duty, torque = constant * duty^2", "N*m")
    handle_radius: float = wire("f", "sector axis to handle", "m")
    pulley_radius: float = wire("f", "motor pulley", "m")
    sector_radius: float = wire("f", "sector drum", "m")
    tick_us: float = wire("f", "resolution of the board's clock", "us")
    counts_per_flip: int = wire("H", "sensor counts per half turn of the motor")
    sample_rate: int = wire("H", "samples per second", "Hz")
    watchdog_ms: int = wire("H", "silence after which the motor goes off", "ms")
    pwm_top: int = wire("H", "pwm value of full duty")
    profile: int = wire("B", "number of the kit's profile")
    arena: int = wire("H", "bytes for the slots, the code and the moving constants of one law")
    origin: int = wire("B", "Origin")
    reset: int = wire("B", "why it started: 1 power, 2 reset, 4 brown-out, 8 watchdog")
    build: str = wire("16s", "name of the firmware build")


@dataclass(frozen=True)
class Sample(Message, id=0x82):
    """One sensor sample and the state of the motor, sent every period while the stream is on."""

    seq: int = wire("H", "sample number, counts every period, wraps at 65536")
    time_us: int = wire("I", "board clock at sampling, wraps at 2^32", "us")
    count: int = wire("i", "sensor counts from the zero, repeats included, positive to the right")
    raw: int = wire("H", "the sensor's reading itself")
    answered: int = wire("H", "sample number that the last applied force answered")
    delay_us: int = wire(
        "H", "from that sampling to its force in the PWM register; 0 none yet, 65535 longer", "us"
    )
    flags: int = wire("B", "BoardFlag")
    pwm: int = wire("h", "signed duty in force, of pwm_top")
    rx_errors: int = wire("B", "bad frames and lost bytes that the board received, wraps at 256")
    stale: int = wire("B", "forces refused because they were too old, wraps at 256")
    generation: int = wire("B", "of the law that is being sent, or was last")
    received: int = wire("H", "bytes of it that have arrived, up to the first one missing")
    refusal: int = wire("B", "Refusal: why it is not rendered")


@dataclass(frozen=True)
class Telemetry(Message, id=0x83):
    """What the board renders by itself, in place of Sample while a law of its own is in force.

    Each tick that comes a millisecond or more after the one shown last: every tick up to 1 kHz, above that
    every second, third or fourth one.
    """

    seq: int = wire("H", "number of the tick shown, wraps at 65536")
    time_us: int = wire("I", "board clock at its sampling, wraps at 2^32", "us")
    count: int = wire("i", "sensor counts from the zero, repeats included, positive to the right")
    velocity: float = wire("f", "as the board estimates it, positive to the right", "m/s")
    asked: float = wire("f", "force that the law asked for, positive to the right", "N")
    pwm: int = wire("h", "signed duty in force, of pwm_top")
    delay_us: int = wire("H", "mean from a sampling to its force since the last frame", "us")
    flags: int = wire("B", "BoardFlag")
    rx_errors: int = wire("B", "bad frames and lost bytes that the board received, wraps at 256")
    overruns: int = wire("B", "ticks that were skipped so far, wraps at 256")
    generation: int = wire("B", "of the law in force, or of its last Tune that was taken")
    state_at: int = wire("B", "which value of the law's state this frame shows; they take turns")
    state: float = wire("f", "that value")


@dataclass(frozen=True)
class Settings(Board, id=0x85):
    """The settings in force, laid out as Board, and whether they are saved."""

    origin: int = wire("B", "Origin")
    refused: int = wire("B", "1: the last Board held numbers that no kit has, nothing was changed")


MESSAGES: tuple[type[Message], ...] = (
    HelloRequest, Force, Stop, Release, Stream, Law, Piece, Tune, Leave, Alive, SettingsRequest, Save, Board,
    Hello, Sample, Telemetry, Settings,
)  # fmt: skip
