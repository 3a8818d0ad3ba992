"""The bench: answers every sample of a board with a bounded force, and with zero whenever in doubt."""

import math
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hapkit_studio.devices.profiles import of_settings, readings
from hapkit_studio.errors import DeviceError
from hapkit_studio.protocol.messages import Board, BoardFlag, Force, Release, Sample, Settings, Stop

Move = Callable[[float, float, float], float]
"""Force in N from time in s, position in m and velocity in m/s."""

KEPT = 10_000
"""Samples kept for drawing: ten seconds."""
_CUTOFF = 30.0
_LATE = 65_535


class StoppedError(DeviceError):
    """The E-stop was pressed."""


class DoubtError(DeviceError):
    """Something is not as it must be, so the force went to zero."""


class LateError(DoubtError):
    """The computer was late, so the board cut its motor off in mid-motion: that says nothing of the kit."""

    def __init__(self) -> None:
        super().__init__(
            "This computer was late, so the board switched its motor off for a moment. That is no fault of "
            "the kit. Close other programs, then try again."
        )


@dataclass(frozen=True)
class Limits:
    """What a run may do at most: force N, distance from where it began m, speed m/s."""

    force: float = 0.0
    travel: float = math.inf
    speed: float = math.inf


@dataclass(frozen=True)
class Track:
    """What a run recorded, arrays (n,): board time s from the first sample, counts, readings, signed duty of
    255, flags, number of the sample, of the one answered, and s from that one to its force in effect."""

    time: np.ndarray
    count: np.ndarray
    raw: np.ndarray
    pwm: np.ndarray
    flags: np.ndarray
    seq: np.ndarray
    answered: np.ndarray
    delay: np.ndarray
    settings: Board

    def __len__(self) -> int:
        return len(self.time)

    @property
    def position(self) -> np.ndarray:
        """Return the handle's position (n,) in m by the settings in force."""
        return self.count * self.settings.quantum


def track_of(samples: list[Sample], settings: Board) -> Track:
    """Return samples as arrays; the clock may have wrapped."""
    columns = {
        name: np.array([getattr(s, name) for s in samples], dtype=np.int64)
        for name in ("time_us", "count", "raw", "pwm", "flags", "seq", "answered", "delay_us")
    }
    steps = np.diff(columns["time_us"], prepend=columns["time_us"][:1]) % 2**32
    columns["raw"] = readings(columns["raw"], settings.sensor)
    late = columns["delay_us"]
    kept = {name: columns[name] for name in ("count", "raw", "pwm", "flags", "seq", "answered")}
    delay = np.where(late < _LATE, late * 1e-6, np.inf)
    return Track(time=np.cumsum(steps) * 1e-6, delay=delay, settings=settings, **kept)


class _Motion:
    """Board time, position and filtered velocity of one sample after the other."""

    def __init__(self, quantum: float):
        self._quantum = quantum
        self._last: Sample | None = None
        self.driven = self._obeyed = False
        self.t = self.x = self.v = 0.0

    def take(self, sample: Sample) -> None:
        x = sample.count * self._quantum
        if self._last is not None:
            dt = ((sample.time_us - self._last.time_us) & 0xFFFFFFFF) * 1e-6
            self.t += dt
            if dt > 0.0:
                self.v += (1.0 - math.exp(-2.0 * math.pi * _CUTOFF * dt)) * ((x - self.x) / dt - self.v)
        self.x, self._last = x, sample

    def cut(self, sample: Sample) -> bool:
        """Return whether the board, that obeyed before, has cut a force because nothing came for too long."""
        off = bool(sample.flags & BoardFlag.WATCHDOG)
        cut = off and self._obeyed and self.driven
        self._obeyed = self._obeyed or not off
        return cut


