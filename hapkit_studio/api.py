"""The Python API without a window. Simulation uses the same tick, laws and device as the window."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hapkit_studio import environments, interrupts
from hapkit_studio.devices.base import Device
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.hand import Grip, Hand, Prescribed, hand_named
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.base import Conditions, Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.files import open_regular
from hapkit_studio.haptics import headless, health, rows
from hapkit_studio.haptics.signals import BY_NAME, COLUMN
from hapkit_studio.parameters import Parameter
from hapkit_studio.sessions import export, settings_events
from hapkit_studio.sessions.chunk import pack
from hapkit_studio.sessions.file import FAULT, SETTINGS, SUFFIX, Event, SessionError, SessionWriter
from hapkit_studio.sessions.session import SQLITE, Session
from hapkit_studio.settings_log import Log
from hapkit_studio.tables import TableColumns

if TYPE_CHECKING:
    from hapkit_studio.analysis.identify import Recording

SECONDS = Parameter("seconds", "Seconds", "s", 2.0, 0.0, 86_400.0)
SPEED = Parameter("max_speed", "Largest speed", "m/s", 3.0, 0.0, 1e6)
_CHUNK = 1000  # number of samples per chunk of a session
# maximum number of samples, which limits the memory: a row takes 272 bytes
MOST_SAMPLES = 10_000_000
_SIGNALS = tuple(
    BY_NAME[name]
    for name in (
        "position", "velocity", "true_position", "true_velocity", "force", "applied_force", "hand_force",
        "energy", "flags",
    )
)  # fmt: skip
"""The signals of a run, in the order of the columns of its tables."""


@dataclass(frozen=True)
class Run:
    """A run in SI units. Arrays have the shape (n,); row k is at k / rate s, and row 0 is the initial state.

    ``position`` and ``velocity`` are the values passed to the law. ``true_position`` and ``true_velocity``
    are those of the simulated paddle at the same times. ``force`` is the law's result for sample k;
    ``applied_force`` is the force after fade, limit and safety. ``state`` has the shape (n, values).
    ``moves`` has the position in m (n,) of other moving objects, by name. ``hand_target`` is the target in m
    of a Hand that was given as an object, and None for other hands. ``settings`` are those at the end;
    ``settings_log`` has all settings with their times in s if they changed. ``warnings`` name effects that
    could not be rendered well at these settings and speeds. ``date`` is the date of the recording.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    true_position: np.ndarray
    true_velocity: np.ndarray
    force: np.ndarray
    applied_force: np.ndarray
    hand_force: np.ndarray
    energy: np.ndarray
    flags: np.ndarray
    state: np.ndarray
    state_names: tuple[str, ...]
    faults: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    settings: dict = field(default_factory=dict)
    settings_log: Log = ()
    hand_target: np.ndarray | None = None
    moves: Mapping[str, np.ndarray] = field(default_factory=dict)
    date: str = ""

    @property
    def log(self) -> Log:
        """Return the settings at the start and after each change, with times in s."""
        return self.settings_log or ((0.0, self.settings),)

    def columns(self) -> dict[str, np.ndarray]:
        """Return every column by its name, which contains its unit.

        Other moving objects are "object.name_m"; state variables of the law are "state.name".
        """
        named = {"time_s": self.time}
        named |= {s.column_name: getattr(self, s.name) for s in _SIGNALS}
        named = {header: values for header, values in named.items() if not np.isnan(values).all()}
        if self.hand_target is not None:
            named[BY_NAME["hand_target"].column_name] = self.hand_target
        named |= {f"object.{name}_m": place for name, place in self.moves.items()}
        return {**named, **{f"state.{name}": self.state[:, i] for i, name in enumerate(self.state_names)}}

    def save(self, path: str | Path, decimal: str = ".") -> None:
        """Write columns, settings and their changes to a file.

        The path's suffix selects CSV, Parquet, .mat or a session. ``decimal`` is the decimal sign of a CSV,
        "." or ",". Raise ParameterError for an unknown suffix or sign, SessionError or OSError if the file
        cannot be written.
        """
        if Path(path).suffix == SUFFIX:
            self._save_session(path)
            return
        export.write(path, self.columns(), self.log, decimal)

    def _save_session(self, path: str | Path) -> None:
        table = np.zeros((len(self.time), rows.ROW_WIDTH))
        table[:, [rows.ENERGY_GIVEN, rows.ENERGY_LIMIT]] = np.nan  # a run does not have these columns
        table[:, rows.TICK], table[:, rows.HOST_TIME] = np.arange(len(table)), self.time
        for signal in _SIGNALS:
            table[:, COLUMN[signal.name]] = getattr(self, signal.name)
        if self.hand_target is not None:
            table[:, rows.HAND_TARGET] = self.hand_target
        states = len(self.state_names)
        table[:, rows.STATE : rows.STATE + states] = self.state
        with SessionWriter.whole(path) as writer:
            for time, settings in self.log:
                writer.note(Event(time, SETTINGS, {**settings, "state_names": self.state_names}))
            for first in range(0, len(table), _CHUNK):
                part = table[first : first + _CHUNK]
                writer.add(pack(part, _quantum(self.settings), states, True))

    def plot(self, path: str | Path, environment: Environment | None = None) -> None:
        """Write a figure of position, velocity and force over time, and of force over position.

        The figure also has the law's curve. ``environment`` is the rendered environment, if it is not in the
        library.
        """
        from hapkit_studio.charts.run import run_figure

        known = {} if environment is None else {environment.key: environment}
        run_figure(self, path, settings_events.change_texts(self.log), known=known)


