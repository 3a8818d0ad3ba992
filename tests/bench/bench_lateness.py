"""Wake-up lateness of the loop while the window repaints, beside cyclictest and a plain Python thread."""

import json
import os
import shutil
import statistics
import subprocess
import sys

import numpy as np

from tests.bench.frame import Row

NAME, ORDER = "lateness", 10
PAIRS, SECONDS = 5, 6
UNPRIVILEGED = ["setpriv", "--bounding-set=-sys_nice,-ipc_lock,-sys_resource"]


def cyclictest(seconds: float, level: int) -> float | None:
    """Return the p99.9 in µs of a thread at 1 kHz by rt-tests, at a real-time level (0: normal priority).

    None where it cannot run. At normal priority it may not keep the processors awake: nobody else may.
    """
    if shutil.which("cyclictest") is None:
        return None
    policy = ["--policy=fifo", f"--priority={level}"] if level else ["--policy=other", "--laptop"]
    command = ["cyclictest", "--quiet", "--threads=1", "--interval=1000", "--histogram=100000", *policy]
    done = subprocess.run(
        [*command, f"--duration={seconds:.0f}"], capture_output=True, text=True, check=False
    )
    if done.returncode:
        return None
    bins = np.array([line.split() for line in done.stdout.splitlines() if line[:1].isdigit()], dtype=float)
    reached = np.cumsum(bins[:, 1])
    return float(bins[np.searchsorted(reached, 0.999 * reached[-1]), 0]) + 1.0


def ask(load: subprocess.Popen, line: str) -> dict:
    """Ask the window in a program of its own for one measurement."""
    print(line, file=load.stdin, flush=True)
    assert load.stdout is not None
    return json.loads(load.stdout.readline())


def measure(prefix: list[str]) -> tuple[str, int, dict[str, list[float]]]:
    """Return the priority obtained, its level, and p99.9 in µs of every alternating block of each kind."""
    found: dict[str, list[float]] = {"engine": [], "cyclictest": [], "python": [], "fps": []}
    command = [*prefix, sys.executable, "-m", "tests.bench.load"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as load:
        level = ask(load, "idle")["level"]
        for _ in range(PAIRS):
            answer = ask(load, f"engine {SECONDS}")
            found["engine"].append(answer["p99.9"])
            found["fps"].append(answer["fps"])
            reference = cyclictest(SECONDS, level)
            found["cyclictest"] += [] if reference is None else [reference]
            found["python"].append(ask(load, f"python {SECONDS}")["p99.9"])
    return answer["priority"], level, found


def rows(prefix: list[str], who: str) -> list[Row]:
    """Return the medians beside both references."""
    priority, level, found = measure(prefix)
    print(f"  {who}, {priority}: {found}", file=sys.stderr)
    value, python = statistics.median(found["engine"]), statistics.median(found["python"])
    what = f"lateness p99.9, {who} ({priority})"
    table = []
    if found["cyclictest"]:
        other = statistics.median(found["cyclictest"])
        reached = value <= 2.0 * other + 50.0
        table.append(Row(what, value, "µs", "cyclictest", other, value / other, "≤ 2 × + 50 µs", reached))
    better = python / value
    # at normal priority the scheduler decides, whatever the language
    goal = ("≥ 20 × better", better >= 20.0) if level else ("", None)
    table.append(Row(what, value, "µs", "Python thread", python, better, *goal))
    table.append(Row(f"window meanwhile, {who}", statistics.median(found["fps"]), "fps"))
    return table


def run() -> list[Row]:
    """Return the rows of this user and, as root, those without any right to priority."""
    table = rows([], "this user")
    if os.name == "posix" and os.geteuid() == 0 and shutil.which("setpriv"):
        table += rows(UNPRIVILEGED, "unprivileged")
    return table
