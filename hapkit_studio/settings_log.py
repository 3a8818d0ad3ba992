"""Settings over time: the log of a recording as JSON, and as readable header lines of a table.

A header has one ``# name: value unit`` per line; a later change is ``# name at 1.5 s: value unit``. A
parameter of the environment has its plain name, or ``parameter.name`` if a setting has the same name.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import pairwise
from numbers import Integral, Real
from typing import Any

from hapkit_studio.errors import FileError
from hapkit_studio.files import parse_json
from hapkit_studio.formatting import printable

LoggedSettings = Mapping[str, Any]
Log = Sequence[tuple[float, LoggedSettings]]
"""Settings with the time in s from which they are valid; the oldest come first."""

_KEYS = (
    "environment", "hand", "hand_grip", "grip", "render", "rate_Hz", "delay_s", "estimator", "controller",
    "max_force_N", "device", "seed", "quantum_m", "studio", "firmware", "protocol",
)  # fmt: skip
_SUFFIX = re.compile(r"_(Hz|s|N|m)$")  # matches the unit at the end of a setting's key
_NAMES = {_SUFFIX.sub("", key): key for key in _KEYS}
_HAND = {"mass": "kg", "damping": "N·s/m", "stiffness": "N/m"}
_DEVICE = {
    "mass": "kg", "damping": "N·s/m", "coulomb_force": "N", "quantum": "m", "max_force": "N",
    "initial_position": "m", "initial_velocity": "m/s", "end_stops": "m",
}  # fmt: skip
_UNITS = {"hand_grip": _HAND, "device": _DEVICE, "estimator": {"cutoff": "Hz", "noise": "counts"}}
_PARAMETER = "parameter"  # prefix of a parameter whose name is also that of a setting
_UNKNOWN_SETTING = "setting"  # prefix of an unknown setting
_LINE = re.compile(r"(?P<name>[^\s:]+)(?: at (?P<time>[-+.\de]+) s)?:(?: (?P<value>.*))?")
_NUMBER = re.compile(
    r"(?P<number>[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:e[-+]?\d+)?|[-+]?inf|nan)(?: (?P<unit>\S.*))?"
)
_WORDS = {"true": True, "false": False}
_INFINITE = ("inf", "-inf")  # JSON has no infinite numbers, so they are stored as these texts


def changed(before: LoggedSettings, after: LoggedSettings) -> dict[str, Any]:
    """Return the settings that have changed; for parameters and device, only their changed entries.

    If the environment has changed, return all its parameters.
    """
    other = before.get("environment") != after.get("environment")
    found: dict[str, Any] = {}
    for key, new in after.items():
        old = before.get(key)
        if key in ("parameters", "device", "hand_grip") and isinstance(new, Mapping):
            known = old if isinstance(old, Mapping) and not (other and key == "parameters") else {}
            part = {name: value for name, value in new.items() if name not in known or known[name] != value}
            if part:
                found[key] = part
        elif (key not in ("units", "state_names") or other) and new != old:
            found[key] = new
    return found


def merged(before: LoggedSettings, changes: LoggedSettings) -> dict[str, Any]:
    """Return settings after applying changes, which ``changed`` returned."""
    other = "environment" in changes
    gone = ("parameters", "units", "state_names") if other else ()
    found = {key: value for key, value in before.items() if key not in gone}
    for key, new in changes.items():
        old = found.get(key)
        found[key] = {**old, **new} if isinstance(old, Mapping) and isinstance(new, Mapping) else new
    return found


def steps(log: Log) -> Iterator[tuple[float, dict[str, Any]]]:
    """Yield each later change as its time in s and its ``changed`` settings."""
    for (_, before), (time, after) in pairwise(log):
        yield time, changed(before, after)


def as_json(log: Log) -> str:
    """Return the initial settings as a JSON object.

    Its entry "changes" is a list of objects, each of which contains its ``time_s``.
    """
    changes = [{"time_s": round(time, 6), **what} for time, what in steps(log)]
    return json.dumps({**log[0][1], "changes": changes}, ensure_ascii=False, default=float)


# --- header lines


def lines(log: Log) -> list[str]:
    """Return the header lines of a log; each begins with "# "."""
    found = [f"# {name}: {text}" for name, text in _flattened(log[0][1], log[0][1])]
    for (time, what), (_, after) in zip(steps(log), log[1:], strict=True):
        found += [
            f"# {name} at {_number(round(time, 6))} s: {text}" for name, text in _flattened(what, after)
        ]
    return found


def read(comments: Iterable[str], name: str = "header") -> Log:
    """Return the log in a table's comments, which are given without "#"; () without settings.

    A single JSON object, the studio's former format, is also accepted. Other comments are ignored. Raise
    FileError for invalid JSON; its text begins with ``name``, the file's name.
    """
    parts: dict[float | None, dict[str, Any]] = {}
    for number, comment in enumerate(map(str.strip, comments)):
        if number == 0 and comment.startswith("{"):
            old = parse_json(comment, f"{name}, settings in the first line")
            return [(0.0, {key: value for key, value in old.items() if key != "changes"})]
        if found := _LINE.fullmatch(comment):
            try:
                time = None if found["time"] is None else float(found["time"])
            except ValueError:
                continue
            _store_setting(parts.setdefault(time, {}), found["name"], *_value(found["value"] or ""))
    if not parts:
        return []
    log: list[tuple[float, LoggedSettings]] = [(0.0, parts.pop(None, {}))]
    for time in sorted(time for time in parts if time is not None):
        log.append((time, merged(log[-1][1], parts[time])))
    return log


def _flattened(settings: LoggedSettings, whole: LoggedSettings) -> Iterator[tuple[str, str]]:
    """Yield each setting's name, and its value with its unit."""
    units = whole.get("units")
    units = units if isinstance(units, Mapping) else {}
    for key, value in settings.items():
        if key in ("units", "state_names") or value is None:
            continue
        if key == "parameters" and isinstance(value, Mapping):
            for name, one in value.items():
                plain = name if name not in _NAMES else f"{_PARAMETER}.{name}"
                yield plain, _text(one, units.get(name))
            continue
        options: Any = value
        if isinstance(value, list | tuple) and len(value) == 2 and isinstance(value[1], Mapping):
            yield key, _text(value[0])
            options = value[1]
        if isinstance(options, Mapping):
            known = _UNITS.get(key, {})
            for name, one in options.items():
                yield f"{key}.{name}", _text(one, known.get(name))
        else:
            unit, name = _SUFFIX.search(key), _SUFFIX.sub("", key)
            yield (
                name if key in _KEYS else f"{_UNKNOWN_SETTING}.{name}",
                _text(value, unit[1] if unit else ""),
            )


