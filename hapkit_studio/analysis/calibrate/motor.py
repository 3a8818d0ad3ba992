"""The motor: its direction, the break-away force of the handle, and the true force per commanded force."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy import signal, stats

from hapkit_studio.analysis.calibrate import motions
from hapkit_studio.analysis.calibrate.motions import (
    CARRY_PERIOD,
    PULL_PERIOD,
    PULLS,
    SETTLE_SECONDS,
    SHAKE_PERIOD,
    STROKE,
)
from hapkit_studio.analysis.calibrate.result import CheckResult, passed, warn
from hapkit_studio.devices.board_runner import AbortedError, BoardRunner, Track, motor_force
from hapkit_studio.devices.profiles import of_settings
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import compact
from hapkit_studio.parameters import check_number
from hapkit_studio.protocol.messages import Board

MOVED = 0.3e-3
"""m: a handle that moves farther counts as moved."""
AVERAGED = 9
"""Number of samples that are averaged, so that sensor noise is not mistaken for motion."""
GRAVITY = 9.81
PLAUSIBLE = (0.25, 4.0)
"""Accepted ratio of a motor's measured strength to the strength in the settings."""
_SUSPICIOUS = 0.35
"""N: break-away force above which a dead band is a likelier cause than friction."""
_BELOW = 0.85
# relative uncertainty of a weight, from the tolerance of coins, the release, and sticking friction
_WEIGHT_UNCERTAINTY = 0.02
_AT_LIMIT = 0.5
"""Fraction of time at the largest duty above which a motor counts as saturated."""
SPRING_UNCERTAINTY, LENGTH_UNCERTAINTY = 0.03, 0.01
"""Relative uncertainties of a spring's stiffness and, without marks, of the length scale."""
SPRINGS = (40.0, 1000.0)
"""N/m: the handle cannot stretch softer springs enough, and stiffer springs ring with the shaking force."""
SPRINGS_DIFFER = 2.0
"""Smallest ratio of the stiffest to the softest spring."""
# Fractions of a pull: the part excluded at either end, where the handle reverses; the part in which it must
# slide.
_EXCLUDED_ENDS, _SLIDING = 0.15, 0.2
# A leg is the rise or the fall of a pull. A step of size s in a leg causes a residual rms of s / _STEP. A leg
# is straight if its step is smaller than the fraction _BENT of its length.
_STEP, _BENT = 6.0, 0.05
_FEWEST_COUNTS = 5.0
_MEANS = round(0.5 * PULL_PERIOD / (4.0 * SHAKE_PERIOD))
"""Number of means in half a pull of a spring; each mean covers four shaking periods."""


def displacement(track: Track, averaged: int = 1) -> float:
    """Return the largest displacement in m from the first position, with its sign.

    Each position is the mean of ``averaged`` samples.
    """
    place = np.convolve(track.position, np.full(averaged, 1.0 / averaged), "valid")
    away = place - place[0]
    return float(away[np.argmax(np.abs(away))])


@dataclass(frozen=True)
class Direction:
    """The motor's direction according to pushes, with a text.

    ``agrees`` is True if force and position have the same sign, and None if the pushes do not show the
    direction.
    """

    agrees: bool | None
    result: CheckResult


