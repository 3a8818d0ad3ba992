"""How the loop is doing: rate, lateness, what was missed and lost; a latched fault in words."""

import time
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.formatting import number
from hapkit_studio.haptics import arrays, block
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.link import LONGEST_DELAY
from hapkit_studio.haptics.priority import Priority

_PER_DECADE = 1000
LATENESS_BINS = _PER_DECADE + 2 * 900 + 1


def new_histogram() -> np.ndarray:
    """Return empty bins, int64 (LATENESS_BINS,).

    1 µs wide up to 1 ms, 10 µs up to 10 ms, 100 µs up to 100 ms, and one for all beyond.
    """
    return np.zeros(LATENESS_BINS, dtype=np.int64)


@compiled
def add_lateness(bins: np.ndarray, lateness: float) -> None:
    """Count one lateness in s."""
    us = lateness * 1e6
    if us < 0.0:
        us = 0.0
    if us < 1e3:
        bins[int(us)] += 1
    elif us < 1e4:
        bins[900 + int(us / 10.0)] += 1
    elif us < 1e5:
        bins[1800 + int(us / 100.0)] += 1
    else:
        bins[LATENESS_BINS - 1] += 1


def _upper_edges() -> np.ndarray:
    fine = np.arange(1, 1001)
    return np.concatenate((fine, 1000 + 10 * np.arange(1, 901), 10_000 + 100 * np.arange(1, 901), [np.inf]))


LATENESS_EDGES_US = _upper_edges()


def lateness_percentiles(bins: np.ndarray) -> dict[str, float]:
    """Return p50, p99, p99.9 and max in µs, each the upper edge of its bin; 0 where nothing was counted."""
    total = int(bins.sum())
    if not total:
        return {"p50": 0.0, "p99": 0.0, "p99.9": 0.0, "max": 0.0}
    upto = np.cumsum(bins)
    edges = np.where(np.isinf(LATENESS_EDGES_US), 100_000.0, LATENESS_EDGES_US)
    found = {f"p{q:g}": float(edges[np.searchsorted(upto, q / 100.0 * total)]) for q in (50, 99, 99.9)}
    return {**found, "max": float(edges[np.flatnonzero(bins)[-1]])}


WINDOW_SECONDS = 10.0


@dataclass(frozen=True)
class LinkCounts:
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


def count_link(control: np.ndarray) -> LinkCounts:
    """Return what the loop has counted."""
    causes = (int(control[arrays.STALE_CAUSES + cause]) for cause in arrays.CAUSES)
    places = arrays.LOST_FRAMES, arrays.CRC_ERRORS, arrays.BOARD_ERRORS, arrays.STALE_FORCES
    return LinkCounts(*(int(control[place]) for place in places), *causes)


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
    link: LinkCounts
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
        now, head, counts = time.perf_counter(), int(control[arrays.HEAD]), bins.copy()
        missed = int(control[arrays.MISSED] + control[arrays.LOST_FRAMES])
        self.past.append((now, head, counts, missed))
        while len(self.past) > 2 and now - self.past[1][0] > WINDOW_SECONDS:
            self.past.popleft()
        then, before, old, missed_before = self.past[0]
        if now - then < 1e-3:
            return 0.0, lateness_percentiles(counts), 0
        recent = lateness_percentiles(counts - old)
        return (head - before) / (now - then), recent, missed - missed_before

    def forget(self) -> None:
        """Start anew, e.g. after another device or rate."""
        self.past.clear()


HOLD_THEN_CLEAR = "Force is zero. Hold the handle, then clear."


_STALE = {
    arrays.NO_SAMPLE: ("no sensor frame for 20 ms", "Cable or hub loose?"),
    arrays.AWAY: ("this computer was busy elsewhere for 20 ms", "Close other programs."),
    arrays.HELD_UP: ("the law held the loop up for 20 ms", "Simplify the law or lower the rate."),
    arrays.CUT: (
        "the board switched its motor off: forces came too late or not at all",
        "Cable or hub loose?",
    ),
}


