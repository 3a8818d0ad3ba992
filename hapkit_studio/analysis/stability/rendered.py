"""The rule by which a rendered spring is stable: let go off its centre, does the handle come to rest?

F = -K (x - c) - B v^ is rendered by the tick on the simulated Hapkit, no force limit, for 12 s or 12,000
samples or 80 rad of the slowest oscillation, whichever is longest.

A linear loop (no Coulomb friction, no sensor steps, a linear velocity estimate) has exact limits, and its map
is taken from these. To measure its boundary all the same it is let go 1 µm away. It DECAYS where the sum of
a² + (ω v)² over the last third of the time is less than over the third before, ω² = K / m, or where it has
died to 1e-30 of its start; otherwise, and beyond 1 m, it GROWS. At 1 % beyond a limit it grows by 0.02 to
0.05 1/s.

Any other loop is let go 200.3 sensor steps away, and 3.3 steps away where it came to rest from there
(Diolaiti et al. 2006). The centre lies half a step off an edge between two steps, where friction holds it
worst: it stays in motion there if the force of one step is more than twice the friction. It DECAYS where
friction holds it for good, or where it reaches 10 % less far in the last third than in the one before. Where
it stays in motion within five steps it BUZZES, which is known once three twelfths of the time reach equally
far; beyond five steps, and beyond 0.2 m at any time, it GROWS. But with a linear velocity estimate the steps
add no more than a bounded motion, a long one near the limit: what has come down by 10 % since the first third
and reaches no farther in the last third than before BUZZES, however far it reaches. The passivity controller
lets a motion of an energy that nobody feels be: with it, what reaches less than 10 % farther BUZZES too, and
so does what grows to no more than twice that energy and reaches no farther than 200.3 steps.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hapkit_studio import environments
from hapkit_studio.analysis.checks import DAMPING, STIFFNESS, checked_row
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability import few_cells
from hapkit_studio.analysis.stability.kb_plane import Cells, Points
from hapkit_studio.analysis.stability.limits import checked_loop
from hapkit_studio.analysis.sweeps import no_progress, sweep
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import USUAL_QUANTUM, Spec, parse
from hapkit_studio.dynamics.hand import Grip, Hand
from hapkit_studio.dynamics.sampled_loop import Intervals, Loop, first_end, stable, stable_intervals
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import headless, survey
from hapkit_studio.haptics.passivity import FELT
from hapkit_studio.haptics.settings import LoopSettings

DECAYS, BUZZES, GROWS = range(3)

SECONDS = 12.0
FEWEST_SAMPLES = 12_000
MOST_SAMPLES = 5_000_000
_TURNS = 80.0
# The softest spring that pulls home within the time a run may take, in N/m.
SOFTEST = 1e-3

LINEAR_START, LINEAR_FAR, LINEAR_FAINT = 1e-6, 1.0, 1e-36
# In sensor steps.
STARTS = (200.3, 3.3)
FEW_STEPS = 5.0
FAR = 0.2
# A second without any motion: by then every velocity estimate has forgotten what was before.
_STILL_SECONDS = 1.0
_DYING, _STEADY, _GROWING = 0.9, 1.01, 1.1


@dataclass(frozen=True)
class Rendered:
    """What renders the spring: the device, its loop with or without the controller, the hand on it.

    quantum in m: what the velocity estimator is designed for where the device's own sensor is ideal.
    """

    device: SimulatedHapkit
    loop: LoopSettings
    grip: Grip | None = None
    quantum: float = USUAL_QUANTUM

    @property
    def step(self) -> float:
        """Return the sensor's step in m, the quantum where the sensor is ideal."""
        return self.device.quantum or self.quantum

    @property
    def linear(self) -> bool:
        """Return whether twice the motion is twice the force, so that its size does not matter."""
        exact = self.device.coulomb_force == 0.0 and self.device.quantum == 0.0 and not self.loop.controller
        return exact and self.linear_estimate

    @property
    def linear_estimate(self) -> bool:
        """Return whether the velocity estimator has a transfer function."""
        return parse(self.loop.estimator)[0].response is not None

    @property
    def exact(self) -> Loop:
        """Return the loop without friction, steps and controller, and without virtual damping."""
        device, loop = self.device, self.loop
        ideal = device.mass, device.viscous, 0.0, loop.rate, loop.delay, loop.estimator, self.grip
        return checked_loop(*ideal, self.step)

    @property
    def mass(self) -> float:
        """Return what moves, handle and hand, in kg."""
        return self.device.mass + (self.grip.mass if self.grip else 0.0)

    def scene(self) -> headless.Scene:
        """Return the spring's scene, with numbers that every run replaces."""
        values = {"stiffness": 0.0, "damping": 0.0, "center": 0.0}
        spring = environments.named("spring")
        return headless.Scene(spring, values, self.device, self.loop, designed_for=self.step)


