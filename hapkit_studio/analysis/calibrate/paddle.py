"""Mass, damping and dry friction of the paddle, and the motor's dead band, from a sweep without a hand."""

import math
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.analysis.calibrate import motions
from hapkit_studio.analysis.calibrate.motor import breakaway
from hapkit_studio.analysis.identify.estimates import Part
from hapkit_studio.analysis.identify.handle import handle
from hapkit_studio.analysis.identify.recording import Recording, Setup
from hapkit_studio.analysis.identify.windows import Grid, Windows, lay
from hapkit_studio.devices.board_runner import BoardRunner, Track, motor_force
from hapkit_studio.devices.profiles import of_settings
from hapkit_studio.haptics import rows
from hapkit_studio.protocol.messages import Board, BoardFlag

FORCE_UNCERTAINTY = 0.002
"""Relative uncertainty of a force, because its duty has steps."""
TIME_UNCERTAINTY = 50e-6
"""s: uncertainty of the board's time of a reading or of a force's start."""
BAND_UNCERTAINTY = 3
"""Uncertainty of a fitted dead band, in duty steps."""
MOST_COMPENSATED = 1.0
"""N: upper limit of the friction compensation in a sweep."""
_COMPENSATED = 0.8
"""Fraction of the break-away force that is compensated."""
_OFF = BoardFlag.STOPPED | BoardFlag.OVER_SPEED | BoardFlag.REFUSED
_PIECES = (24, 12, 6)
_FEWEST = 40
_MOST_BAND = 200
# A fitted dead band is credible if it reduces the residual by at least this factor, and differs from the
# board's by at least this number of duty steps.
_CREDIBLE_RATIO = 1.25
_STEPS = 5
_FINE = 10
"""Duty steps on either side of the board's dead band that a fine search covers."""


def mean_forces(track: Track, board: Board) -> np.ndarray:
    """Return the motor's mean force (n,) in N between consecutive samples.

    For each sample the board reports the duty in effect, and the time in s since its last change.
    """
    at = motor_force(board, track.pwm)
    after = np.append(at[1:], at[-1])
    period = float(np.median(np.diff(track.time)))
    answered = (track.seq - track.answered) % 65536
    ages = np.append(answered[1:], 1)
    since = np.append(track.delay[1:], np.inf) - (ages - 1) * period
    share = np.where(np.isfinite(since), np.clip(since / period, 0.0, 1.0), 0.5)
    return share * at + (1.0 - share) * after


def recording_of(track: Track, board: Board) -> Recording:
    """Return a track as a recording, for an identification without a hand."""
    position = track.count * board.quantum
    applied = mean_forces(track, board)
    nothing = np.zeros(len(track))
    off = (track.flags & int(_OFF)) != 0
    return Recording(
        track.time, position, np.gradient(position, track.time), applied, applied,
        np.where(off, rows.STOPPED, 0), nothing, nothing,
        Setup(rate=1.0 / float(np.median(np.diff(track.time))), quantum=board.quantum),
    )  # fmt: skip


def paddle_of(track: Track, board: Board) -> Part:
    """Return the paddle's mass, viscous and Coulomb friction, according to a board's settings."""
    recording = recording_of(track, board).check()
    part = handle(lay(recording), recording.setup, released=True)
    return widened(part, FORCE_UNCERTAINTY, 0.0, TIME_UNCERTAINTY) if part.estimates else part


def dead_bands_nearby(board: Board) -> list[Board]:
    """Return the settings with the dead band at either end of its uncertainty; empty without a dead band."""
    ends = (board.dead_band - BAND_UNCERTAINTY, board.dead_band + BAND_UNCERTAINTY) if board.dead_band else ()
    return [replace(board, dead_band=max(band, 0)) for band in ends]


def widened_by_dead_band(part: Part, track: Track, board: Board) -> Part:
    """Widen a part's intervals by the uncertainty of the dead band, which affects friction most."""
    others = [other for near in dead_bands_nearby(board) if (other := paddle_of(track, near)).estimates]
    made = []
    for e in part.estimates:
        moved = max((abs(other[e.key].value - e.value) for other in others), default=0.0)
        made.append(replace(e, half=math.hypot(e.half, moved)))
    return replace(part, estimates=tuple(made))