def judge_pulses(pulses: list[tuple[float, float]]) -> Direction:
    """Return the direction that pulses (force in N, displacement in m) of both signs show."""
    moved = [(force, moved_by) for force, moved_by in pulses if abs(moved_by) >= MOVED]
    rights, lefts = ([m for m in moved if m[0] * sign > 0.0] for sign in (1.0, -1.0))
    pushed = max((abs(force) for force, _ in pulses), default=0.0)
    if not moved:
        text = f"Pulses up to {pushed:.1f} N did not move the handle."
        remedy = (
            "Is the motor's power supply on (12 V plug, not only USB)? Is the cable on the pulley, and not "
            "jammed? Is the handle free? If all this is right, press Look for a dead band in Set up my "
            "Hapkit, step Direction."
        )
        return Direction(None, warn("no motion", text, remedy))
    signs = {np.sign(force * moved_by) for force, moved_by in moved}
    if len(signs) > 1 or not rights or not lefts:
        text = "The handle did not follow the pulses in both directions."
        remedy = (
            "Put the kit on a level surface, release the handle in the middle, and keep your hands off. Then "
            "push again."
        )
        return Direction(None, warn("one way", text, remedy))
    farthest = 1e3 * max(abs(moved_by) for _, moved_by in moved)
    if signs == {-1.0}:
        text = f"A push to the right moved the handle to the left, {farthest:.1f} mm."
        remedy = "You need not do anything: the motor is reversed now, and the test is repeated."
        return Direction(False, warn("opposite", text, remedy))
    return Direction(
        True, passed(f"The handle follows the force: it moved up to {farthest:.1f} mm in each direction.")
    )


def push_both_ways(runner: BoardRunner) -> Direction:
    """Push with pulses of up to 0.3 N, each to the right and then to the left."""
    pulses: list[tuple[float, float]] = []
    for size in motions.PULSES:
        for force in (size, -size):
            pulses.append((force, displacement(motions.pulse(runner, force), AVERAGED)))
        if any(abs(moved_by) >= MOVED for _, moved_by in pulses[-2:]):
            break
    return judge_pulses(pulses)


@dataclass(frozen=True)
class Breakaway:
    """The break-away force in N according to the settings, and a first estimate of the dead band.

    The dead band is a duty out of 255; it is 0 if the force is small enough to be friction. ``pulses``
    contains force in N and displacement in m for each direction.
    """

    force: float
    dead_band: int
    pulses: list[tuple[float, float]]


def breakaway(runner: BoardRunner) -> Breakaway:
    """Increase the force slowly, in both directions, until the handle moves.

    Raise AbortedError if 1.5 N does not move the handle.
    """
    duties, shifts = [], []
    for sign in (1.0, -1.0):
        track = motions.raise_force(runner, sign)
        if abs(displacement(track)) < MOVED / 2.0:
            raise AbortedError(
                f"Not even {motions.RAISE_LIMITS.force:g} N moved the handle. The force is zero again. "
                "Switch the motor's supply on (12 V), and look for a cable that is jammed or has slipped. "
                "Then try again."
            )
        duties.append(int(np.abs(track.pwm).max()))
        shifts.append(displacement(track))
    right, left = motor_force(of_settings(runner.settings), np.array(duties)).tolist()
    force = 0.5 * (right + left)
    dead_band = round(_BELOW * float(np.mean(duties))) if force > _SUSPICIOUS else 0
    return Breakaway(force, dead_band, [(right, shifts[0]), (-left, shifts[1])])


@dataclass(frozen=True)
class Strength:
    """Ratio of true to commanded force with its 95 % half width, and the motor constant in N·m."""

    ratio: float
    half: float
    motor_constant: float

    @property
    def text(self) -> str:
        share = f"{100.0 * self.ratio:.0f} ± {100.0 * self.half:.0f} %"
        constant = f"motor constant {1e3 * self.motor_constant:.2f} mN·m"
        return f"The motor gives {share} of the force that was set: {constant}."


