"""A scripted board that seems to render by itself: what it is told, and frames as the test wants them."""

import time
from dataclasses import dataclass, field, replace

import numpy as np

from hapkit_studio.haptics import arrays, clock, link
from hapkit_studio.laws.machine import Refusal
from hapkit_studio.protocol.framing import crc16, encode
from hapkit_studio.protocol.messages import Law, Leave, Piece, Sample, Stream, Telemetry, Tune
from tests.devices.fake_board import ARENA, KIT, FakeBoard, FakeKit
from tests.haptics.serial_support import repeated
from tests.waiting import PATIENCE

ZERO = 1000
SILENCE = PATIENCE
"""s after which a loop that has not taken a frame has given the board up."""


@dataclass
class Loaded:
    """A law as far as it has come: its data, and what its constants were set to since."""

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
    """Takes a law in pieces and its changes, and renders once it is whole, or refuses it.

    refuses: why; deaf: kinds of message and how many of each it does not hear; moving: constants that it has
    room to move.
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
    def told(self):
        """Return the generation that telemetry says: the last change's, or the law's."""
        since = [t.generation for t in self.tuned if t.law == self.generation]
        return since[-1] if since else self.generation

    @property
    def received(self):
        return 0 if self.loaded is None else len(self.loaded.data)

    def _stream(self, message: Stream):
        return None


class BoardSetup:
    """One such board with the engine on it: frames go out one by one, each is waited for."""

    def __init__(self, connect, kit, environment, **options):
        self.kit = kit
        self.board = FakeBoard(kit)
        self.engine = connect(self.board, environment=environment, **options)
        self.reader = self.engine.reader()
        self.engine.start()
        while not any(isinstance(m, Stream) and m.on for m in self.board.received):
            time.sleep(0.001)
        self.seq = 0
        self.count, self.telemetry, self.sample = ZERO, {}, {}

    def frame(self):
        """Return the next frame: a sample, or telemetry where the board renders."""
        self.seq += 1
        time_us = 1000 * self.seq
        if not self.kit.renders:
            count = self.count - self.kit.settings.zero
            why = self.kit.refuses if self.kit.loaded is not None else 0
            said = {"generation": self.kit.generation, "received": self.kit.received, "refusal": int(why)}
            said |= {"flags": 0, "pwm": 0, "rx_errors": 0, "stale": 0} | self.sample
            return encode(Sample(self.seq, time_us, count, 0, self.seq - 1, 500, **said))
        known = {
            "velocity": 0.0, "asked": 0.0, "pwm": 0, "delay_us": 100, "flags": 0, "rx_errors": 0,
            "overruns": 0, "generation": self.kit.told, "state_at": 0, "state": 0.0,
        }  # fmt: skip
        count = self.count - self.kit.settings.zero
        return encode(Telemetry(seq=self.seq, time_us=time_us, count=count, **known | self.telemetry))

    def run(self, frames):
        """Send so many frames; return their rows, those shown."""
        found = []
        for _ in range(frames):
            conn, said = self.engine.driver.conn, clock.now()
            self.board.say(self.frame())
            over = time.monotonic() + SILENCE
            while conn.samples[0, 0] != self.seq or conn.numbers[link.LAST_ANSWER] < said:
                assert time.monotonic() < over, "the loop takes no frame"
                time.sleep(0.0002)
            found.append(self.reader.read())
            time.sleep(0.0003)
        late = self.reader.read()
        found.append(late)
        return [row for part in found for row in part]

    def until(self, true):
        """Send frames until something is so."""
        found, over = [], time.monotonic() + SILENCE
        while not true():
            assert time.monotonic() < over, "it never came about"
            found += self.run(1)
        return found

    def excuse_over(self):
        """Send frames until what the board latched before it was told to forget is no longer excused."""
        self.run(1)
        self.until(lambda: clock.now() > self.engine.driver.conn.numbers[link.EXCUSED])

    def go(self, rate=None):
        """Let the board render; return the rows until it does."""
        assert self.engine.board_refusal(wait=True) == ""
        self.engine.set_where("board", rate)
        return self.until(lambda: self.engine.rendering == "board")

    def told(self, *kinds):
        """Return what the board was told of some kinds of message."""
        return [m for m in list(self.board.received) if isinstance(m, kinds)]

    def change_all_numbers(self):
        """Change every number of the environment in force; wait until that is compiled for the board."""
        engine = self.engine
        numbers = {p.key: 0.9 * engine.values[p.key] for p in engine.environment.parameters if not p.discrete}
        engine.set_environment(engine.environment, engine.values | numbers)
        self.compiled()

    def compiled(self):
        """Wait until what is wanted is compiled for the board."""
        self.engine.board_refusal(wait=True)
        over = time.monotonic() + SILENCE
        while self.engine.board_plan != self.engine.possible_plan:
            assert time.monotonic() < over
            time.sleep(0.001)


def undisturbed(environment="spring", values=None, stale=False, **options):
    """Run a scenario with such a board; stale: it may be repeated though nothing came late."""

    def begin(connect):
        return (BoardSetup(connect, RendersItself(**options), environment, values=values),)

    def came_late(setup):
        return stale or setup.engine.arrays.control[arrays.STALE_COUNT] > 0

    return lambda scenario: repeated(scenario, begin, came_late)
