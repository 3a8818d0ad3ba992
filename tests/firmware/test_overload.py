"""The firmware at its limits, in board time: a deep stack, a full line, the longest law, and hangs."""

import itertools
import math
import shutil
import struct
from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.devices.virtual_board import truth
from hapkit_studio.laws import machine
from hapkit_studio.laws.board import Program
from hapkit_studio.laws.machine import ARENA, EQUAL, MOST_JUMPS, RAMP, RAMPS
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import (
    PIECE,
    TUNED,
    Alive,
    Estimator,
    Force,
    Hello,
    HelloRequest,
    Leave,
    Origin,
    Release,
    Sample,
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
from tests.firmware.board_runs import announced, piece, program, usual
from tests.firmware.test_firmware import BUILD, make, stack_counted
from tests.firmware.turns import Turns
from tests.firmware.vb import FULL_FORCE, LONGEST_INTERRUPT, needs_board, needs_compiler
from tests.wide import wide

pytestmark = needs_board


class Talk:
    """A computer that communicates with a board; ``heard`` has the board's messages."""

    def __init__(self, turns: Turns):
        self.turns, self.decoder = turns, Decoder()
        self.heard: list = []

    def turn(self) -> list:
        """Advance the board by one turn; return its messages."""
        self.turns.turn()
        new = self.decoder.feed(self.turns.take(4096))
        self.heard += new
        return new

    def send(self, *messages) -> None:
        self.turns.send(b"".join(map(encode, messages)))

    def of(self, kind) -> list:
        return [m for m in self.heard if isinstance(m, kind)]

    def load(self, law: Program, rate: int, generation: int) -> None:
        """Send a law, one piece per sample, with requests in between; send lost pieces again."""
        head = announced(law, rate, usual(rate), generation)
        for turn in range(2000):
            known = False
            for message in self.turn():
                known = message.generation == generation if isinstance(message, Sample | Telemetry) else known
                if known and isinstance(message, Telemetry):
                    return
                if known and isinstance(message, Sample):
                    assert not message.refusal
                    self.send(piece(law, generation, message.received))
            if turn % 5 == 0:
                self.send(*(() if known else (head,)), HelloRequest(), SettingsRequest(), Alive())
        raise AssertionError("the law never began")

    def run(self, law: Program, generation: int, seconds: float) -> None:
        """Let a law render with ramping constants, and with occasional stops and releases."""
        moves = range(2 + law.states, 2 + len(law.given))[:TUNED]
        values = law.given[law.states : law.states + len(moves)]
        until, change = self.turns.time + seconds, 0
        while self.turns.time < until:
            self.turn()
            change += 1
            slots, targets = (*moves, *[0] * TUNED)[:TUNED], (*values, *[0.0] * TUNED)[:TUNED]
            self.send(Tune(generation, 128 + change % 100, len(moves), slots, targets))
            self.send(HelloRequest(), SettingsRequest(), Alive())
            if change % 7 == 0:
                self.send(Stop(), Release(), Alive())


# --- the stack
TOP = 0x8FF
"""Start address of the stack."""
# among them are laws with the deepest functions, with subroutines, and with a long verification
DEEP = (
    ("texture", {"kind": "grating"}, 4000),
    ("detents", {}, 4000),
    ("button", {}, 1000),
    ("puck", {}, 1000),
    ("cat", {}, 500),
)
# the handle moves to and fro; every 20th movement is too fast for the sensor
TO_AND_FRO = [
    f"{0.02 * k:.2f} position {0.04 * (-1) ** k} {0.018 if k % 20 else 0.005}" for k in range(1, 150)
]


@pytest.mark.slow
@pytest.mark.parametrize("sensor", list(Sensor))
def test_stack_use_is_within_the_builds_assumption(tmp_path, sensor):
    kit, memory = kits.board(sensor=sensor), tmp_path / "eeprom"
    memory.write_bytes(kits.eeprom(kit))
    noise = () if sensor == Sensor.QUADRATURE else ("--sensor-jump", "0.02")
    turns = Turns(tmp_path, TO_AND_FRO, (*kits.options(kit, memory), *noise))
    talk = Talk(turns)
    room = turns.ask(HelloRequest(), Hello).arena
    talk.send(Stream(1, 0))
    for generation, (key, given, rate) in enumerate(DEEP, 1):
        environment = environments.named(key)
        law = program(environment, environment.values(given), rate, room)
        talk.load(law, rate, generation)
        talk.run(law, generation, 0.1)
        talk.send(Leave(), Leave(), kit, Save())
    summary = turns.end()
    stack = TOP - summary["lowest_stack"]
    assert 200 < stack <= stack_counted()


# --- a law takes longer to verify than the hardware watchdog permits
OPCODES = {operation.name: operation.code for operation in machine.OPERATIONS}
RESET_AFTER = 0.016


def long_law():
    """Return a law that fills the arena, with as many pending jumps from its start to its end as possible."""
    size = ARENA - 4 * 3 - RAMPS * RAMP
    code = bytearray([OPCODES["MAIN"]])
    jumps = []
    for _ in range(MOST_JUMPS - 1):
        code += bytes([OPCODES["TEST"] | EQUAL, 3, OPCODES["FAR_JUMP"], 0, 0])
        jumps.append(len(code))
    code += bytes([OPCODES["ABSOLUTE"]]) * (size - 1 - len(jumps) - len(code))
    for at in jumps:
        code[at - 2 : at] = struct.pack("<H", len(code) - at)
        code += bytes([OPCODES["ABSOLUTE"]])
    code += bytes([OPCODES["RETURN"]])
    data = struct.pack("<f", 1.0) + code
    return SimpleNamespace(states=0, given=(1.0,), slots=3, code=bytes(code), data=data)


def test_a_law_with_a_long_verification_starts(tmp_path):
    turns = Turns(tmp_path, ())
    talk = Talk(turns)
    talk.send(Stream(1, 0))
    talk.load(long_law(), 500, 1)
    turns.end()
    times = np.array([m.time_us for m in talk.heard if isinstance(m, Sample | Telemetry)]) * 1e-6
    assert np.all(np.diff(times) > 0.0)
    assert np.diff(times).max() > RESET_AFTER


# --- a computer sends continuously while the board renders
SECONDS = 2.0
BYTES = 100_000
"""Number of bytes per second on the line."""
AHEAD = 2500
"""Number of bytes sent in advance: enough for the longest turn of 20 ms, and a reserve."""
KITS = 8
"""Number of turns in which a different kit is sent.

Half of these kits arrive. After these turns the kit is saved, which takes 0.25 s.
"""
LAWS = ("wall", "texture", "friction", "cat", "button", "spring")
RATES = (4000, 3400, 2000, 1600, 1000, 900, 500)
COEFFICIENTS = ((0.0, 0.0), (0.2, 0.0), (0.35, 120.0))
MOTION = [(0.02, 4.0, 0.5), (0.01, 11.0, 0.7)]


def words_of(turn: int, room: int) -> tuple[bytes, bytes]:
    """Return the bytes that send a complete law, and the bytes that change one of its constants."""
    key, rate, kind = LAWS[turn // 3 % len(LAWS)], RATES[turn % len(RATES)], turn % len(Estimator)
    environment = environments.named(key)
    law = program(environment, environment.values(), rate, room)
    generation = 1 + turn % 255
    head = announced(law, rate, (Estimator(kind), *COEFFICIENTS[kind]), generation)
    pieces = (piece(law, generation, at) for at in range(0, len(law.data), PIECE))
    slots, values = (2 + law.states, *[0] * 5), (law.given[law.states], *[0.0] * 5)
    return b"".join(map(encode, (head, *pieces))), encode(Tune(generation, 200, 1, slots, values))


def talk(room: int, kit) -> Iterator[bytes]:
    """Yield valid and invalid messages of a computer, repeatedly."""
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
    """Return the load of the line: alternately more than the board can read, and as much as it can read."""
    return 1.0 if time % 0.1 < 0.03 else 0.2


def flood(turns: Turns, kit) -> Talk:
    """Keep the line to a board full; return the computer's side with the board's messages."""
    frames = talk(turns.ask(HelloRequest(), Hello).arena, kit)
    line, now, owed = Talk(turns), turns.time, AHEAD
    line.send(Stream(1, 0))
    end = now + SECONDS
    while now < end:
        while owed > 0:
            frame = next(frames)
            turns.send(frame)
            owed -= len(frame)
        line.turn()
        owed += share(now) * BYTES * (turns.time - now)
        now = turns.time
    return line


@pytest.mark.slow
@pytest.mark.parametrize("sensor", wide(Sensor, lambda sensor: sensor == Sensor.MAGNETORESISTIVE))
def test_a_full_line_does_not_block_interrupts(tmp_path, sensor):
    kit, memory = kits.board(sensor=sensor), tmp_path / "eeprom"
    memory.write_bytes(kits.eeprom(kit))
    turns = Turns(tmp_path, kits.motion(0.05, MOTION), kits.options(kit, memory))
    line = flood(turns, kit)
    summary = turns.end()
    assert 0 < summary["interrupts_off_cycles"] <= LONGEST_INTERRUPT
    assert summary["overruns"] == summary["overwritten"] == 0  # the chip's port lost no bytes
    assert summary["received"] > 0.95 * 0.44 * BYTES * SECONDS
    duty = truth(turns.log).duty
    assert FULL_FORCE * (np.abs(duty).max() - 1.0) ** 2 / 255.0**2 <= kit.max_force
    # frames are complete, the board did not restart, laws give forces, and every request has a reply
    shown = line.of(Telemetry)
    assert line.decoder.bad_frames == 0
    assert np.all(np.diff([frame.time_us for frame in shown]) > 0)
    assert np.ptp([frame.rx_errors for frame in shown]) > 0
    assert len({frame.generation for frame in shown}) > 4
    assert sum(frame.pwm != 0 for frame in shown) > 30
    assert line.of(Hello)
    assert {frame.refused for frame in line.of(Settings)} == {0, 1}
    assert {Origin.UNSAVED, Origin.STORED} <= {frame.origin for frame in line.of(Settings)}


# --- the hardware watchdog resets firmware that hangs in its tick or main program
HANGS_AT = 0.3
WATCHDOG = 0.025


@needs_compiler
@pytest.mark.parametrize("where", wide([1, 2], lambda where: where == 1))
def test_a_hang_switches_the_motor_off_within_25_ms(tmp_path, where):
    others = shutil.ignore_patterns("program.o", "hapkit.elf", "fuzz", "tests")
    shutil.copytree(BUILD, tmp_path, dirs_exist_ok=True, ignore=others)
    built = make(f"BUILD={tmp_path}", f"DEFINES=-DHAPKIT_HANG={where}", f"{tmp_path}/hapkit.elf")
    assert built.returncode == 0, built.stderr
    turns = Turns(tmp_path, (), ("--await", str(Sample.ID)), tmp_path / "hapkit.elf")
    line = Talk(turns)
    line.send(Stream(1, 0))
    while turns.time < HANGS_AT + 0.06:
        line.send(*(Force(m.seq, 0, 1.0) for m in line.turn() if isinstance(m, Sample)))
    turns.end()
    rows = truth(turns.log)
    before = (rows.time > HANGS_AT - 0.05) & (rows.time < HANGS_AT)
    assert np.all(rows.duty[before] != 0)
    again = rows.time[(rows.time > HANGS_AT) & (rows.duty == 0)]
    assert again.size > 0
    assert again[0] <= HANGS_AT + WATCHDOG
