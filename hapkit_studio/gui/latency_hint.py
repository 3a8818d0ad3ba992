"""Why the delay of a board is long, and what shortens it, in words for the stability card."""

from typing import Any

LONG = 2e-3
"""s from which on a delay is worth a word: two periods, on a good line it is half of one."""
_BOARD = "render on the board"
_FRAMES = "fill its frames (Device, USB frames)"


def reason(device: Any, delay: float) -> str:
    """Return the likeliest reason and what helps; nothing where the delay in s is short."""
    if device.simulated or delay <= LONG:
        return ""
    if getattr(device, "hand", False):  # a virtual board has no USB chip, and frames filled do not help
        return f"The virtual board shares this computer's processors: {_BOARD}."
    what = _BOARD if getattr(device, "padding", 0) else f"{_FRAMES}, or {_BOARD}"
    timer = held_back(device)
    holds = f"The USB chip holds frames back, up to {timer} ms" if timer else "The line holds frames back"
    return f"{holds}: {what}."


def held_back(device: Any) -> str:
    """Return the USB chip's latency timer in ms, nothing where it is short or not known."""
    latency = getattr(device, "latency", None)
    return f"{1e3 * latency.timer:.0f}" if latency is not None and latency.long else ""


def remedy(device: Any) -> str:
    """Return what shortens the timer itself, for a tooltip."""
    return device.latency.words if held_back(device) else ""
