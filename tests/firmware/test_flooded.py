"""A computer that never stops talking while the board renders: the line is full, with every kind of message.

By board time alone: the same bytes at the same instants in every run.
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.devices.virtual_board import truth
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import (
    PIECE,
    Alive,
    Estimator,
    Force,
    Hello,
    HelloRequest,
    Leave,
    Origin,
    Release,
    Save,
    Sensor,
    Settings,
    SettingsRequest,
    Stop,
    Stream,
    Telemetry,
    Tune,
)
from tests.firmware import kits
from tests.firmware.board_runs import announced, piece, program
from tests.firmware.faults_turns import Turns
from tests.firmware.vb import FULL_FORCE, needs_board
from tests.wide import wide

pytestmark = needs_board

SECONDS = 2.0
BYTES = 100_000
"""Bytes a second that the line carries."""
AHEAD = 2500
"""Bytes that wait: the longest turn, 20 ms, and more."""
KITS = 8
"""Turns of the talk with another kit, half of which come through; then it is saved, which takes 0.25 s."""
SHOWN = ("--await", "0")
LAWS = ("wall", "texture", "friction", "cat", "button", "spring")
RATES = (4000, 2000, 1000, 500)
COEFFICIENTS = ((0.0, 0.0), (0.2, 0.0), (0.35, 120.0))
MOTION = [(0.02, 4.0, 0.5), (0.01, 11.0, 0.7)]


def words_of(turn: int, room: int) -> tuple[bytes, bytes]:
    """Return what sends a law, whole, and what gives one of its constants the value that it has."""
    key, rate, kind = LAWS[turn // 3 % len(LAWS)], RATES[turn % len(RATES)], turn % len(Estimator)
    environment = environments.named(key)
    law = program(environment, environment.values(), rate, room)
    generation = 1 + turn % 255
    head = announced(law, rate, (Estimator(kind), *COEFFICIENTS[kind]), generation)
    pieces = (piece(law, generation, at) for at in range(0, len(law.data), PIECE))
    slots, values = (2 + law.states, *[0] * 5), (law.given[law.states], *[0.0] * 5)
    return b"".join(map(encode, (head, *pieces))), encode(Tune(generation, 200, 1, slots, values))


def talk(room: int, kit) -> Iterator[bytes]:
    """Yield what a computer may say and what none would, again and again."""
    rng = np.random.default_rng(3)
    for turn in itertools.count(1):
        law, change = words_of(turn, room)
        for number in range(8):
            yield encode(Alive()) + encode(Force(number, number, 2.0)) + law
            yield encode(SettingsRequest()) + encode(HelloRequest()) + change
        yield encode(Tune(1 + turn % 255, 201, 7, (255,) * 6, (math.nan,) * 6))
        yield rng.integers(0, 256, 150, dtype=np.uint8).tobytes() + b"\0"
        yield encode(Stream(1, (0, 62, 255)[turn % 3]))
        yield b"\xff" * 300 + b"\0" * 100
        yield encode(replace(kit, max_force=1000.0)) + encode(Stop()) + encode(Release()) + encode(Alive())
        yield encode(Leave()) if turn % 4 == 0 else b"\0"
        yield encode(replace(kit, zero=kit.zero + 500)) if turn <= KITS else encode(Save())


def share(time: float) -> float:
    """Return how full the line is: more than the board can read, then as much as it can, in turns."""
    return 1.0 if time % 0.1 < 0.03 else 0.2


class Flood:
    """Keeps the line to a board full and hears what it says."""

    def __init__(self, turns: Turns, kit):
        self.turns, self.heard, self._decoder = turns, [], Decoder()
        self._words = talk(turns.ask(HelloRequest(), Hello).arena, kit)
        turns.say(encode(Stream(1, 0)))

    def run(self) -> None:
        turns, now, owed = self.turns, self.turns.time, AHEAD
        end = now + SECONDS
        while now < end:
            while owed > 0:
                words = next(self._words)
                turns.say(words)
                owed -= len(words)
            turns.turn()
            self.heard += self._decoder.feed(turns.take(4096))
            owed += share(now) * BYTES * (turns.time - now)
            now = turns.time

    @property
    def bad_frames(self) -> int:
        return self._decoder.bad_frames

    def of(self, kind):
        return [m for m in self.heard if isinstance(m, kind)]


@pytest.mark.slow
@pytest.mark.parametrize("sensor", wide(Sensor, lambda sensor: sensor == Sensor.MAGNETORESISTIVE))
def test_a_full_line_never_keeps_interrupts_off(tmp_path, sensor):
    kit, memory = kits.board(sensor=sensor), tmp_path / "eeprom"
    memory.write_bytes(kits.eeprom(kit))
    turns = Turns(tmp_path, kits.motion(0.05, MOTION), (*kits.options(kit, memory), *SHOWN))
    flood = Flood(turns, kit)
    flood.run()
    summary = turns.end()
    assert 0 < summary["interrupts_off_cycles"] <= 250
    assert summary["overruns"] == summary["overwritten"] == 0  # of bytes, in the chip's port
    assert summary["received"] > 0.95 * 0.44 * BYTES * SECONDS
    heard_all(flood)
    duty = truth(turns.log).duty
    assert FULL_FORCE * (np.abs(duty).max() - 1.0) ** 2 / 255.0**2 <= kit.max_force


def heard_all(flood):
    """Hold what the board said: whole frames, no restart, laws that push, an answer to every question."""
    shown = flood.of(Telemetry)
    assert flood.bad_frames == 0
    assert np.all(np.diff([frame.time_us for frame in shown]) > 0)
    assert np.ptp([frame.rx_errors for frame in shown]) > 0
    assert len({frame.generation for frame in shown}) > 4
    assert sum(frame.pwm != 0 for frame in shown) > 30
    assert flood.of(Hello)
    assert {frame.refused for frame in flood.of(Settings)} == {0, 1}
    assert {Origin.UNSAVED, Origin.STORED} <= {frame.origin for frame in flood.of(Settings)}
