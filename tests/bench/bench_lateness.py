"""Wake-up lateness of the loop while the window repaints, beside cyclictest and a plain Python thread."""

import json
import os
import shutil
import statistics
import subprocess
import sys

from tests.bench import cyclictest
from tests.bench.frame import Row

NAME = "lateness"
ORDER = 10
PAIRS = 5
SECONDS = 6
UNPRIVILEGED = ["setpriv", "--bounding-set=-sys_nice,-ipc_lock,-sys_resource"]


class Load:
    """The window in a program of its own; asks it for one measurement after the other."""

    def __init__(self, prefix: list[str]):
        command = [*prefix, sys.executable, "-m", "tests.bench.load"]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, line: str) -> dict:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()
        return json.loads(self._process.stdout.readline())

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(timeout=30)


def measure(prefix: list[str]) -> tuple[str, int, dict[str, list[float]]]:
    """Return the priority obtained, its level, and p99.9 in µs of every alternating block of each kind."""
    load = Load(prefix)
    found: dict[str, list[float]] = {"engine": [], "cyclictest": [], "python": [], "fps": []}
    try:
        level = load.ask("idle")["level"]
        for _ in range(PAIRS):
            answer = load.ask(f"engine {SECONDS}")
            found["engine"].append(answer["p99.9"])
            found["fps"].append(answer["fps"])
            reference = cyclictest.block(SECONDS, level)
            found["cyclictest"] += [] if reference is None else [reference]
            found["python"].append(load.ask(f"python {SECONDS}")["p99.9"])
        return answer["priority"], level, found
    finally:
        load.close()


def rows(prefix: list[str], who: str) -> list[Row]:
    """Return the medians beside both references."""
    priority, level, found = measure(prefix)
    print(f"  {who}, {priority}: {found}", file=sys.stderr)
    value, python = statistics.median(found["engine"]), statistics.median(found["python"])
    what = f"lateness p99.9, {who} ({priority})"
    table = []
    if found["cyclictest"]:
        reference = statistics.median(found["cyclictest"])
        reached = value <= 2.0 * reference + 50.0
        table.append(
            Row(what, value, "µs", "cyclictest", reference, value / reference, "≤ 2 × + 50 µs", reached)
        )
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
