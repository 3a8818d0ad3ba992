"""The loop's health: rate, lateness, losses, and messages for latched faults."""

import math
import time
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from hapkit_studio.devices.delays import LONGEST_DELAY
from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.formatting import number, on_screen
from hapkit_studio.haptics import arrays
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.priority import Priority
from hapkit_studio.haptics.record import Record

_FINE = np.arange(1, 1001)
# widths of the bins: 1 µs up to 1 ms, 10 µs up to 10 ms, 100 µs up to 100 ms, and one overflow bin
LATENESS_EDGES_US = np.concatenate((_FINE, 1000 + 10 * _FINE[:900], 10_000 + 100 * _FINE[:900], [np.inf]))
LATENESS_BINS = 2801


def new_histogram() -> np.ndarray:
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


def lateness_percentiles(bins: np.ndarray) -> dict[str, float]:
    """Return p50, p99, p99.9 and max in µs, each as the upper edge of its bin; 0 if all bins are empty."""
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
    """Counts of link errors between computer and board since the start.

    ``no_sample``, ``away``, ``law_blocked`` and ``cut`` count how often the force went to zero because no
    sample arrived, the computer was suspended, the law blocked the loop, or the board switched its motor off.
    ``clock_jumps`` counts how often the board's clock jumped back, stopped or jumped ahead.
    """

    lost_frames: int
    crc_errors: int
    board_errors: int
    stale_forces: int
    no_sample: int
    away: int
    law_blocked: int
    cut: int
    clock_jumps: int = 0


def count_link(control: Record) -> LinkCounts:
    """Return the loop's counters."""
    counts = control.lost_frames, control.crc_errors, control.board_errors, control.stale_forces
    causes = (int(control.stale_causes[cause]) for cause in arrays.CAUSES)
    return LinkCounts(*(int(word[0]) for word in counts), *causes)


@dataclass(frozen=True)
class Health:
    """A snapshot of the loop for status bar and command line; the delay in s is None before it is measured.

    Rate, lateness in µs and missed_lately (which includes lost frames) cover the last 10 s; all other counts
    cover the whole time. ``stale`` is the reason why the force is temporarily zero, or "".
    """

    rate: float
    lateness_us: dict[str, float]
    missed: int
    stale: str
    link: LinkCounts
    priority: Priority
    delay: float | None
    running: bool
    message: str = ""
    missed_lately: int = 0


@dataclass
class Watch:
    """Compares counts over a sliding window, for the rate and lateness of the last seconds."""

    past: deque = field(default_factory=deque)

    def poll(self, control: Record, bins: np.ndarray) -> tuple[float, dict[str, float], int]:
        """Return rate in Hz, lateness percentiles in µs, and missed or lost ticks, over WINDOW_SECONDS."""
        now, head, counts = time.perf_counter(), int(control.head[0]), bins.copy()
        missed = int(control.missed[0] + control.lost_frames[0])
        self.past.append((now, head, counts, missed))
        while len(self.past) > 2 and now - self.past[1][0] > WINDOW_SECONDS:
            self.past.popleft()
        then, before, old, missed_before = self.past[0]
        if now - then < 1e-3:
            return 0.0, lateness_percentiles(counts), 0
        recent = lateness_percentiles(counts - old)
        return (head - before) / (now - then), recent, missed - missed_before

    def forget(self) -> None:
        """Discard past counts, for example after a change of device or rate."""
        self.past.clear()


HOLD_THEN_CLEAR = "Force is zero. Hold the handle, then clear the fault."
SIMPLIFY = "Simplify the law or lower the servo rate."


_STALE = {
    arrays.NO_SAMPLE: ("no sensor reading arrived for 20 ms", "Check the USB cable and the USB hub."),
    arrays.AWAY: ("this computer was busy with other programs for 20 ms", "Close other programs."),
    arrays.LAW_BLOCKED: ("the law kept the loop waiting for 20 ms", SIMPLIFY),
    arrays.CUT: (
        "the board switched its motor off: forces came too late or not at all",
        "Check the USB cable and the USB hub.",
    ),
    arrays.CLOCK_JUMP: ("the board's clock jumped", "Update the firmware or use another board."),
}


