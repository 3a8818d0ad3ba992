"""What a latched fault says to a person: the reason, value, limit, and what to do."""

from dataclasses import dataclass

from hapkit_studio.haptics import block, rig
from hapkit_studio.haptics.rig import Rig

HOLD_THEN_CLEAR = "Force is zero. Hold the handle, then clear."


@dataclass(frozen=True)
class Fault:
    """A latched fault: its code, the reason in one line, what to do."""

    code: int
    text: str
    detail: str = HOLD_THEN_CLEAR


def describe(code: int, r: Rig) -> Fault | None:
    """Return the fault of a code with the values the loop left, None for no fault."""
    value, position = float(r.real[rig.FAULT_VALUE]), 1e3 * float(r.real[rig.FAULT_POSITION])
    line, limit = int(r.fault[1]), float(r.values[block.MAX_SPEED])
    texts = {
        rig.NOT_A_NUMBER: f"Fault: the law returned {_name(value)} at x = {_signed(position)} mm{_at(line)}.",
        rig.LAW_INDEX: f"Fault: line {line} of the law reaches beyond its state.",
        rig.LAW_FUEL: f"Fault: line {line} of the law does not come to an end.",
        rig.LAW_DIVISION: f"Fault: line {line} of the law divides by zero at x = {_signed(position)} mm.",
        rig.OVER_SPEED: f"Fault: over-speed, {_beyond(abs(value), limit)} (limit {limit:.1f} m/s).",
        rig.STALE_SENSOR: f"Fault: no sensor frame for {1e3 * value:.0f} ms, three times in 10 s.",
        rig.RUNAWAY: f"Fault: this machine cannot keep {value:.0f} Hz.",
        rig.DEVICE_GONE: _gone(value),
    }
    details = {
        rig.STALE_SENSOR: "Force is zero. Cable loose, or computer too busy? Hold the handle, then clear.",
        rig.RUNAWAY: "Force is zero. Lower the rate, then clear.",
        rig.DEVICE_GONE: "Force is zero. Nothing is lost. Looking again every second.",
    }
    if code not in texts:
        return None
    return Fault(code, texts[code], details.get(code, HOLD_THEN_CLEAR))


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


def _signed(millimetres: float) -> str:
    return f"{millimetres:.2f}".replace("-", "−")
