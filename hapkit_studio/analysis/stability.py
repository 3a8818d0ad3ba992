"""The stiffest virtual spring that stays stable: exact from the sampled loop, and measured by simulation.

The loop: exact paddle, force held between samples and delayed by any time, u = -(K x + B v^) with the linear
velocity estimate v^ = H(z) x, a hand as a spring and damper to the ground with its mass added. No quantum,
no Coulomb friction, no clamp. The limits are where the characteristic equation 1 + (K + B H) P = 0 has a root
on the unit circle.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hapkit_studio import environments
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import Spec, design, parse
from hapkit_studio.dynamics.filter_design import USUAL_QUANTUM
from hapkit_studio.dynamics.hand import GRIPS, Grip, Hand, hand_named
from hapkit_studio.dynamics.paddle import transition
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings_writer import LoopSettings

_SLOWEST = 1e-7
_HALVINGS = 50

_RELEASED_AT = 1e-6
_RELEASED_FAR = 1e-3
_SMALL = 5.0 * USUAL_QUANTUM
_DYING = 0.9
_LOST_AT = 1.0
_SECONDS = 12.0
_TURNS = 80.0
_SAMPLES = 12_000
_MOST_SAMPLES = 5_000_000
_SOFTEST, _STIFFEST = 1e-3, 1e9
_PRECISION = 1e-4

Curve = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class _Loop:
    """One sampled loop: the handle, the hand on it, and what the loop adds."""

    handle_mass: float
    handle_viscous: float
    hand: Grip
    damping: float
    rate: float
    delay: float
    estimator: Spec

    @property
    def mass(self) -> float:
        return self.handle_mass + self.hand.mass

    @property
    def viscous(self) -> float:
        return self.handle_viscous + self.hand.damping


def _loop(
    mass: float,
    viscous: float,
    damping: float,
    rate: float,
    delay: float,
    estimator: Spec,
    hand: Hand | Grip | str | None,
) -> _Loop:
    """Return the checked loop with the hand's terms added; raise ParameterError."""
    for name, value, unit, above in (
        ("mass", mass, "kg", True),
        ("viscous damping", viscous, "N·s/m", False),
        ("virtual damping", damping, "N·s/m", False),
        ("rate", rate, "Hz", True),
        ("delay", delay, "s", False),
    ):
        if not isinstance(value, int | float | np.number):
            raise ParameterError(f"The {name} takes a number in {unit}, not {value!r}.")
        if not math.isfinite(value) or value < 0.0 or (above and value == 0.0):
            bound = "more than 0" if above else "0 or more"
            raise ParameterError(f"The {name} must be {bound} {unit}, not {value:g} {unit}.")
    if isinstance(hand, str):
        hand = GRIPS[hand] if hand in GRIPS else hand_named(hand)
    if hand is not None and not isinstance(hand, Hand | Grip):
        raise ParameterError(f"hand takes a Hand, a Grip, a name or None, not {hand!r}.")
    held = Grip(hand.mass, hand.damping, hand.stiffness) if hand else Grip(0.0, 0.0, 0.0)
    return _Loop(mass, viscous, held, damping, rate, delay, estimator)


def _inverse_plant(loop: _Loop, w: np.ndarray) -> np.ndarray:
    """Return 1 / P(e^jw): command to sampled position, hold and delay included.

    Written in z - 1, without differences of nearly equal numbers, so that slow crossings keep their digits.
    """
    m, c, k = loop.mass, loop.viscous, loop.hand.stiffness
    period = 1.0 / loop.rate
    whole = math.floor(loop.delay * loop.rate + 1e-9)
    rest = max(loop.delay - whole * period, 0.0)
    g0, g1 = transition(m, c, k, period)[4:7:2]
    a, b, c_, d, new0, _, new1, _ = transition(m, c, k, period - rest)
    first0, first1 = transition(m, c, k, rest)[4:7:2]
    old0, old1 = a * first0 + b * first1, c_ * first0 + d * first1
    z = np.exp(1j * w)
    step = -2.0 * np.sin(0.5 * w) ** 2 + 1j * np.sin(w)
    slow = step + c * g1 + k * g0
    poles = (step + k * g0) * slow + m * k * g1 * g1
    zeros = slow * (new0 * z + old0) + m * g1 * (new1 * z + old1)
    return np.exp(1j * w * (whole + 1)) * poles / zeros


def _frequencies(loop: _Loop) -> np.ndarray:
    """Return rad/sample from nearly 0 to pi, dense enough for every turn the delay puts into the phase.

    Without delay or hand the crossing lies near sqrt(2 b T / m), so the sweep starts well below that.
    """
    turns = loop.delay * loop.rate + 2.0
    slowest = min(_SLOWEST, 0.1 * math.sqrt(loop.viscous / (loop.mass * loop.rate))) or _SLOWEST
    even = np.linspace(0.0, math.pi, int(1000 + 24 * turns))[1:]
    return np.union1d(np.geomspace(slowest, 1.0, 600), even)


def _lowest_crossing(curve: Curve, w: np.ndarray) -> float:
    """Return the smallest positive real value that a complex curve takes on [w[0], pi]; inf if none."""
    values = curve(w)
    change = np.flatnonzero(np.signbit(values.imag[:-1]) != np.signbit(values.imag[1:]))
    low, high = w[change], w[change + 1]
    below = np.signbit(values.imag[change])
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        left = np.signbit(curve(middle).imag) == below
        low, high = np.where(left, middle, low), np.where(left, high, middle)
    real = np.append(curve(0.5 * (low + high)).real, values.real[-1])
    return float(np.min(real[real > 0.0], initial=math.inf))


