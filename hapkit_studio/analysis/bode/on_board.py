"""The impedance of a virtual board's handle, rendered first by the computer and then by the board's firmware.

Each measurement starts its own board in lockstep mode, which moves its handle by a motion script. The board's
truth log contains the force in effect and the true position at each sample. If a busy computer disturbs a
motion, the motion is repeated.
"""

import contextlib
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hapkit_studio.analysis.bode.drive import Drive
from hapkit_studio.analysis.bode.result import Bode, Curve, Spectra, linear_law
from hapkit_studio.analysis.sweeps import Progress, no_progress
from hapkit_studio.devices.virtual_board import VirtualBoard, truth
from hapkit_studio.dynamics.loop_settings import BOARD, COMPUTER, LoopSettings
from hapkit_studio.errors import DeviceError
from hapkit_studio.haptics import arrays, board_plan, rows
from hapkit_studio.haptics.board_plan import BoardPlan, PlanRequest
from hapkit_studio.haptics.engine import Engine

# s on the board's clock: the time at which the handle moves to its place, and the duration of this movement
_MOVE_AT, _MOVE_SECONDS = 1.0, 0.5
_TURNS = 4  # all motions are repeated this many times, in case some are disturbed
_SINE_TURNS, _SINE_REPEATS = 2, 2  # turns and repeats for single sines, which take 1.5 s each
_STEP = 1e-4  # s: time between points of the script, which the board interpolates linearly
_MARGIN = 0.02  # s: the loop must also render for this time before and after a motion
_POLL_SECONDS = 0.02
_USELESS = rows.STOPPED | rows.FAULT | rows.STALE | rows.FADING | rows.GAP
_BUSY = arrays.STALE_SENSOR, arrays.RUNAWAY  # faults that a busy computer causes


def measure(simulated: Bode, board_rate: float | None = None, progress: Progress = no_progress) -> Bode:
    """Return the response of the computer and of the board for a scene, excited as in a simulated diagram.

    The estimator and the added delay are those of the diagram's first setting. ``board_rate`` is in Hz; None
    uses the law's highest rate on the board. If the board cannot render the law, the board's curve is missing
    and the notes give the reason. Raise StudioError if a measurement fails.
    """
    setting = simulated.curves[0].setting
    request = PlanRequest(simulated.environment, simulated.values, setting.estimator, rate=board_rate)
    computer, plan = _rendered(simulated, request, None, progress)
    if isinstance(plan, str):
        return replace(simulated, curves=(computer,), notes=(plan,))
    board, _ = _rendered(simulated, request, plan, progress)
    return replace(simulated, curves=(computer, board))


def _rendered(
    simulated: Bode, request: PlanRequest, plan: BoardPlan | None, progress: Progress
) -> tuple[Curve, BoardPlan | str]:
    """Return the response curve and the board's plan.

    If a plan is given, the board renders; otherwise the computer renders.
    """
    first_setting = simulated.curves[0].setting
    law = linear_law(request.environment, request.values, simulated.place, simulated.amplitude)
    rate = 1000.0 if plan is None else float(plan.rate)
    drive = Drive(simulated.place, simulated.amplitude, rate, sines=law is None)
    drive = replace(drive, repeats=_SINE_REPEATS) if drive.sines else drive
    where = COMPUTER if plan is None else BOARD
    with tempfile.TemporaryDirectory() as folder:
        log, script = Path(folder, "truth.f64"), Path(folder, "script.txt")
        script.write_text(_script(drive))
        board = VirtualBoard("lockstep", log, script, ("--answer-timeout", "60"))
        engine = Engine(board, request.environment, realtime=False)
        engine.set_environment(request.environment, request.values)
        engine.set_loop(
            delay=first_setting.delay, estimator=first_setting.estimator, controller=first_setting.controller
        )
        with contextlib.closing(engine):
            engine.start()
            assert engine.driver is not None
            assert engine.driver.planner is not None
            possible = engine.driver.planner.plan(replace(request, quantum=board.quantum))
            if plan is not None:
                engine.set_where(BOARD, request.rate)
            begins, clamped = _measured(engine, where, drive, progress)
            delay = engine.delay_of(where)
            assert delay is not None
            spec = (
                first_setting.estimator if plan is None else board_plan.spec_on_board(first_setting.estimator)
            )
            setting = LoopSettings(
                drive.rate, delay.mean, spec, first_setting.controller and plan is None, mass=board.mass,
                viscous=board.viscous, coulomb=0.0, quantum=board.quantum,
            )  # fmt: skip
            board.flush()
        spectra = _spectra(drive, truth(log), begins, delay.mean)
    return spectra.curve(where, setting, clamped, law), possible


