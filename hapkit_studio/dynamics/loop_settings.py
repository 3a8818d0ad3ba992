"""The settings of a loop and its device: one type, and one schema for all files that contain them."""

import math
from collections.abc import Callable, Iterable, Mapping
from copy import copy
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self

from hapkit_studio.dynamics import nominal
from hapkit_studio.dynamics.estimators import ESTIMATORS, USUAL, Spec, parse
from hapkit_studio.dynamics.hand import ALL_GRIPS, Grip, grip_named
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import quoted
from hapkit_studio.parameters import AnyParameter, Choice, Parameter, check_number
from hapkit_studio.quantity import Quantity

RENDERERS = COMPUTER, BOARD = "computer", "board"
MODELS = ("scene", "everything", "frictionless")
"""The modelled terms of a simulated device: those that the scene needs, all, or all except dry friction."""

# the range that a user may set; an analysis accepts every possible device and loop (POSSIBLE)
RATE = Parameter(
    "rate", "Servo rate", "Hz", 1000.0, 100.0, 10_000.0,
    "How many times per second the force is computed. In between, the force stays the same, so a "
        "wall pushes a little longer on the way out than it resisted on the way in. This adds energy, "
        "and a stiff wall buzzes. At half the rate, a wall can be about half as stiff.",
)  # fmt: skip
DELAY = Parameter(
    "delay", "Added delay", "s", 0.0, 0.0, 0.1,
    "Extra time between sensor and motor, added on purpose. The force then depends on where "
        "the handle was, not on where it is. The longer the delay, the softer a wall must be so that it "
        "does not buzz.",
)  # fmt: skip
ESTIMATOR = Choice(
    "estimator", "Velocity", tuple(ESTIMATORS), USUAL,
    "How the speed is computed from the measured positions. Difference: fast, but it jumps, so "
        "damping rattles. IIR and Butterworth: smooth but late, and late damping can make a wall "
        "buzz. FOAW: smooth in slow motion, fast at an impact. Kalman: predicts the speed with a "
        "model and corrects it with each sample.",
    labels=("Difference", "IIR", "Butterworth", "FOAW", "Kalman"),
)  # fmt: skip
GRIP = Choice(
    "grip", "Grip", tuple(ALL_GRIPS), "medium",
    "How firmly the simulated hand holds the handle while you drag. A hand absorbs energy: a "
        "scene that buzzes when released may be stable in a firm grip. A rubber band absorbs almost none.",
)  # fmt: skip
CONTROLLER = Choice("controller", "Passivity controller", ("off", "on"))
MODEL = Choice("model", "Model", MODELS)
WHERE = Choice("where", "Rendered by", RENDERERS)
_RATES = range(4000, 499, -500)  # Hz: rates offered to users; the board itself supports finer steps
BOARD_RATE = Choice(
    "board_rate", "Board's rate", ("fastest", *map(str, _RATES)), "fastest",
    (
        "How many times per second the board computes the force. The longer a law takes, the lower "
        "its fastest rate."
    ),
    labels=("fastest", *(f"{rate:,} Hz" for rate in _RATES)),
)  # fmt: skip

POSSIBLE = {
    p.key: p
    for p in (
        Parameter("mass", "The mass", "kg", nominal.MASS, 1e-13, 1e9),
        Parameter("viscous", "The viscous damping", "N·s/m", nominal.VISCOUS, 0.0, 1e5),
        Parameter("coulomb", "The Coulomb friction", "N", nominal.COULOMB_FORCE, 0.0, 1e4),
        Parameter("quantum", "The sensor quantum", "m", nominal.QUANTUM, 0.0, 0.1),
        Parameter("rate", "The rate", "Hz", RATE.default, 1e-3, 1e9),
        Parameter("delay", "The delay", "s", DELAY.default, 0.0, 10.0),
    )
}
"""Possible range of every setting, wider than the range that a user may set."""
# longest delay in periods; it bounds the computing time, because the exact limit evaluates points in every
# turn of the delay's phase
MOST_LATE = 2000.0


