"""Time from starting the program to the first plotted sample: compiled before, and with nothing compiled."""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

from tests.bench.frame import Row

NAME = "startup"
ORDER = 50
WARM_RUNS = 5


def start(**environment: str) -> tuple[float, float, list[str]]:
    """Return s to the window, s to the first plotted sample, and what was said while preparing."""
    inherited = {"QT_QPA_PLATFORM": "offscreen", **os.environ}
    begin = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-m", "tests.bench.first_sample"],
        env={**inherited, **environment},
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    seen = json.loads(done.stdout.splitlines()[-1])
    return seen["window"] - begin, seen["sample"] - begin, seen["said"]


def run() -> list[Row]:
    """Return the median of warm starts, and one cold start with its message."""
    start()
    warm = [start() for _ in range(WARM_RUNS)]
    value = statistics.median(sample for _, sample, _ in warm)
    with tempfile.TemporaryDirectory() as cache:
        window, cold, said = start(NUMBA_CACHE_DIR=cache)
    message = f"says “{said[0]}”" if said else "says nothing"
    return [
        Row("start to first plotted sample, warm", value, "s", target="< 2 s", ok=value < 2.0),
        Row(
            f"the same, nothing compiled ({message})",
            cold,
            "s",
            target="< 10 s, with a message",
            ok=cold < 10.0 and bool(said),
        ),
        Row("start to the window, nothing compiled", window, "s"),
    ]
