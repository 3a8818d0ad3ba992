"""The window under load, controlled line by line: ``engine 6``, ``python 6``, ``processor 1``, ``idle``.

It answers each line with one line of JSON. It is a separate process, so that it can run unprivileged.
"""

import json
import os
import sys
import threading
import time

import numpy as np
from PySide6.QtCore import QTimer

from hapkit_studio.haptics import health
from tests.bench.window import keep_busy, open_window

PERIOD = 1e-3


def engine_block(engine, seconds: float) -> dict[str, float]:
    """Return the loop's lateness percentiles in µs over the next seconds."""
    before = engine.lateness_bins.copy()
    time.sleep(seconds)
    return health.lateness_percentiles(engine.lateness_bins - before)


def python_block(seconds: float) -> dict[str, float]:
    """Return the lateness percentiles of a plain Python thread with the same deadlines."""
    count = round(seconds / PERIOD)
    lateness = np.zeros(count)
    start = time.perf_counter()
    for k in range(count):
        deadline = start + (k + 1) * PERIOD
        time.sleep(max(0.0, deadline - time.perf_counter()))
        lateness[k] = time.perf_counter() - deadline
    p50, p99, p999 = 1e6 * np.percentile(lateness, (50.0, 99.0, 99.9))
    return {"p50": p50, "p99": p99, "p99.9": p999, "max": 1e6 * lateness.max()}


def serve(window, frames: list[int], finish) -> None:
    """Answer lines until the end of the input."""
    engine = window.studio.engine
    for line in sys.stdin:
        word, *seconds = line.split()
        first, begin = frames[0], time.perf_counter()
        if word == "engine":
            answer = engine_block(engine, float(seconds[0]))
        elif word == "python":
            answer = python_block(float(seconds[0]))
        else:
            answer = {}
            if word == "processor":
                os.sched_setaffinity(engine._thread.native_id, {int(seconds[0])})
        answer["fps"] = (frames[0] - first) / (time.perf_counter() - begin)
        answer["priority"] = engine.health().priority.text
        answer["level"] = engine.health().priority.level
        print(json.dumps(answer), flush=True)
    finish()


def main() -> None:
    """Open the window, keep it busy, and answer lines until told to quit."""
    application, window = open_window()
    frames = [0]

    def count(*_) -> None:
        frames[0] += 1

    window.live.frame.connect(count)
    timer = keep_busy(window)
    finish = QTimer(window, interval=50)
    done = threading.Event()
    finish.timeout.connect(lambda: done.is_set() and window.close())
    finish.start()
    thread = threading.Thread(target=serve, args=(window, frames, done.set), daemon=True)
    thread.start()
    application.exec()
    timer.stop()


if __name__ == "__main__":
    main()