def _turns(drive: Drive) -> int:
    return _SINE_TURNS if drive.sines else _TURNS


def _script(drive: Drive) -> str:
    """Return script commands that move the handle to ``place`` and repeat all motions."""
    count = round(_turns(drive) * drive.motions * drive.slot / _STEP)
    ends = drive.position(np.arange(1, count + 1) * _STEP)
    begins = _MOVE_AT + _MOVE_SECONDS + np.arange(count) * _STEP
    lines = [f"0 position 0 0\n{_MOVE_AT} position {drive.place} {_MOVE_SECONDS}\n"]
    lines += [
        f"{t:.4f} position {x:.9f} {_STEP}\n" for t, x in zip(begins.tolist(), ends.tolist(), strict=True)
    ]
    return "".join(lines)


class _Watch:
    """Reads a running engine's rows; stores the times in s of the newest row and the newest invalid row."""

    def __init__(self, engine: Engine, where: str):
        self._engine, self._where, self._reader = engine, where, engine.reader()
        self.now = self.spoilt = 0.0
        self._clamped = self._good = 0

    @property
    def clamped(self) -> float:
        """Return the fraction of samples at the motor's limit."""
        return self._clamped / max(self._good, 1)

    def wait_until(self, end: float) -> None:
        """Read rows until a time in s on the board's clock; raise DeviceError if the board fails."""
        while self.now < end:
            time.sleep(_POLL_SECONDS)
            self._check()
            found = self._reader.read()
            if not len(found):
                continue
            self.now = float(found[-1, rows.BOARD_TIME])
            flags = found[:, rows.FLAGS].astype(int)
            useless = flags & _USELESS != 0
            if self._engine.rendering != self._where or not self._engine.settled:
                useless[:] = True
            if useless.any():
                self.spoilt = float(found[useless, rows.BOARD_TIME].max())
            self._good += int(np.count_nonzero(~useless))
            self._clamped += int(np.count_nonzero(flags[~useless] & rows.CLAMPED))

    def _check(self) -> None:
        fault = self._engine.fault
        if fault is not None and fault.code not in _BUSY:
            raise DeviceError(f"{fault.text} The measurement ended.")
        if fault is not None:
            self._engine.clear_fault()


def _measured(engine: Engine, where: str, drive: Drive, progress: Progress) -> tuple[list[float], float]:
    """Return the start times in s, on the board's clock, of all motions that were rendered validly.

    Also return the fraction of samples at the motor's limit. Raise DeviceError if the board fails or the
    computer is too busy.
    """
    watch, found = _Watch(engine, where), dict[int, float]()
    for number in range(_turns(drive) * drive.motions):
        begin = _MOVE_AT + _MOVE_SECONDS + drive.begin(number)
        watch.wait_until(begin + drive.period + _MARGIN)
        if watch.spoilt < begin - _MARGIN:
            found.setdefault(number % drive.motions, begin)
            progress(len(found), drive.motions)
        if len(found) == drive.motions:
            return [found[motion] for motion in range(drive.motions)], watch.clamped
    raise DeviceError("This computer is too busy to measure on the virtual board. Close other programs.")


def _spectra(drive: Drive, log: Any, begins: list[float], delay: float) -> Spectra:
    """Return the spectra of the motions; a force takes effect ``delay`` s after the previous sample.

    Positions are relative to ``place``: the ticks jitter by 3 µs, so a constant offset would leak into the
    tones.
    """
    spectra = Spectra(drive)
    for motion, begin in enumerate(begins):
        first = int(np.searchsorted(log.time, begin))
        part = slice(first, first + drive.samples)
        edges = log.time[first - 1 : first + drive.samples] + delay % (1.0 / drive.rate)
        spectra.add(motion, log.time[part], log.position[part] - drive.place, edges, log.motor_force[part])
    return spectra
