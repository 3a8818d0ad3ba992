"""What the handle is: its mass and friction, out of the forces on it and its motion.

m a + b v + F_c sgn v + c = F + F_hand, averaged over smooth windows: the acceleration's average is that of
the position times the window's second derivative. Even and odd samples give every column twice, with errors
that have nothing in common. While a hand holds, the mass is the handle's and the hand's together.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.analysis.identify.estimates import Estimate, Part, Points, Sizes, estimate, sizes
from hapkit_studio.analysis.identify.recording import Setup
from hapkit_studio.analysis.identify.regression import QUANTILE, STRONG, Fit, by_target, solve, widening
from hapkit_studio.analysis.identify.windows import Grid, Windows

NAMES = ("mass", "viscous", "coulomb")
PIECES = (2, 4, 8, 16, 32, 64)
# While so many counts of the sensor go by, their errors are many and average out.
_COUNTS = 40.0
# Shares of the sensor's steps in what the acceleration tells alone: so few do no harm, so many all of it.
_RICH, _POOR = 5e-4, 0.1
# So strong must instruments be where no other length of windows can be compared.
_SURE = 20.0
UNKNOWN_HOLD = (
    "Cannot tell: the file does not say how the hand held. Save the run anew, or let go in the piece."
)
UNKNOWN_HAND = (
    "Cannot tell: the hand's force is not known. Let go, and take a piece in which the handle moves freely."
)
NOTHING_MOVES = (
    "Cannot tell: the motion keeps still, or keeps one speed. Move farther and faster, both ways; shake."
)


def handle(grid: Grid, setup: Setup, released: bool = False) -> Part:
    """Identify the handle; released says that no hand holds it, where the recording does not know."""
    if not grid.hand_known and not released:
        return Part("handle", advice=UNKNOWN_HAND, left_out=grid.left_out)
    held = grid.held & (not released)
    ways = ((~held, True), (held & setup.hold_known, False))
    parts = [_best(grid, setup, free, free_hand) for free, free_hand in ways]
    found = [part for part in parts if part is not None]
    if not found:
        unknown = not setup.hold_known and bool(held.any())
        return Part("handle", advice=UNKNOWN_HOLD if unknown else NOTHING_MOVES, left_out=grid.left_out)
    return min(found, key=lambda part: part["mass"].half / max(abs(part["mass"].value), 1e-9))


@dataclass(frozen=True)
class _Found:
    """What windows of one length tell: how little, the part, and the motion in them."""

    little: float
    part: Part
    moved: Sizes
    rich: bool
    sure: bool


def _best(grid: Grid, setup: Setup, chosen: np.ndarray, released: bool) -> Part | None:
    """Return the part from the windows that tell most; chosen (n,) says which samples belong to it."""
    found: list[_Found] = []
    moving = chosen & (grid.sign != 0.0)
    speed = float(np.sqrt(np.mean(grid.slope[moving] ** 2))) if moving.any() else 0.0
    least = _COUNTS * setup.quantum / max(speed, 1e-9)
    for piece in PIECES:
        windows = Windows(len(grid), piece, grid.period, setup.delay)
        if windows.length * grid.period < least:
            continue
        kept = windows.every(chosen & grid.there) & windows.every(grid.known, windows.lead)
        kept &= windows.every(grid.sign > 0) | windows.every(grid.sign < 0)
        made = _fitted(grid, setup, windows, kept, released)
        found += [made] if made is not None else []
    if not found:
        return None
    at = min(range(len(found)), key=lambda i: found[i].little)
    return _agreeing(found[at], found[max(at - 1, 0) : at] + found[at + 1 : at + 2])


def _agreeing(best: _Found, others: list[_Found]) -> Part | None:
    """Return the part, its intervals as wide as other windows disagree; None without any.

    Each length lets other errors pass; what a loop makes of the sensor's steps at a steady speed is slow, and
    looks like motion to one of them. Where the motion is rich, their own intervals excuse them.
    """
    if not (best.sure or others or best.part.released):
        return None
    made, least = [], float(best.rich)
    for e in best.part.estimates:
        apart = [abs(o.part[e.key].value - e.value) - least * o.part[e.key].half for o in others]
        half = math.hypot(e.half, max([0.0, *apart]))
        made.append(estimate(e.key, e.value, half, best.moved, e.asked, e.expected))
    return replace(best.part, estimates=tuple(made))


def _fitted(grid: Grid, setup: Setup, windows: Windows, kept: np.ndarray, released: bool) -> _Found | None:
    """Return what these windows tell, None where that is nothing."""
    sign = np.sign(windows.derivative(grid.sign, 0))
    halves = [_columns(grid, windows, sign, part) for part in (0, 1)]
    columns = 0.5 * (halves[0] + halves[1])
    made, wider = columns, np.ones(len(NAMES))
    noise = _noise(windows, columns[kept], grid.step)
    rich = bool(noise < _RICH)
    if noise > _POOR and (released or grid.target is None):
        return None
    sure = False
    if not (rich or released or grid.target is None):
        made, strong = by_target(grid.target, windows, columns, kept)
        if not (strong[: len(NAMES)] > STRONG).all():
            return None
        sure = bool(noise < _POOR and strong.min() > _SURE)
        wider = widening(strong[: len(NAMES)])
        halves = [made, made]
    force, fit = _solved(grid, setup, windows, halves, columns, kept, released)
    if fit is None:
        return None
    variances = _by_steps(windows, made, kept)
    times = grid.begin + windows.middles[kept]
    moved = sizes(grid.position, windows, kept)
    part = Part(
        "handle",
        _estimates(fit, wider, grid.step * np.sqrt(variances), moved, setup, released),
        explained=fit.explained,
        turning=moved.turning,
        seconds=float(kept.sum()) * windows.piece * grid.period,
        released=released,
        points=Points(times, (*NAMES, "offset"), columns[kept], force[kept], fit, grid.middle),
        left_out=grid.left_out,
    )
    # chosen by the variances and not by the intervals found, the windows do not favour small intervals
    return _Found(float(np.log(np.maximum(variances, 1e-300)).sum()), part, moved, rich, rich or sure)


def _solved(
    grid: Grid,
    setup: Setup,
    windows: Windows,
    halves: list[np.ndarray],
    columns: np.ndarray,
    kept: np.ndarray,
    released: bool,
) -> tuple[np.ndarray, Fit | None]:
    """Return the windows' forces (windows,) in N and the fit to them."""
    rest = columns - 0.5 * (halves[0] + halves[1])
    force = windows.held(grid.commands)
    if not released:
        force = force + windows.derivative(grid.hand, 0) + windows.held(grid.hand_held, 0.0)
    fit = solve(halves[0], halves[1], force, kept, again=True)
    if not released and fit is not None and fit.beta[0] > 0.0:
        force = force + windows.derivative(_jerks(grid, setup), 0) / fit.beta[0]
        fit = solve(halves[0], halves[1], force, kept, again=True)
    if fit is not None and rest.any():
        # what the target does not make of the columns explains nothing, but it is no residual either
        fit = solve(halves[0], halves[1], force - rest @ fit.beta, kept, again=True)
    return force, fit


