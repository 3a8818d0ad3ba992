"""The growth rate of a sampled oscillation, computed from its samples alone."""

import numpy as np

# Growth in 1/s of a mass of 2 kg with 1 N·s/m on 300 N/m. Columns: without contact at 1 kHz; with a contact
# of 1000 N/m at 1 kHz, and at 230 Hz. The exact growth is -0.25 1/s.
COURSE_RATES = {
    "explicit_euler": (-0.175, 0.075, 1.158),
    "lecture": (-0.175, 0.075, 1.153),
    "semi_implicit": (-0.250, -0.250, -0.250),
    "verlet": (-0.250, -0.250, -0.250),
    "rk4": (-0.250, -0.250, -0.250),
    "implicit_euler": (-0.325, -0.575, -1.652),
    "trapezoid": (-0.250, -0.250, -0.250),
    "exact": (-0.250, -0.250, -0.250),
}


def per_sample(x):
    """Return the factor by which the amplitude of an oscillation x about 0 changes per sample.

    x_n+1 = s x_n - p x_n-1 makes x_n^2 - x_n+1 x_n-1 a geometric sequence of ratio p, the factor squared.
    """
    w = x[1:-1] ** 2 - x[2:] * x[:-2]
    return (w[-1] / w[0]) ** (0.5 / (len(w) - 1))


def rate(x, dt):
    """Return the growth in 1/s of the amplitude of x, sampled every dt s."""
    return np.log(per_sample(x)) / dt
