"""Every message between computer and board, declared once; the firmware's header is generated from here."""

from dataclasses import dataclass
from enum import IntFlag

from hapkit_studio.protocol.declare import Message, wire

PROTOCOL_VERSION = 1
BAUD = 1_000_000


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
    """The last force command was not a finite number: motor off until the next one."""


@dataclass(frozen=True)
class HelloRequest(Message, id=0x01):
    """Ask the board who it is; it answers with Hello."""


@dataclass(frozen=True)
class Force(Message, id=0x02):
    """Command the force on the handle, in answer to a sample."""

    seq: int = wire("H", "number of the sample that this answers")
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
    profile: int = wire("B", "number of the board profile")
    build: str = wire("16s", "name of the firmware build")


@dataclass(frozen=True)
class Sample(Message, id=0x82):
    """One sensor sample and the state of the motor, sent every period while the stream is on."""

    seq: int = wire("H", "sample number, counts every period, wraps at 65536")
    time_us: int = wire("I", "board clock at sampling, wraps at 2^32", "us")
    count: int = wire("i", "sensor counts, half turns of the motor included")
    answered: int = wire("H", "sample number that the last applied force answered")
    delay_us: int = wire(
        "H", "from that sampling to its force in the PWM register; 0 none yet, 65535 longer", "us"
    )
    flags: int = wire("B", "BoardFlag")
    pwm: int = wire("h", "signed duty in force, of pwm_top")
    rx_errors: int = wire("B", "bad frames and lost bytes that the board received, wraps at 256")


MESSAGES: tuple[type[Message], ...] = (HelloRequest, Force, Stop, Release, Stream, Hello, Sample)
