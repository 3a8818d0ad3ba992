"""How fast a sampled oscillation grows or dies, from its samples alone."""

import numpy as np


def per_sample(x):
    """Return the factor of the amplitude from one sample of x to the next, x swinging about 0.

    x_n+1 = s x_n - p x_n-1 makes x_n^2 - x_n+1 x_n-1 a geometric sequence of ratio p, the factor squared.
    """
    w = x[1:-1] ** 2 - x[2:] * x[:-2]
    return (w[-1] / w[0]) ** (0.5 / (len(w) - 1))


def rate(x, dt):
    """Return the growth in 1/s of the amplitude of x, sampled every dt s."""
    return np.log(per_sample(x)) / dt
