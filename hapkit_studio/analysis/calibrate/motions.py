"""The motions of a calibration, small and bounded. A function raises DeviceError if the board fails."""

import math
from collections.abc import Callable

from hapkit_studio.devices.board_runner import BoardRunner, Limits, Track

PULSES = (0.1, 0.2, 0.3)
"""N: the forces of the pulses; until the motor's direction is known, no force exceeds the last one."""
PULSE_SECONDS = 0.08
COAST_SECONDS = 0.25
PULSE_END = 0.002
"""m: a pulse ends after this motion."""

PULSE_LIMITS = Limits(0.3, 0.020, 1.0)
RAISE_LIMITS = Limits(1.5, 0.020, 1.0)
CARRY_LIMITS = Limits(2.5, 0.020, 0.5)
PUSH_LIMITS = Limits(1.5, 0.010, 0.5)
SWEEP_LIMITS = Limits(1.2, 0.025, 0.8)
SPRING_LIMITS = Limits(1.2, 0.025, 0.8)
PULL_LIMITS = Limits(2.0, 0.025, 0.8)
SWEEP_SECONDS = 12.0

_FADE_SECONDS = 0.5
_RISE = 0.5  # N/s: rate at which the force rises
# Amplitude in m and frequency in Hz of each sine. The sines have no short common period, so the quantisation
# errors do not repeat.
_SINES = ((0.0085, 0.83), (0.0050, 2.37), (0.0015, 4.91))


def pulse(runner: BoardRunner, force: float) -> Track:
    """Push once with a force of at most 0.3 N and record the motion."""
    done = False

    def pushing(t: float, x: float, v: float) -> float:
        nonlocal done
        done = done or t > PULSE_SECONDS or abs(x) > PULSE_END
        return 0.0 if done else force

    return runner.run(pushing, PULSE_SECONDS + COAST_SECONDS, PULSE_LIMITS)


def raise_force(runner: BoardRunner, sign: float = 1.0) -> Track:
    """Increase a force by 0.5 N/s up to 1.5 N until the handle moves 0.5 mm."""
    moved = False

    def rising(t: float, x: float, v: float) -> float:
        nonlocal moved
        moved = moved or abs(x) > 0.25 * PULSE_END
        return 0.0 if moved else sign * _RISE * t

    return runner.run(rising, RAISE_LIMITS.force / _RISE, RAISE_LIMITS, lambda: moved)


SETTLE_SECONDS, STROKE, _CREEP = 3.0, 0.006, 0.012
"""Duration in s before the slow motion; amplitude in m and speed in m/s of the slow motion."""
CARRY_PERIOD = 4.0 * STROKE / _CREEP
_CARRY_SECONDS = SETTLE_SECONDS + 3.0 * CARRY_PERIOD
_HAND_OVER_SECONDS = 1.0


def carry(runner: BoardRunner, weight: float = 0.0) -> Track:
    """Carry a weight in N that pulls to the left; after 3 s move it slowly by ± 6 mm.

    A controller holds the handle at its position, then moves it up and down so that friction acts with both
    signs. The force fades in while the user still holds the weight.
    """
    stiffness, damping, integral = 40.0, 0.8, 120.0
    before = total = 0.0

    def carrying(t: float, x: float, v: float) -> float:
        nonlocal before, total
        phase = max(t - SETTLE_SECONDS, 0.0) * _CREEP / STROKE
        error = STROKE * (1.0 - abs((phase + 1.0) % 4.0 - 2.0)) - x
        total += integral * error * (t - before)
        before = t
        return weight * min(t / _HAND_OVER_SECONDS, 1.0) + stiffness * error + total - damping * v

    return runner.run(carrying, _CARRY_SECONDS, CARRY_LIMITS)


def push(runner: BoardRunner, force: float, seconds: float, until: Callable[[], bool]) -> Track:
    """Push with a constant force in N, faded in over 0.5 s."""
    return runner.run(lambda t, x, v: force * min(t / _FADE_SECONDS, 1.0), seconds, PUSH_LIMITS, until)


PULLS, PULL_PERIOD = 6, 3.0
"""Number of pulls at a spring, and the duration of each in s."""
SHAKE_PERIOD = 0.025
"""Period in s of a shaking force that overcomes dry friction."""
_SHAKE, _STRETCH = 0.4, 0.016  # N: amplitude of the shaking force; m: largest stretch of the spring


def pull(runner: BoardRunner, stiffness: float) -> Track:
    """Pull a spring of ``stiffness`` N/m to the right, up to 16 mm or 2 N, then move back.

    A shaking force overcomes dry friction. The force never pushes to the left.
    """
    most = min(_STRETCH * stiffness, PULL_LIMITS.force - _SHAKE)

    def pulling(t: float, x: float, v: float) -> float:
        rise = 1.0 - abs(2.0 * (t / PULL_PERIOD % 1.0) - 1.0)
        shake = _SHAKE * math.sin(2.0 * math.pi * t / SHAKE_PERIOD)
        return _SHAKE + (most - _SHAKE) * rise + shake

    return runner.run(pulling, PULLS * PULL_PERIOD, PULL_LIMITS)


def sweep(runner: BoardRunner, seconds: float = SWEEP_SECONDS, friction: float = 0.1) -> Track:
    """Move the handle within ± 25 mm and with at most 1.2 N, to excite mass and friction.

    The handle follows three sines on a soft spring that stiffens towards the ends. ``friction`` is the
    friction compensation in N.
    """
    stiffness, damping, soft_travel, edge_stiffness = 30.0, 0.7, 0.017, 120.0

    def following(t: float, x: float, v: float) -> float:
        place = speed = 0.0
        for size, hertz in _SINES:
            omega = 2.0 * math.pi * hertz
            place += size * math.sin(omega * t)
            speed += size * omega * math.cos(omega * t)
        beyond = math.copysign(max(abs(x) - soft_travel, 0.0), x)
        pull = stiffness * (place - x) + damping * (speed - v) - edge_stiffness * beyond
        return min(t / _FADE_SECONDS, 1.0) * (pull + friction * math.tanh(speed / 0.02))

    return runner.run(following, seconds, SWEEP_LIMITS)


def spring(runner: BoardRunner, stiffness: float, seconds: float = 1.5) -> Track:
    """Render a spring about the handle's first position, and knock the handle with 0.4 N for 60 ms."""
    return runner.run(
        lambda t, x, v: (0.4 if 0.1 < t < 0.16 else 0.0) - stiffness * x, seconds, SPRING_LIMITS
    )
