"""Where the sampled loop's roots cross the unit circle: the exact limits of stiffness and damping.

The loop: exact paddle, force held between samples and delayed by any time, u = -(K x + B v^) with the linear
velocity estimate v^ = H(z) x, a hand as a spring and damper to the ground with its mass added. No quantum,
no Coulomb friction, no clamp. The limits are where the characteristic equation 1 + (K + B H) P = 0 has a root
on the unit circle: where K = -1/P - B H is real on z = e^jw, the lowest such K > 0.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from hapkit_studio.dynamics.estimators import USUAL_QUANTUM, Spec, design, parse
from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.dynamics.paddle import transition
from hapkit_studio.errors import ParameterError

_SLOWEST = 1e-7
_HALVINGS = 50
# Dampings looked at together: enough to hide Python's own time, few enough for the processor's cache.
_TOGETHER = 32

# Angles w per sample (m,), and for each of them its column: complex values (m,).
Curve = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Loop:
    """One sampled loop: the handle, the hand on it, and what the loop adds.

    quantum in m: the sensor's, which the estimator is designed for; the positions themselves are exact.
    """

    handle_mass: float
    handle_viscous: float
    hand: Grip
    damping: float
    rate: float
    delay: float
    estimator: Spec
    quantum: float = USUAL_QUANTUM

    def __hash__(self) -> int:
        """Return the hash of the numbers; the estimator's options are a dictionary, which has none."""
        return hash((self.mass, self.viscous, self.damping, self.rate, self.delay, self.quantum))

    @property
    def mass(self) -> float:
        return self.handle_mass + self.hand.mass

    @property
    def viscous(self) -> float:
        return self.handle_viscous + self.hand.damping


def _inverse_plant(loop: Loop, w: np.ndarray) -> np.ndarray:
    """Return 1 / P(e^jw): command to sampled position, hold and delay included.

    Written in z - 1, without differences of nearly equal numbers, so that slow crossings keep their digits.
    """
    m, c, k = loop.mass, loop.viscous, loop.hand.stiffness
    period = 1.0 / loop.rate
    whole_periods = math.floor(loop.delay * loop.rate + 1e-9)
    fraction = max(loop.delay - whole_periods * period, 0.0)
    g0, g1 = transition(m, c, k, period)[4:7:2]
    a, b, c_, d, new0, _, new1, _ = transition(m, c, k, period - fraction)
    first0, first1 = transition(m, c, k, fraction)[4:7:2]
    old0, old1 = a * first0 + b * first1, c_ * first0 + d * first1
    z = np.exp(1j * w)
    step = -2.0 * np.sin(0.5 * w) ** 2 + 1j * np.sin(w)
    slow = step + c * g1 + k * g0
    poles = (step + k * g0) * slow + m * k * g1 * g1
    zeros = slow * (new0 * z + old0) + m * g1 * (new1 * z + old1)
    return np.exp(1j * w * (whole_periods + 1)) * poles / zeros


def _frequencies(loop: Loop) -> np.ndarray:
    """Return rad/sample from nearly 0 to pi, dense enough for every turn the delay puts into the phase.

    Without delay or hand the crossing lies near sqrt(2 b T / m), so the sweep starts well below that.
    """
    turns = loop.delay * loop.rate + 2.0
    slowest = min(_SLOWEST, 0.1 * math.sqrt(loop.viscous / (loop.mass * loop.rate))) or _SLOWEST
    even = np.linspace(0.0, math.pi, int(1000 + 24 * turns))[1:]
    return np.union1d(np.geomspace(slowest, 1.0, 600), even)


def _lowest_crossings(curve: Curve, w: np.ndarray, columns: int) -> np.ndarray:
    """Return the smallest positive real value (columns,) of each complex curve on [w[0], pi]; inf if none."""
    values = curve(w, np.arange(columns)[:, np.newaxis])
    negative = np.signbit(values.imag)
    column, place = np.nonzero(negative[:, :-1] != negative[:, 1:])
    low, high, below = w[place], w[place + 1], negative[column, place]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        left = np.signbit(curve(middle, column).imag) == below
        low, high = np.where(left, middle, low), np.where(left, high, middle)
    real = curve(0.5 * (low + high), column).real
    lowest = np.where(values.real[:, -1] > 0.0, values.real[:, -1], math.inf)
    np.minimum.at(lowest, column[real > 0.0], real[real > 0.0])
    return lowest


def _velocity_of(loop: Loop) -> Callable[[np.ndarray], np.ndarray]:
    """Return the estimator's response at angles w per sample; raise ParameterError if it is not linear."""
    coefs = design(loop.estimator, loop.rate, loop.quantum)[1]
    method = parse(loop.estimator)[0]
    response = method.response
    if response is None:
        raise ParameterError(
            f"The estimator {method.key} is not linear, it has no exact stiffness limit: "
            "measured_stiffness_limit finds it by simulation."
        )
    return lambda w: response(coefs, 1.0 / loop.rate, np.exp(1j * w))


@lru_cache(maxsize=64)
def damping_limit(loop: Loop) -> float:
    """Return the largest stable virtual damping in N·s/m without stiffness, inf where all is.

    Raise ParameterError for an estimator that is not linear.
    """
    velocity = _velocity_of(loop)

    def curve(w: np.ndarray, column: np.ndarray) -> np.ndarray:
        return np.broadcast_to(-_inverse_plant(loop, w) / velocity(w), np.broadcast(w, column).shape)

    return float(_lowest_crossings(curve, _frequencies(loop), 1)[0])


def stiffness_limits(loop: Loop, damping: np.ndarray) -> np.ndarray:
    """Return the largest stable stiffness (n,) in N/m for each virtual damping (n,) in N·s/m.

    K = -1/P - B H on the unit circle, one column a damping; the loop's own damping does not count. 0 where
    the damping alone is unstable. Raise ParameterError.
    """
    velocity, limits = _velocity_of(loop), np.zeros(len(damping))
    inside = np.flatnonzero((damping + loop.viscous > 0.0) & (damping < damping_limit(loop)))
    for start in range(0, len(inside), _TOGETHER):
        part = inside[start : start + _TOGETHER]

        def curve(w: np.ndarray, column: np.ndarray, virtual: np.ndarray = damping[part]) -> np.ndarray:
            return -_inverse_plant(loop, w) - virtual[column] * velocity(w)

        limits[part] = _lowest_crossings(curve, _frequencies(loop), len(part))
    return limits


@lru_cache(maxsize=64)
def stiffness_limit(loop: Loop) -> float:
    """Return the largest stable stiffness in N/m at the loop's own damping; raise ParameterError."""
    return float(stiffness_limits(loop, np.array([loop.damping]))[0])


def growing_amplitude(stiffness: float, limit: float, mass: float, coulomb: float, late: float) -> float:
    """Return the smallest amplitude in m that grows on a spring of N/m, given its limit; inf where none does.

    Energy balance of one cycle, the exact limit standing for all that is linear: friction of so many N takes
    4 f A, a force that is late s late on the mean gives π ω A² (K - K_limit) late.
    """
    if not stiffness > limit:
        return math.inf
    return 4.0 * coulomb / (math.pi * math.sqrt(stiffness / mass) * (stiffness - limit) * late)