def stale_reason(r: LoopArrays) -> str:
    """Return the reason why the force is temporarily zero, or ""."""
    cause = int(r.tick.stale) - 1
    return "" if cause < 0 else _STALE[cause][0]


@dataclass(frozen=True)
class Fault:
    """A latched fault: its code, the reason in one line, the remedy."""

    code: int
    text: str
    detail: str = HOLD_THEN_CLEAR


def describe_fault(code: int, r: LoopArrays, law: str = "the law") -> Fault | None:
    """Return the description of a latched fault, with values from the loop; None without a fault.

    ``law`` is the law's name.
    """
    value, second = float(r.tick.fault_value), float(r.tick.fault_position)
    line, limit = int(r.fault[1]), float(r.settings.max_speed)
    place = f"x = {number(1e3 * second, 2)} mm"
    name, at = "NaN (not a number)" if math.isnan(value) else "infinity", f" (line {line})" if line else ""
    stale, remedy = _STALE[int(value) if code == arrays.STALE_SENSOR else arrays.NO_SAMPLE]
    # the board cannot measure longer delays
    trip = f"more than {_ms(LONGEST_DELAY)} ms" if value >= LONGEST_DELAY else f"{_ms(value)} ms"
    gone = silent("The board", value) if value > 0.0 else "The device is disconnected."
    duration, period = on_screen(value, "s", 3), on_screen(second, "s", 3)
    found = {
        arrays.NOT_A_NUMBER: (f"Fault: the law returned {name} at {place}{at}.", ""),
        arrays.LAW_INDEX: (f"Fault: line {line} of the law uses an index outside the state or table.", ""),
        arrays.LAW_FUEL: (f"Fault: the loop or function in line {line} of the law does not end.", ""),
        arrays.LAW_DIVISION: (f"Fault: line {line} of the law divides by zero at {place}.", ""),
        arrays.OVER_SPEED: (
            f"Fault: the handle moved too fast, {_beyond(abs(value), limit)} (limit {limit:.1f} m/s).",
            "",
        ),
        arrays.STALE_SENSOR: (
            f"Fault: {stale}, three times in 10 s.",
            f"{remedy} Hold the handle, then clear the fault.",
        ),
        arrays.RUNAWAY: (
            f"Fault: this computer cannot keep the servo rate of {value:,.0f} Hz.",
            "Lower the servo rate, then clear the fault.",
        ),
        arrays.SLOW_LAW: (
            f"Fault: {law} takes {duration}, but the period is {period}.",
            f"{SIMPLIFY} Then clear the fault.",
        ),
        arrays.SLOW_LINK: (
            f"Fault: a force came {trip} after its sample; the board rejects forces older than "
            f"{_ms(second)} ms.",
            "Let the board render, or use a faster USB port, then clear the fault.",
        ),
        arrays.DEVICE_GONE: (gone, "Nothing is lost. Trying to reconnect every second."),
    }.get(code)
    if found is None:
        return None
    return Fault(code, found[0], f"Force is zero. {found[1]}" if found[1] else HOLD_THEN_CLEAR)


def _ms(seconds: float) -> str:
    """Format a time in ms with two significant digits."""
    return f"{1e3 * seconds:.{0 if seconds >= 0.01 else 2}f}"


def silent(name: str, seconds: float) -> str:
    """Return the message that a board has sent nothing for some seconds, with likely causes."""
    return f"{name} has sent nothing for {seconds:.0f} s: it restarted or froze."


def _beyond(value: float, limit: float) -> str:
    """Format a speed with enough decimals to show that it exceeds the limit.

    The board samples up to four times per telemetry frame, so a short peak may be missing in the rows.
    """
    if value <= limit:
        return f"measured by the board between two frames; the frames show {value:.1f} m/s"
    written = (f"{value:.{decimals}f}" for decimals in (1, 2, 3))
    return next((text for text in written if float(text) > limit), f"{value:.4f}") + " m/s"
