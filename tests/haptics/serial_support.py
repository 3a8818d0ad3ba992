"""Boards that a test scripts, and the engine on either serial loop."""

import threading

import numpy as np

from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.haptics import engine as engine_module
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import Force, Hello, HelloRequest, Sample, Stream
from tests.devices.fake_board import HELLO_FIELDS, FakeBoard
from tests.haptics import support
from tests.lateness import ATTEMPTS, LATENESS
from tests.waiting import PATIENCE, wait_until

QUANTUM = float(np.float32(HELLO_FIELDS["quantum"]))


def sample(seq, count, answered=0, delay_us=0, flags=0, period_us=1000):
    """Return the frame of a sample as a board would send it."""
    time_us = seq * period_us & 0xFFFFFFFF
    return encode(Sample(seq & 0xFFFF, time_us, count, 0, answered & 0xFFFF, delay_us, flags, *6 * (0,)))


class SteppedBoard(FakeBoard):
    """A board without a clock: sends a sample, waits for the force that answers it, sends the next.

    counts: sensor counts, one a sample; delay_us: what it says of each answer, None for nothing; first:
    number of the first sample. At the end it falls silent; ``finished`` says that all was answered.
    """

    def __init__(self, counts, delay_us=None, first=0):
        self.counts, self.delay_us, self.first = list(counts), delay_us, first
        self.sent = 0
        self.answers = []
        super().__init__(self._say_next)

    def _say_next(self, message):
        if isinstance(message, HelloRequest):
            return encode(Hello(**HELLO_FIELDS))
        if isinstance(message, Stream) and message.on:
            return self._next()
        if isinstance(message, Force) and self.sent and not self.finished:
            self.answers.append(message)
            return self._next()
        return None

    def _next(self):
        self.sent += 1
        if self.finished:
            return None
        answered, delay = 0, 0
        if self.answers and self.delay_us is not None:
            answered = self.answers[-1].seq - self.answers[-1].behind
            delay = self.delay_us
        return sample(self.first + self.sent - 1, self.counts[self.sent - 1], answered, delay)

    @property
    def finished(self):
        return self.sent > len(self.counts)


class Told(FakeBoard):
    """Says what the test tells it to, and knows hello."""

    def __init__(self):
        self.streaming = threading.Event()
        super().__init__(self._answer)

    def _answer(self, message):
        if isinstance(message, Stream) and message.on:
            self.streaming.set()
        return encode(Hello(**HELLO_FIELDS)) if isinstance(message, HelloRequest) else None

    def forces(self):
        return [m for m in list(self.received) if isinstance(m, Force)]


def connector(kind, monkeypatch, finally_):
    def connect(board, hold=0.0, environment="spring", values=None, **loop):
        def driver_for(device):
            driver = kind(device)
            driver.hold_seconds = hold
            return driver

        monkeypatch.setattr(engine_module, "driver_for", driver_for)
        engine = Engine(HapkitBoard(board.path), environment, realtime=False)
        engine.set_environment(environment, values or {})
        engine.set_loop(**loop)
        finally_(board.unplug)
        finally_(engine.close)
        return engine

    return connect


def stream_once(engine, board):
    """Run a stepped board to its end; return (rows, answers, the engine's health and fault then)."""
    reader = engine.reader()
    engine.start()
    wait_until(lambda: board.finished)
    health, fault = engine.health(), engine.fault
    engine.close()
    return reader.read(), board.answers, health, fault


def played(connect, make_board, **options):
    """Run a stepped board to its end undisturbed; return (rows, answers, the engine's health then).

    On a busy machine the loop may be away for too long (stale), or always find the next sample there already,
    as this board answers without a pause (the latched fault of a machine that cannot keep up).
    """
    for _ in range(ATTEMPTS):
        out, answers, health, fault = stream_once(connect(board := make_board(), **options), board)
        late = fault is not None and fault.code in LATENESS
        if not late and not np.any(out[:, rows.FLAGS].astype(int) & rows.STALE):
            return out, answers, health
    raise AssertionError("the machine was too busy")


def stream(connect, make_board, **options):
    """Run a stepped board to its end undisturbed; return (rows, answers)."""
    return played(connect, make_board, **options)[:2]


def told(connect, **options):
    board = Told()
    engine = connect(board, **options)
    reader = engine.reader()
    engine.start()
    assert board.streaming.wait(PATIENCE)
    return board, engine, reader


def repeated(scenario, begin, excusable=lambda *begun: True):
    """Return a test: the scenario on what begin(connect) returns, again where the machine got in its way."""

    def test(connect):
        for left in reversed(range(ATTEMPTS)):
            begun = begin(connect)
            try:
                return scenario(*begun)
            except AssertionError:
                if not left or not excusable(*begun):
                    raise
        return None

    test.__doc__ = scenario.__doc__
    return test


def undisturbed(**options):
    """Run a scenario with a board that does what it is told."""
    return lambda scenario: repeated(scenario, lambda connect: told(connect, **options))


def read(reader, count):
    """Return the next rows, at least count of them."""
    return support.read(reader, lambda found: len(found) >= count)