def softest(what: Rendered) -> float:
    """Return the softest spring in N/m that is looked for: 1 mN/m, or what turns in the longest run."""
    slowest = _TURNS * what.loop.rate / MOST_SAMPLES
    return max(SOFTEST, what.mass * slowest**2)


def judge(what: Rendered, stiffness: ArrayLike, damping: ArrayLike) -> np.ndarray:
    """Return DECAYS, BUZZES or GROWS for stiffness (n,) N/m and damping (n,) N·s/m; raise ParameterError.

    A spring softer than 1 mN/m is taken as one of 1 mN/m.
    """
    stiffness = np.maximum(stiffness, SOFTEST).astype(float)
    damping = np.asarray(damping, dtype=float)
    if what.linear:
        limits = survey.Limits(LINEAR_FAR, survey.NEVER_STILL, LINEAR_FAINT, survey.NEVER_SMALL)
        return _by_envelope(_let_go(what, stiffness, damping, LINEAR_START, 0.0, limits))
    few = FEW_STEPS * what.step
    reach = np.full(stiffness.size, few)
    if what.loop.controller:
        reach = np.clip(4.0 * np.sqrt(FELT / stiffness), few, STARTS[0] * what.step)
    verdict = np.zeros(stiffness.size, dtype=np.int8)
    quiet = np.arange(stiffness.size)
    for start in STARTS:
        found = _let_go_steps(what, stiffness[quiet], damping[quiet], start, few)
        verdict[quiet] = by_reach(found, reach[quiet], what.loop.controller, what.linear_estimate)
        quiet = quiet[verdict[quiet] == DECAYS]
    return verdict


