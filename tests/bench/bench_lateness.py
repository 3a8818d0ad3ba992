"""Wake-up lateness of the loop with a busy window, beside cyclictest and a Python thread as references."""

import json
import os
import shutil
import subprocess
import sys

import numpy as np

from tests.bench.frame import Row

NAME, ORDER = "lateness", 10
BLOCKS, SECONDS = 20, 5
PYTHON_BLOCKS = 5
POINTS = (50.0, 99.0, 99.9)  # percentiles in %
UNPRIVILEGED = ["setpriv", "--bounding-set=-sys_nice,-ipc_lock,-sys_resource"]


def start_cyclictest(level: int, processor: int) -> subprocess.Popen | None:
    """Start cyclictest at 1 kHz on a processor, at a real-time level (0 means normal priority).

    Return None if it is not installed. At normal priority it must not keep the processors awake.
    """
    if shutil.which("cyclictest") is None:
        return None
    policy = ["--policy=fifo", f"--priority={level}"] if level else ["--policy=other", "--laptop"]
    command = ["cyclictest", "--quiet", "--threads=1", "--interval=1000", "--histogram=100000", *policy]
    return subprocess.Popen(
        [*command, f"--affinity={processor}", f"--duration={SECONDS}"], stdout=subprocess.PIPE, text=True
    )


def percentiles(program: subprocess.Popen) -> list[float] | None:
    """Return cyclictest's lateness in µs at POINTS, or None if it could not run."""
    printed, _ = program.communicate(timeout=SECONDS + 30)
    if program.returncode:
        return None
    bins = np.array([line.split() for line in printed.splitlines() if line[:1].isdigit()], dtype=float)
    reached = np.cumsum(bins[:, 1])
    return [float(bins[np.searchsorted(reached, 0.01 * p * reached[-1]), 0]) + 1.0 for p in POINTS]


def ask(load: subprocess.Popen, line: str) -> dict:
    """Request one measurement from the window's process."""
    print(line, file=load.stdin, flush=True)
    assert load.stdout is not None
    answer = load.stdout.readline()
    if not answer:
        raise RuntimeError("the window under load has ended")
    return json.loads(answer)


def processors() -> tuple[int, int]:
    """Return two processors that this program may use; if there is only one, return it twice."""
    allowed = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else [0]
    return allowed[0], allowed[-1]


def measure(prefix: list[str]) -> tuple[str, int, dict[str, np.ndarray]]:
    """Return the priority, its level, and the lateness in µs (blocks, POINTS) of each program.

    The key "fps" has the frame rates (blocks,).

    Loop and cyclictest run at the same time on one processor each, and exchange processors after every block,
    so that the host's load affects both equally.
    """
    found: dict[str, list] = {"engine": [], "cyclictest": [], "python": [], "fps": []}
    command = [*prefix, sys.executable, "-m", "tests.bench.load"]
    pair = processors()
    names = [f"p{point:g}" for point in POINTS]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as load:
        level = ask(load, "idle")["level"]
        for block in range(BLOCKS):
            mine, other = pair if block % 2 == 0 else pair[::-1]
            ask(load, f"processor {mine}")
            beside = start_cyclictest(level, other)
            answer = ask(load, f"engine {SECONDS}")
            reference = None if beside is None else percentiles(beside)
            found["engine"].append([answer[name] for name in names])
            found["fps"].append(answer["fps"])
            found["cyclictest"] += [] if reference is None else [reference]
        for _ in range(PYTHON_BLOCKS):
            answer = ask(load, f"python {SECONDS}")
            found["python"].append([answer[name] for name in names])
        assert load.stdin is not None
        load.stdin.close()
    return answer["priority"], level, {kind: np.array(values) for kind, values in found.items()}


def rows(prefix: list[str], who: str) -> list[Row]:
    """Return the medians over the blocks for loop, cyclictest, their difference, and a Python thread."""
    priority, level, found = measure(prefix)
    print(f"  {who}, {priority}: { {k: v.tolist() for k, v in found.items()} }", file=sys.stderr)
    engine, other, python = found["engine"], found["cyclictest"], found["python"]
    table = []
    for k, point in enumerate(POINTS):
        what, value = f"lateness p{point:g}, {who} ({priority})", float(np.median(engine[:, k]))
        if len(other) == len(engine):  # every block has its reference
            beside = float(np.median(other[:, k]))
            goal = ("≤ 2 × + 50 µs", value <= 2.0 * beside + 50.0) if point == POINTS[-1] else ("", None)
            table.append(Row(what, value, "µs", "cyclictest", beside, value / beside, *goal))
            low, middle, high = np.percentile(engine[:, k] - other[:, k], (25.0, 50.0, 75.0))
            text = f"loop less cyclictest, p{point:g}, {who} (quartiles {low:.0f} to {high:.0f} µs)"
            table.append(Row(text, float(middle), "µs"))
        else:
            table.append(Row(what, value, "µs"))
    value, slow = float(np.median(engine[:, -1])), float(np.median(python[:, -1]))
    # at normal priority the scheduler determines the lateness of any program
    goal = ("≥ 20 × better", slow / value >= 20.0) if level else ("", None)
    what = f"lateness p{POINTS[-1]:g}, {who} ({priority})"
    table.append(Row(what, value, "µs", "Python thread", slow, slow / value, *goal))
    table.append(Row(f"window meanwhile, {who}", float(np.median(found["fps"])), "fps"))
    return table


def run() -> list[Row]:
    """Return the rows of this user; if the user is root, add rows without real-time priority."""
    table = rows([], "this user")
    if os.name == "posix" and os.geteuid() == 0 and shutil.which("setpriv"):
        table += rows(UNPRIVILEGED, "unprivileged")
    return table
