"""Open the window on the virtual board, keep both busy, and print lost frames and the median round trip."""

import json
import sys
import time

import numpy as np
from PySide6.QtCore import QTimer

from hapkit_studio.devices import delays
from hapkit_studio.gui.shell.window import MainWindow
from hapkit_studio.haptics import rows
from tests.bench.window import keep_busy, open_window


class RoundTrips:
    """A collector of every measured round trip in s; it clears faults, because a fault stops round trips."""

    def __init__(self, window: MainWindow):
        self._studio = window.studio
        self._delays = window.studio.engine.driver.conn.delays
        self._seen = int(self._delays.counts[delays.OF_COMPUTER])
        self.values: list[float] = []
        self.faults: list[str] = []

    def read(self) -> None:
        """Copy the new entries of the ring; this must be called before the ring wraps."""
        count = int(self._delays.counts[delays.OF_COMPUTER])
        new = np.arange(max(self._seen, count - delays.DELAYS_KEPT), count) % delays.DELAYS_KEPT
        self.values += self._delays.values[delays.OF_COMPUTER, new].tolist()
        self._seen = count
        fault = self._studio.fault
        if fault is not None:
            self.faults.append(fault.text)
            self._studio.clear_fault()


def main(seconds: float) -> None:
    """Print one JSON object: lost frames, rows per second, median round trip in s, and number of faults."""
    application, window = open_window("--device=virtual-board")
    engine = window.studio.engine
    timer, trips = keep_busy(window), RoundTrips(window)
    if window.studio.waits_for_render:
        window.studio.release_stop()
    timer = QTimer(window, interval=500)
    timer.timeout.connect(trips.read)
    timer.start()
    begin, first = time.perf_counter(), engine.health().link.lost_frames
    start = window.live.last[rows.TICK]
    QTimer.singleShot(int(1000 * seconds), application.quit)
    application.exec()
    timer.stop()
    trips.read()
    elapsed = time.perf_counter() - begin
    if not trips.values:
        reason = trips.faults[-1] if trips.faults else "no force was rendered"
        sys.exit(f"no round trip measured in {seconds:g} s; {len(trips.faults)} faults, last: {reason}")
    found = {
        "lost": engine.health().link.lost_frames - first + window.live.lost,
        "rate": (window.live.last[rows.TICK] - start) / elapsed,
        "round_trips": len(trips.values),
        "round_trip": float(np.median(trips.values)),
        "faults": len(trips.faults),
    }
    print(json.dumps(found))
    window.close()


if __name__ == "__main__":
    main(float(sys.argv[1]))
