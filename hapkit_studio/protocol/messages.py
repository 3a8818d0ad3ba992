"""Every message between computer and board, declared once; the firmware's header is generated from here.

A message is a frozen dataclass, sent as a packed little-endian struct. Each field declares its type.
"""

import struct
from dataclasses import dataclass, field, fields
from enum import IntEnum, IntFlag
from typing import Any, ClassVar, NamedTuple, Self

FROM_BOARD = 0x80
FLOAT_MAX = (2.0 - 2.0**-23) * 2.0**127  # largest finite float32


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
        """Return how many numbers the field contains; a text is one value."""
        return 1 if self.code.endswith("s") else int(self.code[:-1] or 1)

    @property
    def limits(self) -> tuple[float, float]:
        """Return the smallest and largest value of each number in the field."""
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
    """The base of all messages; a subclass declares its id, whose top bit is set if the board sends it."""

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
        """Return the offset of a field from the start of the message, whose first byte is the id."""
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
        """Return the message whose id and payload are ``body``; raise ValueError for a wrong size or id."""
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
"""Largest number of a law's bytes in a message."""

TUNED = 6
"""Largest number of a law's constants in a message."""


class Estimator(IntEnum):
    """The velocity estimator of the board; its coefficients are ``first`` and ``second`` of Law."""

    DIFFERENCE = 0
    """v = (x - before) / T."""
    IIR = 1
    """v += first ((x - before) / T - v)."""
    KALMAN = 2
    """Steady-state filter: r = x - (at + T v); at += T v + first r; v += second r."""


class Pins(IntEnum):
    """Connector of motor 1."""

    D5_D8 = 0
    """PWM on D5, direction on D8: every board after board 1.0."""
    D3_D12 = 1
    """PWM on D3, direction on D12: board 1.0."""


class Sensor(IntEnum):
    """Type of the motor's angle sensor."""

    MAGNETORESISTIVE = 0
    """Analog on A2, repeats every half turn."""
    AS5048A = 1
    """14 bits over SPI, selected by D10, repeats every turn."""
    QUADRATURE = 2
    """Two channels on D2 and D3, counted without repeating."""


class MotorMap(IntEnum):
    """Relation of the motor's torque to its duty."""

    SQUARE = 0
    """torque = constant * duty^2."""
    LINEAR = 1
    """torque = constant * duty."""
    TABLE = 2
    """torque = constant * table / 255, interpolated between eight duties."""


class Origin(IntEnum):
    """Origin of the settings that the board uses."""

    DEFAULT = 0
    STORED = 1
    """The settings were loaded from the EEPROM, or saved to it."""
    DAMAGED = 2
    """The checksum of the EEPROM is wrong, so the defaults are used."""
    UNSAVED = 3
    """The settings were changed since the start and not saved."""


class BoardFlag(IntFlag):
    """State of the board's motor and loop in a sample."""

    WATCHDOG = 1
    """No valid force command came within the watchdog's time: the motor is off until the next command."""
    STOPPED = 2
    """Emergency stop: the motor is off until Release."""
    CLAMPED = 4
    """The last force command exceeded the force limit and was clamped."""
    OVERRUN = 8
    """Since the last frame, a sample was skipped, or its frame did not fit into the send buffer."""
    REFUSED = 16
    """The last force was not a finite number: the motor is off until the next command, or the next law."""
    OVER_SPEED = 32
    """The handle was faster than the board's limit: the motor is off until Release."""
    SENSOR = 64
    """Implausible readings were replaced since the last frame; after several in a row the motor is off."""


@dataclass(frozen=True)
class HelloRequest(Message, id=0x01):
    """Ask the board for its identity; it answers with Hello."""


@dataclass(frozen=True)
class Force(Message, id=0x02):
    """Set the force on the handle. The board refuses a nonzero force whose sample is too old."""

    seq: int = wire("H", "number of the newest sample that the computer has received")
    behind: int = wire("B", "number of samples from the answered sample to the newest one")
    force: float = wire("f", "force on the handle, positive to the right", "N")


@dataclass(frozen=True)
class Stop(Message, id=0x03):
    """Emergency stop: the motor is off at once, and stays off until Release."""


@dataclass(frozen=True)
class Release(Message, id=0x04):
    """End the emergency stop; the motor stays off until the next Force."""


