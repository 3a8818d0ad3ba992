"""Garbage collection in the window's own thread.

Python collects in whichever thread allocates: what compiles a law in the background would free widgets there,
and Qt crashes.
"""

import gc

from PySide6.QtCore import QObject, QTimer

PERIOD_MS = 250


class Collector(QObject):
    """Collects by a timer of its thread, as often as Python would; nobody else does from now on.

    It does not give that back when it goes: a collection within Qt's own destruction locks Qt up.
    """

    def __init__(self, parent: QObject):
        super().__init__(parent)
        gc.disable()
        timer = QTimer(self)
        timer.timeout.connect(collect)
        timer.start(PERIOD_MS)


def collect() -> None:
    """Collect the oldest generation whose turn it is."""
    due = [
        g
        for g, (count, most) in enumerate(zip(gc.get_count(), gc.get_threshold(), strict=True))
        if count > most
    ]
    if due:
        gc.collect(due[-1])
