"""A window of a history that rolls on with time, at the cost of its newest columns only."""

import numpy as np

from hapkit_studio.gui.history import History, Window


class Reel:
    """A window that rolls on: columns that are complete are kept, only the newest are reduced again."""

    def __init__(self) -> None:
        self._kept = Window(np.empty(0), {}, False)
        self._key: tuple[float, int, int] = (0.0, 0, 0)
        self._until = 0

    def window(self, history: History, first: int, count: int, width: float) -> Window:
        """Return history's window of so many columns, each width s wide; column n starts at n * width."""
        key = (width, count, history.epoch)
        rolls = self._kept.dense and key == self._key and first < self._until <= first + count
        shown = self._roll(history, first, first + count, width) if rolls else None
        if shown is None:
            shown = history.window(np.arange(first, first + count + 1) * width)
        self._kept, self._key = shown, key
        done = int(np.floor(history.now / width)) - 1 if len(history) else first
        self._until = min(first + count, done)
        return shown

    def _roll(self, history: History, first: int, stop: int, width: float) -> Window | None:
        fresh = history.window(np.arange(self._until, max(stop, self._until + 1) + 1) * width, dense=True)
        x = self._kept.x
        a, b = np.argmax(x >= first * width), np.argmax(np.append(x, np.inf) >= self._until * width)
        b -= bool(b) and bool(np.isnan(x[b - 1]))  # the break before the newest columns comes with them
        if not len(fresh.x) or b <= a:
            return None
        y = {name: np.concatenate([old[a:b], fresh.y[name]]) for name, old in self._kept.y.items()}
        return Window(np.concatenate([x[a:b], fresh.x]), y, True)
