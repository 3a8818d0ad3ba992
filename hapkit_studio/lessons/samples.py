"""Recorded samples, and their segments in which the settings are constant."""

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from hapkit_studio import environments
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import StudioError
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.signals import COLUMN
from hapkit_studio.sessions import settings_events
from hapkit_studio.sessions.session import Session
from hapkit_studio.settings_log import Log, LoggedSettings

# s: a change is recorded up to 0.1 s late, and parameters ramp for 30 ms after it
_BEFORE_CHANGE, _AFTER_CHANGE = 0.1, 0.05
_SIGNALS = ("position", "velocity", "force", "applied_force", "energy")
_NUMBERS = ("time", *_SIGNALS)
_BAD = rows.STOPPED | rows.FAULT | rows.STALE | rows.GAP


@dataclass(frozen=True)
class Samples:
    """Samples as columns (n,) in SI units, named as in ``simulate``, and the law's state (n, values).

    ``time`` is in s after the start of the recording. ``log`` has the settings, with the time from which they
    are valid.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    applied_force: np.ndarray
    energy: np.ndarray
    flags: np.ndarray
    state: np.ndarray
    log: Log
    date: str = ""
    known: Mapping[str, Environment] = field(default_factory=dict, repr=False)
    """Environments, by key, that are not in the library."""

    @classmethod
    def of_rows(
        cls, table: np.ndarray, log: Log, known: Mapping[str, Environment] | None = None
    ) -> "Samples":
        """Return the samples of telemetry rows (n, ROW_WIDTH).

        The log's times are relative to the first row.
        """
        signals: dict[str, Any] = {name: table[:, COLUMN[name]] for name in _SIGNALS}
        time, log = _device_clock(table[:, rows.HOST_TIME], table[:, rows.BOARD_TIME], log)
        return cls(
            time=time,
            **signals,
            flags=table[:, rows.FLAGS].astype(int),
            state=table[:, rows.STATE :],
            log=log,
            known=known or {},
        )

    @classmethod
    def of_session(cls, session: Session) -> "Samples":
        """Return the samples of a session; raise SessionError if they are too many to be read."""
        found = session.read(["time", "board_time", *_SIGNALS, "flags", "state"])
        time, board = found["time"], found["board_time"]
        log = settings_events.log(session.events, float(time[0]), float(time[-1]))
        time, log = _device_clock(time, board, log)
        signals: dict[str, Any] = {name: found[name] for name in _SIGNALS}
        return cls(
            time=time,
            **signals,
            flags=found["flags"].astype(int),
            state=found["state"],
            log=log,
            date=session.date,
        )

    def __len__(self) -> int:
        return len(self.time)

    def between(self, start: float, stop: float) -> "Samples":
        """Return the samples with start <= time <= stop, with their part of the settings log."""
        first, last = np.searchsorted(self.time, [start, stop], "left")
        last += last < len(self.time) and self.time[last] == stop
        return self.cut(slice(int(first), int(last)))

    def cut(self, part: slice) -> "Samples":
        columns = {name: getattr(self, name)[part] for name in (*_NUMBERS, "flags", "state")}
        if not len(columns["time"]):
            return replace(self, **columns)
        begin, end = float(columns["time"][0]), float(columns["time"][-1])
        before = [(begin, settings) for when, settings in self.log if when <= begin][-1:]
        log = [*before, *((when, s) for when, s in self.log if begin < when <= end)]
        return replace(self, **columns, log=log or self.log[:1])

    def segments(self) -> Iterator["Samples"]:
        """Yield the segments with constant settings and without faults; the newest is first."""
        if not len(self):
            return
        changes = [when for when, _ in self.log[1:]]
        begins = [float(self.time[0]), *(when + _AFTER_CHANGE for when in changes)]
        ends = [*(when - _BEFORE_CHANGE for when in changes), float(self.time[-1])]
        for begin, end in reversed(list(zip(begins, ends, strict=True))):
            if begin < end:
                yield from reversed(list(self.between(begin, end)._working()))

    def _working(self) -> Iterator["Samples"]:
        """Yield the segments that have no fault, and no gap of more than 20 periods."""
        good = (self.flags & _BAD) == 0
        gaps = np.diff(self.time)
        broken = gaps > 20.0 * np.median(gaps) if len(gaps) else np.zeros(0, bool)
        for part in runs(good, np.flatnonzero(broken) + 1):
            yield self.cut(part)

    # --- settings at the end of the segment

    @property
    def settings(self) -> LoggedSettings:
        """Return the settings at the end."""
        return self.log[-1][1]

    @cached_property
    def scene(self) -> tuple[Environment, dict[str, float]] | None:
        """Return the environment and its values at the end; None if the environment is unknown."""
        key = str(self.settings.get("environment"))
        try:
            found = self.known.get(key) or environments.named(key)
            return found, found.values(self.settings.get("parameters"))
        except StudioError:
            return None

    @property
    def delay(self) -> float:
        return float(self.settings.get("delay_s") or 0.0)

    @property
    def period(self) -> float:
        """Return the sampling period in s, computed from the recorded times."""
        return float(np.median(np.diff(self.time))) if len(self) > 1 else math.nan

    @property
    def quantum(self) -> float:
        """Return the sensor's step in m; 20.7 µm if it is unknown."""
        device = self.settings.get("device")
        found = device.get("quantum") if isinstance(device, Mapping) else self.settings.get("quantum_m")
        return float(found) if isinstance(found, int | float) else 20.7e-6

    @property
    def hand_force(self) -> np.ndarray:
        """Return NaN (n,) as the hand's force.

        Checks ignore the force of a simulated hand, because that of a real hand is unknown.
        """
        return np.full(len(self), math.nan)

    @property
    def moves(self) -> dict[str, np.ndarray]:
        """Return the positions in m (n,) of the scene's other moving objects by name."""
        if self.scene is None or self.scene[0].moves is None:
            return {}
        environment, values = self.scene
        place = environment.place(values, self.position, self.state)
        return {} if place is None else {environment.moves.name: place}  # type: ignore[union-attr]

    @cached_property
    def depth(self) -> np.ndarray | None:
        """Return the penetration in m (n,) of the surface; None if the scene has no surface."""
        if self.scene is None or not self.scene[0].shades:
            return None
        _, values = self.scene
        side = -1.0 if values.get("side", 0.0) == 1.0 else 1.0
        return side * (self.position - values["position"])

    def count(self, name: str) -> np.ndarray | None:
        """Return a state variable of the law (n,) by its name; None if the name is unknown."""
        names = self.scene[0].state_names[: self.state.shape[1]] if self.scene else ()
        return self.state[:, names.index(name)] if name in names else None

    def stamp(self) -> str:
        """Return a hash of samples and settings; it detects changes of both."""
        total = hashlib.sha256()
        for name in _NUMBERS:
            total.update(np.ascontiguousarray(getattr(self, name), dtype="<f8").tobytes())
        states = len(self.scene[0].state_names) if self.scene else 0  # files pad the state with NaN
        total.update(np.ascontiguousarray(self.state[:, :states], dtype="<f8").tobytes())
        settings = [[round(when - self.time[0], 6), change] for when, change in self.log]
        settings = json.loads(json.dumps(settings, default=str))  # as read from a file
        total.update(json.dumps(settings, sort_keys=True).encode())
        return total.hexdigest()


def _device_clock(time: np.ndarray, board: np.ndarray, log: Log) -> tuple[np.ndarray, Log]:
    """Return times in s after the first sample, and the log with times of the same clock.

    The device's own clock is preferred, because it has no jitter. It is not used if it stops or goes back.
    """
    if len(time) < 2 or not (np.diff(board) > 0.0).all():
        return time - time[:1].sum(), log
    changed = np.interp([time[0] + when for when, _ in log], time, board - board[0]).tolist()
    return board - board[0], [(when, settings) for when, (_, settings) in zip(changed, log, strict=True)]


def runs(good: np.ndarray, breaks: np.ndarray | tuple = ()) -> list[slice]:
    """Return the slices of consecutive true values (n,); they are also split at each index in ``breaks``."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(np.int8), [0]])))
    found = []
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        inside = [int(b) for b in breaks if first < b < last]
        ends = [int(first), *inside, int(last)]
        found += [slice(a, b) for a, b in pairwise(ends)]
    return found