def _estimates(
    fit: Fit, wider: np.ndarray, by_steps: np.ndarray, moved: Sizes, setup: Setup, released: bool
) -> tuple[Estimate, ...]:
    """Return the estimates; no interval is narrower than the sensor's steps or noise alone make it."""
    truth = _truth(setup, released)
    steps = QUANTILE / math.sqrt(12.0) * abs(fit.beta[0]) * by_steps
    half = wider * np.maximum(fit.half[: len(NAMES)], steps)
    return tuple(
        estimate(name, fit.beta[i], half[i], moved, truth.get(name), truth.get(name))
        for i, name in enumerate(NAMES)
    )


def _columns(grid: Grid, windows: Windows, sign: np.ndarray, part: int) -> np.ndarray:
    acceleration = windows.derivative(grid.position, 2, part)
    return np.column_stack(
        [acceleration, windows.derivative(grid.position, 1, part), sign, np.ones(len(sign))]
    )


def _by_steps(windows: Windows, columns: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Return the variances (p,) that independent errors of the samples cause, per their own and m^2."""
    used = columns * kept[:, None]
    of_samples = windows.back(used, windows.kernel(2))
    inverse = np.linalg.pinv(used.T @ used)
    return np.diag(inverse @ (of_samples.T @ of_samples) @ inverse)[: len(NAMES)]


def _noise(windows: Windows, columns: np.ndarray, step: float) -> float:
    """Return the share of the sensor's steps in what accelerations tell beside the other columns (m, p)."""
    if not len(columns):
        return math.inf
    steps = step**2 / 12.0 * float(np.sum(windows.kernel(2) ** 2))
    return len(columns) * steps * float(np.linalg.pinv(columns.T @ columns)[0, 0])


def _jerks(grid: Grid, setup: Setup) -> np.ndarray:
    """Return what a hand's damper makes of the motor's and its own steps between samples, in N kg (n,).

    Each step bends the speed, and a sum over samples of what bends is off by T^2 B2(u) / 2 times the bend for
    one that lies u periods after a sample (Euler and Maclaurin; B2 the second Bernoulli polynomial).
    """
    if setup.grip is None:
        return np.zeros(len(grid))
    late = setup.delay / grid.period
    whole_periods = int(late + 1e-9)
    u = late - whole_periods
    motor = np.zeros(len(grid))
    motor[whole_periods + 1 :] = np.diff(grid.commands)[: max(len(grid) - whole_periods - 1, 0)]
    own = np.diff(grid.hand_held, prepend=grid.hand_held[0])
    bends = (u * u - u + 1.0 / 6.0) * motor + own / 6.0
    return np.where(grid.held, -0.5 * setup.grip.damping * grid.period * bends, 0.0)


def _truth(setup: Setup, released: bool) -> dict[str, float]:
    """Return what a simulated handle was given, with the hand's mass while it holds."""
    if setup.handle is None or (not released and setup.grip is None):
        return {}
    grip = 0.0 if released or setup.grip is None else setup.grip.mass
    truth = vars(setup.handle) | {"mass": setup.handle.mass + grip}
    return {name: value for name, value in truth.items() if math.isfinite(value)}
