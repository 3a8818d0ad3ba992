"""What the motor does while a kit is calibrated: pulses, holding, a gentle sweep. Small and bounded."""

import math
from collections.abc import Callable

from hapkit_studio.devices.calibration import Bench, Limits, Track

PULSES = (0.1, 0.2, 0.3)
"""N: the largest that a direction which may be wrong is tried with."""
PULSE_SECONDS = 0.08
COAST_SECONDS = 0.25
FAR = 0.002
"""m after which a pulse has said what it had to say."""

PULSE_LIMITS = Limits(0.3, 0.020, 1.0)
SEARCH_LIMITS = Limits(1.5, 0.020, 1.0)
HOLD_LIMITS = Limits(2.5, 0.020, 0.5)
PUSH_LIMITS = Limits(1.5, 0.010, 0.5)
SWEEP_LIMITS = Limits(1.2, 0.025, 0.8)
SPRING_LIMITS = Limits(1.2, 0.025, 0.8)
SWEEP_SECONDS = 12.0

_SOFT = 0.5
# m, Hz: no small common period, so that the sensor's steps fall otherwise each time
_SINES = ((0.0085, 0.83), (0.0050, 2.37), (0.0015, 4.91))


class _Pulse:
    """A short constant force that ends early once the handle has moved."""

    def __init__(self, force: float):
        self._force, self._start, self._done = force, math.nan, False

    def __call__(self, t: float, x: float, v: float) -> float:
        if math.isnan(self._start):
            self._start = x
        self._done = self._done or t > PULSE_SECONDS or abs(x - self._start) > FAR
        return 0.0 if self._done else self._force


def pulse(bench: Bench, force: float) -> Track:
    """Push once with a force in N, at most 0.3 N, and see what the handle does; raise DeviceError."""
    return bench.run(_Pulse(force), PULSE_SECONDS + COAST_SECONDS, PULSE_LIMITS)


def search(bench: Bench, sign: float = 1.0, rate: float = 0.5) -> Track:
    """Raise a force by rate in N/s up to 1.5 N until the handle moves 0.5 mm; raise DeviceError."""
    start = [math.nan]
    moved = [False]

    def rising(t: float, x: float, v: float) -> float:
        start[0] = x if math.isnan(start[0]) else start[0]
        moved[0] = moved[0] or abs(x - start[0]) > 0.25 * FAR
        return 0.0 if moved[0] else sign * rate * t

    return bench.run(rising, SEARCH_LIMITS.force / rate, SEARCH_LIMITS, lambda: moved[0])


class Hold:
    """Carries the handle where it was, then moves it slowly up and down: friction shows with both signs.

    weight: N that are expected to pull to the left; they fade in while a person still holds.
    """

    stiffness, damping, integral = 40.0, 0.8, 120.0
    taken_over, settle, stroke, speed = 1.0, 3.0, 0.006, 0.012

    def __init__(self, weight: float = 0.0):
        self._start, self._before, self._sum, self._weight = math.nan, 0.0, 0.0, weight

    def target(self, t: float) -> float:
        """Return how far from its start the handle shall be after t s, in m."""
        phase = max(t - self.settle, 0.0) * self.speed / self.stroke
        return self.stroke * (1.0 - abs((phase + 1.0) % 4.0 - 2.0))

    def __call__(self, t: float, x: float, v: float) -> float:
        if math.isnan(self._start):
            self._start = x
        error = self._start + self.target(t) - x
        self._sum += self.integral * error * (t - self._before)
        self._before = t
        expected = self._weight * min(t / self.taken_over, 1.0)
        return expected + self.stiffness * error + self._sum - self.damping * v


HOLD_PERIOD = 4.0 * Hold.stroke / Hold.speed
HOLD_SECONDS = Hold.settle + 3.0 * HOLD_PERIOD


def hold(bench: Bench, weight: float = 0.0, seconds: float = HOLD_SECONDS) -> Track:
    """Carry a weight in N that pulls to the left, creeping ± 6 mm after 3 s; raise DeviceError."""
    return bench.run(Hold(weight), seconds, HOLD_LIMITS)


def push(bench: Bench, force: float, seconds: float, until: Callable[[], bool]) -> Track:
    """Push against something with a constant force in N, faded in over 0.5 s; raise DeviceError."""
    return bench.run(lambda t, x, v: force * min(t / _SOFT, 1.0), seconds, PUSH_LIMITS, until)


class _Sweep:
    """Follows three sines on a soft spring that stiffens far out; helped: dry friction in N, pushed along."""

    stiffness, damping, room, edge = 30.0, 0.7, 0.017, 120.0

    def __init__(self, helped: float):
        self._helped, self._start = helped, math.nan

    def __call__(self, t: float, x: float, v: float) -> float:
        if math.isnan(self._start):
            self._start = x
        soft = min(t / _SOFT, 1.0)
        place = speed = 0.0
        for size, hertz in _SINES:
            turn = 2.0 * math.pi * hertz
            place += size * math.sin(turn * t)
            speed += size * turn * math.cos(turn * t)
        along = self._helped * math.tanh(speed / 0.02)
        away = x - self._start
        beyond = math.copysign(max(abs(away) - self.room, 0.0), away)
        pull = self.stiffness * (place - away) + self.damping * (speed - v) - self.edge * beyond
        return soft * (pull + along)


def sweep(bench: Bench, seconds: float = SWEEP_SECONDS, helped: float = 0.1) -> Track:
    """Move the handle by itself, within ± 25 mm and 1.2 N, so that mass and friction show."""
    return bench.run(_Sweep(helped), seconds, SWEEP_LIMITS)


def spring(bench: Bench, stiffness: float, seconds: float = 1.5) -> Track:
    """Render a spring about where the handle is, after a knock of 0.4 N for 60 ms; raise DeviceError."""
    start = [math.nan]

    def pull(t: float, x: float, v: float) -> float:
        start[0] = x if math.isnan(start[0]) else start[0]
        return -stiffness * (x - start[0]) + (0.4 if 0.1 < t < 0.16 else 0.0)

    return bench.run(pull, seconds, SPRING_LIMITS)
