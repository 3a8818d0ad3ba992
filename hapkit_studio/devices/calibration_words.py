"""A board's settings as a person reads them: a name, a number, its unit."""

from hapkit_studio.devices.profiles import numbered
from hapkit_studio.formatting import number
from hapkit_studio.protocol.messages import Board, MotorMap, Origin, Pins, Sensor

_CHOICES: dict[str, tuple[str, dict[int, str]]] = {
    "pins": (
        "Motor's pins",
        {Pins.D5_D8: "PWM D5, direction D8", Pins.D3_D12: "PWM D3, direction D12"},
    ),
    "sensor": (
        "Sensor",
        {
            Sensor.MAGNETORESISTIVE: "magnetoresistive, on A2",
            Sensor.AS5048A: "AS5048A, over SPI",
            Sensor.QUADRATURE: "two channels, on D2 and D3",
        },
    ),
    "motor_map": (
        "Torque grows with the",
        {MotorMap.SQUARE: "square of the duty", MotorMap.LINEAR: "duty", MotorMap.TABLE: "table of duties"},
    ),
    "sense": ("Counts grow to the", {1: "right", -1: "left"}),
    "direction": ("Direction pin high pushes to the", {1: "right", -1: "left"}),
}
# words, factor, unit, decimals
_NUMBERS = {
    "counts_per_flip": ("Counts from repeat to repeat", 1.0, "", 0),
    "quantum": ("Travel per count", 1e6, "µm", 2),
    "zero": ("Zero, a count", 1.0, "", 0),
    "motor_constant": ("Motor constant", 1e3, "mN·m", 2),
    "max_force": ("Force limit", 1.0, "N", 2),
    "dead_band": ("Dead band, duty of 255", 1.0, "", 0),
    "mass": ("Mass at the handle", 1e3, "g", 1),
    "viscous": ("Damping", 1.0, "N·s/m", 3),
    "coulomb": ("Dry friction", 1.0, "N", 3),
    "handle_radius": ("Axis to handle, rh", 1e3, "mm", 2),
    "pulley_radius": ("Pulley, rp", 1e3, "mm", 2),
    "sector_radius": ("Sector, rs", 1e3, "mm", 2),
}
MEASURED = (
    "counts_per_flip", "quantum", "zero", "sense", "direction", "motor_constant", "max_force", "dead_band",
    "mass", "viscous", "coulomb", "handle_radius", "pulley_radius", "sector_radius",
)  # fmt: skip
"""What a calibration may change, in the order of its steps."""
ALL = ("label", "profile", "pins", "sensor", "motor_map", *MEASURED, "table")
_ORIGINS = {
    Origin.DEFAULT: "the usual kit's: nothing is stored",
    Origin.STORED: "stored on the board",
    Origin.DAMAGED: "the usual kit's: what is stored is damaged",
    Origin.UNSAVED: "changed, not stored yet",
}
_WORDS = {"label": "Name", "profile": "Kit", "table": "Torque at 1/8 to 8/8, of 255"}


def words_of(name: str) -> str:
    """Return the name of a setting."""
    if name in _CHOICES:
        return _CHOICES[name][0]
    return _NUMBERS[name][0] if name in _NUMBERS else _WORDS[name]


def shown(board: Board, name: str) -> str:
    """Return one of a board's settings, with its unit."""
    value = getattr(board, name)
    if name in _CHOICES:
        return _CHOICES[name][1].get(value, f"unknown, {value}")
    if name in _NUMBERS:
        _words, factor, unit, decimals = _NUMBERS[name]
        return f"{number(factor * value, decimals)} {unit}".strip()
    if name == "profile":
        kit = numbered(value)
        return kit.title if kit else "a kit of its own"
    return str(value) if name == "label" else ", ".join(str(int(part)) for part in value)


def origin_words(origin: int) -> str:
    """Return where settings in force come from."""
    return _ORIGINS.get(Origin(origin), str(origin))
