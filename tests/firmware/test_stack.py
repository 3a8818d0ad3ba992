"""How deep the stack gets while everything happens at once: the build counts on no more."""

import pytest

from hapkit_studio import environments
from hapkit_studio.laws.board import Program
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import (
    TUNED,
    Alive,
    Hello,
    HelloRequest,
    Leave,
    Release,
    Sample,
    Save,
    Sensor,
    SettingsRequest,
    Stop,
    Stream,
    Telemetry,
    Tune,
)
from tests.firmware import kits
from tests.firmware.board_runs import announced, piece, program, usual
from tests.firmware.faults_turns import Turns
from tests.firmware.test_firmware import stack_counted
from tests.firmware.vb import needs_board

pytestmark = needs_board

TOP = 0x8FF
"""Where the stack begins."""
# Among them the ones with the deepest functions, with subroutines and with much to verify.
LAWS = (
    ("texture", {"kind": "grating"}, 4000),
    ("detents", {}, 4000),
    ("button", {}, 1000),
    ("puck", {}, 1000),
    ("cat", {}, 500),
)
# Too fast a handle at first and now and then, else to and fro.
MOTION = [f"{0.02 * k:.2f} position {0.04 * (-1) ** k} {0.018 if k % 20 else 0.005}" for k in range(1, 150)]


class Talk:
    """A computer that asks for everything while laws come and go."""

    def __init__(self, turns: Turns):
        self.turns, self._decoder = turns, Decoder()
        self.heard: list = []

    def turn(self) -> list:
        self.turns.turn()
        new = self._decoder.feed(self.turns.take(4096))
        self.heard += new
        return new

    def say(self, *messages) -> None:
        self.turns.say(b"".join(map(encode, messages)))

    def load(self, law: Program, rate: int, generation: int) -> None:
        """Send a law, a piece a sample, with questions in between; what gets lost is said again."""
        head = announced(law, rate, usual(rate), generation)
        for turn in range(2000):
            known = False
            for message in self.turn():
                known = message.generation == generation if isinstance(message, Sample | Telemetry) else known
                if known and isinstance(message, Telemetry):
                    return
                if known and isinstance(message, Sample):
                    assert not message.refusal
                    self.say(piece(law, generation, message.received))
            if turn % 5 == 0:
                self.say(*(() if known else (head,)), HelloRequest(), SettingsRequest(), Alive())
        raise AssertionError("the law never began")

    def run(self, law: Program, generation: int, seconds: float) -> None:
        """Let a law render, its constants always moving, stopped and let go now and then."""
        moves = range(2 + law.states, 2 + len(law.given))[:TUNED]
        values = law.given[law.states : law.states + len(moves)]
        until, change = self.turns.time + seconds, 0
        while self.turns.time < until:
            self.turn()
            change += 1
            slots, targets = (*moves, *[0] * TUNED)[:TUNED], (*values, *[0.0] * TUNED)[:TUNED]
            self.say(Tune(generation, 128 + change % 100, len(moves), slots, targets))
            self.say(HelloRequest(), SettingsRequest(), Alive())
            if change % 7 == 0:
                self.say(Stop(), Release(), Alive())


@pytest.mark.parametrize("sensor", list(Sensor))
def test_the_stack_takes_no_more_than_the_build_counts_on(tmp_path, sensor):
    kit, memory = kits.board(sensor=sensor), tmp_path / "eeprom"
    memory.write_bytes(kits.eeprom(kit))
    noise = () if sensor == Sensor.QUADRATURE else ("--sensor-jump", "0.02")
    turns = Turns(tmp_path, MOTION, (*kits.options(kit, memory), *noise))
    talk = Talk(turns)
    room = turns.ask(HelloRequest(), Hello).arena
    talk.say(Stream(1, 0))
    for generation, (key, given, rate) in enumerate(LAWS, 1):
        environment = environments.named(key)
        law = program(environment, environment.values(given), rate, room)
        talk.load(law, rate, generation)
        talk.run(law, generation, 0.1)
        talk.say(Leave(), Leave(), kit, Save())
    summary = turns.end()
    stack = TOP - summary["lowest_stack"]
    assert 200 < stack <= stack_counted()
