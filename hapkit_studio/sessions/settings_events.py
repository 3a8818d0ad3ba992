"""An engine's settings and device as JSON values, and descriptions of their changes."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

from hapkit_studio.devices.base import Device
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import FIELDS, USUAL_LOOP, from_table, recorded
from hapkit_studio.dynamics.loop_settings import differences as loop_differences
from hapkit_studio.environments.base import Environment
from hapkit_studio.formatting import plain
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.sessions.file import ABOUT, SETTINGS, Event
from hapkit_studio.settings_log import Log, LoggedSettings
from hapkit_studio.version import __version__

_NESTED = ("parameters", "units", "state_names", "device")


def of_scene(environment: Environment, values: dict[str, float]) -> dict[str, Any]:
    """Return an environment's key, its values in SI (choices by name), and its units."""
    parameters = environment.parameters
    return {
        "environment": environment.key,
        "parameters": {p.key: p.text(values[p.key]) if p.discrete else values[p.key] for p in parameters},
        "units": {p.key: p.unit for p in parameters if p.unit},
    }


def of_model(device: Device, modelled: SimulatedHapkit) -> dict[str, Any]:
    """Return a device's title and its model's simulated terms; infinite values are converted to text."""
    terms = {key: repr(value) if math.isinf(value) else value for key, value in vars(modelled).items()}
    return {"title": device.title, **terms}


def in_force(engine: Engine) -> dict[str, Any]:
    """Return an engine's present settings as JSON values."""
    device, modelled = engine.device, engine.modelled
    return {
        **of_scene(engine.environment, engine.values),
        "state_names": list(engine.environment.state_names),
        "hand": "own",
        **plain(recorded(replace(engine.loop, where=engine.where))),
        "device": device.title if modelled is None else of_model(device, modelled),
    }


def about_device(engine: Engine) -> dict[str, Any]:
    """Return the device's description: name and sensor, and for a board also firmware and calibration."""
    device = engine.device
    found: dict[str, Any] = {"device": device.title, "quantum_m": device.quantum, "studio": __version__}
    return found | device.about()


def log(events: Sequence[Event], start: float, stop: float) -> Log:
    """Return the settings at a start time and every change until ``stop``, with times in s after the start.

    The settings include the device's description. A recorder adds the first settings up to 0.1 s after the
    first sample, so they are taken to be valid from the start.
    """
    timed: list[tuple[float, Event]] = []
    for kind in (ABOUT, SETTINGS):
        own = [event for event in events if event.kind == kind]
        timed += [(-math.inf, event) for event in own[:1]] + [(event.time, event) for event in own[1:]]
    found: list[tuple[float, LoggedSettings]] = [(0.0, {})]
    known: dict[str, LoggedSettings] = {ABOUT: {}, SETTINGS: {}}
    for time, event in sorted(timed, key=lambda pair: pair[0]):
        known[event.kind] = event.what
        settings = {**known[ABOUT], **known[SETTINGS]}
        if time <= start:
            found[0] = 0.0, settings
        elif time <= stop and settings != found[-1][1]:
            found.append((time - start, settings))
    return found


def differences(before: LoggedSettings, after: LoggedSettings) -> list[str]:
    """Describe each changed setting with its old and new value."""
    old, new = ({**kept, **kept.get("parameters", {})} for kept in (before, after))
    units = {"rate_Hz": "Hz", "delay_s": "s", "max_force_N": "N", **after.get("units", {})}
    if old.get("environment") != new.get("environment"):
        return [f"environment {old.get('environment')} → {new.get('environment')}"]
    changed = [key for key in new if key not in _NESTED and old.get(key) != new[key]]
    loop = [from_table({key: kept[key] for key in changed if key in kept}, USUAL_LOOP) for kept in (old, new)]
    known = [FIELDS[key].recorded for key in loop[0].keys() & loop[1].keys()]
    return [
        *map(str, loop_differences(*loop)),
        *(
            f"{_word(key)} {_text(old.get(key))} → {_text(new[key])} {units.get(key, '')}".rstrip()
            for key in changed
            if key not in known
        ),
    ]


def changes(events: Sequence[Event], start: float, stop: float) -> list[str]:
    """Describe each change of the settings between two times in s, with its time after the start."""
    return [f"At {when:.2f} s: {what}." for when, what in timed_changes(events, start, stop)]


def timed_changes(events: Sequence[Event], start: float, stop: float) -> list[tuple[float, str]]:
    """Return each change until ``stop`` as its time in s after ``start``, and a description."""
    return change_texts(log(events, start, stop))


def change_texts(log: Log) -> list[tuple[float, str]]:
    """Return each change in a log as its time in s, and a description."""
    pairs = ((time, differences(before, after)) for (_, before), (time, after) in pairwise(log))
    return [(time, ", ".join(found) or "device changed") for time, found in pairs]


def _word(key: str) -> str:
    name, _, unit = key.rpartition("_")
    return (name if unit in ("Hz", "s", "N") else key).replace("_", " ")


def _text(value: Any) -> str:
    return f"{value:,g}" if isinstance(value, int | float) and not isinstance(value, bool) else str(value)
