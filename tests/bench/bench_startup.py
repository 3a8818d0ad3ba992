"""Time from the program's start to the first plotted sample, and until all laws are compiled."""

import statistics
import tempfile
import time
from typing import Any

from tests.bench.frame import Row, child

NAME, ORDER = "startup", 50
WARM_RUNS = 5


def start(*args: str, **environment: str) -> dict[str, Any]:
    """Return the times in s until the window, the first plotted sample and the end, and all messages."""
    begin = time.perf_counter()
    seen = child("first_sample", *args, **environment)
    return {key: value - begin if isinstance(value, float) else value for key, value in seen.items()}


def run() -> list[Row]:
    """Return rows for the median warm start, and for one cold start until all laws are compiled."""
    start()
    value = statistics.median(start()["sample"] for _ in range(WARM_RUNS))
    with tempfile.TemporaryDirectory() as cache:
        seen = start("everything", NUMBA_CACHE_DIR=cache)
    lines, cold = seen["notices"], seen["sample"]
    what = f"the same, nothing compiled ({f'says “{lines[0]}”' if lines else 'says nothing'})"
    reached = cold < 10.0 and bool(lines)
    return [
        Row("start to first plotted sample, warm", value, "s", target="< 1.5 s", ok=value < 1.5),
        Row(what, cold, "s", target="< 10 s, with a message", ok=reached),
        Row("start to the window, nothing compiled", seen["window"], "s"),
        Row("start until every environment can be had, nothing compiled", seen["everything"], "s"),
    ]