def check_delay(rate: float, delay: float) -> None:
    """Raise ParameterError if a delay in s exceeds MOST_LATE periods at a rate in Hz."""
    if rate * delay > MOST_LATE:
        raise ParameterError(
            f"A delay of {delay:g} s at {rate:,g} Hz is {rate * delay:,g} periods; "
            f"{MOST_LATE:,g} at most: lower the delay or the rate."
        )


@dataclass(frozen=True)
class LoopSettings:
    """The settings of a loop, the hand and the device; raise ParameterError for impossible values.

    ``rate`` is in Hz. ``delay`` is the time in s from a sample to its force. ``estimator`` is the velocity
    estimator: "iir" or ("iir", {"cutoff": 20.0}). ``controller`` is True if the passivity controller is on.
    ``hand`` is the name of a grip; ``own_grip`` replaces it by a grip without a name. The device has ``mass``
    in kg, ``viscous`` in N·s/m, ``coulomb`` in N, the sensor's ``quantum`` in m, and the force limit
    ``max_force`` in N. ``model`` selects the modelled terms of a simulated device. ``where`` is the renderer,
    computer or board. ``board_rate`` is in Hz; None means the highest rate that the law allows.
    """

    rate: float = RATE.default
    delay: float = DELAY.default
    # the options are a dictionary, which has no hash
    estimator: Spec = field(default="difference", hash=False)
    controller: bool = False
    hand: str = "released"
    mass: float = nominal.MASS
    viscous: float = nominal.VISCOUS
    coulomb: float = nominal.COULOMB_FORCE
    quantum: float = nominal.QUANTUM
    max_force: float = nominal.MAX_FORCE
    model: str = MODELS[0]
    where: str = COMPUTER
    board_rate: float | None = None
    own_grip: Grip | None = None

    def __post_init__(self) -> None:
        for key, number in POSSIBLE.items():
            object.__setattr__(self, key, number.check(getattr(self, key)))
        check_number(self.max_force, "force limit", "N", above=True, endless=True)
        check_delay(self.rate, self.delay)
        method, _ = parse(self.estimator)
        options = {} if isinstance(self.estimator, str) else dict(self.estimator[1])
        object.__setattr__(self, "estimator", (method.key, options) if options else method.key)
        if not isinstance(self.hand, str):
            raise ParameterError(f"The hand takes a grip's name, not {self.hand!r}.")
        grip_named(self.hand)

    @property
    def period(self) -> float:
        """Return the sampling period in s."""
        return 1.0 / self.rate

    @property
    def parted(self) -> tuple[int, float]:
        """Return the number of whole periods in the delay, and the remaining time in s."""
        whole = math.floor(self.delay * self.rate + 1e-9)
        return whole, max(self.delay - whole * self.period, 0.0)

    @property
    def grip(self) -> Grip | None:
        """Return the hand's impedance; None for a released handle."""
        return self.own_grip or grip_named(self.hand)

    @property
    def moving_mass(self) -> float:
        """Return the mass of handle and hand in kg."""
        return self.mass + (self.grip.mass if self.grip else 0.0)

    @property
    def total_viscous(self) -> float:
        """Return the damping of handle and hand in N·s/m."""
        return self.viscous + (self.grip.damping if self.grip else 0.0)

    @property
    def grip_stiffness(self) -> float:
        """Return the hand's stiffness in N/m; 0 for a released handle."""
        return self.grip.stiffness if self.grip else 0.0

    @property
    def method(self) -> str:
        """Return the name of the velocity estimator without its options."""
        return self.estimator if isinstance(self.estimator, str) else self.estimator[0]

    @property
    def options(self) -> dict[str, float]:
        """Return the options of the velocity estimator that were given or differ from the defaults."""
        return {} if isinstance(self.estimator, str) else dict(self.estimator[1])

    @property
    def linear(self) -> bool:
        """Return True if the velocity estimator has a transfer function, so that an exact limit exists."""
        return parse(self.estimator)[0].response is not None

    def changed(self, **changes: Any) -> Self:
        """Return the settings with some changes; raise ParameterError if a change exceeds a user's limits.

        Only the changes are checked.
        """
        changed = copy(self)
        for key, value in changes.items():
            object.__setattr__(changed, key, FIELDS[key].check(value))
        check_delay(changed.rate, changed.delay)
        return changed


