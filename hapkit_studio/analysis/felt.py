"""Force over position as felt: each force over the handle's position while that force acted.

A force is computed from a sample, begins to act a delay later and is constant until the next force. A plot
over the positions of the samples lies on the law's line for any delay. A plot over the positions while the
forces acted shows the hysteresis loop that the hand feels; the area of this loop is the energy added.
"""

from dataclasses import dataclass

import numpy as np


def as_felt(
    time: np.ndarray, position: np.ndarray, force: np.ndarray, delay: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return position in m and force in N, (2 n,) each: both ends of the interval in which each force acts.

    ``time`` in s, ``position`` and ``force`` (n,) belong to the samples. ``delay`` is the time in s from a
    sample to its force. Positions are interpolated linearly. NaN marks lost samples and positions that are
    not known yet.
    """
    known = np.isfinite(time)
    places = np.full((len(time), 2), np.nan)
    if known.any():
        t, x = time[known], position[known]
        ends = np.append(t[1:], np.nan)
        for column, at in enumerate((t + delay, ends + delay)):
            places[known, column] = np.interp(at, t, x, right=np.nan)
        lost = np.flatnonzero(~known)
        places[np.clip(lost - 1, 0, None)] = np.nan  # no samples were received while this force acted
    return places.ravel(), np.repeat(force, 2)


@dataclass(frozen=True)
class Cycle:
    """One cycle of a motion: duration in s and work in J done by the force."""

    seconds: float
    energy: float


def last_cycle(
    time: np.ndarray, position: np.ndarray, force: np.ndarray, delay: float, least: float
) -> Cycle | None:
    """Return the newest complete cycle between two upward crossings of the motion's middle; None without one.

    ``least`` is the smallest peak-to-peak motion in m that counts as a cycle.
    """
    known = np.isfinite(time)
    t, x, f = time[known], position[known], force[known]
    if not len(x) or np.ptp(x) < least:
        return None
    middle, back = 0.5 * (x.max() + x.min()), 0.25 * np.ptp(x)
    # The hysteresis of the crossings is a quarter of the peak-to-peak motion.
    state = np.where(x > middle, 1, np.where(x < middle - back, -1, 0))
    marked = np.flatnonzero(state)
    rises = marked[1:][(state[marked[1:]] == 1) & (state[marked[:-1]] == -1)]
    rises = rises[t[rises] + delay <= t[-1]]  # the positions under a cycle's last force must be known
    if len(rises) < 2:
        return None
    # the last force of the cycle acts until one delay after the next sample
    first, last = rises[-2], rises[-1]
    stop = min(int(np.searchsorted(t, t[last] + delay, side="right")) + 1, len(t))
    places, forces = as_felt(t[first:stop], x[first:stop], f[first:stop], delay)
    steps = np.diff(places.reshape(-1, 2), axis=1)[: last - first, 0]
    if not np.isfinite(steps).all():
        return None
    return Cycle(float(t[last] - t[first]), float(steps @ forces[::2][: last - first]))
