"""Z-width by simulation: for each virtual damping, the stiffness up to which all walls settle after a hit.

The handle hits the wall at a speed, and a constant force pushes it into the wall, at three sampling phases.
The wall fails if the handle leaves it, or still moves by more than two counts at the end (Colgate & Brown,
ICRA 1994; automated hits after Chawda). Spring and damper act in both directions inside the wall; outside
there is no force. The stiffness rises by a factor up to the first failure, then it is bisected. Around the
limit, walls pass and fail alternately, in a band that is up to a third of the limit wide. The band is
measured with walls 1 % apart; its lower end is the result.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.simulated_handle import simulated_handle
from hapkit_studio.analysis.sweeps import Progress, no_progress, sweep, workers
from hapkit_studio.analysis.zwidth import SIMULATED_DAMPING, result
from hapkit_studio.dynamics.estimators import USUAL_QUANTUM
from hapkit_studio.dynamics.hand import Grip, Hand
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.haptics import headless, rows

# N/m: stiffness of a soft, long spring that models a constant force: its force changes by 1e-6 N per metre
_THREAD = 1e-6
# N/m: upper end of the search
_STIFFEST = 1e6

Arrived = Callable[[float, result.Point], object]


def compute(
    setting: LoopSettings,
    damping: Sequence[float] = SIMULATED_DAMPING,
    protocol: result.Protocol | None = None,
    *,
    progress: Progress = no_progress,
    executor: Executor | None = None,
    arrived: Arrived = lambda damping, point: None,
) -> result.ZWidth:
    """Return the Z-width of a setting; ``arrived`` is called with every new point.

    Raise ParameterError for an invalid argument, and any exception of ``progress``.
    """
    protocol = protocol or result.Protocol()
    levels = result.levels_of(damping)
    result.samples_of(setting, protocol)
    points: list[result.Point] = []
    together = workers(executor)
    for first in range(0, len(levels), together):
        cells = [(setting, protocol, level) for level in levels[first : first + together]]

        def report(done: int, _of: int, before: int = first) -> None:
            progress(before + done, len(levels))

        points += sweep(points_of, cells, executor=executor, progress=report, chunk=1)
        for level, point in zip(levels[first:], points[first:], strict=False):
            arrived(level, point)
    return result.ZWidth.of("simulation", levels, points, setting, result.conditions(setting, protocol))


def points_of(cells: list[tuple[LoopSettings, result.Protocol, float]]) -> list[result.Point]:
    """Return the stiffest wall of each cell (setting, protocol, damping)."""
    found = []
    for setting, protocol, damping in cells:
        held = partial(trial, setting, damping=damping, protocol=protocol)
        softest = protocol.softest
        point = result.stiffest(held, softest, protocol.raised, _STIFFEST, protocol.halvings)
        found.append(result.with_band(held, point, protocol.apart, softest, _STIFFEST))
    return found


def trial(
    setting: LoopSettings, stiffness: float, damping: float, protocol: result.Protocol | None = None
) -> result.TrialOutcome:
    """Return the outcome over all sampling phases of a wall with stiffness in N/m and damping in N·s/m."""
    protocol = protocol or result.Protocol()
    clamped = False
    for phase in protocol.phases:
        out = hit(setting, stiffness, damping, phase, protocol)
        clamped = clamped or bool((out[:, rows.FLAGS].astype(np.int64) & rows.CLAMPED).any())
        x = out[:, rows.TRUE_POSITION]
        if not np.abs(x).max() <= protocol.travel:
            return result.TrialOutcome(result.LEAVES, clamped)
        left = np.ptp(x[-round(protocol.tail * setting.rate) :])
        if left > protocol.counts * (setting.quantum or USUAL_QUANTUM):
            return result.TrialOutcome(result.BUZZES, clamped)
    return result.TrialOutcome("", clamped)


def hit(
    setting: LoopSettings, stiffness: float, damping: float, phase: float, protocol: result.Protocol
) -> np.ndarray:
    """Return the rows of one hit; the handle starts ``phase`` samples before it reaches the wall at 0."""
    values = {"stiffness": stiffness, "damping": damping, "position": 0.0, "side": 0.0, "damping_mode": 1.0}
    start = -phase * protocol.speed * setting.period
    device = simulated_handle(setting, position=start, velocity=protocol.speed)
    device = replace(device, max_force=protocol.max_force)
    grip = setting.grip or Grip(0.0, 0.0, _THREAD)
    goal = protocol.push / grip.stiffness
    pusher = Hand(grip.mass, grip.damping, grip.stiffness, lambda t: 0.0 * t + goal, vectorised=True)
    scene = headless.Scene(environments.named("wall"), values, device, setting)
    return headless.prepare_run(scene, pusher, result.samples_of(setting, protocol)).run()
