"""Velocity from sampled positions: one entry per method, designed in Python, stepped in compiled code.

To add a method, write a design function, a code with a branch in ``step``, and an entry in the table. A
design takes the rate in Hz, the sensor's quantum in m and the options of its method, and returns float64[8].
A response takes these coefficients, the period in s and complex z, and returns the transfer function. The
memory of a method is kept between samples.

First-order adaptive windowing uses the longest line that fits the newest samples (Janabi-Sharifi, Hayward and
Chen, IEEE Trans. Control Systems Technology 8(6), 2000, the best-fit variant). This is a least-squares line
from which no sample deviates by more than the sensor's noise. The line is long and smooth at low speed, and
short and fast at an impact. Samples have time stamps, so that a late sample does not tilt the line.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from hapkit_studio.dynamics import nominal
from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import quoted
from hapkit_studio.parameters import Parameter, check_number, resolve

Spec = str | tuple[str, dict[str, float]]

# default estimator of the graphical interface: its error is small in most motions (see ``accuracy``)
USUAL = "kalman"
# m: quantum assumed for an ideal sensor, because a Kalman filter cannot be designed without noise
USUAL_QUANTUM = nominal.QUANTUM
# highest cutoff as a fraction of the rate; the bilinear transform ends at half the rate
HIGHEST_SHARE = 0.45
# beta in the limit without noise, in which the correction equals the innovation
_LARGEST_BETA = 3.0 - math.sqrt(3.0)
_HALVINGS = 60
# number of samples after which the response to one count has passed its peak
_RESPONSE_SAMPLES = 256

MEMORY = 48
COEFFICIENTS = 8
DIFFERENCE, IIR, BUTTERWORTH, FOAW, KALMAN = range(5)
_POSITION, _VELOCITY, _RAW, _OLDER_RAW, _OLDER, _ESTIMATE, _WINDOW = range(7)
LONGEST = 16  # length of the window in periods
# indices into the memory of adaptive windowing: flag for "initialised", samples, ages
_BEGUN, _SAMPLES, _AGES = 0, 1, 2 + LONGEST
# samples of a quantised motion often lie exactly at the tolerance: reject them despite rounding errors
_TIE = 1.0 - 1e-9


@internal
def _fits(memory, count, mean_age, mean, falling, tolerance):
    """Return True if the newest ``count`` samples deviate from a line by at most the tolerance."""
    newest = memory[_SAMPLES]
    for i in range(count):
        line = mean + falling * (memory[_AGES + i] - mean_age)
        if abs(memory[_SAMPLES + i] - newest - line) > _TIE * tolerance:
            return False
    return True


@internal
def _foaw(coefs, full, position, period):
    """Return the velocity of the longest line that fits its samples.

    ``coefs`` contains the window in periods and the tolerance in m. The window is initialised with a steady
    motion.
    """
    window, tolerance, memory = int(coefs[0]), coefs[1], full[_WINDOW:]
    if memory[_BEGUN] == 0.0:
        memory[_BEGUN] = 1.0
        for i in range(LONGEST + 1):
            memory[_AGES + i] = i * period
            memory[_SAMPLES + i] = full[_POSITION] - i * period * full[_VELOCITY]
    for i in range(LONGEST, 0, -1):
        memory[_AGES + i] = memory[_AGES + i - 1] + period
        memory[_SAMPLES + i] = memory[_SAMPLES + i - 1]
    memory[_AGES], memory[_SAMPLES] = 0.0, position
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


@compiled
def reset(memory: np.ndarray, position: float) -> None:
    """Initialise the memory as if the handle had rested at ``position``."""
    resume(memory, position, 0.0)


@compiled
def resume(memory: np.ndarray, position: float, velocity: float) -> None:
    """Initialise the memory at ``position`` with a steady ``velocity``.

    This avoids a jump of the velocity when the method changes.
    """
    memory[:] = 0.0
    memory[_POSITION] = memory[_ESTIMATE] = position
    memory[_VELOCITY] = memory[_RAW] = memory[_OLDER_RAW] = memory[_OLDER] = velocity


@compiled
def step(code: int, coefs: np.ndarray, memory: np.ndarray, position: float, period: float) -> float:
    """Process a measured position, ``period`` s after the previous one; return the velocity in m/s."""
    raw, before = (position - memory[_POSITION]) / period, memory[_VELOCITY]
    velocity = raw
    if code == IIR:
        velocity = before + coefs[0] * (raw - before)
    elif code == BUTTERWORTH:  # two poles; coefs contains b0, a1, a2
        velocity = coefs[0] * (raw + 2.0 * memory[_RAW] + memory[_OLDER_RAW])
        velocity -= coefs[1] * before + coefs[2] * memory[_OLDER]
        memory[_OLDER_RAW], memory[_RAW], memory[_OLDER] = memory[_RAW], raw, before
    elif code == KALMAN:  # alpha-beta filter: predict with constant velocity, then correct
        guess = memory[_ESTIMATE] + period * before
        surprise = position - guess
        memory[_ESTIMATE] = guess + coefs[0] * surprise
        velocity = before + coefs[1] * surprise / period
    elif code == FOAW:
        velocity = _foaw(coefs, memory, position, period)
    memory[_POSITION] = position
    memory[_VELOCITY] = velocity
    return velocity


def _coefficients(*numbers: float) -> np.ndarray:
    return np.array(numbers + (0.0,) * (COEFFICIENTS - len(numbers)))


def difference(rate: float, quantum: float) -> np.ndarray:
    return _coefficients()


def difference_response(coefs: np.ndarray, period: float, z: np.ndarray) -> np.ndarray:
    return (z - 1.0) / (period * z)


def iir(rate: float, quantum: float, cutoff: float) -> np.ndarray:
    """Return alpha = 1 - exp(-2 pi f_c T), which gives a first-order low-pass its exact discrete pole."""
    return _coefficients(-math.expm1(-2.0 * math.pi * cutoff / rate))


def iir_response(coefs: np.ndarray, period: float, z: np.ndarray) -> np.ndarray:
    return coefs[0] * (z - 1.0) / (period * (z - (1.0 - coefs[0])))


def butterworth(rate: float, quantum: float, cutoff: float) -> np.ndarray:
    """Return b0, a1, a2 of the second-order low-pass by the bilinear transform with prewarping."""
    k = math.tan(math.pi * min(cutoff / rate, HIGHEST_SHARE))
    whole = 1.0 + math.sqrt(2.0) * k + k * k
    return _coefficients(
        k * k / whole, 2.0 * (k * k - 1.0) / whole, (1.0 - math.sqrt(2.0) * k + k * k) / whole
    )


def butterworth_response(coefs: np.ndarray, period: float, z: np.ndarray) -> np.ndarray:
    low_pass = coefs[0] * (z + 1.0) ** 2 / (z * z + coefs[1] * z + coefs[2])
    return low_pass * difference_response(coefs, period, z)


def foaw(rate: float, quantum: float, window: float, noise: float) -> np.ndarray:
    return _coefficients(round(window), noise * (quantum or USUAL_QUANTUM))


def kalman(rate: float, quantum: float, q: float) -> np.ndarray:
    """Return alpha and beta of the steady-state filter with constant velocity and white acceleration q.

    The measurement noise is R = quantum^2 / 12. The steady-state Riccati equation gives alpha^2 = beta (2 -
    alpha) - beta^2 / 6. The value beta^2 / (1 - alpha) equals q T^3 / R and increases with beta, so beta is
    found by bisection.
    """
    noise = (quantum or USUAL_QUANTUM) ** 2 / 12.0
    wanted = q / (rate**3 * noise)
    low, high = 0.0, _LARGEST_BETA
    for _ in range(_HALVINGS):
        beta = 0.5 * (low + high)
        low, high = (beta, high) if beta * beta < wanted * (1.0 - _alpha(beta)) else (low, beta)
    return _coefficients(_alpha(high), high)


def _alpha(beta: float) -> float:
    return 0.5 * (math.sqrt(beta * (8.0 + beta / 3.0)) - beta)


def kalman_response(coefs: np.ndarray, period: float, z: np.ndarray) -> np.ndarray:
    alpha, beta = coefs[0], coefs[1]
    return beta / period * z * (z - 1.0) / (z * z - (2.0 - alpha - beta) * z + 1.0 - alpha)


@dataclass(frozen=True)
class Estimator:
    """A velocity estimator.

    ``design(rate, quantum, **options)`` returns the coefficients, float64[8]. ``response(coefs, period, z)``
    returns the transfer function from position to velocity at complex z; it is None for a nonlinear method.
    """

    key: str
    label: str
    code: int
    parameters: tuple[Parameter, ...]
    design: Callable[..., np.ndarray]
    response: Callable[[np.ndarray, float, np.ndarray], np.ndarray] | None = None


def _cutoff(default: float, help: str) -> Parameter:
    return Parameter("cutoff", "Cutoff", "Hz", default, 1.0, 2000.0, help, "f_c")


_CORNER = _cutoff(35.5, "Cutoff frequency of the first-order low-pass filter")
_CORNERS = _cutoff(
    60.0, "Cutoff frequency of the second-order low-pass filter, at most 45 % of the servo rate"
)
_LINE = Parameter(
    "window",
    "Window",
    "",
    LONGEST,
    2.0,
    LONGEST,
    "The largest number of periods over which FOAW fits a line to the positions",
    "N",
)
_NOISE = Parameter(
    "noise", "Noise", "counts", 0.5, 0.1, 5.0, "How far a sample may deviate from the fitted line", "d"
)
_AGILITY = Parameter(
    "q",
    "Reaction speed",
    "m²/s³",
    1e-2,
    1e-3,
    1.0,
    "How quickly the filter follows a change of speed; a large value lets more noise through",
    "q",
)
_METHODS = (
    Estimator("difference", "Backward difference", DIFFERENCE, (), difference, difference_response),
    Estimator("iir", "Low-pass filtered difference", IIR, (_CORNER,), iir, iir_response),
    Estimator(
        "butterworth",
        "Butterworth filtered difference",
        BUTTERWORTH,
        (_CORNERS,),
        butterworth,
        butterworth_response,
    ),
    Estimator("foaw", "First-order adaptive windowing", FOAW, (_LINE, _NOISE), foaw),
    Estimator("kalman", "Kalman filter with constant gain", KALMAN, (_AGILITY,), kalman, kalman_response),
)
ESTIMATORS: dict[str, Estimator] = {method.key: method for method in _METHODS}


def parse(spec: Spec) -> tuple[Estimator, dict[str, float]]:
    """Return the estimator and the checked options of a spec such as "iir" or ("iir", {"cutoff": 20.0}).

    Raise ParameterError if a method or an option is unknown, or if an option is out of range.
    """
    pair = (spec, {}) if isinstance(spec, str) else spec
    if not (isinstance(pair, tuple | list) and len(pair) == 2 and isinstance(pair[1], Mapping)):
        raise ParameterError(
            f"The velocity estimator is a name or (name, {{option: value}}), not {quoted(spec)}."
        )
    key, options = pair
    estimator = ESTIMATORS.get(key) if isinstance(key, str) else None
    if estimator is None:
        raise ParameterError(
            f"The velocity estimator must be one of {', '.join(ESTIMATORS)}, not {quoted(key)}."
        )
    numbers = resolve(estimator.parameters, options, estimator.label)
    return estimator, {p.key: n for p, n in zip(estimator.parameters, numbers, strict=True)}


def design(spec: Spec, rate: float, quantum: float = 0.0) -> tuple[int, np.ndarray]:
    """Return (code, float64[8]) for ``step`` at ``rate`` Hz and a sensor of ``quantum`` m.

    Raise ParameterError like ``parse``, and for an invalid rate or a negative quantum.
    """
    check_number(rate, "rate", "Hz", above=True)
    check_number(quantum, "quantum", "m")
    estimator, options = parse(spec)
    return estimator.code, estimator.design(rate, quantum, **options)


@compiled
def _run(code, coefs, memory, position, period, velocity):
    reset(memory, position[0])
    for k in range(position.size):
        velocity[k] = step(code, coefs, memory, position[k], period)


def estimate_velocity(
    position: np.ndarray, rate: float, estimator: Spec = "difference", quantum: float = nominal.QUANTUM
) -> np.ndarray:
    """Return the velocity (n,) in m/s of positions (n,) in m sampled at ``rate`` Hz; its first value is 0.

    ``quantum`` is the resolution of the positions in m, for the design of the estimator. The positions are
    not rounded again. Raise ParameterError for an invalid argument.
    """
    try:
        samples = np.ascontiguousarray(position, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError("The positions must be numbers in m.") from None
    if samples.ndim != 1:
        raise ParameterError(f"The positions must be one row of numbers, not of shape {samples.shape}.")
    code, coefs = design(estimator, rate, quantum)
    velocity = np.zeros(samples.size)
    if samples.size:
        _run(code, coefs, np.zeros(MEMORY), samples, 1.0 / rate, velocity)
    return velocity


def count_response(estimator: Spec, rate: float, quantum: float) -> np.ndarray:
    """Return the estimated velocity (n,) in m/s after a handle at rest has moved by one count."""
    position = np.full(_RESPONSE_SAMPLES, quantum)
    position[0] = 0.0
    return estimate_velocity(position, rate, estimator, quantum)[1:]
