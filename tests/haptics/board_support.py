"""A scripted board that seems to render by itself: what it is told, and frames as the test wants them."""

import time
from dataclasses import replace

from hapkit_studio import environments
from hapkit_studio.haptics import rows, way
from hapkit_studio.haptics.board_offer import fingerprint
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import (
    NO_LAW,
    Board,
    LawName,
    LawRequest,
    Sample,
    Scene,
    Settings,
    Stream,
    Telemetry,
)
from tests.devices.fake_board import FakeBoard
from tests.devices.fake_kit import KIT, FakeKit
from tests.haptics.serial_support import read
from tests.lateness import ATTEMPTS

LAWS = tuple(environments.discover())
ZERO = 1000
SILENCE = 30.0
"""s after which a loop that has not taken a frame has given the board up."""


class RendersItself(FakeKit):
    """Takes scenes, and does what its test says: ``law`` is what it renders, None where the computer does."""

    def __init__(self, changed=(), **options):
        super().__init__(settings=replace(KIT, **options), laws=LAWS)
        self.changed, self.scene, self.hears = changed, None, True

    def _lawrequest(self, message: LawRequest):
        environment = environments.named(LAWS[message.law])
        mark = fingerprint(environment) ^ (environment.key in self.changed)
        numbers = len(environment.parameters), len(environment.state_names)
        return encode(LawName(message.law, *numbers, mark, environment.key))

    def _scene(self, message: Scene):
        if self.hears:
            self.scene = message

    @property
    def renders(self):
        return self.scene is not None and self.scene.law != NO_LAW

    def _stream(self, message: Stream):
        return None


class Desk:
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
        self.count, self.telemetry = ZERO, {}

    def frame(self):
        """Return the next frame: a sample, or telemetry where the board renders."""
        self.seq += 1
        time_us = 1000 * self.seq
        if not self.kit.renders:
            count = self.count - self.kit.settings.zero
            return encode(Sample(self.seq, time_us, count, 0, self.seq - 1, 500, 0, 0, 0))
        known = {
            "velocity": 0.0, "asked": 0.0, "pwm": 0, "delay_us": 100, "flags": 0, "rx_errors": 0,
            "overruns": 0, "generation": self.kit.scene.generation, "state_at": 0, "state": 0.0,
        }  # fmt: skip
        count = self.count - self.kit.settings.zero
        return encode(Telemetry(seq=self.seq, time_us=time_us, count=count, **known | self.telemetry))

    def run(self, frames):
        """Send so many frames; return their rows, those shown."""
        found = []
        for _ in range(frames):
            self.board.say(self.frame())
            answered = self.seq
            over = time.monotonic() + SILENCE
            while self.engine.driver.conn.samples[0, 0] != answered:
                assert time.monotonic() < over, "the loop takes no frame"
                time.sleep(0.0002)
            found.append(self.reader.read())
            time.sleep(0.0003)
        late = self.reader.read()
        found.append(late)
        return [row for part in found for row in part]

    def until(self, true, frames=400):
        """Send frames until something is so."""
        found = []
        while not true():
            assert frames > 0, "it never came about"
            found += self.run(1)
            frames -= 1
        return found

    def go(self, rate=None):
        """Let the board render; return the rows until it does."""
        self.engine.set_where("board", rate)
        return self.until(lambda: self.engine.rendering == "board")

    def told(self, *kinds):
        """Return what the board was told of some kinds of message."""
        return [m for m in list(self.board.received) if isinstance(m, kinds)]

    def clean(self):
        """Tell whether nothing came late; else the test is done again."""
        return self.engine.health().stale_count == 0


def undisturbed(environment="spring", values=None, changed=(), stale=False, **options):
    """Run a scenario at a desk; again where the machine got in its way."""

    def decorated(scenario):
        def test(connect):
            for left in reversed(range(ATTEMPTS)):
                desk = Desk(connect, RendersItself(changed, **options), environment, values=values)
                try:
                    scenario(desk)
                except AssertionError:
                    if not left or (desk.clean() and not stale):
                        raise
                else:
                    return

        test.__doc__ = scenario.__doc__
        return test

    return decorated


__all__ = ["LAWS", "NO_LAW", "ZERO", "Board", "Desk", "Settings", "read", "rows", "undisturbed", "way"]
