"""The caption of a figure: scene, device, hand, loop, date, and each change of settings with its time."""

from collections.abc import Mapping
from contextlib import suppress
from datetime import datetime
from itertools import pairwise
from typing import Any

from hapkit_studio import environments
from hapkit_studio.charts.style import unbroken
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import RUBBER_BAND
from hapkit_studio.dynamics.loop_settings import estimator_texts
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import compact, on_screen
from hapkit_studio.parameters import AnyParameter, Choice
from hapkit_studio.sessions.settings_events import differences
from hapkit_studio.settings_log import Log, LoggedSettings

Known = Mapping[str, Environment]
"""Environments by key, in addition to those of the library."""

_MOST_CHANGES = 4  # largest number of lines for changes in a caption
_HANDS = {"released": "no hand", "own": "own hand"}
_SPACE = "\N{NO-BREAK SPACE}"


def caption(log: Log, known: Known, date: str = "") -> str:
    """Return the caption lines for a settings log; ``date`` is the date of its start; "" means now."""
    date = date or datetime.now().isoformat(" ", "minutes")
    log = [(time, _checked(settings)) for time, settings in log]
    first = log[0][1]
    device, *others = _conditions(first)
    return "\n".join([scene(first, known), unbroken([device, date, *others]), *_changes(log, known)])


def _checked(settings: LoggedSettings) -> LoggedSettings:
    """Return the settings from an untrusted file, without invalid parameters and units."""
    groups = ("parameters", "units")
    return {k: v for k, v in settings.items() if k not in groups or isinstance(v, Mapping)}


def environment_of(settings: LoggedSettings, known: Known) -> tuple[Environment, dict[str, float]] | None:
    """Return the recorded environment and its values; None if no known environment accepts the values."""
    key, given = settings.get("environment"), settings.get("parameters")
    found = known.get(key) or environments.discover().get(key) if isinstance(key, str) else None
    with suppress(ParameterError):
        return (found, found.values(given)) if found is not None else None
    return None


def scene(settings: LoggedSettings, known: Known) -> str:
    """Return the environment's title and its active parameters as text."""
    found = environment_of(settings, known)
    if found is not None:
        environment, values = found
        unused, title = environment.unused(values), environment.title
        texts = [
            f"{_lower_first(p.label)} {_value(p, values)}"
            for p in environment.parameters
            if p.key not in unused
        ]
    else:
        title = str(settings.get("environment") or "")
        given, units = (settings.get(key, {}) for key in ("parameters", "units"))
        texts = [f"{key.replace('_', ' ')} {_raw(value, units.get(key))}" for key, value in given.items()]
    parts = ", ".join(part.replace(" ", _SPACE) for part in texts)
    return f"{title}: {parts}" if parts else title


def _conditions(settings: LoggedSettings) -> list[str]:
    """Return device, hand and loop as text."""
    device, hand, grip = (settings.get(key) for key in ("device", "hand", "grip"))
    rate, delay, render = (settings.get(key) for key in ("rate_Hz", "delay_s", "render"))
    model = device.get("title") if isinstance(device, Mapping) else None
    parts = [device if isinstance(device, str) else str(model or SimulatedHapkit.title)]
    parts += [_HANDS.get(hand, f"hand: {hand}")] if isinstance(hand, str) else []
    parts += (
        [grip if grip == RUBBER_BAND else f"{grip} grip"]
        if isinstance(grip, str) and not isinstance(device, str)
        else []
    )
    parts += [f"rendered on the {render}"] if isinstance(render, str) and isinstance(device, str) else []
    parts += [f"{rate:,g} Hz"] if isinstance(rate, int | float) else []
    parts += [f"delay {compact(1e3 * delay, 3)} ms"] if isinstance(delay, int | float) else []
    parts += _estimator(settings.get("estimator"))
    return [*parts, "passivity controller"] if settings.get("controller") is True else parts


def _estimator(spec: Any) -> list[str]:
    with suppress(ParameterError, TypeError, ValueError):
        return [estimator_texts(tuple(spec) if isinstance(spec, list) else spec)[1]]
    return []


def _changes(log: Log, known: Known) -> list[str]:
    """Return one line for each change; the last line gives the number of changes that do not fit."""
    changes = [(time, _change(before, after, known)) for (_, before), (time, after) in pairwise(log)]
    lines = [f"At {time:.2f} s: {text}" for time, text in changes[:_MOST_CHANGES]]
    more = len(changes) - _MOST_CHANGES
    return [*lines, f"and {more} more changes, the last at {changes[-1][0]:.2f} s"] if more > 0 else lines


def _change(before: LoggedSettings, after: LoggedSettings, known: Known) -> str:
    """Return the changed settings with old and new values; for a new environment, all its settings."""
    if before.get("environment") != after.get("environment"):
        return scene(after, known)
    old, new = environment_of(before, known), environment_of(after, known)
    if old is None or new is None:
        return ", ".join(differences(before, after)) or "device changed"
    parts = [
        f"{_lower_first(p.label)} {_old_and_new(_value(p, old[1]), _value(p, new[1]))}"
        for p in new[0].parameters
        if old[1][p.key] != new[1][p.key]
    ]
    parts += differences({**before, "parameters": {}}, {**after, "parameters": {}})
    return ", ".join(parts) or "device changed"


def _old_and_new(old: str, new: str) -> str:
    """Join two values with one unit, as in "250 → 600 N/m"."""
    number, _, unit = old.partition(" ")
    return f"{number if unit and new.endswith(f' {unit}') else old} → {new}"


def _value(parameter: AnyParameter, values: Mapping[str, float]) -> str:
    value = values[parameter.key]
    return parameter.phrase(value) if isinstance(parameter, Choice) else on_screen(value, parameter.unit)


def _raw(value: Any, unit: Any) -> str:
    return (
        on_screen(value, str(unit or "")) if isinstance(value, int | float) else str(value).replace("_", " ")
    )


def _lower_first(text: str) -> str:
    """Return text with a lower-case first letter, except for names such as RK4."""
    return text[:1].lower() + text[1:] if text[1:2].islower() else text
