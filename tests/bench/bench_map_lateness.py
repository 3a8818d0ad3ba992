"""The loop's lateness while a stability map takes every core, beside the loop alone."""

import statistics
import threading
import time

from hapkit_studio.analysis.stability import rendered
from hapkit_studio.analysis.sweeps import Cancelled
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics import health
from hapkit_studio.haptics.engine import Engine
from tests.bench.bench_map import DAMPING, SETTING, STIFFNESS
from tests.bench.frame import Row

NAME = "map-lateness"
ORDER = 26
PAIRS, BLOCK_SECONDS = 3, 5.0


def keep_mapping(done: threading.Event) -> None:
    """Measure maps until told to stop."""

    def watch(*_) -> None:
        if done.is_set():
            raise Cancelled("Enough.")

    try:
        while True:
            rendered.classes(SETTING, DAMPING, STIFFNESS, real=True, progress=watch)
    except Cancelled:
        return


def lateness(engine: Engine) -> float:
    """Return the loop's p99.9 in µs over the next seconds."""
    before = engine.lateness_bins.copy()
    time.sleep(BLOCK_SECONDS)
    return health.lateness_percentiles(engine.lateness_bins - before)["p99.9"]


def lateness_with_map(engine: Engine) -> float:
    done = threading.Event()
    thread = threading.Thread(target=keep_mapping, args=(done,))
    thread.start()
    try:
        return lateness(engine)
    finally:
        done.set()
        thread.join()


def run() -> list[Row]:
    """Return the loop's lateness while the map takes every core, beside the loop alone, in turns."""
    engine = Engine(SimulatedHapkit(), "wall")
    engine.start()
    try:
        pairs = [(lateness(engine), lateness_with_map(engine)) for _ in range(PAIRS)]
        priority = engine.health().priority.text
    finally:
        engine.close()
    alone, beside_it = (statistics.median(times) for times in zip(*pairs, strict=True))
    what = f"lateness p99.9, 1 kHz, the map on every core ({priority})"
    reached = beside_it <= 2.0 * alone + 50.0
    return [Row(what, beside_it, "µs", "without the map", alone, beside_it / alone, "≤ 2 × + 50 µs", reached)]