def dead_band_of(track: Track, board: Board, fine: bool = False) -> int:
    """Return the dead band, a duty out of 255, that fits a sweep best.

    Return the board's dead band unless another value fits much better. With ``fine``, return the best value
    near the board's, however small the improvement.

    m a + b v + Fc sgn v + c must equal the force. The force has this form only with the right dead band,
    whatever the motor constant is. Residuals are relative to the inertial force, not to friction: a dead band
    that is too small looks like friction, which would make the relative residual small.
    """
    recording = recording_of(track, board)
    grid = lay(recording)
    windows, kept = _longest_windows(grid)
    if kept.sum() < _FEWEST:
        return board.dead_band
    rates = [windows.derivative(grid.position, order) for order in (2, 1)]
    direction = np.sign(windows.derivative(grid.sign, 0))
    features = np.column_stack([direction, np.ones(len(direction)), *rates])
    friction, inertial = np.split(np.linalg.qr(features[kept])[0], 2, axis=1)

    def residual(band: int) -> float:
        y = _window_forces(track, replace(board, dead_band=band), grid, windows)[kept]
        moving = y - friction @ (friction.T @ y)
        rest = moving - inertial @ (inertial.T @ moving)
        size = float(moving @ moving)
        return float(rest @ rest) / size if size > 0.0 else math.inf

    low, high = (board.dead_band - _FINE, board.dead_band + _FINE) if fine else (0, _MOST_BAND)
    best = min(range(max(low, 0), min(high, _MOST_BAND) + 1), key=residual)
    if fine:
        return best
    far = abs(best - board.dead_band) >= _STEPS
    return best if far and residual(board.dead_band) > _CREDIBLE_RATIO * residual(best) else board.dead_band


def _longest_windows(grid: Grid) -> tuple[Windows, np.ndarray]:
    """Return the longest windows with enough motion in one direction, and the mask of the usable windows."""
    for piece in _PIECES:
        windows = Windows(len(grid), piece, grid.period, 0.0)
        one_way = windows.every(grid.sign > 0.0) | windows.every(grid.sign < 0.0)
        kept = windows.every(grid.there) & one_way
        if kept.sum() >= _FEWEST:
            break
    return windows, kept


def _window_forces(track: Track, board: Board, grid: Grid, windows: Windows) -> np.ndarray:
    """Return each window's mean force (windows,) in N, according to a board's settings."""
    values = mean_forces(track, board)
    if len(values) != len(grid):
        times = (track.time - track.time[0]) / grid.period
        values = np.interp(np.arange(len(grid)), times, values)
    return windows.zero_order_hold(values)


def widened(part: Part, force: float, length: float, late: float = 0.0) -> Part:
    """Widen the intervals of a part's estimates by relative errors of force and length, and by a time error.

    The time error ``late`` is in s. It adds part of the damping to the mass, and part of the mass to the
    damping. An estimate is undetermined if its widened interval exceeds its value and its just-noticeable
    difference.
    """
    viscous = late * part.turning**2 * part["mass"].value
    moved = {"mass": late * part["viscous"].value, "viscous": viscous}
    made = []
    for e in part.estimates:
        scales = math.hypot(force, 0.0 if e.key == "coulomb" else 2.0 * length)
        wider = replace(e, half=math.hypot(e.half, scales * e.value, moved.get(e.key, 0.0)))
        if e.determined and wider.half > max(abs(e.value), e.term.fine):
            scale = (
                "Take the marks of the step Zero and scale"
                if 2.0 * length >= force
                else "Do the step Strength"
            )
            wider = replace(
                wider, determined=False, advice=f"The scale is too inaccurate to tell. {scale} again."
            )
        made.append(wider)
    return replace(part, estimates=tuple(made))


def changes(part: Part) -> dict[str, float]:
    """Return the settings that a sweep determines; undetermined numbers are left out."""
    return {e.key: max(e.value, 0.0) for e in part.estimates if e.determined}


@dataclass(frozen=True)
class SweepResult:
    """A sweep and its results: the settings with the fitted dead band, and the paddle."""

    board: Board
    part: Part
    track: Track


def sweep(runner: BoardRunner, seconds: float = motions.SWEEP_SECONDS, fine: bool = False) -> SweepResult:
    """Find the break-away force, sweep the handle and evaluate the sweep. The board's settings do not change.

    ``fine`` also accepts a small change of the dead band; set it if the board's value is nearly right.
    """
    friction = min(_COMPENSATED * breakaway(runner).force, MOST_COMPENSATED)
    track = motions.sweep(runner, seconds, friction)
    board = of_settings(runner.settings)
    board = replace(board, dead_band=dead_band_of(track, board, fine))
    return SweepResult(board, paddle_of(track, board), track)
