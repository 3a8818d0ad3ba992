"""Open the window on the virtual board, keep both busy for some seconds, print what was lost and how late."""

import json
import statistics
import sys
import time

from PySide6.QtCore import QTimer

from hapkit_studio.haptics import rows
from tests.bench.window import keep_busy, open_window


def main(seconds: float) -> None:
    """Print one JSON object: frames lost, rows a second, the median round trip in s by the board's clock."""
    application, window = open_window("--device=virtual-board")
    engine = window.studio.engine
    timer = keep_busy(window)
    if window.studio.held:
        window.studio.release_stop()
    delays: list[float] = []
    look = QTimer(window, interval=500)
    look.timeout.connect(lambda: delays.append(engine.health().delay))
    look.start()
    begin, first = time.perf_counter(), engine.health().link.lost_frames
    start = window.live.last[rows.TICK]
    QTimer.singleShot(int(1000 * seconds), application.quit)
    application.exec()
    timer.stop()
    elapsed = time.perf_counter() - begin
    found = {
        "lost": engine.health().link.lost_frames - first + window.live.lost,
        "rate": (window.live.last[rows.TICK] - start) / elapsed,
        "round_trip": statistics.median(delay for delay in delays if delay > 0.0),  # 0: not measured yet
    }
    print(json.dumps(found))
    window.close()


if __name__ == "__main__":
    main(float(sys.argv[1]))
