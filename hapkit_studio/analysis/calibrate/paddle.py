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

FORCE_SURE = 0.002
"""Share of a force that the steps of its duty leave open."""
TIME_SURE = 50e-6
"""s by which a reading, or a force's beginning, may be off the board's own time for it."""
BAND_SURE = 3
"""Steps of duty by which a dead band that was found may be off."""
MOST_COMPENSATED = 1.0
"""N of dry friction that a sweep compensates at most."""
_COMPENSATED = 0.8
"""Share of the break-away force that it compensates."""
_OFF = BoardFlag.STOPPED | BoardFlag.OVER_SPEED | BoardFlag.REFUSED
_PIECES = (24, 12, 6)
_FEWEST = 40
_MOST_BAND = 200
# a dead band has to explain so much of what is left over, and be so many steps of duty away, to be believed
_BETTER = 1.25
_STEPS = 5
_FINE = 10
"""Steps of duty about the board's own among which a fine search looks: what it began with is near."""


def mean_forces(track: Track, board: Board) -> np.ndarray:
    """Return the motor's mean force (n,) in N from each sample to the next.

    The board says which duty was in force at each sample, and when the last one came into force: that many s
    after the sample that it answers.
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
    """Return a track as a recording for identification; no hand holds the handle."""
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
    """Return the paddle's mass, viscous and Coulomb friction with 95 % intervals, by a board's settings."""
    recording = recording_of(track, board).check()
    part = handle(lay(recording), recording.setup, released=True)
    return widened(part, FORCE_SURE, 0.0, TIME_SURE) if part.estimates else part


def dead_bands_nearby(board: Board) -> list[Board]:
    """Return a board's settings with its dead band as far off as it may be; none without a dead band."""
    ends = (board.dead_band - BAND_SURE, board.dead_band + BAND_SURE) if board.dead_band else ()
    return [replace(board, dead_band=max(band, 0)) for band in ends]


def widened_by_dead_band(part: Part, track: Track, board: Board) -> Part:
    """Return a part whose intervals also hold what the dead band may be off; friction is moved by it most."""
    others = [other for near in dead_bands_nearby(board) if (other := paddle_of(track, near)).estimates]
    made = []
    for e in part.estimates:
        moved = max((abs(other[e.key].value - e.value) for other in others), default=0.0)
        made.append(replace(e, half=math.hypot(e.half, moved)))
    return replace(part, estimates=tuple(made))


def dead_band_of(track: Track, board: Board, fine: bool = False) -> int:
    """Return the dead band of 255 that explains a sweep best; the board's own unless another is much better.

    fine: the best one near the board's, however little better.

    m a + b v + Fc sgn v + c must make the force: only the right dead band gives the force its right shape,
    whatever the motor constant. What is left over counts against the force that moves the mass, not against
    friction: too small a dead band looks like more of that, and would make everything left over look small.
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
    return best if far and residual(board.dead_band) > _BETTER * residual(best) else board.dead_band


def _longest_windows(grid: Grid) -> tuple[Windows, np.ndarray]:
    """Return the longest windows of which enough go one way all through, and which those are."""
    for piece in _PIECES:
        windows = Windows(len(grid), piece, grid.period, 0.0)
        one_way = windows.every(grid.sign > 0.0) | windows.every(grid.sign < 0.0)
        kept = windows.every(grid.there) & one_way
        if kept.sum() >= _FEWEST:
            break
    return windows, kept


def _window_forces(track: Track, board: Board, grid: Grid, windows: Windows) -> np.ndarray:
    """Return each window's mean force in N by a board's settings, (windows,)."""
    values = mean_forces(track, board)
    if len(values) != len(grid):
        times = (track.time - track.time[0]) / grid.period
        values = np.interp(np.arange(len(grid)), times, values)
    return windows.held(values)


def widened(part: Part, force: float, length: float, late: float = 0.0) -> Part:
    """Return a part whose intervals also hold relative errors of the scales of force and length, and late s.

    Where forces begin late s after what is believed, damping looks like mass and, at the motion's frequency,
    mass like damping. What is then wider than its value, and than what is felt, is not told.
    """
    viscous = late * part.turning**2 * part["mass"].value
    moved = {"mass": late * part["viscous"].value, "viscous": viscous}
    made = []
    for e in part.estimates:
        scales = math.hypot(force, 0.0 if e.key == "coulomb" else 2.0 * length)
        wider = replace(e, half=math.hypot(e.half, scales * e.value, moved.get(e.key, 0.0)))
        if e.told and wider.half > max(abs(e.value), e.term.fine):
            scale = "length: take the marks" if 2.0 * length >= force else "force: take the weights"
            wider = replace(wider, told=False, advice=f"Cannot tell by such a scale of {scale} again.")
        made.append(wider)
    return replace(part, estimates=tuple(made))


def changes(part: Part) -> dict[str, float]:
    """Return what of a board's settings a sweep tells; a number that it does not tell stays."""
    return {e.key: max(e.value, 0.0) for e in part.estimates if e.told}


@dataclass(frozen=True)
class SweepResult:
    """A sweep and what it says: the board's settings with the dead band found, and the paddle."""

    board: Board
    part: Part
    track: Track


def sweep(runner: BoardRunner, seconds: float = motions.SWEEP_SECONDS, fine: bool = False) -> SweepResult:
    """Find what it takes to move the handle, sweep, judge; raise DeviceError. Changes nothing on the board.

    fine: the board has a dead band near the true one, so that any better one counts.
    """
    friction = min(_COMPENSATED * breakaway(runner).force, MOST_COMPENSATED)
    track = motions.sweep(runner, seconds, friction)
    board = of_settings(runner.settings)
    board = replace(board, dead_band=dead_band_of(track, board, fine))
    return SweepResult(board, paddle_of(track, board), track)