class Bench:
    """Owns a board from open to close. One thread runs it; ``stop`` may come from any."""

    def __init__(self, board: Any):
        self.board = board
        self.settings: Settings | None = None
        self.seen: deque[Sample] = deque(maxlen=KEPT)
        self.progress = (0.0, 0.0)
        """s of the present run that have passed, and s that it takes; no run: both 0."""
        self._stop = threading.Event()

    def open(self) -> Settings:
        """Open the board and read its settings; raise DeviceError."""
        self.board.open()
        try:
            self.settings = self.board.settings()
        except BaseException:
            self.board.close()
            raise
        return self.settings

    def close(self) -> None:
        """Motor off, let go of the board; never fails."""
        self.board.close()

    @property
    def now(self) -> Settings:
        """Return the settings in force; DeviceError before open."""
        if self.settings is None:
            raise DeviceError("The board is not open.")
        return self.settings

    def stop(self) -> None:
        """E-stop: whatever runs ends with the force at zero; nothing runs until ``release``."""
        self._stop.set()

    def release(self) -> None:
        """End the E-stop; the board hears of it when the next run begins."""
        self._stop.clear()

    @property
    def stopped(self) -> bool:
        """Say whether the E-stop is pressed."""
        return self._stop.is_set()

    def configure(self, **changes: Any) -> Settings:
        """Change some of the settings in force, not yet saved; raise ParameterError or DeviceError."""
        self.settings = self.board.configure(replace(of_settings(self.now), **changes))
        return self.now

    def save(self) -> Settings:
        """Keep the settings in force on the board; raise DeviceError."""
        self.settings = self.board.save()
        return self.now

    def watch(self, seconds: float = math.inf, until: Callable[[], bool] = lambda: False) -> Track:
        """Record with the motor at zero; E-stop does not end it. Raise DeviceError."""
        return self._run(None, seconds, Limits(), until)

    def run(
        self, move: Move, seconds: float, limits: Limits, until: Callable[[], bool] = lambda: False
    ) -> Track:
        """Record while a move drives the handle; raise StoppedError, DoubtError or another DeviceError."""
        if self.stopped:
            raise StoppedError("Stopped. Force is zero. Release the E-stop, then try again.")
        self.board.tell(Release())
        return self._run(move, seconds, limits, until)

    def _run(self, move: Move | None, seconds: float, limits: Limits, until: Callable[[], bool]) -> Track:
        self.settings = self.board.settings()  # whatever was still on its way is read away with it
        motion, kept, start = _Motion(self.now.quantum), [], None
        self.board.start_stream()
        try:
            for sample in self.board.samples():
                motion.take(sample)
                kept.append(sample)
                self.seen.append(sample)
                start = motion.x if start is None else start
                self.progress = motion.t, seconds
                self._answer(sample, move, motion, limits, start)
                if motion.t >= seconds or until():
                    break
        finally:
            self.progress = 0.0, 0.0
            self.board.stop_stream()
        return track_of(kept, of_settings(self.now))

    def _answer(
        self, sample: Sample, move: Move | None, motion: _Motion, limits: Limits, start: float
    ) -> None:
        """Send the force that answers a sample; stop at once at any doubt."""
        if move is None:
            self.board.tell(Force(sample.seq, 0, 0.0))
            return
        if self.stopped:
            self.board.tell(Stop())
            raise StoppedError("Stopped. Force is zero.")
        if motion.cut(sample):
            raise LateError
        _doubt(sample, motion, limits, start)
        force = move(motion.t, motion.x, motion.v)
        motion.driven = force != 0.0
        if not math.isfinite(force):
            raise DoubtError("The force is no number. Force is zero.")
        self.board.tell(Force(sample.seq, 0, min(max(force, -limits.force), limits.force)))


def _doubt(sample: Sample, motion: _Motion, limits: Limits, start: float) -> None:
    """Raise DoubtError where the handle is not where or as fast as it may be, or the board refuses."""
    if sample.flags & (BoardFlag.STOPPED | BoardFlag.OVER_SPEED):
        raise DoubtError("The board has switched its motor off. Force is zero. Hold the handle, try again.")
    gone = abs(motion.x - start)
    if gone > limits.travel:
        raise DoubtError(
            f"The handle is {1e3 * gone:.0f} mm from where it began (limit {1e3 * limits.travel:.0f} mm). "
            "Force is zero."
        )
    if abs(motion.v) > limits.speed:
        raise DoubtError(
            f"The handle moves at {abs(motion.v):.2f} m/s (limit {limits.speed:.2f} m/s). Force is zero."
        )
