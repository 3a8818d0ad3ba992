"""A scripted board behind a pseudo-terminal: remembers what it received, says what it is told to say."""

import os
import select
import threading
import tty

from hapkit_studio.protocol.framing import Decoder
from tests.waiting import PATIENCE

HELLO_FIELDS = {
    "version": 3,
    "quantum": 2e-5,
    "max_force": 2.5,
    "motor_constant": 0.0183,
    "handle_radius": 0.09,
    "pulley_radius": 0.005,
    "sector_radius": 0.074,
    "tick_us": 0.5,
    "counts_per_flip": 921,
    "sample_rate": 1000,
    "watchdog_ms": 25,
    "pwm_top": 255,
    "profile": 1,
    "arena": 0,
    "origin": 0,
    "reset": 1,
    "build": "test",
}


UNPLUG = b"unplug"


class FakeBoard:
    """Calls ``answer(message)`` for every message received; what that returns is sent back.

    The answer UNPLUG hangs up, as a pulled cable does.
    """

    def __init__(self, answer):
        self._answer = answer
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.path = os.ttyname(self._slave)
        self.received = []
        self._arrived = threading.Condition()
        self._stop_read, self._stop_write = os.pipe()
        self._open = [self._master, self._slave, self._stop_read, self._stop_write]
        self._thread = threading.Thread(target=self._run, name="fake board", daemon=True)
        self._thread.start()

    def say(self, data):
        """Send bytes unasked."""
        os.write(self._master, data)

    def wait_for(self, count):
        """Return the messages received once there are count of them."""
        with self._arrived:
            assert self._arrived.wait_for(lambda: len(self.received) >= count, PATIENCE), self.received
            return list(self.received)

    def unplug(self):
        """Hang up; may be called twice."""
        if self._thread.is_alive():
            os.write(self._stop_write, b"x")
            self._thread.join()
        for descriptor in self._open:
            os.close(descriptor)
        self._open.clear()

    def _run(self):
        decoder = Decoder()
        while True:
            ready, _, _ = select.select([self._master, self._stop_read], [], [])
            if self._stop_read in ready:
                return
            for message in decoder.feed(os.read(self._master, 4096)):
                if not self._handle(message):
                    return

    def _handle(self, message):
        with self._arrived:
            self.received.append(message)
            self._arrived.notify_all()
        answer = self._answer(message)
        if answer == UNPLUG:
            os.close(self._master)
            self._open.remove(self._master)
            return False
        os.write(self._master, answer or b"")
        return True
