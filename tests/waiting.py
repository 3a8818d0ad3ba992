"""Tests wait for conditions, never for fixed times; time-outs only end hanging tests."""

import os
import select
import time
from collections.abc import Callable

from tests.lateness import ATTEMPTS

PATIENCE = 120.0
"""Time-out in s that suffices on a machine with any load."""


def wait_until(true: Callable[[], object]) -> None:
    """Return as soon as a condition holds; fail after a time-out."""
    over = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < over, "it never came about"
        time.sleep(0.001)


def write_all(descriptor: int, data: bytes) -> None:
    """Write as fast as the other end reads; fail if it stops reading."""
    while data:
        _, ready, _ = select.select([], [descriptor], [], PATIENCE)
        assert ready, f"{len(data)} bytes are not taken"
        data = data[os.write(descriptor, data) :]


def shortest(measure: Callable[[], float], limit: float) -> float:
    """Return the first time below a limit, or else the shortest, because load only increases times."""
    took = []
    while len(took) < ATTEMPTS and (not took or took[-1] >= limit):
        took.append(measure())
    return min(took)
