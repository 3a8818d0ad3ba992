"""Presets: named settings of one environment, which are stored as TOML files in the user's folder."""

import json
import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from hapkit_studio.devices import calibration_file
from hapkit_studio.dynamics.loop_settings import OPTIONS, USUAL_LOOP, WITH_SCENE, from_table, to_table
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import FileError, ParameterError
from hapkit_studio.files import read_toml
from hapkit_studio.formatting import quoted
from hapkit_studio.gui.state.undo import ENVIRONMENT, Snapshot
from hapkit_studio.parameters import AnyParameter, Choice

FOLDER = "presets"
_LONGEST = 160  # maximum number of letters of a line that describes an error
_NAME = re.compile(r"\w[\w ,.()+-]{0,23}")
_BARE = re.compile(r"[A-Za-z0-9_-]+")


class PresetError(ParameterError):
    """A file is not a valid preset or demo; ``lines`` has one line per error."""

    def __init__(self, lines: list[str]):
        self.lines = [line if len(line) <= _LONGEST else f"{line[:_LONGEST]}…" for line in lines]
        super().__init__("\n".join(self.lines))


def folder(environment: str) -> Path:
    """Return the folder of an environment's presets, which may not exist."""
    return calibration_file.folder().parent / FOLDER / re.sub(r"[^\w-]+", "-", environment)


def found(environment: str) -> dict[str, Path]:
    """Return the files of an environment's presets by their names."""
    found = sorted(folder(environment).glob("*.toml"))
    return {path.stem: path for path in found if path.stem.isprintable()}


def checked_name(name: str) -> str:
    """Return a trimmed name; raise ParameterError unless it is a valid file name on every system."""
    name = name.strip().rstrip(".")
    if not _NAME.fullmatch(name):
        raise ParameterError(
            "A preset's name must have 1 to 24 characters: letters, digits, spaces and , . ( ) + -"
        )
    return name


def write(environment: Environment, name: str, settings: Snapshot) -> Path:
    """Write settings of an environment under a name, and return the file.

    Raise ParameterError for an invalid name, and OSError if the file cannot be written.
    """
    path = folder(environment.key) / f"{checked_name(name)}.toml"
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_text("\n".join(_lines(environment, settings)) + "\n", encoding="utf-8")
    os.replace(part, path)
    return path


def read(path: str | Path, environments: Mapping[str, Environment]) -> Snapshot:
    """Return the settings of a preset; raise PresetError if they are invalid for its environment."""
    path = Path(path)
    table = load(path)
    key = table.pop("environment", None)
    if not isinstance(key, str) or key not in environments:
        raise PresetError(
            [f"{path.name} is a preset for {quoted(key)}, which is not an installed environment."]
        )
    return checked(table, environments[key])


def load(path: Path) -> dict[str, Any]:
    """Return the table of a preset or demo; raise PresetError if the file is invalid."""
    try:
        return read_toml(path)
    except FileError as error:
        raise PresetError([str(error)]) from None


def checked(table: dict[str, Any], environment: Environment) -> Snapshot:
    """Return the settings of a table; if the table is invalid, raise PresetError with all errors."""
    wrong = [
        f"A preset cannot have the entry {quoted(key)}." for key in table if key not in ("values", "loop")
    ]
    settings: Snapshot = {ENVIRONMENT: environment.key}
    known = {p.key: p for p in environment.parameters}
    given: dict[str, float] = {}
    for name, value in _items(table, "values", wrong):
        try:
            if name not in known:
                raise ParameterError(f"{environment.title} has no parameter {quoted(name)}.")
            given[name] = number(known[name], value)
        except ParameterError as error:
            wrong.append(str(error))
    given_loop = dict(_items(table, "loop", wrong))
    loop = from_table(given_loop, USUAL_LOOP, lambda error: wrong.append(str(error)), WITH_SCENE)
    try:
        values = environment.values(given)
    except ParameterError as error:
        wrong.append(str(error))
    if wrong:
        raise PresetError(wrong)
    settings |= {("value", environment.key, name): value for name, value in values.items()}
    return settings | {("loop", name): value for name, value in loop.items() if name in WITH_SCENE}


def _items(table: dict[str, Any], name: str, wrong: list[str]) -> Iterator[tuple[str, Any]]:
    part = table.get(name, {})
    if not isinstance(part, dict):
        wrong.append(f"{name} must be a table [{name}], not {quoted(part)}.")
        return
    yield from part.items()


def number(parameter: AnyParameter, value: object) -> float:
    """Convert a stored value to the number that the law uses; raise ParameterError if it is invalid.

    An option is stored by its name.
    """
    if isinstance(parameter, Choice) != isinstance(value, str):
        wanted = f"one of {', '.join(parameter.options)}" if isinstance(parameter, Choice) else "a number"
        raise ParameterError(f"{parameter.label} must be {wanted}, not {quoted(value)}.")
    return parameter.check(value)


def _lines(environment: Environment, settings: Snapshot) -> Iterator[str]:
    """Yield the lines of a preset's file: values in SI with their units, options by name."""
    yield f"# A preset of Hapkit Studio for {environment.title}. Import it with: Environment, Import preset…"
    yield f"environment = {_toml(environment.key)}"
    yield "\n[values]"
    for p in environment.parameters:
        value = settings["value", environment.key, p.key]
        unit = f"  # {p.unit}" if p.unit else ""
        yield f"{_key(p.key)} = {_toml(p.text(value) if isinstance(p, Choice) else value)}{unit}"
    loop = {name: settings["loop", name] for name in WITH_SCENE if ("loop", name) in settings}
    if not loop:
        return
    yield "\n[loop]"
    written = to_table(replace(USUAL_LOOP, **loop), loop)
    options = written.pop(OPTIONS, {})
    for name, value in written.items():
        yield f"{name} = {_toml(value)}"
    if options:
        yield f"\n[loop.{OPTIONS}]"
        yield from (f"{_key(name)} = {_toml(value)}" for name, value in options.items())


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else _toml(name)


def _toml(value: str | bool | float) -> str:
    """Format a value for TOML, in which strings and booleans are written as in JSON."""
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str | bool) else repr(float(value))
