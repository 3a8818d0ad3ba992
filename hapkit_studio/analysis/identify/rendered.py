"""What was rendered: the stiffness, damping and friction that the handle met, beside what had been set.

-F = K (x - x0) + B v + F_c sgn v, with F the commanded force in effect: held, and late by the loop's delay.
No force is measured, so what the motor makes of the command is neither in the numbers nor in their intervals.
Each side is averaged over smooth windows, so speed comes without a difference of counts. What the hold and
the delay take from the damping is part of what was rendered.

What the loop must make of what was set, on this very motion: a command is held for a period T and comes td
late, so the force at the handle lags the position by T / 2 + td: of -K x it makes -K x + K (T / 2 + td) v, a
damping of B - K (T / 2 + td). The velocity estimate comes later still: of -B v it makes some stiffness as
well, B w^2 times its lag.
"""

import math

import numpy as np

from hapkit_studio.analysis.identify.estimates import Estimate, Part, Points, Sizes, estimate, sizes
from hapkit_studio.analysis.identify.recording import Setup
from hapkit_studio.analysis.identify.regression import QUANTILE, Fit, solve
from hapkit_studio.analysis.identify.windows import Grid, Windows
from hapkit_studio.environments.base import ForceTerms

# Windows of about that length are short beside any motion of a hand, and long beside the sensor's steps.
LONGEST_SECONDS = 0.026
PIECES = (32, 16, 8, 4, 2)
# Shorter windows are worth it only where they find so much more that can be used.
_GAIN = 1.3
# A term's column is this derivative of the position.
_DERIVATIVES = {"stiffness": 0, "damping": 1, "damping_in": 1, "damping_out": 1}
# After a change of direction the velocity estimate still has the old sign for a few samples.
_ESTIMATOR_SAMPLES = 4


def rendered(grid: Grid, setup: Setup, terms: tuple[str, ...] | None = None) -> Part:
    """Identify what was rendered; terms None: what the environment consists of."""
    known = setup.environment  # without a known environment nothing was set
    asked = known.force_terms(setup.values) if known else ForceTerms(simple=False)
    names = _names(asked, terms or asked.terms)
    best: tuple[int, Windows, np.ndarray] | None = None
    for piece in PIECES:
        windows = Windows(len(grid), piece, grid.period, setup.delay)
        if windows.length * grid.period > LONGEST_SECONDS and piece > PIECES[-1]:
            continue
        kept = _kept(grid, windows, asked, names)
        used = int(kept.sum()) * piece
        if best is None or used > _GAIN * best[0]:
            best = used, windows, kept
    assert best is not None  # the shortest windows are always looked at
    return _fitted(grid, setup, asked, names, *best[1:])


def _names(asked: ForceTerms, terms: tuple[str, ...]) -> tuple[str, ...]:
    """Return the columns' names: damping that acts one way only has two."""
    if asked.one_way == 0.0:
        return terms
    return tuple(n for t in terms for n in (("damping_in", "damping_out") if t == "damping" else (t,)))


def _kept(grid: Grid, windows: Windows, asked: ForceTerms, names: tuple[str, ...]) -> np.ndarray:
    good = grid.law & grid.contact if asked.contact else grid.law
    if asked.settle > 0.0:
        good = good & (grid.gone > asked.settle)
    kept = windows.every(good, windows.lead)
    if "friction" in names or "damping_in" in names:
        before = windows.lead + _ESTIMATOR_SAMPLES
        kept &= windows.every(grid.sign > 0, before) | windows.every(grid.sign < 0, before)
    return kept


def _columns(grid: Grid, windows: Windows, asked: ForceTerms, names: tuple[str, ...]) -> np.ndarray:
    position, speed = windows.derivative(grid.position, 0), windows.derivative(grid.position, 1)
    sign = np.sign(windows.derivative(grid.sign, 0))
    inward = sign * asked.one_way > 0.0
    known = {
        "stiffness": position,
        "damping": speed,
        "damping_in": np.where(inward, speed, 0.0),
        "damping_out": np.where(inward, 0.0, speed),
        "friction": sign,
    }
    return np.column_stack([*(known[name] for name in names), np.ones(len(position))])


def _fitted(
    grid: Grid, setup: Setup, asked: ForceTerms, names: tuple[str, ...], windows: Windows, kept: np.ndarray
) -> Part:
    columns, against = _columns(grid, windows, asked, names), -windows.held(grid.commands)
    left_out = dict(grid.left_out)
    if asked.contact and (away := int((grid.law & ~grid.contact).sum())):
        left_out["not in contact"] = away
    there = columns[kept].any(axis=0) if kept.any() else np.zeros(len(names) + 1, bool)
    absent = tuple(name for name, any_ in zip(names, there, strict=False) if not any_)
    names, columns = tuple(name for name in names if name not in absent), columns[:, there]
    fit = solve(columns, columns, against, kept) if there.any() else None
    if fit is None:
        return Part("rendered", advice=_why_not(grid, asked, names), left_out=left_out)
    moved, times = sizes(grid.position, windows, kept), grid.begin + windows.middles[kept]
    steps = _steps(fit, names, windows, columns[kept], grid.step)
    noise = math.sqrt(max(grid.step**2 - setup.quantum**2, 0.0) / 12.0)
    half = np.maximum(fit.half, QUANTILE * noise * _by_noise(fit, names, windows, columns, kept)) + steps
    expected = _expected(grid, asked, names, windows, columns, kept)
    known = {"stiffness": asked.stiffness, "friction": asked.friction, "damping_out": 0.0}
    known |= dict.fromkeys(("damping", "damping_in"), asked.damping)
    estimates = [
        estimate(name, fit.beta[i], half[i], moved, known[name], expected.get(name))
        for i, name in enumerate(names)
    ]
    estimates += [estimate(name, 0.0, math.inf, moved, known[name]) for name in absent]
    estimates += _centre(fit, names, grid, asked, estimates, moved, expected.get("offset"))
    return Part(
        "rendered",
        tuple(estimates),
        explained=fit.explained,
        turning=moved.turning,
        seconds=float(kept.sum()) * windows.piece * grid.period,
        points=Points(times, (*names, "offset"), columns[kept], against[kept], fit, grid.middle),
        left_out=left_out,
        damped=int(grid.damped.sum()),
    )


