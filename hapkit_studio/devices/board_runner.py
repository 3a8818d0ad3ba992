"""Run a board from plain Python: answer each sample with a limited force, which is zero after any fault."""

import contextlib
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hapkit_studio import lab
from hapkit_studio.devices.profiles import full_force, of_settings, readings
from hapkit_studio.errors import DeviceError, NoDataError
from hapkit_studio.protocol.messages import Board, BoardFlag, Force, MotorMap, Release, Sample, Settings, Stop

Motion = Callable[[float, float, float], float]
"""Force in N as a function of time in s, distance from the run's start in m, and velocity in m/s."""

RECENT_SAMPLES = 10_000
"""Samples kept for drawing: ten seconds."""
FULL_DUTY = 255.0
_VELOCITY_CUTOFF = 30.0
_NO_DELAY_KNOWN = 65_535
_SLOWEST, _SPARE_SECONDS = 10.0, 30.0
"""The time-out of a run is its board time × _SLOWEST + _SPARE_SECONDS, on the computer's clock."""


class StoppedError(DeviceError):
    """The E-stop was pressed."""


class CancelledError(DeviceError):
    """The user cancelled the run."""

    def __init__(self) -> None:
        super().__init__("Cancelled. The motor is off.")


class AbortedError(DeviceError):
    """A fault occurred, so the force was set to zero."""


class LateError(AbortedError):
    """The computer was late, so the board's watchdog switched the motor off; the kit has no fault."""

    def __init__(self) -> None:
        super().__init__(
            "This computer was late, so the board switched its motor off briefly. This is not a fault of "
            "the kit. Close other programs, then try again."
        )


class ForceLimitError(DeviceError):
    """A motion may need more force than the lab allows, so it was not started."""


@dataclass(frozen=True)
class Limits:
    """The limits of a run: force in N, distance from its start in m, speed in m/s."""

    force: float = 0.0
    travel: float = math.inf
    speed: float = math.inf


@dataclass(frozen=True)
class Track:
    """Recorded samples of a run, arrays (n,).

    The columns are: board time in s from the first sample, counts, readings, signed duty (255 is full duty),
    flags, the number of the sample, the number of the answered sample, and the time in s from the answered
    sample until its force took effect.
    """

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
        """Return the handle's position (n,) in m, computed with the settings of the track."""
        return self.count * self.settings.quantum


def track_of(samples: list[Sample], settings: Board) -> Track:
    """Return samples as arrays, with the board's clock unwrapped."""
    columns = {
        name: np.array([getattr(s, name) for s in samples], dtype=np.int64)
        for name in ("time_us", "count", "raw", "pwm", "flags", "seq", "answered", "delay_us")
    }
    clock, late = columns.pop("time_us"), columns.pop("delay_us")
    time = np.cumsum(np.diff(clock, prepend=clock[:1]) % 2**32) * 1e-6
    columns["raw"] = readings(columns["raw"], settings.sensor)
    delay = np.where(late < _NO_DELAY_KNOWN, late * 1e-6, np.inf)
    return Track(time=time, delay=delay, settings=settings, **columns)


def motor_force(board: Board, pwm: np.ndarray) -> np.ndarray:
    """Return the handle force (n,) in N, positive to the right, at signed duties pwm (n,) of at most 255."""
    size = np.abs(np.asarray(pwm, dtype=float))
    duty = np.clip((size - board.dead_band) / (FULL_DUTY - board.dead_band), 0.0, 1.0)
    if board.motor_map == MotorMap.SQUARE:
        share = duty * duty
    elif board.motor_map == MotorMap.LINEAR:
        share = duty
    else:
        share = np.interp(duty, np.arange(9) / 8.0, np.array((0.0, *board.table)) / FULL_DUTY)
    return full_force(board) * np.sign(pwm) * share