def stiffness_limit(
    mass: float,
    viscous: float,
    *,
    damping: float = 0.0,
    rate: float = 1000.0,
    delay: float = 0.0,
    estimator: Spec = "difference",
    hand: Hand | Grip | str | None = None,
) -> float:
    """Return the largest stable virtual stiffness in N/m, exact; 0 if the damping alone is unstable.

    mass kg, viscous and virtual damping N·s/m, rate Hz, delay s; hand: a Hand, a Grip, a name, or None for a
    released handle. Where K = -1/P - B H is real on z = e^jw, a root crosses: the lowest such K > 0.
    Raise ParameterError.
    """
    loop = _loop(mass, viscous, damping, rate, delay, estimator, hand)
    if loop.viscous + loop.damping == 0.0:
        return 0.0
    coefs = design(estimator, rate)[1]
    response = parse(estimator)[0].response
    if response is None:
        raise ParameterError(
            f"The estimator {parse(estimator)[0].key} is not linear, it has no exact stiffness limit: "
            "measured_stiffness_limit finds it by simulation."
        )

    def velocity(w: np.ndarray) -> np.ndarray:
        return response(coefs, 1.0 / rate, np.exp(1j * w))

    w = _frequencies(loop)
    if damping > 0.0 and damping >= _lowest_crossing(lambda w: -_inverse_plant(loop, w) / velocity(w), w):
        return 0.0
    return _lowest_crossing(lambda w: -_inverse_plant(loop, w) - damping * velocity(w), w)


def _settles(loop: _Loop, stiffness: float) -> bool:
    """Return whether the handle, let go 1 µm away, moves less in the run's last third than in the one before.

    Compares a^2 + (w v)^2: steady along a spring's own oscillation, and large where a fast one grows beside a
    slow creep home.
    """
    out = _released(loop, stiffness, _RELEASED_AT)
    if not np.abs(out[:, rows.TRUE_POSITION]).max() < _LOST_AT:
        return False
    third = len(out) // 3
    slowest = math.sqrt((stiffness + loop.hand.stiffness) / loop.mass)
    speed = out[:, rows.TRUE_VELOCITY]
    size = np.hypot(np.diff(speed) * loop.rate, slowest * speed[1:])
    before, after = np.linalg.norm(size[third : 2 * third]), np.linalg.norm(size[2 * third :])
    return bool(after < before or before == 0.0)


def _stays_small(loop: _Loop, stiffness: float) -> bool:
    """Return whether the handle, let go 1 mm away, moves within five counts in the run's last third.

    For an estimator that is not linear: it answers motion within the sensor's noise otherwise than motion
    beyond, and so may keep a buzz alive without letting it grow.
    """
    x = _released(loop, stiffness, _RELEASED_FAR)[:, rows.TRUE_POSITION]
    if not np.abs(x).max() < _LOST_AT:
        return False
    third = len(x) // 3
    before, after = np.ptp(x[third : 2 * third]), np.ptp(x[2 * third :])
    return bool(after <= _SMALL or after < _DYING * before)


def _released(loop: _Loop, stiffness: float, start: float) -> np.ndarray:
    """Return the rows of a rendered spring whose handle is let go at `start`; raise ParameterError."""
    device = SimulatedHapkit(
        loop.handle_mass, loop.handle_viscous, 0.0, 0.0, math.inf, initial_position=start
    )
    settings = LoopSettings(loop.rate, loop.delay, loop.estimator)
    values = {"stiffness": stiffness, "damping": loop.damping, "center": 0.0}
    slowest = math.sqrt((stiffness + loop.hand.stiffness) / loop.mass)
    count = 3 * math.ceil(max(_SECONDS * loop.rate, _TURNS / slowest * loop.rate, _SAMPLES) / 3.0)
    if count > _MOST_SAMPLES:
        raise ParameterError(f"Measuring at {loop.rate:g} Hz takes {count} samples; {_MOST_SAMPLES} at most.")
    return headless.spring_rows(environments.named("spring"), values, device, settings, loop.hand, count)


def measured_stiffness_limit(
    mass: float,
    viscous: float,
    *,
    damping: float = 0.0,
    rate: float = 1000.0,
    delay: float = 0.0,
    estimator: Spec = "difference",
    hand: Hand | Grip | str | None = None,
) -> float:
    """Return the largest stable virtual stiffness in N/m to 1e-4, found by rendering the spring.

    Arguments as ``stiffness_limit``; a hand rests at the centre. 0 if no spring is stable. With
    an estimator that is not linear, a buzz of up to five counts of the usual sensor counts as stable.
    Raise ParameterError.
    """
    loop = _loop(mass, viscous, damping, rate, delay, estimator, hand)
    design(estimator, rate)
    stable = _settles if parse(estimator)[0].response else _stays_small
    low, high = 0.0, 1.0
    while low == 0.0 and high > _SOFTEST:
        low, high = (high, high) if stable(loop, high) else (0.0, high / 4.0)
    if low == 0.0:
        return 0.0
    while high == low or stable(loop, high):
        low, high = high, 4.0 * high
        if high > _STIFFEST:
            return math.inf
    while high > low * (1.0 + _PRECISION):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(loop, middle) else (low, middle)
    return math.sqrt(low * high)