USUAL_LOOP = LoopSettings(estimator=ESTIMATOR.default_option, hand=GRIP.default_option)
"""Initial settings of a user's loop."""


def estimator_texts(spec: Spec) -> tuple[str, str]:
    """Format a velocity estimator with its options in two forms: as on the command line, and for people."""
    method, options = parse(spec)
    numbers = [f"{key}={value:g}" for key, value in options.items()]
    given = f"{method.key}:{','.join(numbers)}" if numbers else method.key
    parts = [f"{p.label.lower()} {options[p.key]:,g} {p.unit}".rstrip() for p in method.parameters]
    return given, ", ".join([method.label, *parts])


# --- one schema for window state, undo, presets, demos, sessions and headers of tables


class Difference(NamedTuple):
    """A changed setting as text: name, old and new value, and their unit."""

    name: str
    old: str
    new: str
    unit: str

    def __str__(self) -> str:
        name = f"{self.name[:1].lower()}{self.name[1:]}"
        return f"{name} {self.old} → {self.new} {self.unit}".rstrip()


def difference(parameter: AnyParameter, old: Any, new: Any) -> Difference:
    """Return two values of a parameter as text; an option of a choice is given by index or by name."""
    if isinstance(parameter, Choice):
        before, after = (parameter.option_label(parameter.check(value)) for value in (old, new))
        return Difference(parameter.label, before, after, "")
    shown = Quantity(parameter)
    before, after = (shown.text(value * shown.factor) for value in (old, new))
    return Difference(parameter.label, before, after, shown.unit)


@dataclass(frozen=True)
class Field:
    """A loop setting in files: its parameter, and its key in sessions, which includes the unit."""

    parameter: AnyParameter
    recorded: str
    attribute: str = ""
    """Name of the attribute in LoopSettings if it differs from the parameter's key, else ""."""

    @property
    def key(self) -> str:
        """Return the setting's name in LoopSettings."""
        return self.attribute or self.parameter.key

    def check(self, value: Any) -> Any:
        """Return the value in the form of LoopSettings; raise ParameterError if it is invalid."""
        match self.parameter.key:
            case "estimator":
                method, _ = parse(tuple(value) if isinstance(value, list) else value)
                return method.key if isinstance(value, str) else (method.key, dict(value[1]))
            case "controller":
                if not isinstance(value, bool):
                    raise ParameterError(f"controller takes true or false, not {quoted(value)}.")
                return value
            case "board_rate":
                return None if value is None else float(BOARD_RATE.text(BOARD_RATE.check(_rate_name(value))))
        if isinstance(self.parameter, Choice):
            if not isinstance(value, str):
                known = ", ".join(self.parameter.options)
                raise ParameterError(f"{self.parameter.label} takes one of {known}, not {quoted(value)}.")
            return self.parameter.text(self.parameter.check(value))
        if isinstance(value, str):
            raise ParameterError(f"{self.parameter.label} must be a number, not {quoted(value)}.")
        return self.parameter.check(value)

    def difference(self, old: Any, new: Any) -> Difference:
        """Return two values as text; the options of an estimator are omitted if its method has changed."""
        match self.parameter.key:
            case "estimator":
                (one, given), (other, wanted) = (_method_and_options(value) for value in (old, new))
                if one == other:
                    return Difference("Velocity filter", _options(given), _options(wanted), "")
                old, new = one, other
            case "controller":
                old, new = (CONTROLLER.options[value] for value in (old, new))
                return Difference(CONTROLLER.label, old, new, "")
            case "board_rate":
                old, new = ("fastest" if value is None else _rate_name(value) for value in (old, new))
        return difference(self.parameter, old, new)


