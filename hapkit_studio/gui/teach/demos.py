"""Demos. A demo is a TOML file with settings, a hand's path and captions over time; it contains no code."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hapkit_studio import resources
from hapkit_studio.dynamics.loop_settings import USUAL_LOOP, WITH_SCENE
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import quoted
from hapkit_studio.gui.state import presets
from hapkit_studio.gui.state.presets import PresetError, number
from hapkit_studio.gui.state.undo import ENVIRONMENT, Snapshot
from hapkit_studio.parameters import Parameter

RELEASE = "release"
_DEMO, _STEP = ("title", "seconds", "step"), ("at", "environment", "set", "loop", "hand", "caption")
_SECONDS = Parameter("seconds", "seconds", "s", 60.0, 1.0, 3600.0)
_AT = Parameter("at", "at", "s", 0.0, 0.0, 3600.0)
_TIME = Parameter("time", "The hand's time", "s", 0.0, 0.0, 3600.0)
_PLACE = Parameter("place", "The hand's place", "mm", 0.0, -60.0, 60.0)
_LONGEST_TITLE, _LONGEST_CAPTION = 40, 160
Path_ = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Step:
    """One step of a demo: settings, caption and the hand's path, valid from the time ``at`` in s on.

    The path consists of (time in s, position in m). Without a path the handle is released.
    """

    at: float
    settings: Snapshot
    caption: str
    path: Path_

    def hand(self, time: float) -> float | None:
        """Return the hand's position in m at a time in s; None without a path."""
        if not self.path:
            return None
        times, places = zip(*self.path, strict=True)
        return float(np.interp(time, times, places))


@dataclass(frozen=True)
class Demo:
    """A demo. It repeats after ``seconds``, and its first step is at 0 s."""

    title: str
    seconds: float
    steps: tuple[Step, ...]

    def step(self, time: float) -> Step:
        """Return the step at a time in s."""
        return next(step for step in reversed(self.steps) if step.at <= time)

    @property
    def environments(self) -> set[str]:
        """Return the keys of the required environments."""
        return {step.settings[ENVIRONMENT] for step in self.steps}


def shipped() -> dict[str, Path]:
    """Return the files of the shipped demos by name."""
    return {path.stem: path for path in sorted(resources.path("demos").glob("*.toml"))}


def title(path: Path) -> str:
    """Return the title of a shipped demo."""
    return str(presets.load(path)["title"])


def named(name: str) -> Path:
    """Return the file of a shipped demo ("" means the first one), or the given path.

    Raise ParameterError for an unknown name or a missing file.
    """
    known = shipped()
    name = name or next(iter(known))
    if name not in known and not Path(name).is_file():
        raise ParameterError(f"There is no demo or file {quoted(name)}. The demos are: {', '.join(known)}.")
    return known.get(name, Path(name))


def read(path: str | Path, environments: Mapping[str, Environment]) -> Demo:
    """Read a demo from a file; raise PresetError if it is invalid."""
    table = presets.load(Path(path))
    try:
        _check_keys(table, _DEMO, "demo")
        name = _text(table, "title", _LONGEST_TITLE)
        seconds = number(_SECONDS, table.get("seconds"))
        given = table.get("step")
        if not given or not isinstance(given, list) or not all(isinstance(step, dict) for step in given):
            raise ParameterError("A demo needs steps, each starting with [[step]].")
    except ParameterError as error:
        raise PresetError([str(error)]) from None
    steps: list[Step] = []
    state: dict[str, Any] = {"values": {}, "loop": {}, "caption": "", "hand": ()}
    for count, entry in enumerate(given, 1):
        try:
            steps.append(_step(entry, steps[-1].at if steps else None, seconds, state, environments))
        except PresetError as error:
            raise PresetError([f"Step {count}: {line}" for line in error.lines]) from None
        except ParameterError as error:
            raise PresetError([f"Step {count}: {error}"]) from None
    return Demo(name, seconds, tuple(steps))


def _step(
    entry: dict[str, Any], before: float | None, seconds: float, state: dict[str, Any],
    environments: Mapping[str, Environment],
) -> Step:  # fmt: skip
    """Return a step, and update ``state`` with the entries that later steps inherit.

    Raise ParameterError for an invalid entry.
    """
    _check_keys(entry, _STEP, "step")
    at = number(_AT, entry.get("at"))
    if before is None and at != 0.0:
        raise ParameterError(f"The first step must be at 0 s, not {at:g} s.")
    if before is not None and not before < at < seconds:
        raise ParameterError(f"at must be between {before:g} s and {seconds:g} s, not {at:g} s.")
    key = entry.get("environment", state.get("environment"))
    if not isinstance(key, str) or key not in environments:
        raise ParameterError(f"The environment {quoted(key)} is not installed.")
    if "environment" in entry:
        state |= {"environment": key, "values": {}}
    for name, part in (("values", "set"), ("loop", "loop")):
        state[name] = {**state[name], **_table(entry, part)}
    if "caption" in entry:
        state["caption"] = _text(entry, "caption", _LONGEST_CAPTION)
    if "hand" in entry:
        state["hand"] = _path(entry["hand"], at)
    usual: Snapshot = {("loop", name): getattr(USUAL_LOOP, name) for name in WITH_SCENE}
    settings = presets.checked({"values": state["values"], "loop": state["loop"]}, environments[key])
    return Step(at, usual | settings, state["caption"], state["hand"])


def _path(given: object, at: float) -> Path_:
    """Return the hand's path, given as [[s since the step, mm], …] or "release".

    Raise ParameterError for an invalid path.
    """
    if given == RELEASE:
        return ()
    if not given or not isinstance(given, list):
        raise ParameterError(
            f'hand must be [[time in s, position in mm], …] or "{RELEASE}", not {quoted(given)}.'
        )
    path: list[tuple[float, float]] = []
    for point in given:
        if not isinstance(point, list) or len(point) != 2:
            raise ParameterError(
                f"A point of the hand's path must be [time in s, position in mm], not {quoted(point)}."
            )
        time, place = number(_TIME, point[0]), number(_PLACE, point[1])
        if path and at + time <= path[-1][0]:
            raise ParameterError(
                f"The times in the hand's path must increase: {time:g} s comes after {path[-1][0] - at:g} s."
            )
        path.append((at + time, place / 1e3))
    return tuple(path)


def _check_keys(table: Mapping[str, Any], known: Iterable[str], what: str) -> None:
    for key in table:
        if key not in known:
            raise ParameterError(
                f"A {what} cannot have the entry {quoted(key)}. Possible entries: {', '.join(known)}."
            )


def _table(entry: Mapping[str, Any], name: str) -> dict[str, Any]:
    found = entry.get(name, {})
    if not isinstance(found, dict):
        raise ParameterError(f"{name} must be {{key = value, …}}, not {quoted(found)}.")
    return found


def _text(table: Mapping[str, Any], name: str, longest: int) -> str:
    found = table.get(name)
    if not isinstance(found, str) or len(found) > longest or not found.isprintable():
        raise ParameterError(f"{name} must be one line of at most {longest} characters, not {quoted(found)}.")
    return found
