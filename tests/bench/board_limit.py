"""The stiffest spring that is stable with the firmware, rendered by the computer and by the board.

The virtual board runs in lockstep, in board time, without Coulomb friction and without a hand. The handle
rests a little off the spring's centre; the peaks of its oscillation give the growth.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.stability.limits import checked_loop
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.sampled_loop import stiffness_limit
from hapkit_studio.haptics.board_plan import coefficients
from hapkit_studio.laws.board import compile
from hapkit_studio.protocol.messages import Sample
from tests.firmware.board_runs import SETTLE, frames, listen, send
from tests.firmware.vb import exchange, opened

MASS, VISCOUS = 0.044, 0.5
_OFF, _PULL = 1.2e-3, 2.0
"""m and N: limits of the initial displacement, far from the force limit and from single counts."""


@dataclass(frozen=True)
class Swing:
    """An oscillation: times in s, positions in m about the centre, and the mean measured delay in s."""

    time: np.ndarray
    position: np.ndarray
    delay: float
    skipped: int = 0

    @property
    def rate(self) -> float:
        """Return the growth rate in 1/s, negative for decay: the slope of the logarithm of the peaks."""
        x = self.position - np.median(self.position[len(self.position) // 2 :])
        turns = np.flatnonzero((np.diff(np.sign(x)) != 0) & (self.time[1:] > self.time[0] + 0.1))
        parts = [slice(a, b) for a, b in pairwise(turns) if b - a > 2]
        peaks = np.array([np.abs(x[part]).max() for part in parts])
        times = np.array([self.time[part].mean() for part in parts])
        return float(np.polyfit(times, np.log(peaks), 1)[0])


@contextmanager
def _board(stiffness: float) -> Iterator[tuple[VirtualBoard, float, float]]:
    """Open a board at rest; yield the board, its position, and a spring centre nearby in m."""
    options = ["--coulomb", "0", "--mass", str(MASS), "--viscous", str(VISCOUS)]
    # the board's clock stops while it waits for a busy machine
    with opened(options=[*options, "--answer-timeout", "60"]) as board:
        board.start_stream()
        start = exchange(board.fileno(), 0.05, lambda sample: 0.0)[-1].count * board.quantum
        yield board, start, start - min(_OFF, _PULL / stiffness)


def on_computer(stiffness: float, damping: float, spec: str, seconds: float) -> Swing:
    """Render a spring on the computer, by replies to the board's samples."""
    with _board(stiffness) as (board, start, centre):
        quantum = board.quantum
        code, coefs = estimators.design(spec, 1000.0, quantum)
        memory = np.zeros(estimators.MEMORY)
        estimators.reset(memory, start)

        def law(sample: Sample) -> float:
            x = sample.count * quantum
            return -stiffness * (x - centre) - damping * estimators.step(code, coefs, memory, x, 1e-3)

        return _swing(exchange(board.fileno(), seconds, law), quantum, centre)


def on_board(stiffness: float, damping: float, spec: str, seconds: float, rate: int) -> Swing:
    """Let the board render the spring itself."""
    with _board(stiffness) as (board, _, centre):
        values = {"stiffness": stiffness, "damping": damping, "center": centre}
        law = compile(environments.named("spring").force, values, 1.0 / rate, board.hello.arena)
        stream = frames(board)
        send(board, law, rate, coefficients(spec, rate, board.quantum), stream)
        seen = listen(board, seconds, stream)
        settled = next(shown for shown in seen if shown.time_us - seen[0].time_us > 1e6 * SETTLE)
        skipped = (seen[-1].overruns - settled.overruns) & 0xFF
        return _swing(seen, board.quantum, centre, skipped)


def _swing(seen: list, quantum: float, centre: float, skipped: int = 0) -> Swing:
    time = np.array([m.time_us for m in seen]) * 1e-6
    delay = float(np.mean([m.delay_us * 1e-6 for m in seen[20:]]))
    return Swing(time, np.array([m.count for m in seen]) * quantum - centre, delay, skipped)


def theory(damping: float, spec: str, rate: float, delay: float, quantum: float = 20.743e-6) -> float:
    """Return the exact stiffness limit in N/m."""
    loop = checked_loop(MASS, VISCOUS, damping, rate, delay, spec, None, quantum)
    return stiffness_limit(loop, damping)
