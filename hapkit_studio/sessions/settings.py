"""What is set on an engine, and what its device is, by the names that a run's settings have."""

import math
from collections.abc import Iterable
from typing import Any

from hapkit_studio import __version__
from hapkit_studio.environments.base import Environment
from hapkit_studio.formatting import plain
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.sessions.file import SETTINGS, Event

_NESTED = ("parameters", "units", "state_names", "device")


def of_scene(environment: Environment, values: dict[str, float]) -> dict[str, Any]:
    """Return environment, its values in SI, choices by name, and their units."""
    parameters = environment.parameters
    return {
        "environment": environment.key,
        "parameters": {p.key: p.text(values[p.key]) if p.discrete else values[p.key] for p in parameters},
        "units": {p.key: p.unit for p in parameters if p.unit},
    }


def in_force(engine: Engine) -> dict[str, Any]:
    """Return what is set at this moment, as JSON has it."""
    modelled, loop = engine.modelled, engine.loop
    device = {} if modelled is None else vars(modelled)
    return {
        **of_scene(engine.environment, engine.values),
        "state_names": list(engine.environment.state_names),
        "hand": "own",
        "grip": engine.grip,
        "render": engine.where,
        "rate_Hz": loop.rate,
        "delay_s": loop.delay,
        "estimator": plain(loop.estimator),
        "controller": loop.controller,
        "max_force_N": engine.max_force,
        "device": {k: repr(v) if math.isinf(v) else v for k, v in device.items()} or engine.device.title,
    }


def about_device(engine: Engine) -> dict[str, Any]:
    """Return what the device is: its name, its sensor; of a board firmware and calibration too."""
    device = engine.device
    found = {"device": device.title, "quantum_m": device.quantum, "studio": __version__}
    hello = getattr(device, "hello", None)
    if hello is not None:
        found |= {"firmware": hello.build, "protocol": hello.version}
    return found


def differences(before: dict[str, Any], after: dict[str, Any]) -> list[str]:
    """Say in words what of the settings is another now, each with both values."""
    old, new = ({**kept, **kept.get("parameters", {})} for kept in (before, after))
    units = {"rate_Hz": "Hz", "delay_s": "s", "max_force_N": "N", **after.get("units", {})}
    if old.get("environment") != new.get("environment"):
        return [f"environment {old.get('environment')} → {new.get('environment')}"]
    changed = [key for key in new if key not in _NESTED and old.get(key) != new[key]]
    return [
        f"{_word(key)} {_text(old.get(key))} → {_text(new[key])} {units.get(key, '')}".rstrip()
        for key in changed
    ]


def changes(events: Iterable[Event], start: float, stop: float) -> list[str]:
    """Say every change of the settings from start to stop, both in s, each with its time after start."""
    return [f"At {when:.2f} s: {what}." for when, what in timed_changes(events, start, stop)]


def timed_changes(events: Iterable[Event], start: float, stop: float) -> list[tuple[float, str]]:
    """Return every change of the settings from start to stop: when, in s after start, and in words what."""
    said, before = [], None
    for event in events:
        if event.kind == SETTINGS:
            if before is not None and start <= event.time <= stop:
                said.append((event.time - start, ", ".join(differences(before, event.what))))
            before = event.what
    return said


def _word(key: str) -> str:
    name, _, unit = key.rpartition("_")
    return (name if unit in ("Hz", "s", "N") else key).replace("_", " ")


def _text(value: Any) -> str:
    return f"{value:,g}" if isinstance(value, int | float) and not isinstance(value, bool) else str(value)
