"""A scripted board behind a pseudo-terminal or a fake line, with the firmware's replies."""

import os
import select
import threading
from dataclasses import replace

import pytest

from hapkit_studio.devices import profiles
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import (
    PROTOCOL_VERSION,
    Board,
    Hello,
    HelloRequest,
    Origin,
    Sample,
    Save,
    Settings,
    SettingsRequest,
    Stream,
)
from tests.waiting import PATIENCE

HELLO_FIELDS = dict(
    version=PROTOCOL_VERSION, quantum=2e-5, max_force=2.5, motor_constant=0.0183, handle_radius=0.09,
    pulley_radius=0.005, sector_radius=0.074, tick_us=0.5, counts_per_flip=921, sample_rate=1000,
    watchdog_ms=25, pwm_top=255, profile=1, arena=0, origin=0, reset=1, build="test",
)  # fmt: skip
UNPLUG = b"unplug"


class FakeBoard:
    """A board that calls ``answer(message)`` for every message received, and sends its result.

    If ``answer`` returns UNPLUG, the board disconnects, as if its cable were unplugged.
    """

    def __init__(self, answer):
        tty = pytest.importorskip("tty", reason="pseudo-terminals")
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

    def send(self, data):
        """Send bytes that the computer has not requested."""
        os.write(self._master, data)

    def wait_for(self, count):
        """Return the received messages as soon as there are ``count`` of them."""
        with self._arrived:
            assert self._arrived.wait_for(lambda: len(self.received) >= count, PATIENCE), self.received
            return list(self.received)

    def unplug(self):
        """Disconnect; this may be called twice."""
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


class FakeLine:
    """A replacement of serial.Serial and of the time module within this process.

    The board replies at once; only a read without data advances the time.
    """

    def __init__(self, answer):
        self._answer, self._decoder, self._data = answer, Decoder(), b""
        self.received, self.now = [], 0.0

    def __call__(self, _port, _baud, timeout, **_options):
        self.timeout = timeout
        return self

    def monotonic(self):
        return self.now

    def write(self, data):
        for message in self._decoder.feed(data):
            self.received.append(message)
            self._data += self._answer(message) or b""

    @property
    def in_waiting(self):
        return len(self._data)

    def read(self, size):
        found, self._data = self._data[:size], self._data[size:]
        self.now += 0.0 if found else self.timeout
        return found

    def reset_input_buffer(self):
        self._data = b""

    def fileno(self):
        return -1

    def close(self):
        pass


KIT = replace(profiles.default().board, quantum=2e-5, max_force=2.5, label="fake kit")
ARENA = 760
MOST_FORCE = 20.0
"""Force limit of a fake board in N."""


def sample(seq, count=0, **fields):
    """Return the sample of tick ``seq`` of a board that was started at time 0 with 1 kHz."""
    values = dict.fromkeys([w.name for w in Sample.layout()[3:]], 0) | fields
    return Sample(seq=seq & 0xFFFF, time_us=(1000 * seq) & 0xFFFFFFFF, count=count, **values)


class FakeKit:
    """The firmware's replies, for ``FakeBoard(FakeKit())``.

    ``burst`` is the number of samples after Stream(1), ``settings`` are the current ones, ``stored`` those in
    the EEPROM, and ``deaf`` is the number of messages to ignore, by type.
    """

    def __init__(self, settings=KIT, arena=ARENA, burst=0, deaf=None):
        self.settings, self.stored, self.arena = settings, None, arena
        self.origin, self.burst, self.deaf = Origin.DEFAULT, burst, dict(deaf or {})

    def __call__(self, message):
        kind = type(message)
        if self.deaf.get(kind, 0) > 0:
            self.deaf[kind] -= 1
            return None
        answer = getattr(self, f"_{kind.__name__.lower()}", None)
        return answer(message) if answer else None

    def hello(self):
        same = {name: value for name, value in vars(self.settings).items() if name in HELLO_FIELDS}
        return Hello(**HELLO_FIELDS | same | {"arena": self.arena, "origin": int(self.origin)})

    def _hellorequest(self, _message: HelloRequest):
        return encode(self.hello())

    def _answer(self, refused=False):
        kit = {f.name: getattr(self.settings, f.name) for f in Board.layout()}
        return encode(Settings(**kit, origin=int(self.origin), refused=int(refused)))

    def _settingsrequest(self, _message: SettingsRequest):
        return self._answer()

    def _board(self, message: Board):
        if not 0.0 < message.max_force <= MOST_FORCE:
            return self._answer(refused=True)
        self.settings, self.origin = replace(message), Origin.UNSAVED
        return self._answer()

    def _save(self, _message: Save):
        self.stored, self.origin = self.settings, Origin.STORED
        return self._answer()

    def _stream(self, message: Stream):
        return b"".join(encode(sample(k, count=k)) for k in range(self.burst)) if message.on else None
