"""Known kits, each with its board's settings; a calibration measures individual differences."""

import math
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.dynamics import nominal
from hapkit_studio.errors import ParameterError
from hapkit_studio.protocol.messages import Board, Hello, MotorMap, Pins, Sensor

MR_COUNTS = 921
"""Counts per half turn: the sensor spans 5 to 95 % of its supply."""
HALL_COUNTS = 16384
ENCODER_COUNTS = 48
FULL_TABLE = (32, 64, 96, 128, 159, 191, 223, 255)
"""Torque at eighths of the full duty, in units of 1/255; it is linear until it is measured."""


@dataclass(frozen=True)
class Kit:
    """One kind of kit: key, title, a one-line description, and its board's settings."""

    key: str
    title: str
    note: str
    board: Board


def readings(raw: np.ndarray, sensor: int) -> np.ndarray:
    """Return raw readings (n,), signed for an encoder, which counts up and down from its start."""
    return (raw + 2**15) % 2**16 - 2**15 if sensor == Sensor.QUADRATURE else raw


def quantum_of(board: Board) -> float:
    """Return the handle's travel per count in m, computed from the radii of pulley, sector and handle."""
    gear = board.pulley_radius / board.sector_radius
    # the magnetoresistive sensor repeats every half turn of the motor, the other sensors every full turn
    repeat = math.pi if board.sensor == Sensor.MAGNETORESISTIVE else 2.0 * math.pi
    return repeat * gear * board.handle_radius / board.counts_per_flip


def full_force(board: Board | Hello) -> float:
    """Return the handle force at full duty in N: torque * sector radius / (handle radius * pulley radius)."""
    return board.motor_constant * board.sector_radius / (board.handle_radius * board.pulley_radius)


def _board(number: int, **changes: object) -> Board:
    """Return the settings of a kit; ``changes`` are its differences from the default kit."""
    usual = Board(
        profile=number, pins=Pins.D5_D8, sensor=Sensor.MAGNETORESISTIVE, motor_map=MotorMap.SQUARE,
        direction=1, sense=1, counts_per_flip=MR_COUNTS, zero=0, quantum=0.0, max_force=3.0,
        motor_constant=0.0183, handle_radius=0.090, pulley_radius=0.005, sector_radius=0.074,
        mass=nominal.MASS, viscous=nominal.VISCOUS, coulomb=nominal.COULOMB_FORCE,
        dead_band=0, table=FULL_TABLE, label="Hapkit",
    )  # fmt: skip
    made = replace(usual, **changes)  # type: ignore[arg-type]
    return replace(made, quantum=quantum_of(made))


KITS = (
    Kit(
        "hapkit3",
        "Hapkit 3.0",
        "The usual kit: cable drive, a magnet on the motor, and a sensor chip on the board.",
        _board(1),
    ),
    Kit(
        "hapkit3-maxon",
        "Hapkit 3.0, stronger motor",
        "The usual kit with a stronger motor. The Arduino template from class uses 0.03 N·m as its constant.",
        _board(2, motor_constant=0.03, label="Hapkit maxon"),
    ),
    Kit(
        "hapkit3-short",
        "Hapkit 3.0, short handle",
        "The usual kit with a shorter handle: 70 mm from the axis.",
        _board(3, handle_radius=0.070, label="Hapkit short"),
    ),
    Kit(
        "hapkit2013",
        "Hapkit 2013, board 1.0",
        "Friction drive. Handle 65.7 mm from the axis, motor on pins D3 and D12, board marked 2013.",
        _board(
            4, pins=Pins.D3_D12, motor_constant=0.03, handle_radius=0.0657, pulley_radius=0.00419,
            sector_radius=0.0732, label="Hapkit 2013",
        ),
    ),
    Kit(
        "hapkit-hall",
        "Hapkit with AS5048A",
        "A small extra board at the motor, with six wires to pins D10 to D13.",
        _board(5, sensor=Sensor.AS5048A, counts_per_flip=HALL_COUNTS, label="Hapkit Hall"),
    ),
    Kit(
        "hapkit-encoder",
        "Hapkit with an encoder motor",
        "Encoder with 48 steps a turn on pins D2 and D3, motor on D5 and D8. A Longhorn Hapkit has its motor "
        "on D4, D5 and D6: change the wires.",
        _board(
            6, sensor=Sensor.QUADRATURE, counts_per_flip=ENCODER_COUNTS, motor_map=MotorMap.LINEAR,
            motor_constant=0.0167, sector_radius=0.075, max_force=2.7, label="Hapkit enc.",
        ),
    ),
)  # fmt: skip
"""Constants from class templates and student programs of 2013 to 2025; the firmware's kit is the first."""


def nearest_kit(board: Board) -> tuple[Kit, float]:
    """Return the kit with this sensor and the most similar travel per count, and the ratio of the travels."""
    ratios = [(kit, board.quantum / kit.board.quantum) for kit in KITS if kit.board.sensor == board.sensor]
    return min(ratios, key=lambda found: abs(math.log(found[1])))


def default() -> Kit:
    """Return the default kit of a board."""
    return KITS[0]


def named(key: str) -> Kit:
    """Return a kit by its key; raise ParameterError for an unknown key."""
    found = {kit.key: kit for kit in KITS}
    if key not in found:
        raise ParameterError(f"There is no kit {key!r}. Available kits: {', '.join(found)}.")
    return found[key]


def numbered(profile: int) -> Kit | None:
    """Return the kit with the profile number of a board's settings; None if the number is unknown."""
    return next((kit for kit in KITS if kit.board.profile == profile), None)


def of_settings(settings: Board) -> Board:
    """Return settings as a Board message; sending this message applies the settings again."""
    return Board(**{field.name: getattr(settings, field.name) for field in Board.layout()})
