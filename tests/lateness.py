"""What a busy machine does to a loop that runs live: the only faults that a test may clear."""

import time

from hapkit_studio.haptics import arrays

LATENESS = (arrays.STALE_SENSOR, arrays.RUNAWAY)
"""Frames 20 ms late, three times in 10 s; passes that never wait, as where board and loop share a core."""
ATTEMPTS = 8
"""How often what a busy machine may spoil is done at most."""


def clear_lateness(owner) -> None:
    """Clear, as a person would, a fault that a busy machine may cause; fail on any other."""
    fault = owner.fault
    if fault is not None:
        assert fault.code in LATENESS, fault
        owner.clear_fault()


def slowdown(seconds: float = 0.05) -> float:
    """Return by how much other programs stretch a computation now: its time by the clock over its own."""
    start, own = time.perf_counter(), time.process_time()
    while time.process_time() - own < seconds:
        pass
    return (time.perf_counter() - start) / seconds
