"""A value that the user can change: its key, label, unit, default, limits and help."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from numbers import Real

from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import compact, quoted


@dataclass(frozen=True)
class Parameter:
    """A number with a unit and limits for the user; if ``whole`` is True, users see only whole numbers."""

    key: str
    label: str
    unit: str
    default: float
    low: float
    high: float
    help: str = ""
    symbol: str = ""
    whole: bool = False

    discrete = False

    def check(self, value: object) -> float:
        """Return a value as float. Raise ParameterError if it is not a number within the limits."""
        try:
            number = float("" if isinstance(value, bool) else value)  # type: ignore[arg-type]
        except (TypeError, ValueError, OverflowError):
            wanted = f"a number in {self.unit}" if self.unit else "a number"
            raise ParameterError(f"{self.label} must be {wanted}, not {quoted(value)}.") from None
        if not math.isfinite(number) or not self.low <= number <= self.high:
            limits = f"{compact(self.low)} and {compact(self.high)} {self.unit}".rstrip()
            raise ParameterError(f"{self.label} must be between {limits}, not {compact(number)}.")
        return number

    def text(self, value: float) -> str:
        """Format a value with its unit."""
        return f"{compact(value)} {self.unit}".strip()


@dataclass(frozen=True)
class Choice:
    """One of a few named options. Laws use its index, files and programs its name, the window its label.

    Without labels, names are shown with spaces for underscores; raise ParameterError if only some options
    have a label. If ``method`` is True, the options are computation methods of different speed and accuracy.
    ``exact`` is the reference option; if it is omitted, the default option is the reference. ``phrases`` are
    the options as the end of a sentence that begins with the choice's label.
    """

    key: str
    label: str
    options: tuple[str, ...]
    default_option: str = ""
    help: str = ""
    symbol: str = ""
    unit: str = ""
    labels: tuple[str, ...] = ()
    method: bool = False
    exact: str = ""
    phrases: tuple[str, ...] = ()

    discrete = True
    low = 0.0

    def __post_init__(self) -> None:
        if self.labels and [type(word) for word in self.labels] != [str] * len(self.options):
            raise ParameterError(
                f"{self.label} must have one label for each of its {len(self.options)} options."
            )

    @property
    def high(self) -> float:
        return float(len(self.options) - 1)

    @property
    def default(self) -> float:
        return float(self.options.index(self.default_option)) if self.default_option else 0.0

    def check(self, value: object) -> float:
        """Return the index of an option that is given by name or index.

        Raise ParameterError for an unknown option.
        """
        if isinstance(value, str) and value in self.options:
            return float(self.options.index(value))
        if (
            isinstance(value, Real)
            and float(value).is_integer()
            and 0 <= float(value) < len(self.options)
            and not isinstance(value, bool)
        ):
            return float(value)
        raise ParameterError(f"{self.label} must be one of {', '.join(self.options)}, not {quoted(value)}.")

    def text(self, value: float) -> str:
        """Return the option's name."""
        return self.options[int(value)]

    @property
    def option_labels(self) -> tuple[str, ...]:
        """Return all options' labels."""
        return self.labels or tuple(option.replace("_", " ").capitalize() for option in self.options)

    def option_label(self, value: float) -> str:
        """Return one option's label."""
        return self.option_labels[int(value)]

    def phrase(self, value: float) -> str:
        """Return one option as the end of a sentence.

        A label is returned unchanged, because it may be a name.
        """
        phrases = self.phrases or self.labels or [option.replace("_", " ") for option in self.options]
        return phrases[int(value)]


def check_number(
    value: object,
    name: str,
    unit: str,
    *,
    low: float = 0.0,
    above: bool = False,
    high: float = math.inf,
    endless: bool = False,
) -> None:
    """Raise ParameterError unless a value is a number from ``low`` to ``high``.

    This function checks values without a slider, which have no Parameter. If ``above`` is True, ``low``
    itself is excluded. If ``endless`` is True, infinity is allowed.
    """
    number = float(value) if isinstance(value, Real) and not isinstance(value, bool) else math.nan
    if not (math.isfinite(number) or (endless and number == math.inf)):
        raise ParameterError(f"The {name} must be a number in {unit}, not {quoted(value)}.")
    if number < low or (above and number == low):
        bound = f"more than {compact(low)}" if above else f"{compact(low)} or more"
        raise ParameterError(f"The {name} must be {bound} {unit}, not {compact(number)} {unit}.")
    if number > high:
        bound = f"{compact(high)} {unit} or less"
        raise ParameterError(f"The {name} must be {bound}, not {compact(number)} {unit}.")


AnyParameter = Parameter | Choice


def resolve(parameters: Iterable[AnyParameter], values: Mapping[str, object], owner: str) -> list[float]:
    """Return one number per parameter; defaults replace missing values.

    Raise ParameterError for unknown keys and invalid values.
    """
    declared = {p.key: p for p in parameters}
    for key in values:
        if key not in declared:
            known = ", ".join(declared) or "none"
            raise ParameterError(f"{owner} has no parameter {quoted(key)}; it has: {known}.")
    return [p.check(values[key]) if key in values else p.default for key, p in declared.items()]