def carrying_force(track: Track, board: Board) -> tuple[float, float]:
    """Return the mean commanded force in N over full periods of the movement, and its uncertainty.

    Friction cancels, because the movements up and down take the same time. Sticking friction widens the
    interval. Raise ParameterError if the motor cannot carry the weight.
    """
    periods = int((track.time[-1] - SETTLE_SECONDS) / CARRY_PERIOD + 1e-3)
    if periods < 2:
        raise ParameterError("The motor did not carry the weight long enough. Measure again.")
    end = SETTLE_SECONDS + periods * CARRY_PERIOD
    force = motor_force(board, track.pwm)
    means = [
        float(force[(track.time >= t) & (track.time < t + CARRY_PERIOD)].mean())
        for t in end - CARRY_PERIOD * np.arange(1, periods)
    ]
    size = np.abs(track.pwm)
    step = float(np.max(motor_force(board, size + 1) - motor_force(board, size)))
    carrying = (track.time >= SETTLE_SECONDS) & (track.time < end)
    stuck = float(np.ptp(track.position[carrying])) < STROKE
    duty = size[carrying]
    if stuck and float(np.mean(duty == duty.max())) > _AT_LIMIT:
        most = abs(float(force[carrying].mean()))
        raise ParameterError(
            f"According to its settings, the motor carries at most {most:.1f} N. Use less mass."
        )
    held = 0.5 * float(np.ptp(force[carrying])) if stuck else 0.0
    return float(np.mean(means)), 2.0 * float(np.ptp(means)) / len(means) + 0.25 * step + held


def strength_from_weights(carried: list[tuple[float, Track]], board: Board) -> Strength:
    """Return the strength from masses in kg with the tracks in which the handle carries them.

    With a single mass, other constant forces are assumed to be 0; two or more masses eliminate them. Raise
    ParameterError without a usable mass.
    """
    masses = np.array([mass for mass, _ in carried])
    found = [carrying_force(track, board) for _, track in carried]
    force, half = np.array([f for f, _ in found]), np.array([h for _, h in found])
    if not carried or masses.max() <= 0.0:
        raise ParameterError("A mass above 0 g is needed. Hang one on the handle, then measure.")
    weights = GRAVITY * masses
    if len(set(masses)) > 1:
        slope, error = _slope(weights, force, half)
    else:
        slope, error = float(force.mean() / weights[0]), float(half.max() / weights[0])
    return _strength(abs(slope), error, board)


def _slope(known: np.ndarray, found: np.ndarray, half: np.ndarray) -> tuple[float, float]:
    """Return the slope of ``found`` (n,) over ``known`` (n,), and the half width of its interval."""
    around = known - known.mean()
    size = float(around @ around)
    return float(around @ found) / size, float(np.sqrt((around**2) @ (half**2))) / size


HOOKED = (
    "between the handle in the middle and a post on the left of the handle, so that the spring is always "
    "stretched and touches nothing else"
)
"""Text for instructions: where the spring is hooked."""


def check_springs(springs: Iterable[float]) -> None:
    """Raise ParameterError unless spring stiffnesses in N/m are in range and differ enough."""
    found = sorted(springs)
    for stiffness in found:
        check_number(stiffness, "spring's stiffness", "N/m", low=SPRINGS[0], high=SPRINGS[1])
    if len(found) < 2 or found[-1] < SPRINGS_DIFFER * found[0]:
        raise ParameterError(
            f"Two springs are needed, one at least {SPRINGS_DIFFER:g} × as stiff as the other. "
            "The difference of the two measurements does not depend on other springs, such as the cable."
        )


def felt_stiffness(track: Track, board: Board) -> tuple[float, float]:
    """Return a spring's stiffness in N/m according to a board's settings, and the half width of its interval.

    Friction cancels between rise and fall. The first pull is excluded. Raise ParameterError if the handle did
    not move in proportion to the force.
    """
    forces = _rise_and_fall(track, motor_force(board, track.pwm))
    places = _rise_and_fall(track, track.count * board.quantum)
    usual = places.mean(axis=0)
    low, way = float(usual.min()), float(np.ptp(usual))
    if way < _FEWEST_COUNTS * board.quantum:
        raise ParameterError(
            f"The spring was stretched by only {compact(1e3 * way, 2)} mm. Use softer springs."
        )
    slides = (np.abs(usual - low - 0.5 * way) < (0.5 - _EXCLUDED_ENDS) * way).all(axis=0)
    bent = np.inf
    if slides.mean() > _SLIDING:
        force, place = (values.mean(axis=1)[:, slides] for values in (forces, places))
        slopes = np.array([np.polyfit(*pull, 1)[0] for pull in zip(force, place, strict=True)])
        slope = float(slopes.mean())
        off = (places - slope * forces)[:, :, slides]
        bent = _STEP * _curvature_rms(off) / float(np.ptp(place.mean(axis=0)))
    if bent > _BENT:
        raise ParameterError(
            "The handle did not move in proportion to the force. Is the spring slack? Does it touch "
            "something? Does the handle jam? Correct this, then pull again."
        )
    spread = stats.t.ppf(0.975, len(slopes) - 1) * slopes.std(ddof=1) / (slope * len(slopes) ** 0.5)
    return 1.0 / slope, float(np.hypot(spread, bent)) / slope


