"""Times of a replay of one hour at 4 kHz: opening it, and a frame of all plots while scrolling.

It prints one JSON object, with a frame of the live plots over their last minute as reference.
"""

import json
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PySide6.QtWidgets import QApplication, QGridLayout, QWidget

from hapkit_studio.gui.live.recorded import Recorded
from hapkit_studio.sessions.chunk import pack
from hapkit_studio.sessions.file import SessionWriter
from hapkit_studio.sessions.session import Session
from tests.bench.frame import resident
from tests.bench.plots import RATE, SPAN, Ours, telemetry

SECONDS, CHUNK, FRAMES = 3600.0, 1200, 120
QUANTUM = 20.7e-6


def write(path: Path) -> None:
    """Write an hour whose chunks are copies of a minute of a periodic signal."""
    writer = SessionWriter(path)
    for first in range(0, int(SECONDS * RATE), CHUNK):
        table = telemetry(first, CHUNK)
        table[:, 3] = QUANTUM * np.rint(table[:, 3] / QUANTUM)
        writer.add(pack(table, QUANTUM, 0))
    writer.close()


def frames(window: QWidget, draw: Callable[[int], object]) -> float:
    """Return the median time in ms of a painted frame."""
    took = []
    for number in range(FRAMES):
        begin = time.perf_counter()
        draw(number)
        window.grab()
        took.append(1e3 * (time.perf_counter() - begin))
    return statistics.median(took)


def main() -> None:
    """Measure the replay, and print the results."""
    app = QApplication([])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hour.hapkit"
        write(path)
        before, begin = resident(), time.perf_counter()
        history = Recorded(Session(path))
        found = {"open_s": time.perf_counter() - begin, "open_MB": resident() - before}
        window = QWidget()
        window.resize(912, 548)
        ours = Ours(QGridLayout(window))
        window.show()
        count = int(RATE / 60.0)
        ours.frame(telemetry(0, int(SPAN * RATE)))
        live = frames(window, lambda n: ours.frame(telemetry(int(SPAN * RATE) + n * count, count)))
        found |= {"live_ms": live, "file_MB": 1e-6 * path.stat().st_size}
        for plots in (ours.times, ours.phase):
            plots.view.set_history(history)

        def show(seconds: float) -> None:
            history.move_to(history.start + seconds)
            ours.times.refresh()
            ours.phase.refresh()

        found["play_ms"] = frames(window, lambda n: show(600.0 + n / 60.0))
        history.complete = False
        found["scroll_ms"] = frames(window, lambda n: show(100.0 + n * 29.0))
        edges = np.linspace(history.start, history.stop, 1500)
        found["hour_ms"] = frames(QWidget(), lambda _n: history.window(edges))
    app.quit()
    print(json.dumps(found))


if __name__ == "__main__":
    main()
