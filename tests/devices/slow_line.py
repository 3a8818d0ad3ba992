"""A line that takes its time: a pseudo-terminal before another one, each byte on its way for so long."""

import contextlib
import os
import select
import threading
import time
import tty
from collections import deque

_LOOK = 0.002


class SlowLine:
    """Stands between a program and the port of a board; ``path`` is the port that the program opens.

    to, back: s that a byte takes to the board and from it; held: nothing goes on to the board meanwhile;
    passed: bytes that went on to it.
    """

    def __init__(self, port, to=0.0, back=0.0):
        self.to, self.back, self.held, self.passed = to, back, False, 0
        self._board = os.open(port, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self._board)
        self._near, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.path = os.ttyname(self._slave)
        self._end, self._wake = os.pipe()
        self._thread = threading.Thread(target=self._run, name="slow line", daemon=True)
        self._thread.start()

    def close(self):
        os.write(self._wake, b"x")
        self._thread.join()
        for descriptor in (self._board, self._near, self._slave, self._end, self._wake):
            os.close(descriptor)

    def _run(self):
        ways = {self._near: (self._board, deque()), self._board: (self._near, deque())}
        while True:
            now = time.monotonic()
            due = [queue[0][0] for _, queue in ways.values() if queue]
            wait = min(max(min(due) - now, 0.0) if due else _LOOK, _LOOK) if not self.held else _LOOK
            ready, _, _ = select.select([*ways, self._end], [], [], wait)
            if self._end in ready:
                return
            now = time.monotonic()
            for source, (target, queue) in ways.items():
                delay = self.to if source == self._near else self.back
                if source in ready:
                    with contextlib.suppress(OSError):
                        queue.append((now + delay, os.read(source, 4096)))
                held = self.held and source == self._near
                while queue and queue[0][0] <= now and not held:
                    count = os.write(target, queue.popleft()[1])
                    self.passed += count if source == self._near else 0
