"""The simulated Hapkit: a paddle computed exactly between samples, a command delay, and a hand.

The terms of the model have names, so that a scene can omit the terms that it does not need. The compiled
functions work on the two flat arrays of ``new_state``, which belong to the real-time loop.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hapkit_studio.devices import DeviceEntry, DeviceKind
from hapkit_studio.devices.base import SIMULATED, Device
from hapkit_studio.dynamics import nominal, paddle
from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import check_number

END_STOPS = 0.055  # m on either side: travel of the paddle in the window
# kg: the handle's mass if only the hand has a mass; it is not 0, because the equations divide by the mass
NO_MASS = 1e-13


@dataclass(frozen=True)
class Term:
    """A term of the model: key, label, field of the device, and the value that switches the term off.

    ``field`` is "" if the term belongs to the loop.
    """

    key: str
    word: str
    field: str = ""
    off: float = 0.0


TERMS: dict[str, Term] = {
    t.key: t
    for t in (
        Term("mass", "mass", "mass", NO_MASS),
        Term("viscous", "damping", "damping"),
        Term("coulomb", "friction", "coulomb_force"),
        Term("quantization", "sensor steps", "quantum"),
        Term("sampling", "sampling"),
        Term("delay", "delay"),
        Term("saturation", "force limit", "max_force", math.inf),
        Term("filter", "velocity estimate"),
    )
}
# Terms that a live loop may omit. The others are required: a released handle needs its mass, plots and
# velocity filters need sensor steps, and safety needs the force limit. Sampling, delay and filter are the
# user's settings.
OPTIONAL = ("viscous", "coulomb")
MODELLED = ("mass", *OPTIONAL, "quantization")


def term(key: str) -> Term:
    """Return a term by its key; raise ParameterError for an unknown key."""
    if key not in TERMS:
        raise ParameterError(f"A modelled device property must be one of {', '.join(TERMS)}, not {key!r}.")
    return TERMS[key]


X, V, HAND_FORCE, EFFECT, _STOP = 0, 1, 2, 13, 14
_MASS, _DAMPING, _COULOMB, _HAND_DAMPING, _HAND_STIFFNESS = 3, 4, 5, 6, 7
_PERIOD, _DELAY, _WHOLE, _REST, _SAMPLE = 8, 9, 10, 11, 12
_EARLY_MAP, _LATE_MAP = 16, 24
_WIDTH = 64
# smaller numbers are set to 0, because denormals slow processors down by a factor of ten
_FLUSH_BELOW = 1e-150


@dataclass(frozen=True)
class SimulatedHapkit(Device):
    """A paddle with mass kg, damping N·s/m, Coulomb friction N, sensor quantum m and force limit N.

    quantum=0 means an ideal sensor, and max_force=inf no limit. The paddle stops without bouncing at
    ``end_stops`` m on either side. Raise ParameterError for impossible values.
    """

    mass: float = nominal.MASS
    damping: float = nominal.VISCOUS
    coulomb_force: float = nominal.COULOMB_FORCE
    quantum: float = nominal.QUANTUM
    max_force: float = nominal.MAX_FORCE
    initial_position: float = 0.0
    initial_velocity: float = 0.0
    end_stops: float = math.inf

    title = "Simulated Hapkit"
    driver = SIMULATED
    motor = measures_delay = False
    simulated_hand = True

    def __post_init__(self) -> None:
        check_number(self.mass, "device's mass", "kg", above=True)
        check_number(self.damping, "device's damping", "N·s/m")
        check_number(self.coulomb_force, "device's Coulomb friction", "N")
        check_number(self.quantum, "device's sensor quantum", "m")
        check_number(self.max_force, "device's force limit", "N", above=True, endless=True)
        check_number(self.initial_position, "device's initial position", "m", low=-math.inf)
        check_number(self.initial_velocity, "device's initial velocity", "m/s", low=-math.inf)
        check_number(self.end_stops, "device's end stops", "m", above=True, endless=True)

    @property
    def model(self) -> "SimulatedHapkit":
        return self

    @property
    def viscous(self) -> float:  # type: ignore[override]
        """Return the paddle's damping in N·s/m."""
        return self.damping

    def without(self, terms: Iterable[str]) -> "SimulatedHapkit":
        """Return this device without the named terms; raise ParameterError for an unknown term."""
        gone = [term(key) for key in terms]
        return replace(self, **{t.field: t.off for t in gone if t.field})

    def reduced(self, needs: Iterable[str]) -> "SimulatedHapkit":
        """Return the device that a scene needs: damping and friction are kept only if ``needs`` lists them.

        Other terms stay. A scene without a list gets all terms. Raise ParameterError for an unknown term.
        """
        needed = {term(key).key for key in needs}
        return self.without(key for key in OPTIONAL if key not in needed) if needed else self


def new_state(
    position: float = 0.0, velocity: float = 0.0, periods: int = 1022, end_stops: float = math.inf
) -> tuple:
    """Return the initial state (dev, queue) with the motor off, for delays of up to ``periods`` periods."""
    dev = np.zeros(_WIDTH)
    dev[X], dev[V], dev[_STOP] = position, velocity, end_stops
    size = 1 << (max(int(periods), 1) + 1).bit_length()
    # the second half is a buffer in which pending commands are retimed without allocation
    return dev, np.zeros(2 * size)


