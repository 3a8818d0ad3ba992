"""Waiting for what a test needs, never for a time: a limit is there to end what hangs."""

import os
import select
import time
from collections.abc import Callable

from tests.lateness import ATTEMPTS

PATIENCE = 120.0
"""s after which what has not come about never will, however busy the machine is."""


def wait_until(true: Callable[[], object]) -> None:
    """Return as soon as something is so; fail if it never is."""
    over = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < over, "it never came about"
        time.sleep(0.001)


def write_all(descriptor: int, data: bytes) -> None:
    """Write as fast as the other end takes it, which may be full; fail if it takes no more."""
    while data:
        _, ready, _ = select.select([], [descriptor], [], PATIENCE)
        assert ready, f"{len(data)} bytes are not taken"
        data = data[os.write(descriptor, data) :]


def shortest(measure: Callable[[], float], limit: float) -> float:
    """Return the first time below a limit, or the shortest: a busy machine only makes them longer."""
    took = []
    while len(took) < ATTEMPTS and (not took or took[-1] >= limit):
        took.append(measure())
    return min(took)
