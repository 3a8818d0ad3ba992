"""Recordings out of runs and of the CSV files that runs save."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.identify.recording import Handle, Recording, Setup, of_run
from hapkit_studio.dynamics.hand import SCRIPTS, Grip, Hand
from hapkit_studio.errors import ParameterError, StudioError

# Column of the file, field of a run; without the last ones a piece tells less, but something.
_COLUMNS = {
    "time_s": "time",
    "position_m": "position",
    "velocity_m_per_s": "velocity",
    "force_applied_N": "applied_force",
    "force_asked_N": "force",
    "flags": "flags",
    "hand_force_N": "hand_force",
}
_NEEDED = ("time_s", "position_m", "velocity_m_per_s", "force_applied_N")


def from_run(run: Any, hand: Hand | None = None) -> Recording:
    """Return the recording of a run of ``simulate``; hand: the Hand that moved it, if none by name."""
    setup, target = _setup(run.settings, np.asarray(run.time), hand)
    return of_run(run, setup, target)


def from_csv(path: str | Path) -> Recording:
    """Return the recording in a file that ``Run.save`` wrote; raise ParameterError with one line."""
    name = Path(path).name
    with open(path, encoding="utf-8", errors="replace") as file:
        settings = _header(file.readline(), name)
        names = file.readline().strip().split(",")
        lacking = [column for column in _NEEDED if column not in names]
        if lacking:
            raise ParameterError(f"{name} has no column {lacking[0]}: it is no recording of the studio.")
        table = _numbers(file, names, name)
    columns = {field: table[:, names.index(key)] for key, field in _COLUMNS.items() if key in names}
    unknown = np.full(len(table), math.nan)
    defaults = {"force": columns["applied_force"], "flags": np.zeros(len(table)), "hand_force": unknown}
    run = SimpleNamespace(**{**defaults, **columns}, settings=settings)
    return from_run(run)


def _header(line: str, name: str) -> dict:
    try:
        settings = json.loads(line.removeprefix("#")) if line.startswith("#") else None
    except json.JSONDecodeError:
        settings = None
    if not isinstance(settings, dict):
        raise ParameterError(f"{name} does not begin with the settings of a run: save one with run --csv.")
    return settings


def _numbers(file: Any, names: list[str], name: str) -> np.ndarray:
    try:
        table = np.loadtxt(file, delimiter=",", ndmin=2)
    except ValueError as error:
        raise ParameterError(f"{name} is not a table of numbers: {error}.") from None
    if table.shape[1] != len(names) or not len(table):
        shape = f"{len(table)} rows of {table.shape[1]} numbers for {len(names)} names"
        raise ParameterError(f"{name} has {shape}: it is no recording of the studio.")
    needed = table[:, [names.index(column) for column in _NEEDED]]
    if not np.isfinite(needed).all() or not (np.diff(needed[:, 0]) > 0.0).all():
        raise ParameterError(f"{name} has values that are no numbers, or times that go back.")
    return table


def _setup(settings: Mapping, times: np.ndarray, hand: Hand | None) -> tuple[Setup, np.ndarray | None]:
    """Return the setup that settings describe and the hand's target (n,) in m where it is known."""
    device = settings.get("device")
    device = device if isinstance(device, Mapping) else {}
    name = settings.get("hand")
    hand = hand or SCRIPTS.get(name if isinstance(name, str) else "")
    gaps = np.diff(times)
    usual = 1.0 / float(np.median(gaps)) if len(gaps) else 1000.0
    rate = _number(settings, "rate_Hz", usual)
    environment, values = _scene(settings)
    numbers = [_number(device, key) for key in ("mass", "damping", "coulomb_force")]
    setup = Setup(
        environment,
        values,
        rate if rate > 0.0 else usual,
        max(_number(settings, "delay_s", 0.0), 0.0),
        max(_number(device, "quantum", 20.7e-6), 0.0),
        Handle(*numbers) if device else None,
        Grip(hand.mass, hand.damping, hand.stiffness) if hand else None,
    )
    return setup, _target(hand, times)


def _target(hand: Hand | None, times: np.ndarray) -> np.ndarray | None:
    """Return where the hand pulls to (n,) in m, None where nobody holds."""
    if hand is None:
        return None
    target: Any = hand.target
    return np.array(target(times) if hand.vectorised else [target(t) for t in times.tolist()], dtype=float)


def _scene(settings: Mapping) -> tuple[Any, dict[str, float]]:
    """Return the environment and its values; (None, {}) for one that the library does not know."""
    try:
        environment = environments.named(settings["environment"])
        return environment, environment.values(settings.get("parameters"))
    except (StudioError, KeyError, TypeError, AttributeError):
        return None, {}


def _number(settings: Mapping, key: str, default: float = math.nan) -> float:
    try:
        value = float(settings.get(key, default))
    except (TypeError, ValueError):
        return default
    return value if math.isfinite(value) else default