def _rate_name(rate: Any) -> str:
    return f"{rate:g}" if isinstance(rate, int | float) else str(rate)


def _method_and_options(spec: Spec) -> tuple[str, dict[str, float]]:
    return (spec, {}) if isinstance(spec, str) else spec


def _options(options: Mapping[str, float]) -> str:
    return ", ".join(f"{key} {number:g}" for key, number in options.items()) or "as usual"


FIELDS = {
    field.key: field
    for field in (
        Field(RATE, "rate_Hz"),
        Field(DELAY, "delay_s"),
        Field(ESTIMATOR, "estimator"),
        Field(CONTROLLER, "controller"),
        Field(GRIP, "grip", "hand"),
        Field(MODEL, "model"),
        Field(WHERE, "render"),
        Field(BOARD_RATE, "board_rate"),
    )
}
"""Settings that a user may change, by their name in LoopSettings."""
WITH_SCENE = ("rate", "delay", "estimator", "controller", "model", "hand")
"""Settings in presets and demos. ``where`` is not included, because it depends on the device."""
OPTIONS = "options"
"""Key of the velocity estimator's options in a file."""
Reject = Callable[[ParameterError], object]
"""A callback that receives the error of each rejected value."""


def ignore(_error: ParameterError) -> None:
    """Ignore an invalid value."""


def to_table(settings: LoopSettings, keys: Iterable[str] = FIELDS) -> dict[str, Any]:
    """Return the settings for a file, in SI units; choices are given by name."""
    table: dict[str, Any] = {}
    for key in keys:
        value = getattr(settings, key)
        table[FIELDS[key].parameter.key] = value if key != "estimator" else settings.method
    if "estimator" in keys and settings.options:
        table[OPTIONS] = settings.options
    return table


def from_table(
    table: Mapping[str, Any],
    usual: LoopSettings,
    reject: Reject = ignore,
    only: Iterable[str] | None = None,
) -> dict[str, Any]:
    """Return a table's valid settings by their names in LoopSettings; ``reject`` receives the errors.

    The keys are those of ``to_table`` or of a session, such as rate_Hz. If the table has options but no
    estimator, the options belong to the estimator of ``usual``. ``only`` lists the permitted settings; other
    keys are errors.
    """
    fields = FIELDS.values() if only is None else [FIELDS[key] for key in only]
    names = {name: field for field in fields for name in (field.recorded, field.parameter.key)}
    found: dict[str, Any] = {}
    for name, value in table.items():
        field = names.get(name)
        try:
            if field is not None:
                found[field.key] = field.check(value)
            elif only is not None and name != OPTIONS:
                known = ", ".join((*(field.parameter.key for field in fields), OPTIONS))
                raise ParameterError(f"The loop has no {quoted(name)}; it has: {known}.")
        except ParameterError as error:
            reject(error)
    if table.get(OPTIONS):
        method = _method_and_options(found.get("estimator", usual.estimator))[0]
        try:
            found["estimator"] = FIELDS["estimator"].check((method, table[OPTIONS]))
        except (ParameterError, TypeError, ValueError) as error:
            reject(error if isinstance(error, ParameterError) else ParameterError("options takes a table."))
    return found


def recorded(settings: LoopSettings) -> dict[str, Any]:
    """Return settings for sessions and table headers: keys with units, values in SI units."""
    keys = ("hand", "where", "rate", "delay", "estimator", "controller")
    return {FIELDS[key].recorded: getattr(settings, key) for key in keys} | {
        "max_force_N": settings.max_force
    }


def differences(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[Difference]:
    """Return the settings that differ, as text; only settings in both tables are compared."""
    return [
        field.difference(before[key], after[key])
        for key, field in FIELDS.items()
        if key in before and key in after and before[key] != after[key]
    ]
