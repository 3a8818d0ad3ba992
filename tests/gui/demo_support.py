"""Fast playback of a demo: the studio's player and settings on the simulated loop, without a clock."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from PySide6.QtCore import QObject

from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.teach import demos
from hapkit_studio.gui.teach.demo_player import DemoPlayer
from hapkit_studio.haptics import clock, simulated_loop
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.haptics.tick import adopt
from tests.gui.window_support import SIMULATED

FRAME = 16  # samples between two positions of the hand


@njit
def samples(r, body, out, count):
    """Render ``count`` samples as the live loop does, but without waiting for the clock."""
    for _ in range(count):
        simulated_loop.render_sample(r, body, out, clock.now(), 0.0)


class FastEngine(Engine):
    """An engine without a thread: a test runs its loop."""

    def start(self):
        device = {k: getattr(self.device, k) for k in ("mass", "viscous", "quantum", "max_force")}
        self._change_loop(**device)
        self.body = simulated_loop.new_plant(self.device)
        adopt(self.arrays, simulated_loop.measure(self.body))
        simulated_loop.follow_settings(self.body, self.arrays)

    def run(self, count):
        samples(self.arrays, self.body, self._ring, count)


@dataclass
class Played:
    """Result of a demo: its rows (n, width), their times (n,) in s since the demo's start, and captions."""

    demo: demos.Demo
    rows: np.ndarray
    time: np.ndarray
    captions: list[str]

    def of(self, at, start=0.0, stop=np.inf):
        """Return the rows of the step that begins at ``at`` s, from start to stop in s after that."""
        ends = [*(step.at for step in self.demo.steps), self.demo.seconds]
        last = min(next(end for end in ends if end > at) - at, stop)
        return self.rows[(self.time >= at + start) & (self.time < at + last)]


class Clock:
    """A clock that a test sets."""

    now = 0.0

    def __call__(self):
        return self.now


def fast_studio(qtbot):
    """Return a studio on a fast engine."""
    studio = Studio(lambda: [SIMULATED], lambda entry: FastEngine(entry.make(), realtime=False))
    studio.device.open(SIMULATED)
    qtbot.waitUntil(lambda: studio.engine is not None)
    return studio


def play(studio, path, rounds=1):
    """Play a demo several times; return the last run."""
    hands, demo = Clock(), demos.read(path, studio.environments)
    player = DemoPlayer(studio, QObject(studio), hands)
    player.play(demo)
    reader, parts, captions = studio.engine.reader(), [], []
    frames = round(demo.seconds * 1000.0) // FRAME
    for frame in range(rounds * frames):
        hands.now = (frame // frames) * demo.seconds + (frame % frames) * 1e-3 * FRAME
        player.tick()
        assert player.demo is demo, (frame, studio.fault)
        studio.engine.run(FRAME)
        parts.append(reader.read())
        captions.append(player.caption)
    player.end()
    last = np.concatenate(parts[-frames:])
    return Played(demo, last, np.arange(len(last)) * 1e-3, captions)
