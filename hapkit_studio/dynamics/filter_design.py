"""Coefficients of the velocity estimators, and the transfer functions of those that are linear.

A design takes the rate in Hz, the sensor's quantum in m and its method's options, and returns float64[8]. A
response takes these, the period in s and complex z, and returns velocity over position.
"""

import math

import numpy as np

from hapkit_studio.dynamics.filters import COEFFICIENTS

# An ideal sensor is expected to be as noisy as a Hapkit's: without noise there is nothing to weigh.
USUAL_QUANTUM = 20.7e-6
# The bilinear transform ends at half the rate.
HIGHEST_SHARE = 0.45
# Where the correction takes the whole surprise, as it does without any noise.
_LARGEST_BETA = 3.0 - math.sqrt(3.0)
_HALVINGS = 60


def _coefficients(*numbers: float) -> np.ndarray:
    return np.array(numbers + (0.0,) * (COEFFICIENTS - len(numbers)))


def difference(rate: float, quantum: float) -> np.ndarray:
    return _coefficients()


def difference_response(coefs: np.ndarray, period: float, z: np.ndarray) -> np.ndarray:
    return (z - 1.0) / (period * z)


def iir(rate: float, quantum: float, cutoff: float) -> np.ndarray:
    """alpha = 1 - exp(-2 pi f_c T), the exact discrete pole of a first-order low-pass."""
    return _coefficients(-math.expm1(-2.0 * math.pi * cutoff / rate))


def iir_response(coefs: np.ndarray, period: float, z: np.ndarray) -> np.ndarray:
    return coefs[0] * (z - 1.0) / (period * (z - (1.0 - coefs[0])))


def butterworth(rate: float, quantum: float, cutoff: float) -> np.ndarray:
    """b0, a1, a2 of the second-order low-pass by the bilinear transform, its corner kept in place."""
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
    """Return alpha, beta of the steady filter: constant velocity, white acceleration q, noise quantum^2 / 12.

    Its Riccati equation at rest says alpha^2 = beta (2 - alpha) - beta^2 / 6, and that beta^2 / (1 - alpha),
    which rises with beta, is q T^3 / R.
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
