"""Time from starting the program to the first plotted sample, and to the last law, with nothing compiled."""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from typing import Any

from tests.bench.frame import Row

NAME = "startup"
ORDER = 50
WARM_RUNS = 5


def start(*words: str, **environment: str) -> dict[str, Any]:
    """Return s to the window, to the first plotted sample and to the end, and what was said meanwhile."""
    inherited = {"QT_QPA_PLATFORM": "offscreen", **os.environ}
    begin = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-m", "tests.bench.first_sample", *words],
        env={**inherited, **environment},
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    seen = json.loads(done.stdout.splitlines()[-1])
    return {key: value - begin if isinstance(value, float) else value for key, value in seen.items()}


def run() -> list[Row]:
    """Return the median of warm starts, and one cold start with its message until every law is there."""
    start()
    value = statistics.median(start()["sample"] for _ in range(WARM_RUNS))
    with tempfile.TemporaryDirectory() as cache:
        seen = start("everything", NUMBA_CACHE_DIR=cache)
    message = f"says “{seen['said'][0]}”" if seen["said"] else "says nothing"
    cold = seen["sample"]
    return [
        Row("start to first plotted sample, warm", value, "s", target="< 2 s", ok=value < 2.0),
        Row(
            f"the same, nothing compiled ({message})",
            cold,
            "s",
            target="< 10 s, with a message",
            ok=cold < 10.0 and bool(seen["said"]),
        ),
        Row("start to the window, nothing compiled", seen["window"], "s"),
        Row("start until every environment can be had, nothing compiled", seen["everything"], "s"),
    ]