def _curvature_rms(off: np.ndarray) -> float:
    """Return the rms of the curvature that all legs (pulls, 2, n) share; other curvature is noise."""
    rest = signal.detrend(off)
    noise = rest.var(axis=0, ddof=1).mean() / len(rest)
    return float(np.sqrt(max((rest.mean(axis=0) ** 2).mean(axis=1).max() - noise, 0.0)))


def _rise_and_fall(track: Track, values: np.ndarray) -> np.ndarray:
    """Return the means (pulls, 2, means) of values (n,) over the shaking periods.

    Each pull has the means of its rise, and in reverse order the means of its fall.
    """
    edges = np.linspace(PULL_PERIOD, PULLS * PULL_PERIOD, 2 * (PULLS - 1) * _MEANS + 1)
    integral = np.append(0.0, np.cumsum(values[:-1] * np.diff(track.time)))
    means = np.diff(np.interp(edges, track.time, integral)) / (edges[1] - edges[0])
    legs = means.reshape(PULLS - 1, 2, -1)
    legs[:, 1] = legs[:, 1, ::-1].copy()
    return legs


def strength_from_springs(
    pulled: list[tuple[float, Track]],
    board: Board,
    known: float = SPRING_UNCERTAINTY,
    length: float = LENGTH_UNCERTAINTY,
) -> Strength:
    """Return the strength from springs in N/m with the tracks in which the handle pulls them.

    ``known`` and ``length`` are the relative uncertainties of the springs and of the length scale. The
    measured stiffness is (spring + other stiffness) / strength. The other stiffness, of gravity and the
    cable, is constant, so it does not change the slope. Raise ParameterError for unsuitable springs.
    """
    springs = np.array([stiffness for stiffness, _ in pulled])
    check_springs(springs)
    felt, half = np.array([felt_stiffness(track, board) for _, track in pulled]).T
    slope, error = _slope(springs, felt, np.hypot(half, known * felt))
    return _strength(slope, error, board, length)


def strength_from_scale(reading: float, track: Track, board: Board) -> Strength:
    """Return the strength from a kitchen scale's reading in kg; friction widens its interval."""
    force = motor_force(board, track.pwm)
    steady = abs(float(force[len(force) // 2 :].mean()))
    if not reading > 0.0:
        raise ParameterError(f"A reading above 0 g is needed, not {1e3 * reading:g} g.")
    return _strength(steady / (GRAVITY * reading), board.coulomb / (GRAVITY * reading), board)


def _strength(
    asked_per_real: float, error: float, board: Board, sure: float = _WEIGHT_UNCERTAINTY
) -> Strength:
    """Return the strength from commanded force per real force; raise ParameterError if it is implausible.

    ``sure`` is the relative uncertainty from all other causes.
    """
    ratio = 1.0 / asked_per_real if asked_per_real > 0.0 else np.inf
    low, high = PLAUSIBLE
    if not low <= ratio <= high:
        raise ParameterError(
            f"From this measurement, the motor is {compact(ratio, 2)} × as strong as its profile says "
            f"(allowed: {low:g} to {high:g}). "
            "Check the masses or springs, the motor's supply and the chosen kit."
        )
    half = ratio * float(np.hypot(error / asked_per_real, sure))
    return Strength(ratio, half, board.motor_constant * ratio)
