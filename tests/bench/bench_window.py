"""Frames a second and the window thread's share of a core, beside pyqtgraph's own downsampling."""

import json
import os
import subprocess
import sys

from tests.bench.frame import Row

NAME = "window"
ORDER = 60
SECONDS = 10


def run() -> list[Row]:
    """Return both rows; the pictures run in a program of their own, one after the other."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.bench.bench_plots", f"--seconds={SECONDS}"],
        env={"QT_QPA_PLATFORM": "offscreen", **os.environ},
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    found = json.loads(done.stdout.splitlines()[-1])
    ours, reference = found["ours"], found["pyqtgraph_peak"]
    rows = []
    for what, key, scale, unit, target in (
        ("window, 5 curves and scene, 60 s at 4 kHz", "fps", 1.0, "fps", "≥ 55 fps"),
        ("its thread's share of one core", "gui_thread_share", 100.0, "%", "< 50 %"),
    ):
        value, other = scale * ours[key], scale * reference[key]
        reached = value >= 55.0 if unit == "fps" else value < 50.0
        rows.append(Row(what, value, unit, "pyqtgraph", other, value / other, target, reached))
    return rows
