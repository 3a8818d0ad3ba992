"""Where in the past the handle moved as it does now: so that two traces lie on top of each other in time."""

import numpy as np

from hapkit_studio.gui.history import History

STEP = 0.01
LEAST, MOST = 1.0, 3.0
"""s of movement that are compared: fewer say too little, with more the past has not enough to choose from."""
LEAST_WAY = 0.002
"""m: what moves less than this from end to end stands still."""
_ALIKE = 0.3
"""Of the movement's own variance: what differs by more is another movement."""


def _sampled(history: History, start: float, stop: float) -> np.ndarray:
    """Return the positions in m from start to stop s, one every STEP; empty where too few are known."""
    window = history.between(start, stop)
    known = np.isfinite(window.x)
    if np.count_nonzero(known) < 2:
        return np.empty(0)
    at = start + STEP * np.arange(int((stop - start) / STEP))
    return np.interp(at, window.x[known], window.y["position"][known])


def likeness(past: np.ndarray, now: np.ndarray) -> tuple[int, float]:
    """Return where in the past a movement fits best, and how far off: mean square over its variance."""
    stretches = np.lib.stride_tricks.sliding_window_view(past, len(now))
    differences = np.mean((stretches - now) ** 2, axis=1)
    best = int(np.argmin(differences))
    return best, float(differences[best] / max(np.var(now), 1e-12))


def earlier(history: History, start: float, switch: float, begin: float, now: float) -> float | None:
    """Return how many s before begin the handle, between start and switch, moved as from begin to now.

    None where it stands still, where too little is known, and where it moves in no way as before.
    """
    start = max(start, history.start)
    present, past = _sampled(history, begin, min(now, begin + MOST)), _sampled(history, start, switch)
    if len(present) < LEAST / STEP or len(past) < len(present) or np.ptp(present) < LEAST_WAY:
        return None
    place, difference = likeness(past, present)
    return begin - (start + place * STEP) if difference < _ALIKE else None
