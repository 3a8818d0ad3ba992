"""The rendered impedance: stiffness, damping and friction at the handle, compared with the settings.

-F = K (x - x0) + B v + F_c sgn v, where F is the commanded force in effect. It is constant during a period,
and late by the loop's delay. The motor's force is not measured, so the motor's errors appear neither in the
estimates nor in their intervals. Both sides are averaged over smooth windows, which avoids differences of
sensor counts. The zero-order hold and the delay reduce the damping; the estimate includes this loss.

The expected value follows from the lag of the force. The force is constant for a period T and arrives td
late, so it lags the position by T / 2 + td. The spring's force -K x therefore acts as -K x + K (T / 2 + td)
v, which reduces the damping to B - K (T / 2 + td). The velocity estimate has a further lag: -B v adds a
stiffness of B w² times this lag.
"""

import math

import numpy as np

from hapkit_studio.analysis.identify.estimates import Estimate, Part, Points, Sizes, estimate, sizes
from hapkit_studio.analysis.identify.recording import Setup
from hapkit_studio.analysis.identify.regression import QUANTILE, Fit, solve
from hapkit_studio.analysis.identify.windows import Grid, Windows
from hapkit_studio.environments.base import ForceTerms

# longest window: short compared with any motion of a hand, long compared with the time of a sensor step
LONGEST_SECONDS = 0.026
PIECES = (32, 16, 8, 4, 2)
# a shorter window is used only if it increases the usable time by this factor
_GAIN = 1.3
# order of the derivative of the position in each term's regressor
_DERIVATIVES = {"stiffness": 0, "damping": 1, "damping_in": 1, "damping_out": 1}
# after a reversal, the velocity estimate may have the old sign for this many samples
_ESTIMATOR_SAMPLES = 4


def rendered(grid: Grid, setup: Setup, terms: tuple[str, ...] | None = None) -> Part:
    """Identify the rendered impedance; if ``terms`` is None, use the terms of the environment."""
    known = setup.environment  # if it is unknown, so are the values that were set
    asked = known.force_terms(setup.values) if known else ForceTerms(simple=False)
    names = _names(asked, terms or asked.terms)
    best: tuple[int, Windows, np.ndarray] | None = None
    for piece in PIECES:
        windows = Windows(len(grid), piece, grid.period, setup.delay)
        if windows.length * grid.period > LONGEST_SECONDS and piece > PIECES[-1]:
            continue
        usable = _usable(grid, windows, asked, names)
        used = int(usable.sum()) * piece
        if best is None or used > _GAIN * best[0]:
            best = used, windows, usable
    assert best is not None  # the loop always tries the shortest windows
    return _fitted(grid, setup, asked, names, *best[1:])


def _names(asked: ForceTerms, terms: tuple[str, ...]) -> tuple[str, ...]:
    """Return the regressor names; one-way damping has separate names for inward and outward motion."""
    if asked.one_way == 0.0:
        return terms
    return tuple(n for t in terms for n in (("damping_in", "damping_out") if t == "damping" else (t,)))


def _usable(grid: Grid, windows: Windows, asked: ForceTerms, names: tuple[str, ...]) -> np.ndarray:
    good = grid.law & grid.contact if asked.contact else grid.law
    if asked.settle > 0.0:
        good = good & (grid.gone > asked.settle)
    usable = windows.every(good, windows.lead)
    if "friction" in names or "damping_in" in names:
        before = windows.lead + _ESTIMATOR_SAMPLES
        usable &= windows.every(grid.sign > 0, before) | windows.every(grid.sign < 0, before)
    return usable


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
    grid: Grid, setup: Setup, asked: ForceTerms, names: tuple[str, ...], windows: Windows, usable: np.ndarray
) -> Part:
    columns, against = _columns(grid, windows, asked, names), -windows.zero_order_hold(grid.commands)
    left_out = dict(grid.left_out)
    if asked.contact and (away := int((grid.law & ~grid.contact).sum())):
        left_out["not in contact"] = away
    there = columns[usable].any(axis=0) if usable.any() else np.zeros(len(names) + 1, bool)
    absent = tuple(name for name, any_ in zip(names, there, strict=False) if not any_)
    names, columns = tuple(name for name in names if name not in absent), columns[:, there]
    fit = solve(columns, columns, against, usable) if there.any() else None
    if fit is None:
        return Part("rendered", advice=_why_not(grid, asked, names), left_out=left_out)
    moved, times = sizes(grid.position, windows, usable), grid.begin + windows.middles[usable]
    steps = _quantisation_bias(fit, names, windows, columns[usable], grid.step)
    noise = math.sqrt(max(grid.step**2 - setup.quantum**2, 0.0) / 12.0)
    half = (
        np.maximum(fit.half, QUANTILE * noise * _noise_deviations(fit, names, windows, columns, usable))
        + steps
    )
    expected = _expected(grid, asked, names, windows, columns, usable)
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
        seconds=float(usable.sum()) * windows.piece * grid.period,
        points=Points(times, (*names, "offset"), columns[usable], against[usable], fit, grid.middle),
        left_out=left_out,
        damped=int(grid.damped.sum()),
    )