def simulate(
    environment: str | Environment,
    parameters: Mapping[str, object] | None = None,
    *,
    hand: str | Hand | Prescribed | None = None,
    device: Device | None = None,
    rate: float = 1000.0,
    delay: float = 0.0,
    estimator: Spec = "difference",
    seconds: float = 2.0,
    seed: int = 0,
    max_speed: float = math.inf,
    controller: bool = False,
) -> Run:
    """Simulate an environment on a Hapkit; its parameters have their full values from the first sample on.

    ``rate`` is in Hz. ``delay`` is the time in s from sample to applied force, any non-negative value.
    ``max_speed`` in m/s is the over-speed limit, which latches. ``controller`` switches the passivity
    controller on. Raise ParameterError for an unknown name or invalid value, LawError if the law takes longer
    than a period and longer than 1 ms.
    """
    interrupts.listen()
    chosen = environment if isinstance(environment, Environment) else environments.named(environment)
    values = chosen.values(parameters)
    device = SimulatedHapkit() if device is None else device
    if not isinstance(device, Device) or device.model is None:
        raise ParameterError(f"device takes a SimulatedHapkit or None, not {device!r}.")
    model: SimulatedHapkit = device.model
    loop = LoopSettings(
        rate, delay, estimator, bool(controller), mass=model.mass, viscous=model.viscous,
        coulomb=model.coulomb_force, quantum=model.quantum, max_force=model.max_force,
    )  # fmt: skip
    count = _count(SECONDS.check(seconds), loop.rate)
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer):
        raise ParameterError(f"seed takes a whole number, not {seed!r}.")
    moving = _hand(hand)
    if max_speed != math.inf:
        max_speed = SPEED.check(max_speed)
    scene = headless.Scene(chosen, values, model, loop, max_speed)
    out, left = headless.render(scene, moving, count)
    fault = health.describe_fault(int(left.control.fault[0]), left)
    settings = {
        **settings_events.of_scene(chosen, values),
        "hand": hand if isinstance(hand, str) else type(hand).__name__ if hand else "released",
        "rate_Hz": loop.rate,
        "delay_s": loop.delay,
        "estimator": estimator,
        "controller": loop.controller,
        "device": settings_events.of_model(device, model),
        "seed": seed,
    }
    own = isinstance(moving, Hand) and not isinstance(hand, str)
    if own:
        settings["hand_grip"] = {key: float(getattr(moving, key)) for key in ("mass", "damping", "stiffness")}
    speed = float(np.abs(out[:, rows.TRUE_VELOCITY]).max())
    conditions = Conditions(**vars(loop), speed=speed)
    place = chosen.place(values, out[:, rows.POSITION], out[:, rows.STATE :])
    return Run(
        time=np.arange(count) / loop.rate,
        **columns_of(out),
        state=np.ascontiguousarray(out[:, rows.STATE : rows.STATE + len(chosen.state_names)]),
        state_names=chosen.state_names,
        faults=(fault.text,) if fault else (),
        warnings=(*chosen.warnings(values, conditions), *_unsettled(scene, moving, out)),
        settings=settings,
        hand_target=out[:, rows.HAND_TARGET].copy() if own else None,
        moves={} if chosen.moves is None or place is None else {chosen.moves.name: place.copy()},
    )


def open_session(path: str | Path, start: float = 0.0, stop: float = math.inf) -> Run:
    """Return a session's samples from ``start`` to ``stop`` in s since its start, as a Run.

    ``time`` starts at 0, on the device's clock if this clock is continuous. ``settings`` are those at the
    end; ``settings_log`` contains the earlier ones, and ``warnings`` name every change. Columns that were not
    recorded, and state variables of other environments, are NaN. The true motion and the hand are NaN unless
    the device was simulated. Raise SessionError for an invalid file, and ParameterError if there are no
    samples.
    """
    session = Session(path)
    try:
        zero = session.starts[0]
        names = *(signal.name for signal in _SIGNALS), "time", "board_time", "hand_target", "state"
        found = session.read(names, zero + start, zero + stop)
    finally:
        session.close()
    time = found["time"]
    if not len(time):
        if session.damage:
            raise SessionError(f"{' '.join(session.damage)} There are no readable samples in this part.")
        whole = f"samples from 0 to {session.seconds:.6g} s"
        raise ParameterError(f"{session.path.name} has {whole}, none from {start:g} to {stop:g} s.")
    own = found["board_time"]
    own = own if (np.diff(own) > 0.0).all() else time
    log = settings_events.log(session.events, float(time[0]), float(time[-1]))
    changed = np.interp([time[0] + when for when, _ in log], time, own - own[0]).tolist()
    log = [(when, settings) for when, (_, settings) in zip(changed, log, strict=True)]
    state_names, state = _states(own - own[0], found["state"], log)
    events = [event for event in session.events if time[0] <= event.time <= zero + stop]
    columns: dict[str, Any] = {signal.name: found[signal.name] for signal in _SIGNALS}
    return Run(
        time=own - own[0],
        **columns | {"flags": found["flags"].astype(int)},
        state=state,
        state_names=state_names,
        faults=tuple(event.what["text"] for event in events if event.kind == FAULT and event.what["text"]),
        warnings=(*settings_events.changes(session.events, time[0], zero + stop), *session.damage),
        settings=dict(log[-1][1]),
        settings_log=log,
        hand_target=found["hand_target"] if np.isfinite(found["hand_target"]).any() else None,
        date=session.date,
    )