def _store_setting(settings: dict[str, Any], name: str, value: Any, unit: str) -> None:
    """Store a setting that has this name in a header."""
    group, dot, key = name.partition(".")
    if dot and group != _PARAMETER:
        old = settings.get(group)
        if isinstance(old, str):
            settings[group] = old, {key: value}
        elif isinstance(old, tuple):
            old[1][key] = value
        elif isinstance(old, dict):
            old[key] = value
        else:
            settings[group] = {key: value}
    elif not dot and name in _NAMES:
        if _NAMES[name] == f"{name}_{unit}" or (_NAMES[name] == name and not unit):
            settings[_NAMES[name]] = value
    else:
        settings.setdefault("parameters", {})[key or name] = value
        if unit:
            settings.setdefault("units", {})[key or name] = unit


def _text(value: Any, unit: object = "") -> str:
    """Format a value with its unit; a text that would be read as another type is written as JSON."""
    if isinstance(value, bool):
        return str(value).lower()
    if value in _INFINITE:
        value = float(value)
    if isinstance(value, Real):
        text = printable(" ".join(str(unit or "").split()))
        return f"{_number(value)} {text}".rstrip()
    if isinstance(value, str) and value.isprintable() and value and _value(value) == (value, ""):
        return value
    return json.dumps(value, default=str)


def _number(value: Any) -> str:
    """Format a number with the fewest digits that preserve it."""
    if isinstance(value, Integral):
        return str(int(value))
    short = f"{float(value):.15g}"
    return short if float(short) == float(value) else repr(float(value))


def _value(text: str) -> tuple[Any, str]:
    """Return the value and the unit in the text that follows a setting's name."""
    text = text.strip()
    if text in _WORDS:
        return _WORDS[text], ""
    if found := _NUMBER.fullmatch(text):
        return float(found["number"]), found["unit"] or ""
    if text[:1] in ('"', "[", "{"):
        with suppress(FileError):
            return parse_json(text, ""), ""
    return text, ""
