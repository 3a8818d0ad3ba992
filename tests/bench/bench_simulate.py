"""Time to simulate ten seconds with a scripted hand, after the code was compiled."""

import statistics
import time

import hapkit_studio as hs
from tests.bench.frame import Row

NAME, ORDER = "simulate", 30


def run() -> list[Row]:
    """Return the median of twenty runs of 10 s at 1 kHz."""

    def once() -> float:
        start = time.perf_counter()
        hs.simulate("wall", {"damping": 2.0}, hand="press", seconds=10.0)
        return 1e3 * (time.perf_counter() - start)

    once()
    value = statistics.median(once() for _ in range(20))
    return [Row("simulate, 10 s at 1 kHz", value, "ms", target="< 10 ms", ok=value < 10.0)]
