"""What the tests of sweeps compute: functions of a module, so that other programs find them."""

import math
import os


def roots(cells: list[float]) -> list[float]:
    return [math.sqrt(x) for x in cells]


def roots_and_place(cells: list[float]) -> list[tuple[float, int]]:
    """Return every root and the program it was computed in."""
    return [(math.sqrt(x), os.getpid()) for x in cells]


def busy_roots(cells: list[float]) -> list[float]:
    """Return roots that take about a tenth of a millisecond each."""
    return [math.sqrt(x + 0.0 * sum(math.sin(i) for i in range(1000))) for x in cells]


def fails_at_thirty(cells: list[float]) -> list[float]:
    if 30.0 in cells:
        raise KeyError("cell thirty")
    return cells
