"""How stiff a spring the real firmware holds still, rendered by the computer and by the board itself.

The virtual board in lockstep, without Coulomb friction and without a hand: all goes by the board's clock. The
handle rests a little way off the spring's centre; whether its swing grows or dies out is read off the peaks.
"""

import os
import select
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.stability.limits import checked_loop, stiffness_limits
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.dynamics import estimators
from hapkit_studio.haptics.board_plan import coefficients
from hapkit_studio.laws import board
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import Alive, Force, Sample, Telemetry
from tests.firmware.board_runs import send

MASS, VISCOUS = 0.044, 0.5
_OFF, _PULL = 1.2e-3, 2.0
"""At most so many m off the centre and so many N: the clamp is far away, and so are single counts."""
_WAIT = 5.0


@dataclass(frozen=True)
class Swing:
    """What a handle did: times in s, positions in m about the centre; the mean delay in s as measured."""

    time: np.ndarray
    position: np.ndarray
    delay: float
    skipped: int = 0

    @property
    def rate(self) -> float:
        """How fast the swing grows in 1/s, negative where it dies out: the slope of its peaks' logarithm."""
        x = self.position - np.median(self.position[len(self.position) // 2 :])
        turns = np.flatnonzero((np.diff(np.sign(x)) != 0) & (self.time[1:] > self.time[0] + 0.1))
        parts = [slice(a, b) for a, b in pairwise(turns) if b - a > 2]
        peaks = np.array([np.abs(x[part]).max() for part in parts])
        times = np.array([self.time[part].mean() for part in parts])
        return float(np.polyfit(times, np.log(peaks), 1)[0])


class Bench:
    """One run of the firmware: frames are answered by board time."""

    def __init__(self) -> None:
        options = ["--coulomb", "0", "--mass", str(MASS), "--viscous", str(VISCOUS)]
        options += ["--answer-timeout", "60"]  # its clock stands still however long a busy machine thinks
        self.board = VirtualBoard("lockstep", options=options)
        self.board.open()
        self.board.start_stream()
        self._decoder = Decoder()

    def frames(self) -> list:
        ready, _, _ = select.select([self.board.fileno()], [], [], _WAIT)
        assert ready, "the board has gone silent"
        return self._decoder.feed(os.read(self.board.fileno(), 4096))

    def say(self, *messages) -> None:
        os.write(self.board.fileno(), b"".join(map(encode, messages)))

    def samples(self, count: int) -> list[Sample]:
        """Return so many samples, each answered by no force."""
        found: list[Sample] = []
        while len(found) < count:
            new = [m for m in self.frames() if isinstance(m, Sample)]
            if new:
                self.say(Force(new[-1].seq, 0, 0.0))
            found += new
        return found

    def close(self) -> None:
        self.board.close()


def off_centre(stiffness: float) -> float:
    """Return how far in m off the centre of a spring the handle begins."""
    return min(_OFF, _PULL / stiffness)


def on_computer(stiffness: float, damping: float, spec: str, seconds: float) -> Swing:
    """Render a spring by the answers to the board's samples."""
    bench = Bench()
    try:
        quantum = bench.board.quantum
        start = bench.samples(50)[-1]
        centre = start.count * quantum - off_centre(stiffness)
        code, coefs = estimators.design(spec, 1000.0, quantum)
        memory = np.zeros(estimators.MEMORY)
        estimators.reset(memory, start.count * quantum)
        seen: list[Sample] = []
        while len(seen) < 1000 * seconds:
            for sample in (m for m in bench.frames() if isinstance(m, Sample)):
                x = sample.count * quantum
                v = estimators.step(code, coefs, memory, x, 1e-3)
                bench.say(Force(sample.seq, 0, -stiffness * (x - centre) - damping * v))
                seen.append(sample)
    finally:
        bench.close()
    delays = [s.delay_us * 1e-6 for s in seen[20:]]
    return _swing(seen, quantum, centre, float(np.mean(delays)))


def on_board(stiffness: float, damping: float, spec: str, seconds: float, rate: int) -> Swing:
    """Let the board render the spring itself."""
    bench = Bench()
    try:
        quantum = bench.board.quantum
        centre = bench.samples(50)[-1].count * quantum - off_centre(stiffness)
        values = {"stiffness": stiffness, "damping": damping, "center": centre}
        law = board.compile(environments.named("spring").force, values, 1.0 / rate, bench.board.hello.arena)
        send(bench.board, law, rate, coefficients(spec, rate, quantum))
        seen: list[Telemetry] = []
        while len(seen) < 1000 * seconds:
            bench.say(Alive())
            seen += [m for m in bench.frames() if isinstance(m, Telemetry)]
    finally:
        bench.close()
    delays = [s.delay_us * 1e-6 for s in seen[20:]]
    skipped = (seen[-1].overruns - seen[0].overruns) & 0xFF
    return _swing(seen, quantum, centre, float(np.mean(delays)), skipped)


def _swing(seen: list, quantum: float, centre: float, delay: float, skipped: int = 0) -> Swing:
    time = np.array([m.time_us for m in seen]) * 1e-6
    return Swing(time, np.array([m.count for m in seen]) * quantum - centre, delay, skipped)


def theory(damping: float, spec: str, rate: float, delay: float, quantum: float = 20.743e-6) -> float:
    """Return the exact stiffness limit in N/m."""
    loop = checked_loop(MASS, VISCOUS, damping, rate, delay, spec, None, quantum)
    return float(stiffness_limits(loop, np.array([damping]))[0])