class _Handle:
    """Board time, position and filtered velocity of the handle; each sample updates them."""

    def __init__(self, quantum: float):
        self._quantum = quantum
        self._last: Sample | None = None
        self.driven = self._obeyed = False
        self.t = self.x = self.v = self.start = 0.0

    def take(self, sample: Sample) -> None:
        x = sample.count * self._quantum
        if self._last is None:
            self.start = x
        else:
            dt = ((sample.time_us - self._last.time_us) & 0xFFFFFFFF) * 1e-6
            self.t += dt
            if dt > 0.0:
                weight = 1.0 - math.exp(-2.0 * math.pi * _VELOCITY_CUTOFF * dt)
                self.v += weight * ((x - self.x) / dt - self.v)
        self.x, self._last = x, sample

    def was_cut(self, sample: Sample) -> bool:
        """Return True if the board's watchdog has switched off a force that the board had accepted."""
        off = bool(sample.flags & BoardFlag.WATCHDOG)
        cut = off and self._obeyed and self.driven
        self._obeyed = self._obeyed or not off
        return cut


class BoardRunner:
    """The owner of a board from open to close.

    One thread runs the board; ``stop`` and ``cancel`` are thread-safe.
    """

    def __init__(self, board: Any):
        self.board = board
        self.recent: deque[Sample] = deque(maxlen=RECENT_SAMPLES)
        self.progress = (0.0, 0.0)
        """Elapsed time and duration in s of the current run; both are 0 if no run is active."""
        self._settings: Settings | None = None
        self._stop, self._cancel = threading.Event(), threading.Event()

    def open(self) -> Settings:
        """Open the board and read its settings.

        Raise DeviceError if the board fails, and for a mistake in the lab's file.
        """
        lab.force_limit()
        self.board.open()
        try:
            return self.read_settings()
        except BaseException:
            self.board.close()
            raise

    def close(self) -> None:
        """Switch the motor off and release the board; never fails."""
        self.board.close()

    @property
    def settings(self) -> Settings:
        """Return the board's current settings; raise DeviceError before open."""
        if self._settings is None:
            raise DeviceError("The board is not connected.")
        return self._settings

    def read_settings(self) -> Settings:
        """Ask the board for its current settings; raise DeviceError if it does not answer."""
        self._settings = self.board.settings()
        return self.settings

    def configure(self, **changes: Any) -> Settings:
        """Change some settings without saving them.

        Raise ParameterError if the board rejects them, and DeviceError if it does not answer.
        """
        self._settings = self.board.configure(replace(of_settings(self.settings), **changes))
        return self.settings

    def save(self) -> Settings:
        """Store the board's current settings in its EEPROM; raise DeviceError if it does not answer."""
        self._settings = self.board.save()
        return self.settings

    def stop(self) -> None:
        """E-stop: end any run with zero force; no run starts until ``release``."""
        self._stop.set()

    def release(self) -> None:
        """End the E-stop; the board is released at the next run."""
        self._stop.clear()

    @property
    def stopped(self) -> bool:
        """Return True if the E-stop is pressed."""
        return self._stop.is_set()

    def cancel(self) -> None:
        """End a run with the motor off, and refuse further runs until ``begin_job``."""
        self._cancel.set()

    def begin_job(self) -> None:
        """Clear the cancel request that ended an earlier job."""
        self._cancel.clear()

    def check_stopped(self) -> None:
        """Raise CancelledError after a cancellation; in an E-stop, stop the board and raise StoppedError."""
        if self.stopped:
            self.board.send_messages(Stop())
            raise StoppedError("Stopped. Force is zero.")
        if self._cancel.is_set():
            raise CancelledError

    def record(self, seconds: float) -> Track:
        """Record with zero force; an E-stop does not end the recording.

        Raise CancelledError if the user cancels, and DeviceError if the board fails.
        """
        return self._run(None, seconds, Limits(), lambda: False)

    def run(
        self, motion: Motion, seconds: float, limits: Limits, until: Callable[[], bool] = lambda: False
    ) -> Track:
        """Record while ``motion`` drives the handle.

        Raise ForceLimitError if the lab allows less force, StoppedError after an E-stop, CancelledError on
        cancelling, AbortedError after a fault, or another DeviceError if the board fails.
        """
        most = lab.force_limit()
        if limits.force > most:  # a smaller force would give a wrong result
            raise ForceLimitError(
                f"This measurement needs up to {limits.force:g} N, but {lab.FILE} limits the force to "
                f"{most:g} N. Ask the administrator of this computer."
            )
        if self.stopped:
            raise StoppedError("Stopped. Force is zero. Release the E-stop, then try again.")
        self.board.send_messages(Release())
        return self._run(motion, seconds, limits, until)

    def idle(self, until: Callable[[], bool]) -> None:
        """Keep the force at zero and update ``recent``; raise DeviceError if the board fails."""
        with contextlib.closing(self.samples()) as samples:
            for sample in samples:
                self.board.send_messages(Force(sample.seq, 0, 0.0))
                if until():
                    break

    def samples(self, silence: float = 1.0) -> Generator[Sample, None, None]:
        """Read the settings, then yield samples and keep them as ``recent``.

        Closing the generator stops the motor. Raise NoDataError after ``silence`` s without samples. The
        start command is repeated, because a board may miss it.
        """
        self.read_settings()  # this request also discards bytes of an earlier stream
        heard = False
        try:
            for last in (False, True):
                self.board.start_stream()
                try:
                    for sample in self.board.samples(silence):
                        heard = True
                        self.recent.append(sample)
                        yield sample
                except NoDataError:
                    if heard or last:
                        raise
        finally:
            self.board.stop_stream()

    def _run(self, motion: Motion | None, seconds: float, limits: Limits, until: Callable[[], bool]) -> Track:
        handle, received = None, []
        deadline = time.monotonic() + _SLOWEST * seconds + _SPARE_SECONDS
        try:
            with contextlib.closing(self.samples()) as samples:
                for sample in samples:
                    handle = handle or _Handle(self.settings.quantum)
                    handle.take(sample)
                    received.append(sample)
                    self.progress = handle.t, seconds
                    self._answer(sample, motion, handle, limits)
                    if handle.t >= seconds or until():
                        break
                    if time.monotonic() > deadline:
                        raise AbortedError(
                            "The board replies too slowly. Force is zero. Connect the board again."
                        )
        finally:
            self.progress = 0.0, 0.0
        return track_of(received, of_settings(self.settings))

    def _answer(self, sample: Sample, motion: Motion | None, handle: _Handle, limits: Limits) -> None:
        """Send the force that answers a sample; stop at once after a fault."""
        force = 0.0
        if motion is not None:
            self.check_stopped()
            if handle.was_cut(sample):
                raise LateError
            _check(sample, handle, limits)
            force = motion(handle.t, handle.x - handle.start, handle.v)
            handle.driven = force != 0.0
            if not math.isfinite(force):
                raise AbortedError("The force is not a number. Force is zero.")
        elif self._cancel.is_set():
            raise CancelledError
        self.board.send_messages(Force(sample.seq, 0, min(max(force, -limits.force), limits.force)))


def _check(sample: Sample, handle: _Handle, limits: Limits) -> None:
    """Raise AbortedError if the handle is too far or too fast, or the board refuses the force."""
    if sample.flags & (BoardFlag.STOPPED | BoardFlag.OVER_SPEED):
        raise AbortedError(
            "The board has switched its motor off. Force is zero. Hold the handle, then try again."
        )
    distance = abs(handle.x - handle.start)
    if distance > limits.travel:
        limit = f"(limit {1e3 * limits.travel:.0f} mm)"
        raise AbortedError(
            f"The handle has moved {1e3 * distance:.0f} mm from its start {limit}. Force is zero."
        )
    if abs(handle.v) > limits.speed:
        raise AbortedError(
            f"The handle moves at {abs(handle.v):.2f} m/s (limit {limits.speed:.2f} m/s). Force is zero."
        )
