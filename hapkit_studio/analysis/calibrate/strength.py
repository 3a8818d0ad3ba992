"""The motor constant from known weights, or from what a kitchen scale reads."""

from dataclasses import dataclass

import numpy as np

from hapkit_studio.analysis.calibrate.motor_map import force_of
from hapkit_studio.devices.calibration import Track
from hapkit_studio.devices.calibration_moves import HOLD_PERIOD, Hold
from hapkit_studio.errors import ParameterError
from hapkit_studio.protocol.messages import Board

GRAVITY = 9.81
PLAUSIBLE = (0.25, 4.0)
"""How far a motor may be from its profile."""
# share of a weight that coins, the hand that let go and friction that sticks leave open
_WEIGHTS_SURE = 0.02

_AT_LIMIT = 0.5
"""Share of the time at the largest duty from which a motor gives all that it has."""


@dataclass(frozen=True)
class Strength:
    """The real force per force asked with its 95 % half width, and the motor constant in N·m."""

    ratio: float
    half: float
    motor_constant: float


def carried(track: Track, board: Board) -> tuple[float, float]:
    """Return the mean force in N by a board's settings over whole periods of a hold, and its half width.

    Up and down take as long, so that friction, which hinders both, is not in the mean. Where it sticks, the
    mean may be anywhere in what did not move the handle.
    """
    whole = int((track.time[-1] - Hold.settle) / HOLD_PERIOD + 1e-3)
    if whole < 2:
        raise ParameterError("The weight was not carried long enough. Measure it again.")
    end = Hold.settle + whole * HOLD_PERIOD
    force = force_of(board, track.pwm)
    means = [
        float(force[(track.time >= t) & (track.time < t + HOLD_PERIOD)].mean())
        for t in end - HOLD_PERIOD * np.arange(1, whole)
    ]
    step = float(np.max(np.abs(force_of(board, np.abs(track.pwm) + 1) - force_of(board, np.abs(track.pwm)))))
    carrying = (track.time >= Hold.settle) & (track.time < end)
    stuck = float(np.ptp(track.position[carrying])) < Hold.stroke
    duty = np.abs(track.pwm[carrying])
    if stuck and float(np.mean(duty == duty.max())) > _AT_LIMIT:
        most = abs(float(force[carrying].mean()))
        raise ParameterError(f"The motor carries no more than {most:.1f} N by its settings. Hang less on.")
    held = 0.5 * float(np.ptp(force[carrying])) if stuck else 0.0
    return float(np.mean(means)), 2.0 * float(np.ptp(means)) / len(means) + 0.25 * step + held


def of_weights(held: list[tuple[float, Track]], board: Board) -> Strength:
    """Return the strength from holds with masses in kg; raise ParameterError.

    One mass alone counts as if nothing else pulled; from two on, what pulls without any is not in it.
    """
    masses = np.array([mass for mass, _ in held])
    found = [carried(track, board) for _, track in held]
    force, half = np.array([f for f, _ in found]), np.array([h for _, h in found])
    if not len(held) or masses.max() <= 0.0:
        raise ParameterError("One mass above 0 g is needed. Hang one on, then measure.")
    weights = GRAVITY * masses
    if len(set(masses)) > 1:
        around = weights - weights.mean()
        slope = float(around @ force) / float(around @ around)
        error = float(np.sqrt((around**2) @ (half**2))) / float(around @ around)
    else:
        slope, error = float(force.mean() / weights[0]), float(half.max() / weights[0])
    return _strength(abs(slope), error, board)


def of_scale(reading: float, track: Track, board: Board) -> Strength:
    """Return the strength where a kitchen scale reads so many kg during a push; friction hinders it."""
    force = force_of(board, track.pwm)
    steady = abs(float(force[len(force) // 2 :].mean()))
    if not reading > 0.0:
        raise ParameterError(f"A reading above 0 g is needed, not {1e3 * reading:g} g.")
    return _strength(steady / (GRAVITY * reading), board.coulomb / (GRAVITY * reading), board)


def _strength(asked_per_real: float, error: float, board: Board) -> Strength:
    """Return the strength from force asked per real force; raise ParameterError where that cannot be."""
    ratio = 1.0 / asked_per_real if asked_per_real > 0.0 else np.inf
    low, high = PLAUSIBLE
    if not low <= ratio <= high:
        raise ParameterError(
            f"The motor would be {ratio:.2g} × as strong as its profile says (limits {low:g} to {high:g}). "
            "Check the masses, the motor's supply and the kit chosen."
        )
    half = ratio * float(np.hypot(error / asked_per_real, _WEIGHTS_SURE))
    return Strength(ratio, half, board.motor_constant * ratio)
