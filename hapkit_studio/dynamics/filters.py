"""The compiled part of the velocity estimators: one measured position in, one velocity out.

Coefficients come from ``filter_design``; what a method keeps from sample to sample is its memory.

First-order adaptive windowing takes the longest line that fits the newest samples (Janabi-Sharifi, Hayward
and Chen, IEEE Trans. Control Systems Technology 8(6), 2000, the best-fit variant): a line of least squares
as long as no sample lies farther from it than the sensor's noise. It is long and smooth when slow, short and
quick at an impact. Samples carry their age, so that a late one tilts no line.
"""

import numpy as np

from hapkit_studio.dynamics.jit import compiled, internal

LONGEST = 16  # periods in the window of adaptive windowing
# A sample of a quantised motion often lies just at the tolerance: it does not fit, whatever rounding says.
_TIE = 1.0 - 1e-9
_BEGUN, _SAMPLES, _AGES = 0, 1, 2 + LONGEST


@internal
def begun(memory: np.ndarray) -> bool:
    """Return whether the window holds samples."""
    return memory[_BEGUN] != 0.0


@internal
def begin(memory: np.ndarray, position: float, velocity: float, period: float) -> None:
    """Fill the window with a steady motion that has just arrived at `position`."""
    memory[_BEGUN] = 1.0
    for i in range(LONGEST + 1):
        memory[_AGES + i] = i * period
        memory[_SAMPLES + i] = position - i * period * velocity


@internal
def push(memory: np.ndarray, position: float, period: float) -> None:
    """Take a new sample, `period` s after the last; the oldest one drops out."""
    for i in range(LONGEST, 0, -1):
        memory[_AGES + i] = memory[_AGES + i - 1] + period
        memory[_SAMPLES + i] = memory[_SAMPLES + i - 1]
    memory[_AGES] = 0.0
    memory[_SAMPLES] = position


@internal
def _fits(memory, count, mean_age, mean, falling, tolerance):
    """Return whether `count` samples lie on a line to within the tolerance."""
    newest = memory[_SAMPLES]
    for i in range(count):
        line = mean + falling * (memory[_AGES + i] - mean_age)
        if abs(memory[_SAMPLES + i] - newest - line) > _TIE * tolerance:
            return False
    return True


@internal
def slope(memory: np.ndarray, window: int, tolerance: float) -> float:
    """Return the velocity of the longest line, over up to `window` periods, that fits all its samples."""
    newest = memory[_SAMPLES]
    ages, moved, squares, products = 0.0, 0.0, 0.0, 0.0
    velocity = 0.0
    for n in range(1, window + 1):
        age, way = memory[_AGES + n], memory[_SAMPLES + n] - newest
        ages += age
        moved += way
        squares += age * age
        products += age * way
        count = n + 1
        falling = (count * products - ages * moved) / (count * squares - ages * ages)
        if n > 1 and not _fits(memory, count, ages / count, moved / count, falling, tolerance):
            break
        velocity = -falling
    return velocity


MEMORY = 48
COEFFICIENTS = 8
DIFFERENCE, IIR, BUTTERWORTH, FOAW, KALMAN = range(5)

_POSITION, _VELOCITY, _RAW, _OLDER_RAW, _OLDER, _ESTIMATE, _WINDOW = range(7)


@compiled
def reset(memory: np.ndarray, position: float) -> None:
    """Start as if the handle had rested at `position`."""
    resume(memory, position, 0.0)


@compiled
def resume(memory: np.ndarray, position: float, velocity: float) -> None:
    """Start as if the handle had come to `position` at a steady `velocity`: a new method makes no jump."""
    memory[:] = 0.0
    memory[_POSITION] = position
    memory[_VELOCITY] = velocity
    memory[_RAW] = velocity
    memory[_OLDER_RAW] = velocity
    memory[_OLDER] = velocity
    memory[_ESTIMATE] = position


@internal
def _butterworth(coefs, memory, raw):
    """Return the raw velocity through two poles; coefs are b0, a1, a2."""
    before = memory[_VELOCITY]
    velocity = coefs[0] * (raw + 2.0 * memory[_RAW] + memory[_OLDER_RAW])
    velocity -= coefs[1] * before + coefs[2] * memory[_OLDER]
    memory[_OLDER_RAW] = memory[_RAW]
    memory[_RAW] = raw
    memory[_OLDER] = before
    return velocity


@internal
def _kalman(coefs, memory, position, period):
    """Return the velocity after a constant-velocity guess is corrected; coefs are alpha, beta."""
    velocity = memory[_VELOCITY]
    guess = memory[_ESTIMATE] + period * velocity
    surprise = position - guess
    memory[_ESTIMATE] = guess + coefs[0] * surprise
    return velocity + coefs[1] * surprise / period


@compiled
def step(code: int, coefs: np.ndarray, memory: np.ndarray, position: float, period: float) -> float:
    """Take one measured position, `period` s after the last; return the velocity estimate in m/s."""
    velocity = (position - memory[_POSITION]) / period
    if code == IIR:
        velocity = memory[_VELOCITY] + coefs[0] * (velocity - memory[_VELOCITY])
    elif code == BUTTERWORTH:
        velocity = _butterworth(coefs, memory, velocity)
    elif code == KALMAN:
        velocity = _kalman(coefs, memory, position, period)
    elif code == FOAW:
        window = memory[_WINDOW:]
        if not begun(window):
            begin(window, memory[_POSITION], memory[_VELOCITY], period)
        push(window, position, period)
        velocity = slope(window, int(coefs[0]), coefs[1])
    memory[_POSITION] = position
    memory[_VELOCITY] = velocity
    return velocity
