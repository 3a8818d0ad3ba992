"""The handle's mass and friction, estimated from the forces on the handle and its motion.

m a + b v + F_c sgn v + c = F + F_hand is averaged over smooth windows: the mean acceleration is the integral
of the position times the window's second derivative. Each regressor is computed twice, from even and from odd
samples, so that the errors of the two are independent. While a hand holds the handle, the estimated mass
includes the mass of the hand.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.analysis.identify.estimates import Estimate, Part, Points, Sizes, estimate, sizes
from hapkit_studio.analysis.identify.recording import Setup
from hapkit_studio.analysis.identify.regression import QUANTILE, STRONG, Fit, first_stage, solve, widening
from hapkit_studio.analysis.identify.windows import Grid, Windows

NAMES = ("mass", "viscous", "coulomb")
SEGMENT_SAMPLES = (2, 4, 8, 16, 32, 64)
# Length in sensor counts of the shortest window at the RMS speed: over this many counts quantisation errors
# average out.
_SHORTEST_COUNTS = 40.0
# Noise fraction of the part of the acceleration that the other terms do not explain: harmless below _RICH,
# too large above _POOR.
_RICH, _POOR = 5e-4, 0.1
# First-stage F that is required if no neighbouring window length is available for comparison.
_STRONG_ALONE = 20.0
UNKNOWN_HOLD = (
    "Unknown: the file does not say how the hand held the handle. Save the run again, or let go of the "
    "handle while you record."
)
UNKNOWN_HAND = (
    "Unknown: the hand's force is not measured. Let go, and use samples in which the handle moves freely."
)
NOTHING_MOVES = (
    "Unknown: the handle hardly moved, or moved at one speed only. Move it farther and faster, or shake it."
)


def handle(grid: Grid, setup: Setup, released: bool = False) -> Part:
    """Identify the handle; set ``released`` if no hand holds it but the recording does not say so."""
    if not grid.hand_known and not released:
        return Part("handle", advice=UNKNOWN_HAND, left_out=grid.left_out)
    in_hand = grid.in_hand & (not released)
    ways = ((~in_hand, True), (in_hand & setup.hold_known, False))
    parts = [_least_variance_part(grid, setup, free, free_hand) for free, free_hand in ways]
    found = [part for part in parts if part is not None]
    if not found:
        unknown = not setup.hold_known and bool(in_hand.any())
        return Part("handle", advice=UNKNOWN_HOLD if unknown else NOTHING_MOVES, left_out=grid.left_out)
    return min(found, key=lambda part: part["mass"].half / max(abs(part["mass"].value), 1e-9))


@dataclass(frozen=True)
class _WindowResult:
    """The result at one window length; ``log_variance`` is the logarithm of the estimates' variance."""

    log_variance: float
    part: Part
    moved: Sizes
    rich: bool
    sure: bool


def _least_variance_part(grid: Grid, setup: Setup, chosen: np.ndarray, released: bool) -> Part | None:
    """Return the result at the window length with the least variance; ``chosen`` (n,) marks used samples."""
    found: list[_WindowResult] = []
    moving = chosen & (grid.sign != 0.0)
    speed = float(np.sqrt(np.mean(grid.slope[moving] ** 2))) if moving.any() else 0.0
    least = _SHORTEST_COUNTS * setup.quantum / max(speed, 1e-9)
    for piece in SEGMENT_SAMPLES:
        windows = Windows(len(grid), piece, grid.period, setup.delay)
        if windows.length * grid.period < least:
            continue
        usable = windows.every(chosen & grid.there) & windows.every(grid.known, windows.lead)
        usable &= windows.every(grid.sign > 0) | windows.every(grid.sign < 0)
        made = _fitted(grid, setup, windows, usable, released)
        found += [made] if made is not None else []
    if not found:
        return None
    at = min(range(len(found)), key=lambda i: found[i].log_variance)
    return _widened(found[at], found[max(at - 1, 0) : at] + found[at + 1 : at + 2])


def _widened(best: _WindowResult, others: list[_WindowResult]) -> Part | None:
    """Return the part with intervals that include the results of neighbouring window lengths.

    Return None if such a result is needed but no neighbouring window length has one.

    Window lengths differ in their bandwidth. At a steady speed the loop turns quantisation into a slow motion
    that biases the results of only some window lengths. If the acceleration is large compared with its noise,
    a difference within the neighbour's own interval does not widen the interval.
    """
    if not (best.sure or others or best.part.released):
        return None
    made, least = [], float(best.rich)
    for e in best.part.estimates:
        apart = [abs(o.part[e.key].value - e.value) - least * o.part[e.key].half for o in others]
        half = math.hypot(e.half, max([0.0, *apart]))
        made.append(estimate(e.key, e.value, half, best.moved, e.asked, e.expected))
    return replace(best.part, estimates=tuple(made))