@compiled
def quantise(position: float, quantum: float) -> float:
    """Return the reading of a sensor with steps of ``quantum`` m; 0 means an ideal sensor."""
    return quantum * math.floor(position / quantum) if quantum > 0.0 else position


@compiled
def configure(
    dev: np.ndarray,
    queue: np.ndarray,
    mass: float,
    viscous: float,
    coulomb: float,
    hand_mass: float,
    hand_damping: float,
    hand_stiffness: float,
    period: float,
    delay: float,
) -> None:
    """Set new constants; motion and pending commands are kept. Without a hand, the hand's constants are 0.

    ``delay`` is any time in s from a sample to its force; the queue's size limits it.
    """
    delay = min(max(delay, 0.0), (queue.size // 2 - 2) * period)
    if dev[_PERIOD] > 0.0 and (period != dev[_PERIOD] or delay != dev[_DELAY]):
        _retime(dev, queue, period, delay)
    whole = math.floor(delay / period + 1e-9)
    rest = delay - whole * period
    if rest < 1e-9 * period:
        rest = 0.0
    dev[_MASS], dev[_DAMPING], dev[_COULOMB] = mass + hand_mass, viscous + hand_damping, coulomb
    dev[_HAND_DAMPING], dev[_HAND_STIFFNESS] = hand_damping, hand_stiffness
    dev[_PERIOD], dev[_DELAY], dev[_WHOLE], dev[_REST] = period, delay, whole, rest
    _store(dev, _EARLY_MAP, paddle.transition(dev[_MASS], dev[_DAMPING], hand_stiffness, rest))
    _store(dev, _LATE_MAP, paddle.transition(dev[_MASS], dev[_DAMPING], hand_stiffness, period - rest))
    if hand_damping == 0.0 and hand_stiffness == 0.0:
        dev[HAND_FORCE] = 0.0


@internal
def _store(dev, at, m):
    for i in range(8):
        dev[at + i] = m[i]


@internal
def _retime(dev, queue, period, delay):
    """Keep the times of the pending forces, to within a period, when period or delay changes."""
    size = queue.size // 2
    now = int(dev[_SAMPLE])
    pending = int(delay / period) + 2
    for i in range(1, min(pending, size - 1) + 1):
        middle = max(delay - (i - 0.5) * period, 0.0)
        ago = -math.floor((middle - dev[_DELAY]) / dev[_PERIOD])
        queue[size + i] = queue[(now - int(min(max(ago, 0), size - 1))) & (size - 1)]
    for i in range(1, min(pending, size - 1) + 1):
        queue[(now - i) & (size - 1)] = queue[size + i]


@compiled
def command(dev: np.ndarray, queue: np.ndarray, force: float) -> None:
    """Issue a force in N at the current sample; it takes effect one delay later."""
    queue[int(dev[_SAMPLE]) & (queue.size // 2 - 1)] = force


@internal
def _map(dev, at):
    return dev[at], dev[at + 1], dev[at + 2], dev[at + 3], dev[at + 4], dev[at + 5], dev[at + 6], dev[at + 7]


@internal
def _stopped(motion, stop):
    """Return (x, v) limited by end stops at ± stop m; an impact is fully inelastic."""
    x, v = motion
    if abs(x) > stop:
        return math.copysign(stop, x), 0.0
    return x, v


@compiled
def advance(dev: np.ndarray, queue: np.ndarray, target0: float, target1: float) -> None:
    """Move to the next sample while the hand's target moves linearly from target0 to target1 in m.

    Without a new ``command``, the last force continues to act. dev[EFFECT] is the mean motor force over the
    period.
    """
    x, v, mass, damping, coulomb = dev[X], dev[V], dev[_MASS], dev[_DAMPING], dev[_COULOMB]
    grip, stiffness = dev[_HAND_DAMPING], dev[_HAND_STIFFNESS]
    early, late = _map(dev, _EARLY_MAP), _map(dev, _LATE_MAP)
    period, rest = dev[_PERIOD], dev[_REST]
    mask = queue.size // 2 - 1
    sample = int(dev[_SAMPLE])
    newest = sample - int(dev[_WHOLE])
    old, new = queue[(newest - 1) & mask], queue[newest & mask]
    queue[(sample + 1) & mask] = queue[sample & mask]
    dev[_SAMPLE] = sample + 1
    gripped = stiffness != 0.0 or grip != 0.0
    target_rate = (target1 - target0) / period if gripped else 0.0
    pull = stiffness * target0 + grip * target_rate if gripped else 0.0
    rate = stiffness * target_rate
    dev[EFFECT] = new + (old - new) * rest / period
    if rest > 0.0:
        motion = paddle.advance(x, v, old + pull, rate, coulomb, mass, damping, stiffness, rest, early)
        x, v = _stopped(motion, dev[_STOP])
    pull += rate * rest
    motion = paddle.advance(x, v, new + pull, rate, coulomb, mass, damping, stiffness, period - rest, late)
    x, v = _stopped(motion, dev[_STOP])
    if abs(x) + abs(v) < _FLUSH_BELOW:
        x, v = 0.0, 0.0
    dev[X], dev[V] = x, v
    if gripped:
        dev[HAND_FORCE] = stiffness * (target1 - x) + grip * (target_rate - v)


_WITH_STOPS = DeviceEntry("simulated", SimulatedHapkit.title, partial(SimulatedHapkit, end_stops=END_STOPS))
DEVICE = DeviceKind(0, lambda: [_WITH_STOPS])
