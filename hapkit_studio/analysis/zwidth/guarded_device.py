"""A running device for wall trials: rows are monitored, the force is limited, settings are restored."""

import contextlib
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.zwidth import DAMPING, DEVICE_FORCE, PUSH, SPEED
from hapkit_studio.analysis.zwidth.result import FAST, LEAVES
from hapkit_studio.errors import DeviceError, ParameterError, StudioError
from hapkit_studio.formatting import compact
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.parameters import Parameter

_PERSONS = environments.named("wall")
_RANGES = {"stiffness": 1e6, "damping": DAMPING.high}
# the library's wall with a wider range of stiffness; law and position are the same
WALL = replace(
    _PERSONS,
    parameters=tuple(
        replace(p, high=_RANGES[p.key]) if isinstance(p, Parameter) and p.key in _RANGES else p
        for p in _PERSONS.parameters
    ),
)
# N/m: stiffness of a wall that is stable on every Hapkit
CALM = 100.0
_POLL_SECONDS = 0.004
_SILENCE_SECONDS = 3.0
_CHANGED = "The settings were changed. The measurement ended."
_USELESS = rows.STOPPED | rows.FAULT | rows.STALE | rows.FADING


@dataclass(frozen=True)
class TrialLimits:
    """The limits of a trial: ``max_force`` in N, ``max_speed`` in m/s, ``max_travel`` in m from the surface.

    A wall fails if the handle keeps moving by more than ``counts``. The stiffness in N/m rises from
    ``softest`` to ``highest`` by the factor ``raised``. ``precision`` is the relative accuracy of the result.
    Raise ParameterError for an invalid limit.
    """

    max_force: float = DEVICE_FORCE.default
    push: float = PUSH.default
    hit: float = SPEED.default
    max_speed: float = 1.0
    max_travel: float = 0.025
    counts: float = 3.0
    softest: float = 200.0
    highest: float = 20_000.0
    raised: float = 1.5
    precision: float = 0.05

    def __post_init__(self) -> None:
        DEVICE_FORCE.check(self.max_force)
        PUSH.check(self.push)
        SPEED.check(self.hit)
        if self.push > 0.6 * self.max_force:
            raise ParameterError(
                f"The force limit must be {compact(self.push / 0.6, 3)} N or more for a push of "
                f"{self.push:g} N; now it is {self.max_force:g} N."
            )


class Interrupted(StudioError):
    """The measurement ended early; the text contains the reason."""


class Unsafe(Exception):
    """A trial exceeded a limit; the exception's text is a key of ENDED."""


class GuardedDevice:
    """Context manager: set the wall and limit the force; restore all settings on exit.

    The wall replaces the current environment, at the same position. ``into`` is 1 if the wall is on the
    right, -1 if it is on the left. ``instruct`` receives texts for the user. ``poll`` is called about 100
    times per second and may raise to abort. ``clamped`` is True if a sample collected with ``judged`` reached
    the force limit.
    """

    def __init__(
        self, engine: Engine, limits: TrialLimits, instruct: Callable[[str], object], poll: Callable[[], None]
    ):
        self.engine, self.limits, self.instruct, self._poll = engine, limits, instruct, poll
        self._before = engine.environment, engine.values, engine.grip
        self._place = engine.values if engine.environment is _PERSONS else WALL.values()
        self.surface = self._place["position"]
        self.into = 1.0 if self._place["side"] == 0.0 else -1.0
        self._mine = self._before[:2]
        self._most = engine.max_force
        self._samples, self._seconds = 0, 0.0
        self.clamped = False

    def __enter__(self) -> "GuardedDevice":
        self.engine.limit_force(self.limits.max_force)
        self._reader = self.engine.reader()
        try:
            self.calm()
            end = time.monotonic() + _SILENCE_SECONDS
            # the force is withheld for a while after connecting
            while force_withheld(self.collect(0.02, judged=False)):
                if time.monotonic() > end:
                    raise Interrupted("The device gives no force. The measurement ended.")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_error) -> None:
        """Release the hand and restore the settings, except those that were changed elsewhere meanwhile."""
        self.engine.move_hand(None)
        environment, values, grip = self._before
        self.engine.set_loop(hand=grip)
        self.engine.replace_environment(*self._mine, environment, values)
        # a disconnected device cannot receive the limit; the next connection sets it
        with contextlib.suppress(DeviceError):
            self.engine.limit_force(self._most)

    @property
    def quantum(self) -> float:
        """Return the sensor step in m."""
        modelled = self.engine.modelled
        return float(self.engine.device.quantum if modelled is None else modelled.quantum)

    @property
    def rate(self) -> float:
        """Return the mean sampling rate in Hz, by the device's clock; NaN before the first sample."""
        return self._samples / self._seconds if self._seconds > 0.0 else math.nan

    def wall(self, stiffness: float, damping: float) -> None:
        """Apply a wall, ramped over 30 ms; raise Interrupted if the settings were changed elsewhere."""
        values = {"stiffness": stiffness, "damping": damping, "damping_mode": "both"}
        wall = WALL, WALL.values({**self._place, **values})
        if not self.engine.replace_environment(*self._mine, *wall):
            raise Interrupted(_CHANGED)
        self._mine = wall

    def calm(self) -> None:
        """Apply a wall that is certainly stable."""
        self.wall(CALM, 0.0)

    def collect(self, seconds: float, judged: bool = True) -> np.ndarray:
        """Return the rows of the next ``seconds`` s on the device's clock.

        If ``judged`` is true, raise Unsafe if the handle is too fast or too far. Raise Interrupted within a
        few ms if the device stops or the settings are changed; ``poll`` may raise too.
        """
        found, first = [self._reader.read()[:0]], None
        heard = time.monotonic()
        while True:
            self._check()
            new = self._reader.read()
            if len(new):
                heard = time.monotonic()
                first = new[0, rows.BOARD_TIME] if first is None else first
                found.append(new)
                if judged:
                    self._judge(new)
                if new[-1, rows.BOARD_TIME] - first >= seconds - 1e-9:
                    self._seconds += new[-1, rows.BOARD_TIME] - first
                    self._samples += sum(map(len, found)) - 1
                    return np.concatenate(found)
            elif time.monotonic() - heard > _SILENCE_SECONDS:
                raise Interrupted(f"{self.engine.device.title} sends no data. The measurement ended.")
            time.sleep(min(_POLL_SECONDS, 0.05 * seconds))

    def _check(self) -> None:
        self._poll()
        if self.engine.stopped:
            raise Interrupted("Stopped. Force is zero. Release the E-stop, then measure again.")
        fault = self.engine.fault
        if fault is not None:
            raise Interrupted(f"{fault.text} The measurement ended.")
        if (self.engine.environment, self.engine.values) != self._mine:
            raise Interrupted(_CHANGED)

    def _judge(self, new: np.ndarray) -> None:
        self.clamped = self.clamped or bool((new[:, rows.FLAGS].astype(np.int64) & rows.CLAMPED).any())
        if np.abs(new[:, rows.VELOCITY]).max() > self.limits.max_speed:
            raise Unsafe(FAST)
        if np.abs(new[:, rows.POSITION] - self.surface).max() > self.limits.max_travel:
            raise Unsafe(LEAVES)


def pressing_force(found: np.ndarray, into: float) -> float:
    """Return the mean force in N with which the handle presses on the wall."""
    return float(-into * found[:, rows.APPLIED_FORCE].mean())


def force_withheld(found: np.ndarray) -> bool:
    """Return True if rows contain samples at which the force was withheld."""
    return bool((found[:, rows.FLAGS].astype(np.int64) & _USELESS).any())
