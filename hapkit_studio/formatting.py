"""Number formats for people: true minus sign, thousands separators, and powers of ten for extreme values."""

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

MINUS = "\N{MINUS SIGN}"
_UNIT = r"JND|1/s|[kmµn]?(?:N|m|s|g|Hz|J)²?(?:[·/][ms][²³]?)*"
_WITH_NUMBER = re.compile(rf"(?<=[\d–]) (?:×(?: (?:below|above) the limit)?|%|{_UNIT})(?!\w)|× (?=\d)")
_SLASH = re.compile(r"(?<=[Nms1²])/(?=[ms](?![a-z]))")
_WHOLE_HERTZ = 20.0
_MOST_DECIMALS = 12
_LONGEST_SHOWN = 40  # maximum number of characters of a foreign text in a message
# harmless characters that Python calls non-printable
_ALLOWED = "\n\N{NO-BREAK SPACE}\N{WORD JOINER}"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, decimals: int, sign: bool = False) -> str:
    """Format a value with fixed decimals: -1234.5 becomes −1,234.5. A value that rounds to zero has no sign.

    With ``sign``, positive values have a plus.
    """
    rounded = round(float(value), decimals)
    text = f"{abs(rounded):,.{decimals}f}"
    if rounded < 0:
        return MINUS + text
    return "+" + text if sign and rounded > 0 else text


def significant(value: float, digits: int = 2) -> str:
    """Format a value with significant digits, including final zeros; return a dash if it is not finite."""
    if value == 0.0 or not math.isfinite(value):
        return "0" if value == 0.0 else "–"
    places = max(digits - 1 - math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}")))), 0)
    return f"{value:,.{places}f}".replace("-", MINUS)


def power_of_ten(value: float, digits: int = 1) -> str:
    """Format a value with at most ``digits`` digits and its power of ten, for example 2 × 10⁻⁶ or 10⁻⁶."""
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    if "." in mantissa:
        mantissa = mantissa.rstrip("0").rstrip(".")
    power = f"10{str(int(exponent)).translate(_SUPERSCRIPT)}"
    factor = {"1": "", "-1": MINUS}.get(mantissa, f"{mantissa.replace('-', MINUS)} × ")
    return factor + power


def compact(value: float, digits: int = 6, sign: bool = False) -> str:
    """Format a value with at most ``digits`` significant digits, without final zeros: 0.5, 1,230, 10⁻⁶.

    Powers of ten are used below 0.0001 and from a million on. With ``sign``, positive values have a plus.
    """
    rounded = float(f"{value:.{digits}g}")  # round first, because the rounded value determines the format
    text = f"{abs(rounded):,g}"
    if "e" in text:
        text = power_of_ten(abs(rounded), digits)
    if rounded < 0.0:
        return MINUS + text
    return "+" + text if sign and rounded > 0.0 else text


def with_unit(value: float, unit: str = "", digits: int = 3, sign: bool = False) -> str:
    """Format a value with at most ``digits`` significant digits and its unit.

    With ``sign``, positive values have a plus.
    """
    return f"{compact(value, digits, sign)} {unit}".rstrip()


def interval(value: float, half: float, decimals: int) -> str:
    """Format a value with its half width, for example 299.8 ± 0.1.

    The shown half width is at least one unit of the last decimal, because ± 0.0 would make the value look
    exact.
    """
    return f"{number(value, decimals)} ± {number(max(half, 10.0**-decimals), decimals)}"


def tick_labels(values: Sequence[float]) -> list[str]:
    """Format the ticks of a linear axis (n,); all have the fewest decimals that show their values."""
    ticks = np.asarray(values, dtype=float)
    dust = 1e-6 * float(np.abs(ticks).max(initial=0.0))
    exact = (d for d in range(_MOST_DECIMALS) if np.all(np.abs(np.round(ticks, d) - ticks) <= dust))
    decimals = next(exact, _MOST_DECIMALS)
    return [number(value, decimals) for value in values]


def hertz(frequency: float) -> str:
    """Format a frequency with one decimal below 20 Hz, otherwise without decimals."""
    return f"{number(frequency, 1 if round(frequency, 1) < _WHOLE_HERTZ else 0)} Hz"


def on_screen(value: float, unit: str, digits: int = 4) -> str:
    """Format an SI value in display units; a length is in mm, a time below 1 s in ms."""
    if unit == "m" or (unit == "s" and abs(value) < 1.0):
        return with_unit(1e3 * value, f"m{unit}", digits)
    return with_unit(value, unit, digits)


def clock(seconds: float) -> str:
    """Format a duration in s as 0:42, or 1:02:03 from an hour on."""
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def megabytes(size: int) -> str:
    """Format a number of bytes as MB with one decimal, or as kB below 1 MB."""
    return f"{number(1e-6 * size, 1)} MB" if size >= 1e6 else f"{number(1e-3 * size, 0)} kB"


def unbroken(text: str) -> str:
    """Return text that does not wrap between a number and its unit."""
    joined = _WITH_NUMBER.sub(lambda found: found[0].replace(" ", "\N{NO-BREAK SPACE}"), text)
    return _SLASH.sub("/\N{WORD JOINER}", joined)


def printable(text: str) -> str:
    """Return a text in which control, invisible and direction-changing characters are escaped as in JSON.

    All text from files is shown in this form in a terminal or window. JSON text keeps its value.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in _ALLOWED else json.dumps(c)[1:-1] for c in text)


def shortened(text: str, longest: int = _LONGEST_SHOWN) -> str:
    """Return a foreign text for a message: printable, and truncated with an ellipsis if it is long."""
    text = printable(text[: longest + 1])
    return text if len(text) <= longest else f"{text[:longest]}…"


def quoted(value: object) -> str:
    """Return a foreign value's repr for a message, truncated if it is long."""
    if isinstance(value, str) and len(value) > _LONGEST_SHOWN:
        return repr(f"{value[:_LONGEST_SHOWN]}…")
    try:
        return shortened(repr(value))
    except ValueError:  # the integer has more digits than Python prints
        return "a very long number"


def plain(value: Any) -> Any:
    """Return a value as JSON data: records as objects, arrays as lists, non-finite numbers as None."""
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, Mapping):
        return {key: plain(one) for key, one in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