@dataclass(frozen=True)
class Stream(Message, id=0x05):
    """Switch the samples on or off; switching them off also switches the motor off."""

    on: int = wire("B", "1 on, 0 off")
    padded: int = wire(
        "B", "frames are padded with delimiters to a multiple of this number of bytes; 0: no padding"
    )


@dataclass(frozen=True)
class Law(Message, id=0x06):
    """Announce a law. The present law fades out over 30 ms, then its memory receives the new law's pieces.

    After the last byte the new law fades in over 30 ms, unless it is refused. Its bytes are `given` float32,
    which are the state's initial values and the constants, then the code. Repeating the same generation has
    no effect.
    """

    generation: int = wire("B", "differs from that of the last law; samples and telemetry repeat it")
    period: int = wire("H", "period in half microseconds, from 500 (4 kHz) to 4000 (500 Hz)")
    estimator: int = wire("B", "Estimator")
    first: float = wire("f", "first coefficient of the estimator")
    second: float = wire("f", "second coefficient of the estimator", "1/s")
    states: int = wire("B", "number of state variables, in the slots from 2 on")
    given: int = wire("B", "number of slots from 2 on with initial values: state, then constants")
    slots: int = wire("B", "total number of slots; slots without an initial value start at 0")
    code: int = wire("H", "bytes of code")
    check: int = wire("H", "CRC-16 of all bytes sent in pieces")


@dataclass(frozen=True)
class Piece(Message, id=0x07):
    """A piece of a law; the board accepts pieces only in order.

    After a loss, pieces are sent again from the byte offset that the board reports in samples and telemetry.
    """

    generation: int = wire("B", "generation of the law")
    at: int = wire("H", "offset of the first byte; consecutive pieces are adjacent")
    data: tuple[int, ...] = wire(f"{PIECE}B", "the bytes, padded with zeros")


@dataclass(frozen=True)
class Tune(Message, id=0x08):
    """Change constants of the law that is running, with a ramp of 30 ms."""

    law: int = wire("B", "generation of the law")
    generation: int = wire("B", "generation of this change; Telemetry repeats the last accepted one")
    count: int = wire("B", "number of constants")
    slots: tuple[int, ...] = wire(f"{TUNED}B", "slots of the constants, padded with zeros")
    values: tuple[float, ...] = wire(f"{TUNED}f", "values of the constants, padded with zeros")


@dataclass(frozen=True)
class Leave(Message, id=0x0D):
    """Let the computer render: the law's force fades out over 30 ms, then samples follow.

    A second Leave stops the law at once.
    """


@dataclass(frozen=True)
class Alive(Message, id=0x09):
    """Keep-alive while the board renders; after watchdog_ms without it, the board switches the motor off."""


@dataclass(frozen=True)
class SettingsRequest(Message, id=0x0A):
    """Ask for the settings that the board uses; it answers with Settings."""


@dataclass(frozen=True)
class Save(Message, id=0x0B):
    """Save the settings that the board uses in the EEPROM; it answers with Settings."""


@dataclass(frozen=True)
class Board(Message, id=0x0C):
    """Settings of a kit: pins, sensor, geometry, motor.

    They apply at once, with the motor off, and are not saved. The board answers with Settings. If one number
    is implausible, it refuses all.
    """

    profile: int = wire("B", "number of the kit's profile, for the computer")
    pins: int = wire("B", "Pins")
    sensor: int = wire("B", "Sensor")
    motor_map: int = wire("B", "MotorMap")
    direction: int = wire("b", "1: the direction pin is high to push to the right, -1: low")
    sense: int = wire("b", "1: counts grow to the right, -1: to the left")
    counts_per_flip: int = wire("H", "sensor counts after which the readings repeat")
    zero: int = wire(
        "i", "count at the handle's zero, before sense is applied; a start uses it modulo counts_per_flip"
    )
    quantum: float = wire("f", "handle travel per sensor count", "m")
    max_force: float = wire("f", "force limit", "N")
    motor_constant: float = wire("f", "motor torque at full duty", "N*m")
    handle_radius: float = wire("f", "sector axis to handle", "m")
    pulley_radius: float = wire("f", "motor pulley", "m")
    sector_radius: float = wire("f", "sector drum", "m")
    mass: float = wire("f", "mass of the paddle at the handle", "kg")
    viscous: float = wire("f", "viscous friction of the paddle at the handle", "N*s/m")
    coulomb: float = wire("f", "dry friction of the paddle at the handle", "N")
    dead_band: int = wire("B", "pwm up to which the motor does not turn; it is added to every duty")
    table: tuple[int, ...] = wire("8B", "torque in 255ths at 1/8, 2/8 ... 8/8 of full duty, not decreasing")
    label: str = wire("12s", "the kit's name")


