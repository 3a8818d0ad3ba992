"""Why the delay of a board is long, and what shortens it, in words for the stability card."""

from typing import Any

LONG = 2e-3
"""s from which on a delay is worth a word: two periods, on a good line it is half of one."""
_BOARD = "render on the board"
_FRAMES = "fill its frames (Device, USB frames)"


def reason(device: Any, delay: float) -> str:
    """Return the likeliest reason and its remedy; nothing where the delay in s is short."""
    if device.simulated or delay <= LONG:
        return ""
    latency = getattr(device, "latency", None)
    if latency is not None and latency.long:
        return latency.words
    what = f"{_FRAMES}, or {_BOARD}" if not getattr(device, "padding", 0) else _BOARD
    return f"The line holds frames back: {what}."