@dataclass(frozen=True)
class Fault:
    """A latched fault: its code, the reason in one line, what to do."""

    code: int
    text: str
    detail: str = HOLD_THEN_CLEAR


def describe_fault(code: int, r: LoopArrays) -> Fault | None:
    """Return the fault of a code with the values the loop left, None for no fault."""
    value, second = float(r.real[arrays.FAULT_VALUE]), float(r.real[arrays.FAULT_POSITION])
    place = f"x = {number(1e3 * second, 2)} mm"
    cause = int(value) if code == arrays.STALE_SENSOR else arrays.NO_SAMPLE
    line, limit = int(r.fault[1]), float(r.values[block.MAX_SPEED])
    texts = {
        arrays.NOT_A_NUMBER: f"Fault: the law returned {_name(value)} at {place}{_at(line)}.",
        arrays.LAW_INDEX: f"Fault: line {line} of the law reaches beyond its state.",
        arrays.LAW_FUEL: f"Fault: line {line} of the law does not come to an end.",
        arrays.LAW_DIVISION: f"Fault: line {line} of the law divides by zero at {place}.",
        arrays.OVER_SPEED: f"Fault: over-speed, {_beyond(abs(value), limit)} (limit {limit:.1f} m/s).",
        arrays.STALE_SENSOR: f"Fault: {_STALE[cause][0]}, three times in 10 s.",
        arrays.RUNAWAY: f"Fault: this machine cannot keep {value:.0f} Hz.",
        arrays.SLOW_LAW: f"Fault: the law takes {_ms(value)} ms, a period {_ms(second)} ms.",
        arrays.SLOW_LINK: (
            f"Fault: {_trip(value)} from a sample to its force; the board obeys none after {_ms(second)} ms."
        ),
        arrays.DEVICE_GONE: _gone(value),
    }
    details = {
        arrays.STALE_SENSOR: f"Force is zero. {_STALE[cause][1]} Hold the handle, then clear.",
        arrays.RUNAWAY: "Force is zero. Lower the rate, then clear.",
        arrays.SLOW_LAW: "Force is zero. Simplify the law or lower the rate, then clear.",
        arrays.SLOW_LINK: "Force is zero. Let the board render, or use a faster USB port, then clear.",
        arrays.DEVICE_GONE: "Force is zero. Nothing is lost. Looking again every second.",
    }
    if code not in texts:
        return None
    return Fault(code, texts[code], details.get(code, HOLD_THEN_CLEAR))


def _ms(seconds: float) -> str:
    """Write a time in ms with two digits that say something."""
    return f"{1e3 * seconds:.{0 if seconds >= 0.01 else 2}f}"


def _trip(seconds: float) -> str:
    """Write the time that a link takes; beyond LONGEST_DELAY the board does not know."""
    return f"more than {_ms(LONGEST_DELAY)} ms" if seconds >= LONGEST_DELAY else f"{_ms(seconds)} ms"


def _gone(seconds: float) -> str:
    """Say whether the device went away, or has sent nothing for so many s."""
    return silent("The board", seconds) if seconds > 0.0 else "The device is gone."


def silent(name: str, seconds: float) -> str:
    """Say that a board has sent nothing for so many s, and why that may be."""
    return f"{name} has sent nothing for {seconds:.0f} s: it started anew, or hangs."


def _beyond(value: float, limit: float) -> str:
    """Write a speed with as many decimals as show that it is above the limit.

    The board samples up to four times as often as it tells: a short peak is known to it alone.
    """
    if value <= limit:
        return f"seen by the board between two frames, {value:.1f} m/s over a frame"
    return (
        next((t for t in (f"{value:.{d}f}" for d in (1, 2, 3)) if float(t) > limit), f"{value:.4f}") + " m/s"
    )


def _at(line: int) -> str:
    """Write the line of a value that is not finite, where it is known."""
    return f" (line {line})" if line else ""


def _name(value: float) -> str:
    return "NaN" if value != value else "infinity"
