"""The heights of sandpaper's grains: whole numbers that seem random, alike in every precision."""

import math

# Sandpaper repeats after this many half wavelengths. Cubes of whole numbers below this prime are all
# different modulo it, and small enough to be exact in single precision: the board draws the same grains.
GRAINS = 251


def wrapped(n):
    """Return a whole number modulo the number of grains."""
    return n - GRAINS * math.floor(n / GRAINS)


def grain(n, seed):
    """Return the height, 0 to 1, of grain n: each of 251 heights once, in an order that seems random."""
    m = wrapped(n + 17.0 * seed)
    m = wrapped(m * m * m) + seed + 1.0
    m = wrapped(m)
    return wrapped(m * m * m) / (GRAINS - 1.0)


def sandpaper(u, amplitude, seed):
    """Return the force of sandpaper at a place u counted in grains: minus the slope of its heights, scaled.

    A seed >= 0 counts as far as it is whole.
    """
    n = math.floor(u)
    u = u - n
    seed = math.floor(seed)
    bend = 4.0 * u * (1.0 - u)
    return amplitude * (grain(n, seed) - grain(n + 1.0, seed)) * bend * bend
