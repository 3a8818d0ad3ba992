"""How the loop is doing: rate, lateness over the last seconds, what was missed and lost."""

import time
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from hapkit_studio.haptics import histogram, rig
from hapkit_studio.haptics.priority import Priority

WINDOW_SECONDS = 10.0


@dataclass(frozen=True)
class Link:
    """What went wrong between computer and board, counted since the start.

    no_sample, away, held_up, cut: how often the force went to zero because the line brought no sample, the
    computer was busy elsewhere, the law held it up, the board switched its motor off.
    """

    lost_frames: int
    crc_errors: int
    board_errors: int
    stale_forces: int
    no_sample: int
    away: int
    held_up: int
    cut: int


def link(control: np.ndarray) -> Link:
    """Return what the loop has counted."""
    causes = (int(control[rig.STALE_CAUSES + cause]) for cause in rig.CAUSES)
    places = rig.LOST_FRAMES, rig.CRC_ERRORS, rig.BOARD_ERRORS, rig.STALE_FORCES
    return Link(*(int(control[place]) for place in places), *causes)


@dataclass(frozen=True)
class Health:
    """A snapshot for status bar and command line; delay in s.

    Rate, lateness in µs and missed_lately (lost frames too) are of the last 10 s, other counts of all time.
    """

    rate: float
    lateness_us: dict[str, float]
    missed: int
    lost_frames: int
    crc_errors: int
    stale_count: int
    stale: bool
    link: Link
    priority: Priority
    delay: float
    running: bool
    connected: bool
    message: str = ""
    missed_lately: int = 0


@dataclass
class Watch:
    """Keeps past counts, so that rate and lateness speak of the last seconds only."""

    past: deque = field(default_factory=deque)

    def look(self, control: np.ndarray, bins: np.ndarray) -> tuple[float, dict[str, float], int]:
        """Return (rate in Hz, lateness percentiles in µs, ticks missed or lost) of about WINDOW_SECONDS."""
        now, head, counts = time.perf_counter(), int(control[rig.HEAD]), bins.copy()
        missed = int(control[rig.MISSED] + control[rig.LOST_FRAMES])
        self.past.append((now, head, counts, missed))
        while len(self.past) > 2 and now - self.past[1][0] > WINDOW_SECONDS:
            self.past.popleft()
        then, before, old, missed_before = self.past[0]
        if now - then < 1e-3:
            return 0.0, histogram.percentiles(counts), 0
        recent = histogram.percentiles(counts - old)
        return (head - before) / (now - then), recent, missed - missed_before

    def forget(self) -> None:
        """Start anew, e.g. after another device or rate."""
        self.past.clear()
