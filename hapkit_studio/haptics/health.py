"""How the loop is doing: rate, lateness over the last seconds, what was missed and lost."""

import time
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from hapkit_studio.haptics import histogram, rig
from hapkit_studio.haptics.priority import Priority

WINDOW_SECONDS = 10.0


@dataclass(frozen=True)
class Health:
    """A snapshot for status bar and command line; lateness in µs over the last 10 s, delay in s."""

    rate: float
    lateness_us: dict[str, float]
    missed: int
    lost_frames: int
    crc_errors: int
    stale_count: int
    stale: bool
    priority: Priority
    delay: float
    running: bool
    connected: bool
    message: str = ""


@dataclass
class Watch:
    """Keeps past counts, so that rate and lateness speak of the last seconds only."""

    past: deque = field(default_factory=deque)

    def look(self, control: np.ndarray, bins: np.ndarray) -> tuple[float, dict[str, float]]:
        """Return (rate in Hz, lateness percentiles in µs) since about WINDOW_SECONDS ago."""
        now, head, counts = time.perf_counter(), int(control[rig.HEAD]), bins.copy()
        self.past.append((now, head, counts))
        while len(self.past) > 2 and now - self.past[1][0] > WINDOW_SECONDS:
            self.past.popleft()
        then, before, old = self.past[0]
        if now - then < 1e-3:
            return 0.0, histogram.percentiles(counts)
        recent = counts - old
        return (head - before) / (now - then), histogram.percentiles(recent)

    def forget(self) -> None:
        """Start anew, e.g. after another device or rate."""
        self.past.clear()