def _steps(
    fit: Fit, names: tuple[str, ...], windows: Windows, columns: np.ndarray, step: float
) -> np.ndarray:
    """Return by how much (p,) the sensor's steps or noise may draw the coefficients towards zero.

    Errors of variance step^2 / 12 in each sample, as the windows weigh them, against what really moves.
    """
    error = np.zeros(len(fit.beta))
    for i, name in enumerate(names):
        if name in _DERIVATIVES:
            error[i] = step**2 / 12.0 * float(np.sum(windows.kernel(_DERIVATIVES[name]) ** 2))
    inverse = np.linalg.pinv(columns.T @ columns)
    return len(columns) * np.abs(inverse) @ (error * np.abs(fit.beta))


def _by_noise(
    fit: Fit, names: tuple[str, ...], windows: Windows, columns: np.ndarray, kept: np.ndarray
) -> np.ndarray:
    """Return the standard deviations (p,) of the coefficients for white noise of 1 m in the positions.

    Columns (windows, p) hold each sample's error as their windows weigh it; neighbours share samples.
    """
    used = np.where(kept[:, None], columns, 0.0)
    of_samples = np.zeros((windows.count, len(fit.beta)))
    for i, name in enumerate(names):
        if name in _DERIVATIVES:
            there = used[:, i : i + 1] != 0.0  # damping that acts one way has no error in the other's windows
            of_samples += fit.beta[i] * windows.back(there * used, windows.kernel(_DERIVATIVES[name]))
    inverse = np.linalg.pinv(used.T @ used)
    return np.sqrt(np.diag(inverse @ (of_samples.T @ of_samples) @ inverse))


def _expected(
    grid: Grid,
    asked: ForceTerms,
    names: tuple[str, ...],
    windows: Windows,
    columns: np.ndarray,
    kept: np.ndarray,
) -> dict[str, float]:
    """Return what would have been found if the law had done what was set, no more and no less."""
    if not asked.simple:
        return {}
    depth, rate = grid.seen - (asked.centre or 0.0), grid.speed
    if asked.one_way:
        rate = np.where(rate * asked.one_way > 0.0, rate, 0.0)
    commands = -(asked.stiffness or 0.0) * depth - (asked.damping or 0.0) * rate
    commands -= (asked.friction or 0.0) * np.sign(grid.speed)
    fit = solve(columns, columns, -windows.held(commands), kept)
    return dict(zip((*names, "offset"), fit.beta.tolist(), strict=True)) if fit else {}


def _centre(
    fit: Fit,
    names: tuple[str, ...],
    grid: Grid,
    asked: ForceTerms,
    estimates: list[Estimate],
    moved: Sizes,
    offset: float | None = None,
) -> list[Estimate]:
    """Return where the spring pulls to, or the wall's surface, where a stiffness was found.

    What a late velocity adds to the stiffness acts on the motion alone, not on where it is about: there the
    law's own stiffness pulls, so the addition that is expected is taken off.
    """
    if "stiffness" not in names:
        return []
    at = names.index("stiffness")
    found = estimates[at]
    if not found.told or found.half > 0.5 * abs(found.value):
        return []
    still = found.value
    if found.expected is not None and asked.stiffness is not None:
        still -= found.expected - asked.stiffness
    if abs(still) < 0.5 * abs(found.value):
        return []
    mean = moved.middle
    force = fit.beta[at] * mean + fit.beta[-1]
    gradient = np.zeros((1, len(fit.beta)))
    gradient[0, at], gradient[0, -1] = -mean / still + force / still**2, -1.0 / still
    value = float(grid.middle + mean - force / still)
    half = float(fit.half_of(gradient)[0])
    if offset is not None and found.expected is not None and asked.stiffness and asked.centre is not None:
        # what a late velocity adds to the mean force, by the same fit to what was set
        set_force = found.expected * mean + offset
        shift = grid.middle + mean - set_force / asked.stiffness - asked.centre
        value, half = value - shift, math.hypot(half, 0.5 * shift)
    return [estimate("centre", value, half, moved, asked.centre, asked.centre)]


def _why_not(grid: Grid, asked: ForceTerms, names: tuple[str, ...]) -> str:
    if asked.contact and not (grid.contact & grid.there).any():
        return "Cannot tell: the piece never touches. Push into the surface."
    if not grid.law.any():
        return "Cannot tell: the law's force was never applied. Release the stop, lower the force, try again."
    if float(np.ptp(grid.position)) == 0.0:
        return "Cannot tell: nothing moves. Move the handle."
    if asked.contact:
        return "Cannot tell: the contacts are too short. Push and hold, and move while pushing."
    if "friction" in names:
        return "Cannot tell: nothing slides far enough. Move farther and faster, both ways."
    return "Cannot tell: the piece is too short. Take a longer one, and move all the time."