def _quantisation_bias(
    fit: Fit, names: tuple[str, ...], windows: Windows, columns: np.ndarray, step: float
) -> np.ndarray:
    """Return the bias (p,) of the coefficients towards zero, from quantisation or sensor noise.

    Each sample has an error of variance step² / 12. The bias is the ratio of these errors, weighted by the
    windows, to the regressors.
    """
    error = np.zeros(len(fit.beta))
    for i, name in enumerate(names):
        if name in _DERIVATIVES:
            error[i] = step**2 / 12.0 * float(np.sum(windows.kernel(_DERIVATIVES[name]) ** 2))
    inverse = np.linalg.pinv(columns.T @ columns)
    return len(columns) * np.abs(inverse) @ (error * np.abs(fit.beta))


def _noise_deviations(
    fit: Fit, names: tuple[str, ...], windows: Windows, columns: np.ndarray, usable: np.ndarray
) -> np.ndarray:
    """Return the standard deviations (p,) of the coefficients for white position noise of 1 m.

    The errors of overlapping windows are correlated.
    """
    used = np.where(usable[:, None], columns, 0.0)
    of_samples = np.zeros((windows.count, len(fit.beta)))
    for i, name in enumerate(names):
        if name in _DERIVATIVES:
            # one-way damping has no error in the windows of the other direction
            there = used[:, i : i + 1] != 0.0
            of_samples += fit.beta[i] * windows.back(there * used, windows.kernel(_DERIVATIVES[name]))
    inverse = np.linalg.pinv(used.T @ used)
    return np.sqrt(np.diag(inverse @ (of_samples.T @ of_samples) @ inverse))


def _expected(
    grid: Grid,
    asked: ForceTerms,
    names: tuple[str, ...],
    windows: Windows,
    columns: np.ndarray,
    usable: np.ndarray,
) -> dict[str, float]:
    """Return the estimates that are expected if the law renders the set values exactly."""
    if not asked.simple:
        return {}
    depth, rate = grid.seen - (asked.centre or 0.0), grid.speed
    if asked.one_way:
        rate = np.where(rate * asked.one_way > 0.0, rate, 0.0)
    commands = -(asked.stiffness or 0.0) * depth - (asked.damping or 0.0) * rate
    commands -= (asked.friction or 0.0) * np.sign(grid.speed)
    fit = solve(columns, columns, -windows.zero_order_hold(commands), usable)
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
    """Return the centre of the spring or the surface of the wall; empty if the stiffness is not a term.

    A delayed velocity estimate adds stiffness to the motion about the mean position, but not to the mean
    force. The centre is therefore computed without this added stiffness.
    """
    if "stiffness" not in names:
        return []
    at = names.index("stiffness")
    found = estimates[at]
    if not found.determined or found.half > 0.5 * abs(found.value):
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
        # A fit to the force that follows from the set values shows how far the fit shifts the centre.
        # Subtract this shift.
        set_force = found.expected * mean + offset
        shift = grid.middle + mean - set_force / asked.stiffness - asked.centre
        value, half = value - shift, math.hypot(half, 0.5 * shift)
    return [estimate("centre", value, half, moved, asked.centre, asked.centre)]


def _why_not(grid: Grid, asked: ForceTerms, names: tuple[str, ...]) -> str:
    if asked.contact and not (grid.contact & grid.there).any():
        return "Unknown: the handle never touched the surface. Push into it."
    if not grid.law.any():
        return (
            "Unknown: the law's force was never applied. Release the E-stop, lower the force and try again."
        )
    if float(np.ptp(grid.position)) == 0.0:
        return "Unknown: the handle did not move. Move it."
    if asked.contact:
        return "Unknown: the contacts are too short. Push and hold, and move while pushing."
    if "friction" in names:
        return "Unknown: the handle did not move far enough. Move it farther and faster in both directions."
    return "Unknown: there are too few samples. Use a longer time, and move all the time."
