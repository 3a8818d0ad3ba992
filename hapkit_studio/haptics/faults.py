"""What a latched fault says to a person: the reason, value, limit, and what to do."""

from dataclasses import dataclass

from hapkit_studio.formatting import number
from hapkit_studio.haptics import block, rig
from hapkit_studio.haptics.delays import LONGEST
from hapkit_studio.haptics.rig import Rig

HOLD_THEN_CLEAR = "Force is zero. Hold the handle, then clear."


_STALE = {
    rig.NO_SAMPLE: ("no sensor frame for 20 ms", "Cable or hub loose?"),
    rig.AWAY: ("this computer was busy elsewhere for 20 ms", "Close other programs."),
    rig.HELD_UP: ("the law held the loop up for 20 ms", "Simplify the law or lower the rate."),
    rig.CUT: ("the board switched its motor off: forces came too late or not at all", "Cable or hub loose?"),
}


@dataclass(frozen=True)
class Fault:
    """A latched fault: its code, the reason in one line, what to do."""

    code: int
    text: str
    detail: str = HOLD_THEN_CLEAR


def describe(code: int, r: Rig) -> Fault | None:
    """Return the fault of a code with the values the loop left, None for no fault."""
    value, second = float(r.real[rig.FAULT_VALUE]), float(r.real[rig.FAULT_POSITION])
    place = f"x = {number(1e3 * second, 2)} mm"
    cause = int(value) if code == rig.STALE_SENSOR else rig.NO_SAMPLE
    line, limit = int(r.fault[1]), float(r.values[block.MAX_SPEED])
    texts = {
        rig.NOT_A_NUMBER: f"Fault: the law returned {_name(value)} at {place}{_at(line)}.",
        rig.LAW_INDEX: f"Fault: line {line} of the law reaches beyond its state.",
        rig.LAW_FUEL: f"Fault: line {line} of the law does not come to an end.",
        rig.LAW_DIVISION: f"Fault: line {line} of the law divides by zero at {place}.",
        rig.OVER_SPEED: f"Fault: over-speed, {_beyond(abs(value), limit)} (limit {limit:.1f} m/s).",
        rig.STALE_SENSOR: f"Fault: {_STALE[cause][0]}, three times in 10 s.",
        rig.RUNAWAY: f"Fault: this machine cannot keep {value:.0f} Hz.",
        rig.SLOW_LAW: f"Fault: the law takes {_ms(value)} ms, a period {_ms(second)} ms.",
        rig.SLOW_LINK: (
            f"Fault: {_trip(value)} from a sample to its force; the board obeys none after {_ms(second)} ms."
        ),
        rig.DEVICE_GONE: _gone(value),
    }
    details = {
        rig.STALE_SENSOR: f"Force is zero. {_STALE[cause][1]} Hold the handle, then clear.",
        rig.RUNAWAY: "Force is zero. Lower the rate, then clear.",
        rig.SLOW_LAW: "Force is zero. Simplify the law or lower the rate, then clear.",
        rig.SLOW_LINK: "Force is zero. Let the board render, or use a faster USB port, then clear.",
        rig.DEVICE_GONE: "Force is zero. Nothing is lost. Looking again every second.",
    }
    if code not in texts:
        return None
    return Fault(code, texts[code], details.get(code, HOLD_THEN_CLEAR))


def _ms(seconds: float) -> str:
    """Write a time in ms with two digits that say something."""
    return f"{1e3 * seconds:.{0 if seconds >= 0.01 else 2}f}"


def _trip(seconds: float) -> str:
    """Write the time that a link takes; beyond LONGEST the board does not know."""
    return f"more than {_ms(LONGEST)} ms" if seconds >= LONGEST else f"{_ms(seconds)} ms"


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
