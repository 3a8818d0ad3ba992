"""A test may clear only those faults of a live loop that a busy machine can cause."""

import time

from hapkit_studio.haptics import arrays

LATENESS = (arrays.STALE_SENSOR, arrays.RUNAWAY)
"""Frames are 20 ms late three times in 10 s, or the loop never waits as it shares a core with the board."""
ATTEMPTS = 8
"""Number of attempts of a step that a busy machine may disturb."""


def clear_lateness(owner) -> None:
    """Clear a fault that a busy machine may cause; fail on any other."""
    fault = owner.fault
    if fault is not None:
        assert fault.code in LATENESS, fault
        owner.clear_fault()


def slowdown(seconds: float = 0.05) -> float:
    """Return the ratio of wall-clock time to processor time of a computation."""
    start, own = time.perf_counter(), time.process_time()
    while time.process_time() - own < seconds:
        pass
    return (time.perf_counter() - start) / seconds