@dataclass(frozen=True)
class Hello(Message, id=0x81):
    """Identity of the board: version, build and every constant that the computer needs."""

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
    watchdog_ms: int = wire("H", "time without a message after which the motor is switched off", "ms")
    pwm_top: int = wire("H", "pwm value of full duty")
    profile: int = wire("B", "number of the kit's profile")
    arena: int = wire("H", "bytes for the slots, the code and the ramped constants of one law")
    origin: int = wire("B", "Origin")
    reset: int = wire("B", "reason of the last reset: 1 power, 2 reset, 4 brown-out, 8 watchdog")
    build: str = wire("16s", "name of the firmware build")


@dataclass(frozen=True)
class Sample(Message, id=0x82):
    """One sensor sample and the state of the motor, sent every period while the stream is on."""

    seq: int = wire("H", "number of the sample; it counts every period and wraps at 65536")
    time_us: int = wire("I", "board clock at sampling, wraps at 2^32", "us")
    count: int = wire("i", "unwrapped sensor counts from the zero, positive to the right")
    raw: int = wire("H", "raw reading of the sensor")
    answered: int = wire("H", "number of the sample that the last applied force answered")
    delay_us: int = wire(
        "H", "time from that sample to its force in the PWM register; 0: no force yet, 65535: longer", "us"
    )
    flags: int = wire("B", "BoardFlag")
    pwm: int = wire("h", "present signed duty, from -pwm_top to pwm_top")
    rx_errors: int = wire("B", "damaged frames, and bytes lost before the board read them, wraps at 256")
    stale: int = wire("B", "forces refused because they were too old, wraps at 256")
    generation: int = wire("B", "generation of the law that is being sent or was sent last")
    received: int = wire("H", "number of its bytes received without a gap")
    refusal: int = wire("B", "Refusal: reason why the law is not rendered")


@dataclass(frozen=True)
class Telemetry(Message, id=0x83):
    """Motion and force of a law that the board renders, sent instead of Sample.

    Frames are at least a millisecond apart: up to 1 kHz there is one for every tick, above that for every
    second, third or fourth tick.
    """

    seq: int = wire("H", "number of this tick, wraps at 65536")
    time_us: int = wire("I", "board clock at the tick's sample, wraps at 2^32", "us")
    count: int = wire("i", "unwrapped sensor counts from the zero, positive to the right")
    velocity: float = wire("f", "velocity estimated by the board, positive to the right", "m/s")
    asked: float = wire("f", "force of the law, positive to the right", "N")
    pwm: int = wire("h", "present signed duty, from -pwm_top to pwm_top")
    delay_us: int = wire("H", "mean time from a sample to its force since the last frame", "us")
    flags: int = wire("B", "BoardFlag")
    rx_errors: int = wire("B", "damaged frames, and bytes lost before the board read them, wraps at 256")
    overruns: int = wire("B", "number of skipped ticks, wraps at 256")
    generation: int = wire("B", "generation of the law that is running, or of its last accepted Tune")
    state_at: int = wire(
        "B", "index of the state variable in this frame; all state variables are sent in turn"
    )
    state: float = wire("f", "value of that state variable")


@dataclass(frozen=True)
class Settings(Board, id=0x85):
    """The settings that the board uses, in the layout of Board, and whether they are saved."""

    origin: int = wire("B", "Origin")
    refused: int = wire("B", "1: the last Board had implausible numbers and was ignored")


MESSAGES: tuple[type[Message], ...] = (
    HelloRequest, Force, Stop, Release, Stream, Law, Piece, Tune, Leave, Alive, SettingsRequest, Save, Board,
    Hello, Sample, Telemetry, Settings,
)  # fmt: skip
