"""Open the window on the virtual board, keep both busy for a while, print what was lost and how late."""

import argparse
import json
import statistics
import time

from PySide6.QtCore import QTimer

from hapkit_studio.haptics import rows
from tests.bench.window import keep_busy, open_window


def main() -> None:
    """Print one JSON object: frames lost, CRC errors, rows seen, round trips in s by the board's clock."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    seconds = parser.parse_args().seconds
    application, window = open_window("--device=virtual-board")
    engine = window.studio.engine
    timer = keep_busy(window)
    delays: list[float] = []
    look = QTimer(window, interval=500)
    look.timeout.connect(lambda: delays.append(engine.health().delay))
    look.start()
    begin, first = time.perf_counter(), engine.health()
    start = window.live.last[rows.TICK]
    QTimer.singleShot(int(1000 * seconds), application.quit)
    application.exec()
    timer.stop()
    last, elapsed = engine.health(), time.perf_counter() - begin
    print(
        json.dumps(
            {
                "device": engine.device.title,
                "lost": last.lost_frames - first.lost_frames,
                "crc_errors": last.crc_errors - first.crc_errors,
                "stale": last.stale_count - first.stale_count,
                "overrun": window.live.lost,
                "rate": (window.live.last[rows.TICK] - start) / elapsed,
                "round_trip": statistics.median(delays),
                "priority": last.priority.text,
            }
        )
    )
    window.close()


if __name__ == "__main__":
    main()
