"""Memory must not grow while recording at 4 kHz with changing environments and views, for 40 minutes.

``python -m tests.soak [MINUTES]`` prints the memory each minute. The exit code is 1 if it grew by 2 % or more
after minute 11, or if a row is missing in the session.
"""

import os
import sys
import tempfile
import time
from itertools import cycle
from pathlib import Path

import numpy as np
from PySide6.QtCore import QTimer

from hapkit_studio.gui.shell.window import MainWindow
from hapkit_studio.sessions.session import Session
from tests.bench.frame import resident
from tests.bench.window import keep_busy, open_window, process_until

MINUTES = 40
FULL = 11  # from this minute on, the recorder keeps a full ten minutes in memory
GROWTH = 0.02
RATE = 4000.0
CHANGE_MS = 1000  # time in ms between changes of environment or view


def keep_changing(window: MainWindow) -> QTimer:
    """Show the next environment and the next view once per second."""
    keys = [action.key for action in window.actions_by_key.entries]
    views = [key for key in keys if key.startswith("view.tab.")]
    turns = zip(cycle(window.studio.environments), cycle(views), strict=False)
    timer = QTimer(window, interval=CHANGE_MS)

    def change() -> None:
        environment, view = next(turns)
        window.studio.choose(environment)
        window.actions_by_key.run(view)

    timer.timeout.connect(change)
    timer.start()
    return timer


def record(minutes: int) -> tuple[list[float], int, Path]:
    """Return the memory in MB at each minute's end, the number of lost rows, and the session."""
    application, window = open_window("--environment", "spring")
    window.studio.set_loop(rate=RATE)
    timer, changes, recording = keep_busy(window), keep_changing(window), window.studio.recording
    recording.toggle()
    memory = []
    for minute in range(1, minutes + 1):
        end = time.perf_counter() + 60.0
        process_until(application, lambda end=end: time.perf_counter() > end, 90.0)
        memory.append(resident())
        print(f"minute {minute}: {memory[-1]:.1f} MB", flush=True)
    recording.toggle()
    process_until(application, lambda: recording.newest is not None, 30.0)
    timer.stop()
    changes.stop()
    path, lost = recording.newest[0], window.live.lost
    window.close()
    return memory, lost, path


def main() -> int:
    """Record, then read everything back; return the exit code."""
    minutes = int(sys.argv[1]) if len(sys.argv) > 1 else MINUTES
    with tempfile.TemporaryDirectory() as folder:
        os.environ["HAPKIT_STUDIO_FOLDER"] = folder
        memory, lost, path = record(minutes)
        session = Session(path)
        damage = session.check()
        missing = int((np.diff(session.read(("tick",))["tick"]) != 1.0).sum())
        rows, size = int(session.counts.sum()), 1e-6 * path.stat().st_size
        session.close()
    flat = memory[FULL - 1 :] or memory[-1:]
    growth = max(flat) / flat[0] - 1.0
    print(
        f"{rows:,} rows, {size:.0f} MB; missing: {missing}, not shown: {lost}; {' '.join(damage) or 'whole'}"
    )
    print(f"memory from minute {FULL} on: at most {100.0 * growth:+.2f} % (limit {100.0 * GROWTH:.0f} %)")
    return int(growth >= GROWTH or missing > 0 or bool(damage))


if __name__ == "__main__":
    sys.exit(main())
