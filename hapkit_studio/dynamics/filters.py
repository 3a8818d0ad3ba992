"""The compiled part of the velocity estimators: one measured position in, one velocity out.

Coefficients come from ``filter_design``; what a method keeps from sample to sample is its memory.
"""

from hapkit_studio.dynamics import foaw
from hapkit_studio.dynamics.jit import compiled, internal

MEMORY = 48
COEFFICIENTS = 8
DIFFERENCE, IIR, BUTTERWORTH, FOAW, KALMAN = range(5)

_POSITION, _VELOCITY, _RAW, _OLDER_RAW, _OLDER, _ESTIMATE, _WINDOW = range(7)


@compiled
def reset(memory, position):
    """Start as if the handle had rested at `position`."""
    resume(memory, position, 0.0)


@compiled
def resume(memory, position, velocity):
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
def step(code, coefs, memory, position, period):
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
        if not foaw.begun(window):
            foaw.begin(window, memory[_POSITION], memory[_VELOCITY], period)
        foaw.push(window, position, period)
        velocity = foaw.slope(window, int(coefs[0]), coefs[1])
    memory[_POSITION] = position
    memory[_VELOCITY] = velocity
    return velocity