def _fitted(
    grid: Grid, setup: Setup, windows: Windows, usable: np.ndarray, released: bool
) -> _WindowResult | None:
    """Fit at one window length; return None if the acceleration is too noisy or the instruments are weak."""
    sign = np.sign(windows.derivative(grid.sign, 0))
    halves = [_columns(grid, windows, sign, part) for part in (0, 1)]
    columns = 0.5 * (halves[0] + halves[1])
    made, wider = columns, np.ones(len(NAMES))
    noise = _noise_fraction(windows, columns[usable], grid.step)
    rich = bool(noise < _RICH)
    if noise > _POOR and (released or grid.target is None):
        return None
    sure = False
    if not (rich or released or grid.target is None):
        made, strong = first_stage(grid.target, windows, columns, usable)
        if not (strong[: len(NAMES)] > STRONG).all():
            return None
        sure = bool(noise < _POOR and strong.min() > _STRONG_ALONE)
        wider = widening(strong[: len(NAMES)])
        halves = [made, made]
    force, fit = _solved(grid, setup, windows, halves, columns, usable, released)
    if fit is None:
        return None
    variances = _error_variances(windows, made, usable)
    times = grid.begin + windows.middles[usable]
    moved = sizes(grid.position, windows, usable)
    part = Part(
        "handle",
        _estimates(fit, wider, grid.step * np.sqrt(variances), moved, setup, released),
        explained=fit.explained,
        turning=moved.turning,
        seconds=float(usable.sum()) * windows.piece * grid.period,
        released=released,
        points=Points(times, (*NAMES, "offset"), columns[usable], force[usable], fit, grid.middle),
        left_out=grid.left_out,
    )
    # Window lengths are compared by this variance. A comparison by the fitted intervals would prefer
    # intervals that are narrow by chance.
    return _WindowResult(float(np.log(np.maximum(variances, 1e-300)).sum()), part, moved, rich, rich or sure)


def _solved(
    grid: Grid,
    setup: Setup,
    windows: Windows,
    halves: list[np.ndarray],
    columns: np.ndarray,
    usable: np.ndarray,
    released: bool,
) -> tuple[np.ndarray, Fit | None]:
    """Return the mean forces (windows,) in N and their fit; the fit is None if it failed."""
    rest = columns - 0.5 * (halves[0] + halves[1])
    force = windows.zero_order_hold(grid.commands)
    if not released:
        force = force + windows.derivative(grid.hand, 0) + windows.zero_order_hold(grid.hand_held, 0.0)
    fit = solve(halves[0], halves[1], force, usable, again=True)
    if not released and fit is not None and fit.beta[0] > 0.0:
        force = force + windows.derivative(_step_errors(grid, setup), 0) / fit.beta[0]
        fit = solve(halves[0], halves[1], force, usable, again=True)
    if fit is not None and rest.any():
        # subtract the part of the regressors that the instruments do not explain, because it is not a
        # residual
        fit = solve(halves[0], halves[1], force - rest @ fit.beta, usable, again=True)
    return force, fit


def _estimates(
    fit: Fit, wider: np.ndarray, by_steps: np.ndarray, moved: Sizes, setup: Setup, released: bool
) -> tuple[Estimate, ...]:
    """Return the estimates; quantisation and noise set the smallest width of their intervals."""
    truth = _true_values(setup, released)
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


def _error_variances(windows: Windows, columns: np.ndarray, usable: np.ndarray) -> np.ndarray:
    """Return the coefficients' variances (p,) for a mass of 1 kg and independent position errors of 1 m."""
    used = columns * usable[:, None]
    of_samples = windows.back(used, windows.kernel(2))
    inverse = np.linalg.pinv(used.T @ used)
    return np.diag(inverse @ (of_samples.T @ of_samples) @ inverse)[: len(NAMES)]


def _noise_fraction(windows: Windows, columns: np.ndarray, step: float) -> float:
    """Return the noise fraction of the acceleration, after the other regressors (m, p) are removed."""
    if not len(columns):
        return math.inf
    steps = step**2 / 12.0 * float(np.sum(windows.kernel(2) ** 2))
    return len(columns) * steps * float(np.linalg.pinv(columns.T @ columns)[0, 0])


def _step_errors(grid: Grid, setup: Setup) -> np.ndarray:
    """Return the discretisation error (n,) in N·kg of the hand's damping force after force steps.

    A force step between two samples causes a kink in the speed. For a step u periods after a sample, a sum
    over samples misses T² B₂(u) / 2 times the kink (Euler–Maclaurin; B₂ is the second Bernoulli polynomial).
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
    return np.where(grid.in_hand, -0.5 * setup.grip.damping * grid.period * bends, 0.0)


def _true_values(setup: Setup, released: bool) -> dict[str, float]:
    """Return a simulated handle's true parameters; the mass of a hand that holds the handle is included."""
    if setup.handle is None or (not released and setup.grip is None):
        return {}
    grip = 0.0 if released or setup.grip is None else setup.grip.mass
    truth = vars(setup.handle) | {"mass": setup.handle.mass + grip}
    return {name: value for name, value in truth.items() if math.isfinite(value)}
