"""Trials: the motor moves, the numbers judge. What the wizard and the test of a kit both do."""

from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.analysis.calibrate import direction, paddle
from hapkit_studio.analysis.calibrate.motor_map import force_of
from hapkit_studio.analysis.identify.estimates import Part
from hapkit_studio.devices import calibration_moves as moves
from hapkit_studio.devices.calibration import Bench, DoubtError, Track
from hapkit_studio.devices.profiles import of_settings
from hapkit_studio.protocol.messages import Board

MOST_HELP = 1.0
"""N of dry friction at most that a sweep pushes along."""
_HELPED = 0.8
_SUSPICIOUS = 0.35
_BELOW = 0.85


def push_both_ways(bench: Bench) -> direction.Direction:
    """Push with pulses up to 0.3 N, to the right, then as strongly to the left; raise DeviceError."""
    pulses: list[tuple[float, float]] = []
    for size in moves.PULSES:
        for force in (size, -size):
            pulses.append((force, direction.shift(moves.pulse(bench, force), direction.TOGETHER)))
        if any(abs(gone) >= direction.MOVED for _, gone in pulses[-2:]):
            break
    return direction.judge(pulses)


@dataclass(frozen=True)
class Breakaway:
    """Where the handle begins to move: force in N, by the settings, and duty of 255.

    pulses: each way's force in N and how far in m the handle went.
    """

    force: float
    duty: int
    pulses: tuple[tuple[float, float], ...]


def breakaway(bench: Bench) -> Breakaway:
    """Raise the force slowly, both ways, until the handle begins to move; raise DeviceError.

    Raise DoubtError where nothing up to 1.5 N moves it.
    """
    duties, shifts = [], []
    for sign in (1.0, -1.0):
        track = moves.search(bench, sign)
        if abs(direction.shift(track)) < direction.MOVED / 2.0:
            raise DoubtError(
                f"Not even {moves.SEARCH_LIMITS.force:g} N moved the handle. Force is zero. Switch the "
                "motor's supply on (12 V), look for a cable that is jammed or has slipped, then try again."
            )
        duties.append(int(np.abs(track.pwm).max()))
        shifts.append(direction.shift(track))
    forces = force_of(of_settings(bench.now), np.array(duties))
    pulses = ((float(forces[0]), shifts[0]), (-float(forces[1]), shifts[1]))
    return Breakaway(float(np.mean(forces)), round(float(np.mean(duties))), pulses)


@dataclass(frozen=True)
class Swept:
    """A sweep and what it says: the board's settings with the dead band found, the paddle, the force at which
    the handle broke away in N."""

    board: Board
    part: Part
    track: Track
    breakaway: float


def sweep(bench: Bench, seconds: float = moves.SWEEP_SECONDS, fine: bool = False) -> Swept:
    """Find what it takes to move the handle, sweep, judge; raise DeviceError. Changes nothing on the board.

    fine: the board has a dead band near the true one, so that any better one counts.
    """
    force = breakaway(bench).force
    helped = min(_HELPED * force, MOST_HELP)
    track = moves.sweep(bench, seconds, helped)
    board = of_settings(bench.now)
    board = replace(board, dead_band=paddle.dead_band_of(track, board, fine))
    return Swept(board, paddle.paddle_of(track, board), track, force)


def first_dead_band(found: Breakaway) -> int:
    """Return a dead band to begin with, from the duty at which the handle broke away, or 0."""
    return round(_BELOW * found.duty) if found.force > _SUSPICIOUS else 0
