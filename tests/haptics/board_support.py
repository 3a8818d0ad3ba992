"""A scripted board that appears to render: it records messages, and sends frames that the test chooses."""

import time
from dataclasses import dataclass, field, replace

import numpy as np

from hapkit_studio.laws.machine import Refusal
from hapkit_studio.protocol.framing import crc16, encode
from hapkit_studio.protocol.messages import Law, Leave, Piece, Sample, Stream, Telemetry, Tune
from tests.devices.fake_board import ARENA, KIT, FakeKit
from tests.waiting import PATIENCE, wait_until

ZERO = 1000


@dataclass
class Loaded:
    """A received law with its data and the received changes of its constants."""

    law: Law
    data: bytearray = field(default_factory=bytearray)
    numbers: np.ndarray = field(default_factory=lambda: np.zeros(0, np.float32))

    @property
    def whole(self):
        return len(self.data) == self.size

    @property
    def size(self):
        return 4 * self.law.given + self.law.code


class RendersItself(FakeKit):
    """A board that receives a law in pieces, and changes of the law; it renders or refuses the complete law.

    ``refuses`` is the reason for which it refuses the law. ``deaf`` is the number of messages of each kind
    that it ignores. ``moving`` is the largest number of constants that it can ramp at the same time.
    """

    def __init__(self, arena=ARENA, refuses=Refusal.NONE, moving=255, **options):
        super().__init__(settings=replace(KIT, **options), arena=arena)
        self.refuses, self.moving = refuses, moving
        self.loaded, self.generation, self.tuned = None, 0, []

    def _law(self, message: Law):
        if message.generation != self.generation:
            self.loaded, self.generation = Loaded(message), message.generation

    def _piece(self, message: Piece):
        if self.loaded is None or message.at != len(self.loaded.data) or self.loaded.whole:
            return
        left = self.loaded.size - message.at
        self.loaded.data += bytes(message.data[:left])
        if self.loaded.whole:
            assert crc16(bytes(self.loaded.data)) == self.loaded.law.check
            self.loaded.numbers = np.frombuffer(
                self.loaded.data[: 4 * self.loaded.law.given], np.float32
            ).copy()

    def _tune(self, message: Tune):
        if not self.renders or message.law != self.generation or message.count > self.moving:
            return
        for slot, value in zip(message.slots[: message.count], message.values, strict=False):
            self.loaded.numbers[slot - 2] = value
        self.tuned.append(message)

    def _leave(self, _message: Leave):
        self.loaded = None

    @property
    def renders(self):
        return self.loaded is not None and self.loaded.whole and self.refuses == Refusal.NONE

    @property
    def announced(self):
        """Return the generation that telemetry contains: that of the last change, or of an unchanged law."""
        since = [t.generation for t in self.tuned if t.law == self.generation]
        return since[-1] if since else self.generation

    @property
    def received(self):
        return 0 if self.loaded is None else len(self.loaded.data)

    def _stream(self, message: Stream):
        return None


class BoardSetup:
    """A board with an engine: the board sends frames one by one, and the loop handles each at once."""

    def __init__(self, kit, board, engine):
        self.kit, self.board, self.engine = kit, board, engine
        self.messages = board.messages
        self.seq = self.clock = 0  # ``clock`` in µs is added to the time stamps of the board
        self.count, self.telemetry, self.sample = ZERO, {}, {}

    def frame(self):
        """Return the next frame: a sample, or telemetry while the board renders."""
        self.seq += 1
        time_us = 1000 * self.seq + self.clock & 0xFFFFFFFF
        if not self.kit.renders:
            count = self.count - self.kit.settings.zero
            why = self.kit.refuses if self.kit.loaded is not None else 0
            state = {"generation": self.kit.generation, "received": self.kit.received, "refusal": int(why)}
            state |= {"flags": 0, "pwm": 0, "rx_errors": 0, "stale": 0} | self.sample
            return encode(Sample(self.seq, time_us, count, 0, self.seq - 1, 500, **state))
        known = {
            "velocity": 0.0, "asked": 0.0, "pwm": 0, "delay_us": 100, "flags": 0, "rx_errors": 0,
            "overruns": 0, "generation": self.kit.announced, "state_at": 0, "state": 0.0,
        }  # fmt: skip
        count = self.count - self.kit.settings.zero
        return encode(Telemetry(seq=self.seq, time_us=time_us, count=count, **known | self.telemetry))

    def run(self, frames):
        """Send frames; return the resulting rows."""
        return [row for _ in range(frames) for row in self.board.send(self.frame())]

    def until(self, true):
        """Send frames until a condition is true; return the rows."""
        found, over = [], time.monotonic() + PATIENCE
        while not true():
            assert time.monotonic() < over, "it never came about"
            found += self.run(1)
        return found

    def excuse_over(self):
        """End the period in which the engine ignores faults that the board has not yet cleared."""
        self.run(1)
        self.engine.driver.conn.state.excused = 0.0

    def go(self, rate=None):
        """Let the board render; return the rows up to the first that it has rendered."""
        assert self.engine.decision(wait=True).refusal == ""
        self.engine.set_where("board", rate)
        return self.until(lambda: self.engine.rendering == "board")

    def change_all_numbers(self):
        """Change every parameter of the environment, and wait until the law is compiled for the board."""
        engine = self.engine
        numbers = {p.key: 0.9 * engine.values[p.key] for p in engine.environment.parameters if not p.discrete}
        engine.set_environment(engine.environment, engine.values | numbers)
        self.compiled()

    def compiled(self):
        """Wait until the requested law is compiled for the board."""
        self.engine.decision(wait=True)
        wait_until(lambda: self.engine.decision().in_force == self.engine.decision().plan is not None)