def swings(what: Rendered, stiffness: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """Return how far to each side (n,) in m the handle moves in the last third of the time, let go 200.3
    sensor steps away; stiffness and damping (n,) as ``judge``, nan where there is no such spring.
    """
    swing, there = np.full(stiffness.size, math.nan), np.isfinite(stiffness) & (stiffness > 0.0)
    found = _let_go_steps(what, stiffness[there], damping[there], STARTS[0], survey.NEVER_SMALL)
    swing[there] = 0.5 * _reach(found.parts[:, -(survey.PARTS // 3) :])
    return swing


def _let_go_steps(
    what: Rendered, stiffness: np.ndarray, damping: np.ndarray, start: float, small: float
) -> survey.Found:
    """Render every cell, let go `start` sensor steps away, until it rests or is steady and small, in m."""
    still = math.ceil((_STILL_SECONDS + what.loop.delay) * what.loop.rate)
    limits = survey.Limits(FAR, still, survey.NEVER_FAINT, small)
    return _let_go(what, stiffness, damping, start * what.step, -0.5 * what.device.quantum, limits)


def _let_go(
    what: Rendered,
    stiffness: np.ndarray,
    damping: np.ndarray,
    start: float,
    centre: float,
    limits: survey.Limits,
) -> survey.Found:
    """Render every cell, the handle let go at `start` m from the spring's centre in m."""
    held = what.grip.stiffness if what.grip else 0.0
    turning = np.sqrt((stiffness + held) / what.mass)
    samples = np.maximum(np.maximum(SECONDS, _TURNS / turning) * what.loop.rate, FEWEST_SAMPLES)
    most = int(samples.max(initial=0.0))
    if most > MOST_SAMPLES:
        raise ParameterError(
            f"Measuring at {what.loop.rate:,g} Hz takes {most:,} samples; {MOST_SAMPLES:,} at most."
        )
    numbers = np.column_stack([stiffness, damping, np.full(stiffness.size, centre)])
    parts = np.ceil(samples / survey.PARTS).astype(np.int64)
    cells = survey.Cells(numbers, np.full(stiffness.size, start), parts, turning)
    return survey.survey(what.scene(), what.grip, cells, limits)


def _by_envelope(found: survey.Found) -> np.ndarray:
    """Compare the power of the last third with that of the one before."""
    third = survey.PARTS // 3
    power = found.parts[:, :, survey.POWER]
    before, after = power[:, third : 2 * third].sum(axis=1), power[:, 2 * third :].sum(axis=1)
    settles = (found.ends != survey.LEFT_RANGE) & ((after < before) | (before == 0.0))
    settles |= found.ends == survey.DIED_OUT
    return np.where(settles, DECAYS, GROWS).astype(np.int8)


def by_reach(found: survey.Found, few: float | np.ndarray, held: bool, linear: bool) -> np.ndarray:
    """Compare how far the last third reaches with the one before; few is a buzz's longest reach in m.

    held: a controller holds the motion, and only what reaches ever farther grows. linear: the estimate is,
    and what has come down to a steady motion does not grow.
    """
    third = survey.PARTS // 3
    first = _reach(found.parts[:, :third])
    before, after = _reach(found.parts[:, third : 2 * third]), _reach(found.parts[:, 2 * third :])
    whole = found.ends == survey.COMPLETED
    rests = (found.ends == survey.SETTLED) | (whole & (after < _DYING * before))
    grows = whole & ~rests & (after > few)
    if linear:
        grows &= (after >= _DYING * first) | (after > _STEADY * before)
    if held:
        grows &= after > _GROWING * before
    grows |= found.ends == survey.LEFT_RANGE
    return np.where(grows, GROWS, np.where(rests, DECAYS, BUZZES)).astype(np.int8)


def _reach(parts: np.ndarray) -> np.ndarray:
    """Return how far apart the outermost positions of some parts (n, k, 3) are, in m."""
    return parts[:, :, survey.HIGH].max(axis=1) - parts[:, :, survey.LOW].min(axis=1)


_EXPECTED = 0.05  # the progress shows 50 % when this fraction of a map's cells is rendered
_STIFFEST = 1e9
_PRECISION = 1e-4


def rendered(setting: Setting, real: bool = False) -> Rendered:
    """Return what renders a setting's spring; real: with friction and sensor steps.

    The velocity estimator is that of the device either way, designed for its sensor's quantum.
    """
    quantum = setting.quantum or USUAL_QUANTUM
    return Rendered(setting.device(real), setting.loop, setting.grip, quantum)


def classes(
    setting: Setting, damping: np.ndarray, stiffness: np.ndarray, *, real: bool = False, **sweeping: Any
) -> np.ndarray:
    """Return DECAYS, BUZZES or GROWS (m, n) int8 for every stiffness (m,) N/m and damping (n,) N·s/m.

    Of a map whose stiffness and damping both ascend few cells are rendered, as ``few_cells`` says. sweeping:
    executor and progress, as ``sweep``, for cells that only rendering can judge. Raise ParameterError, and
    what progress raises.
    """
    columns, lines = checked_row(damping, DAMPING), checked_row(stiffness, STIFFNESS)
    what, count, judged = rendered(setting, real), lines.size * columns.size, 0
    progress = sweeping.pop("progress", no_progress)

    def say(done: int, _of: int) -> None:  # how many cells are still to come is known once they are judged
        progress(int(count * (judged + done) / (judged + done + _EXPECTED * count)), count)

    def judge_some(k: np.ndarray, b: np.ndarray) -> np.ndarray:
        nonlocal judged
        cells = list(zip(k.tolist(), b.tolist(), strict=True))
        found = sweep(partial(_classes, what), cells, progress=say, **sweeping)
        judged += len(cells)
        return np.array(found, dtype=np.int8)

    found = _grid(what, columns, lines, judge_some)
    progress(count, count)
    return found


def maps(
    settings: Sequence[Setting],
    damping: np.ndarray,
    stiffness: np.ndarray,
    *,
    real: bool = False,
    **sweeping: Any,
) -> np.ndarray:
    """Return the ``classes`` (s, m, n) int8 of many settings: one sweep, whose cell is a map.

    Raise ParameterError, and what progress raises.
    """
    columns, lines = checked_row(damping, DAMPING), checked_row(stiffness, STIFFNESS)
    cells = [rendered(setting, real) for setting in settings]
    found = sweep(partial(_grids, columns, lines), cells, **sweeping)
    return np.array(found, dtype=np.int8).reshape(len(settings), lines.size, columns.size)


def boundary(setting: Setting, damping: np.ndarray, *, real: bool = False, **sweeping: Any) -> np.ndarray:
    """Return the largest stiffness (n,) N/m that does not grow, to 1e-4, for every damping (n,) N·s/m.

    Found by bisection; 0 where no spring of ``softest`` is stable, inf beyond 1 GN/m. Raise
    ParameterError, and what progress raises.
    """
    task = partial(_limits, rendered(setting, real))
    return np.array(sweep(task, checked_row(damping, DAMPING).tolist(), **sweeping), dtype=float)


def _classes(what: Rendered, cells: list[tuple[float, float]]) -> list[int]:
    return judge(what, *np.array(cells).T).tolist()


def _grids(damping: np.ndarray, stiffness: np.ndarray, cells: list[Rendered]) -> list[np.ndarray]:
    return [_grid(what, damping, stiffness, partial(judge, what)) for what in cells]


def _grid(
    what: Rendered,
    damping: np.ndarray,
    stiffness: np.ndarray,
    judge: Callable[[np.ndarray, np.ndarray], np.ndarray],
) -> np.ndarray:
    """Return the classes (m, n) of stiffness (m,) and damping (n,); a linear loop's from its exact limits.

    judge: classes of stiffness (k,) and damping (k,).
    """
    if what.linear:
        steady = stable(what.exact, np.maximum(stiffness, SOFTEST), damping)
        return np.where(steady, DECAYS, GROWS).astype(np.int8)
    k, b = (axis.ravel() for axis in np.meshgrid(stiffness, damping, indexing="ij"))
    shape = stiffness.size, damping.size
    if not ((np.diff(stiffness) > 0.0).all() and (np.diff(damping) > 0.0).all()):
        return judge(k, b).reshape(shape)
    return few_cells.from_few(shape, lambda at: judge(k[at], b[at]), _strips(what, damping, stiffness))


def _strips(what: Rendered, damping: np.ndarray, stiffness: np.ndarray) -> Iterator[tuple[int, int]]:
    """Yield a cell (row, column) of every strip that is stable, or not, without friction and steps.

    Only of strips that a lattice may miss. None where the velocity estimate is not linear.
    """
    if not what.linear_estimate:
        return
    for column, found in enumerate(stable_intervals(what.exact, damping)):
        edges = np.searchsorted(stiffness, [end for ends in found for end in ends])
        for low, high in pairwise(edges.tolist()):
            if low < high < low + few_cells.STEP:
                yield (low + high) // 2, column


def _limits(what: Rendered, columns: list[float]) -> list[float]:
    return [stiffest(what, damping) for damping in columns]


def stiffest(what: Rendered, damping: float) -> float:
    """Return the stiffness in N/m up to which none grows at a virtual damping in N·s/m."""
    least, beyond = softest(what), math.inf
    if what.linear_estimate and not what.loop.controller:
        beyond = in_first_gap(stable_intervals(what.exact, np.array([damping]))[0], least)
    return largest_stable(lambda k: judge(what, [k], [damping])[0] != GROWS, least, beyond)


def in_first_gap(intervals: Intervals, softest: float = SOFTEST) -> float:
    """Return the middle in N/m between the limit and the next interval of stable springs; inf without one."""
    limit = max(first_end(intervals), softest)
    return next((math.sqrt(limit * low) for low, _ in intervals if low > limit), math.inf)


def largest_stable(
    stable: Callable[[float], bool], softest: float = SOFTEST, beyond: float = math.inf
) -> float:
    """Return the stiffness in N/m, to 1e-4, up to which ``stable`` holds; 0 if nowhere, inf if everywhere.

    Nothing softer than the softest is tried, and beyond a stiffness that is known to be too much only where
    it proves to be stable.
    """
    low, high = 1.0, math.inf
    if beyond < math.inf:
        low, high = (beyond, high) if stable(beyond) else (min(low, beyond / 4.0), beyond)
    while not stable(low):
        if low <= softest:
            return 0.0
        low, high = max(low / 4.0, softest), low
    while high == math.inf:
        if 4.0 * low > _STIFFEST:
            return math.inf
        low, high = (4.0 * low, high) if stable(4.0 * low) else (low, 4.0 * low)
    while high > low * (1.0 + _PRECISION):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return math.sqrt(low * high)


def measured_stiffness_limit(
    mass: float,
    viscous: float,
    *,
    damping: float = 0.0,
    rate: float = 1000.0,
    delay: float = 0.0,
    estimator: Spec = "difference",
    hand: Hand | Grip | str | None = None,
    quantum: float = USUAL_QUANTUM,
) -> float:
    """Return the largest stable virtual stiffness in N/m to 1e-4, found by rendering the spring.

    Arguments as ``stiffness_limit``; a hand rests at the centre. 0 if not even a spring of 1 mN/m is stable
    (of more, where a mass needs more than 5 million samples for 80 rad), inf beyond 1 GN/m. The rule is the
    module's, for an ideal device: with an estimator that is not linear, a buzz of up to five of the
    sensor's counts counts as stable. Raise ParameterError.
    """
    loop = checked_loop(mass, viscous, damping, rate, delay, estimator, hand, quantum)
    device = SimulatedHapkit(mass, viscous, 0.0, 0.0, math.inf)
    settings = LoopSettings(rate, delay, estimator)
    return stiffest(Rendered(device, settings, loop.hand, quantum=quantum or USUAL_QUANTUM), damping)


def measure_points(setting: Setting, damping: np.ndarray, *, real: bool = False, **sweeping: Any) -> Points:
    """Return the boundary as rendering finds it, by bisection in each column; sweeping as ``boundary``."""
    found = boundary(setting, damping, real=real, **sweeping)
    inside = found * (1.0 - 2.0 * _PRECISION)
    swing = swings(rendered(setting, real), inside, damping) if setting.controller else None
    return Points(np.asarray(damping), found, real, setting.controller, swing)


def cell_centres(end: float, count: int) -> np.ndarray:
    """Return the centres (count,) of equal cells from 0 to an end."""
    return (np.arange(count) + 0.5) * (end / count)


def measure_cells(
    setting: Setting, damping: np.ndarray, stiffness: np.ndarray, *, real: bool = False, **sweeping: Any
) -> Cells:
    """Return what rendering does in every cell of the plane; sweeping as ``classes``."""
    found = classes(setting, damping, stiffness, real=real, **sweeping)
    return Cells(np.asarray(damping), np.asarray(stiffness), found, real, setting.controller)