def open_recording(path: str | Path, columns: TableColumns | None = None) -> "Recording":
    """Return a recording for identification from a session, the studio's own table or another table.

    ``columns`` are the columns of a table from another program. Raise SessionError or FileError for an
    invalid file, and UnknownColumnsError if ``columns`` is needed.
    """
    from hapkit_studio.analysis.identify import from_csv, from_run  # imported late because it takes seconds

    with open_regular(path) as file:
        is_session = file.read(len(SQLITE)) == SQLITE
    if is_session or Path(path).suffix == SUFFIX:
        return from_run(open_session(path))
    return from_csv(path, columns)


def _states(time: np.ndarray, state: np.ndarray, log: Log) -> tuple[tuple[str, ...], np.ndarray]:
    """Return the names of all state variables and their values (n, names).

    A value is NaN if the law has no such variable.
    """
    width = state.shape[1]
    unnamed = [f"state_{i}" for i in range(width)]
    pieces = [(when, list(settings.get("state_names", unnamed))[:width]) for when, settings in log]
    pieces = [pieces[0], *(after for before, after in pairwise(pieces) if after[1] != before[1])]
    names = list(dict.fromkeys(name for _, piece in pieces for name in piece))
    found = np.full((len(time), len(names)), math.nan)
    ends = [*(when for when, _ in pieces[1:]), math.inf]
    for (when, piece), end in zip(pieces, ends, strict=True):
        there = (time >= when) & (time < end)
        for place, name in enumerate(piece):
            found[there, names.index(name)] = state[there, place]
    return tuple(names), found


def _quantum(settings: Mapping) -> float:
    """Return the sensor's step in m from settings; 0 if it is missing."""
    device = settings.get("device")
    known = device.get("quantum") if isinstance(device, Mapping) else settings.get("quantum_m")
    return float(known) if isinstance(known, int | float) else 0.0


def _unsettled(scene: headless.Scene, hand: Hand | Prescribed | None, out: np.ndarray) -> list[str]:
    """Return the warnings that the handle does not settle, held or released.

    If the run came to rest, there are no warnings. A handle that never moved, and an imposed motion, are not
    checked.
    """
    place = out[:, rows.TRUE_POSITION]
    came, moved = (np.ptp(part) > scene.device.quantum for part in (place, place[-max(len(out) // 5, 1) :]))
    if isinstance(hand, Prescribed) or (came and not moved):
        return []
    from hapkit_studio.analysis.stability.behaviour import (
        behaviour,
    )  # imported late because most runs come to rest

    held = hand is not None and hand.release > 0.0
    let_go = hand is None or hand.release * scene.loop.rate < len(out)
    grips = [Grip(hand.mass, hand.damping, hand.stiffness)] if hand and held else []
    found = [(grip is not None, behaviour(scene, grip)) for grip in [*grips, *([None] if let_go else [])]]
    return [does.sentence(held) for held, does in found if not does.calm]


def columns_of(table: np.ndarray) -> dict[str, Any]:
    """Return the arrays (n,) of a Run from rows of the loop (n, width)."""
    found = {s.name: np.ascontiguousarray(table[:, COLUMN[s.name]]) for s in _SIGNALS}
    return found | {"flags": found["flags"].astype(int)}


def _count(seconds: float, rate: float) -> int:
    count = round(seconds * rate)
    if not 1 <= count <= MOST_SAMPLES:
        limits = f"1 to {MOST_SAMPLES:,} samples"
        raise ParameterError(f"A run has {limits}, not {count:,}: {seconds:,g} s at {rate:,g} Hz.")
    return count


def _hand(hand: str | Hand | Prescribed | None) -> Hand | Prescribed | None:
    if hand is None or isinstance(hand, Hand | Prescribed):
        return hand
    if isinstance(hand, str):
        return hand_named(hand)
    raise ParameterError(f"hand takes a script's name, a Hand, a Prescribed motion or None, not {hand!r}.")
