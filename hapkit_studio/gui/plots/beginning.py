"""From when on samples are the doing of the environment in force."""

import math

from hapkit_studio.gui.history import History

CHANGEOVER = 0.06  # s: the loop's cross-fade, and the rows that are on their way


class Beginning:
    """A time in a history; at the start, and in every other run, it is before all samples."""

    def __init__(self) -> None:
        self._epoch, self._time = 0, -math.inf

    def put(self, history: History) -> None:
        """Begin as soon as a change made now has come through."""
        self._epoch = history.epoch
        self._time = history.now + CHANGEOVER if len(history) else -math.inf

    def within(self, history: History) -> float:
        """Return the time in s."""
        return self._time if history.epoch == self._epoch else -math.inf
