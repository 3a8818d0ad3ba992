"""Checks type, size and range of every value in a session's events before it is used.

An entry whose name this version does not know may have any value. Control characters in text are escaped.
"""

import marshal
import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from hapkit_studio.errors import FileError
from hapkit_studio.files import checked_integer, checked_number, checked_table, checked_text, parse_json
from hapkit_studio.formatting import printable, quoted, shortened
from hapkit_studio.sessions.file import ABOUT, FAULT, MARKER, NOTE, SETTINGS, STOP

MOST_TEXT = 65_536  # maximum number of characters in an event; settings with 32 parameters have 3,000
_NAME, _SENTENCE = 200, 2_000  # maximum numbers of characters in a name and in a sentence
_MOST_NAMES = 64  # maximum number of parameters, units, states or model terms

Check = Callable[[object, str], Any]


def checked_event(
    text: str, kind: str, place: str, accepted: dict[tuple[str, str], tuple[bytes, Any]] | None = None
) -> dict[str, Any]:
    """Return an event's JSON object.

    Raise FileError for an invalid value; its text begins with ``place``. ``accepted`` has the last accepted
    value for each (kind of event, name), both serialised and parsed. An identical value is not checked again;
    the events then share one parsed value.
    """
    accepted = {} if accepted is None else accepted
    if len(text) > MOST_TEXT:
        raise FileError(f"{place} has {len(text):,} characters; the limit is {MOST_TEXT:,}.")
    what = checked_table(parse_json(text, place), place)
    if "\\" in text or not text.isprintable():
        what = _escaped(what)
    for name in _REQUIRED.get(kind, ()):
        if name not in what:
            raise FileError(f"{place}: a {kind} has no {name}.")
    for name, check in _CHECKS.get(kind, {}).items():
        if name not in what:
            continue
        serialised = marshal.dumps(what[name])  # a comparison with == would not distinguish 1 from true
        before, value = accepted.get((kind, name), (b"", None))
        if before == serialised:
            what[name] = value
        else:
            check(what[name], f"{place}: {name}")
            accepted[kind, name] = serialised, what[name]
    return what


def one_line(text: str) -> str:
    """Return a text as one line without control characters."""
    return printable(text).replace("\n", "\\n")


def _escaped(value: Any) -> Any:
    """Return a JSON value; the control characters in its texts and names are escaped."""
    if isinstance(value, str):
        return one_line(value)
    if isinstance(value, list):
        return [_escaped(one) for one in value]
    if isinstance(value, dict):
        return {one_line(name): _escaped(one) for name, one in value.items()}
    return value


def _flag(value: object, place: str) -> None:
    if not isinstance(value, bool):
        raise FileError(f"{place} is {quoted(value)}; it must be true or false.")


def _force_limit(value: object, place: str) -> None:
    """Check a force limit in N; the limit of a simulated device may be infinite."""
    if value != math.inf:
        checked_number(value, place, 0.0, 1e6, "N")


def _scalar(value: object, place: str) -> None:
    if isinstance(value, str):
        _name(value, place)
    elif value is not None and not isinstance(value, bool):
        checked_number(value, place)


def _names(check: Check) -> Check:
    """Return a check that accepts a JSON object if ``check`` accepts each value in it."""

    def check_table(value: object, place: str) -> None:
        table = checked_table(value, place)
        if len(table) > _MOST_NAMES:
            raise FileError(f"{place} has {len(table):,} names; the limit is {_MOST_NAMES}.")
        for name, one in table.items():
            _name(name, f"{place}: a name")
            check(one, f"{place}.{shortened(name)}")

    return check_table


def _state_names(value: object, place: str) -> None:
    if not isinstance(value, list) or len(value) > _MOST_NAMES:
        raise FileError(f"{place} is {quoted(value)}; it must be a list of at most {_MOST_NAMES} names.")
    for one in value:
        _name(one, place)


def _device(value: object, place: str) -> None:
    """Check the description of a device: its title or, for a simulated device, an object with its terms."""
    (_name if isinstance(value, str) else _names(_scalar))(value, place)


def _estimator(value: object, place: str) -> None:
    """Check a velocity estimator, which is a name, or [name, {option: number}]."""
    if isinstance(value, list) and len(value) == 2:
        _name(value[0], place)
        _names(_scalar)(value[1], place)
    else:
        _name(value, place)


_name: Check = partial(checked_text, longest=_NAME)
_sentence: Check = partial(checked_text, longest=_SENTENCE)
_CHECKS: Mapping[str, Mapping[str, Check]] = {
    ABOUT: {
        "device": _name,
        "studio": _name,
        "firmware": _name,
        "protocol": partial(checked_integer, low=0, high=1 << 32),
        "quantum_m": partial(checked_number, low=0.0, high=1.0, unit="m"),
    },
    SETTINGS: {
        "environment": _name,
        "parameters": _names(_scalar),
        "units": _names(_name),
        "state_names": _state_names,
        "hand": _name,
        "hand_grip": _names(_scalar),
        "grip": _name,
        "render": _name,
        "rate_Hz": partial(checked_number, low=1.0, high=1e6, unit="Hz"),
        "delay_s": partial(checked_number, low=0.0, high=1e3, unit="s"),
        "estimator": _estimator,
        "controller": _flag,
        "max_force_N": _force_limit,
        "device": _device,
        "seed": checked_integer,
    },
    STOP: {"stopped": _flag},
    FAULT: {"text": _sentence},
    MARKER: {"text": _sentence},
    NOTE: {"text": _sentence},
}
_REQUIRED = {STOP: ("stopped",), FAULT: ("text",), MARKER: ("text",), NOTE: ("text",)}
