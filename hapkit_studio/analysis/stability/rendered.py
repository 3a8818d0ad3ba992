"""Stability of a rendered spring by simulation: does a handle settle after its release off the centre?

F = -K (x - c) - B v^ is rendered by the tick on the simulated Hapkit without force limit, for 12 s, 12,000
samples or 80 rad of the slowest oscillation, whichever is longest.

A linear loop (no Coulomb friction, no sensor steps, linear velocity estimate) has exact limits, which are
used for its map. To measure its boundary, the handle is released at 1 µm. The motion DECAYS if the sum of a²
+ (ω v)², with ω² = K / m, is smaller over the last third of the time than over the second third, or if it has
fallen to 1e-30 of its start. Otherwise, and beyond 1 m, it GROWS. At 1 % beyond a limit it grows by 0.02 to
0.05 1/s.

In any other loop the handle is released at 200.3 sensor steps and, if it settles, at 3.3 steps (Diolaiti et
al. 2006). The centre lies half a step off an edge between two steps, which is the worst case for friction:
motion persists if the force of one step is more than twice the friction. The motion DECAYS if friction stops
it, or if its reach in the last third is 10 % less than in the second third. It BUZZES if it keeps moving
within five steps; this is known once three twelfths of the time have equal reach. Beyond five steps it GROWS,
and also if it exceeds 0.2 m at any time. With a linear velocity estimate, quantisation adds only a bounded
motion, which is large near the limit: a motion that is 10 % smaller than in the first third and does not
increase in the last third BUZZES, whatever its reach. The passivity controller tolerates a motion of
imperceptible energy: with the controller, a motion that grows by less than 10 % BUZZES too, and so does one
that grows to at most twice that energy within 200.3 steps.
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
from hapkit_studio.analysis.simulated_handle import simulated_handle
from hapkit_studio.analysis.stability import few_cells
from hapkit_studio.analysis.stability.kb_plane import Cells, Points
from hapkit_studio.analysis.stability.limits import checked_loop
from hapkit_studio.analysis.sweeps import no_progress, sweep
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import USUAL_QUANTUM, Spec, parse
from hapkit_studio.dynamics.hand import Grip, Hand
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.dynamics.sampled_loop import Intervals, first_end, stable, stable_intervals
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import cell_batch, headless
from hapkit_studio.haptics.passivity import FELT

DECAYS, BUZZES, GROWS = range(3)

SECONDS = 12.0
FEWEST_SAMPLES = 12_000
MOST_SAMPLES = 5_000_000
_TURNS = 80.0
# N/m: the softest spring that returns the handle within the longest run
SOFTEST = 1e-3

LINEAR_START, LINEAR_FAR, LINEAR_FAINT = 1e-6, 1.0, 1e-36
# distances of the release from the centre, in sensor steps
STARTS = (200.3, 3.3)
FEW_STEPS = 5.0
FAR = 0.2
# s: every velocity estimate has settled after this time without motion
_STILL_SECONDS = 1.0
_DYING, _STEADY, _GROWING = 0.9, 1.01, 1.1


@dataclass(frozen=True)
class Rendered:
    """Device, loop settings, hand and passivity controller with which a spring is rendered.

    ``quantum`` in m is used for the design of the velocity estimator if the device's sensor is ideal.
    """

    device: SimulatedHapkit
    loop: LoopSettings
    grip: Grip | None = None
    quantum: float = USUAL_QUANTUM

    @property
    def step(self) -> float:
        """Return the sensor's step in m; for an ideal sensor return ``quantum``."""
        return self.device.quantum or self.quantum

    @property
    def linear(self) -> bool:
        """Return True if the loop is linear, so that its stability does not depend on the amplitude."""
        exact = self.device.coulomb_force == 0.0 and self.device.quantum == 0.0 and not self.loop.controller
        return exact and self.linear_estimate

    @property
    def linear_estimate(self) -> bool:
        """Return True if the velocity estimator has a transfer function."""
        return parse(self.loop.estimator)[0].response is not None

    @property
    def exact(self) -> LoopSettings:
        """Return the settings of the loop without friction, quantisation, controller and virtual damping."""
        device, loop = self.device, self.loop
        ideal = device.mass, device.viscous, 0.0, loop.rate, loop.delay, loop.estimator, self.grip
        return checked_loop(*ideal, self.step)

    @property
    def mass(self) -> float:
        """Return the moving mass, handle and hand, in kg."""
        return self.device.mass + (self.grip.mass if self.grip else 0.0)

    def scene(self) -> headless.Scene:
        """Return a scene that contains a spring, with placeholder values."""
        values = {"stiffness": 0.0, "damping": 0.0, "center": 0.0}
        spring = environments.named("spring")
        return headless.Scene(spring, values, self.device, self.loop, designed_for=self.step)


def softest(what: Rendered) -> float:
    """Return the softest spring in N/m: 1 mN/m, or more if its period would exceed the longest run."""
    slowest = _TURNS * what.loop.rate / MOST_SAMPLES
    return max(SOFTEST, what.mass * slowest**2)


def judge(what: Rendered, stiffness: ArrayLike, damping: ArrayLike) -> np.ndarray:
    """Return DECAYS, BUZZES or GROWS for stiffness (n,) in N/m and damping (n,) in N·s/m.

    Stiffnesses below 1 mN/m are treated as 1 mN/m. Raise ParameterError for an invalid value.
    """
    stiffness = np.maximum(stiffness, SOFTEST).astype(float)
    damping = np.asarray(damping, dtype=float)
    if what.linear:
        limits = cell_batch.Limits(LINEAR_FAR, cell_batch.NEVER_STILL, LINEAR_FAINT, cell_batch.NEVER_SMALL)
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
    """Return the amplitude (n,) in m in the last third of the time after a release at 200.3 sensor steps.

    ``stiffness`` and ``damping`` (n,) are those of ``judge``. The amplitude is NaN if the stiffness is not
    positive and finite.
    """
    swing, there = np.full(stiffness.size, math.nan), np.isfinite(stiffness) & (stiffness > 0.0)
    found = _let_go_steps(what, stiffness[there], damping[there], STARTS[0], cell_batch.NEVER_SMALL)
    swing[there] = 0.5 * _reach(found.parts[:, -(cell_batch.PARTS // 3) :])
    return swing


def _let_go_steps(
    what: Rendered, stiffness: np.ndarray, damping: np.ndarray, start: float, small: float
) -> cell_batch.CellResults:
    """Simulate every cell from a release at ``start`` sensor steps, until the motion ends or is steady."""
    still = math.ceil((_STILL_SECONDS + what.loop.delay) * what.loop.rate)
    limits = cell_batch.Limits(FAR, still, cell_batch.NEVER_FAINT, small)
    return _let_go(what, stiffness, damping, start * what.step, -0.5 * what.device.quantum, limits)


def _let_go(
    what: Rendered,
    stiffness: np.ndarray,
    damping: np.ndarray,
    start: float,
    centre: float,
    limits: cell_batch.Limits,
) -> cell_batch.CellResults:
    """Simulate every cell from a release at ``start`` m from the spring's centre in m."""
    held = what.grip.stiffness if what.grip else 0.0
    turning = np.sqrt((stiffness + held) / what.mass)
    samples = np.maximum(np.maximum(SECONDS, _TURNS / turning) * what.loop.rate, FEWEST_SAMPLES)
    most = int(samples.max(initial=0.0))
    if most > MOST_SAMPLES:
        raise ParameterError(
            f"A measurement at {what.loop.rate:,g} Hz takes {most:,} samples, more than {MOST_SAMPLES:,}. "
            "Lower the rate."
        )
    numbers = np.column_stack([stiffness, damping, np.full(stiffness.size, centre)])
    parts = np.ceil(samples / cell_batch.PARTS).astype(np.int64)
    cells = cell_batch.Cells(numbers, np.full(stiffness.size, start), parts, turning)
    return cell_batch.run_cells(what.scene(), what.grip, cells, limits)


def _by_envelope(found: cell_batch.CellResults) -> np.ndarray:
    """Classify each cell by the power of the last third of the time relative to the second third."""
    third = cell_batch.PARTS // 3
    power = found.parts[:, :, cell_batch.POWER]
    before, after = power[:, third : 2 * third].sum(axis=1), power[:, 2 * third :].sum(axis=1)
    settles = (found.ends != cell_batch.LEFT_RANGE) & ((after < before) | (before == 0.0))
    settles |= found.ends == cell_batch.DIED_OUT
    return np.where(settles, DECAYS, GROWS).astype(np.int8)


def by_reach(found: cell_batch.CellResults, few: float | np.ndarray, held: bool, linear: bool) -> np.ndarray:
    """Classify each cell by the reach of the motion in the last third of the time and in the second third.

    ``few`` is the largest reach in m of a motion that BUZZES. If ``held`` is true, a controller limits the
    motion, so a cell GROWS only if its motion continues to grow. If ``linear`` is true, the estimate is
    linear, so a cell whose motion has become smaller and steady does not GROW.
    """
    third = cell_batch.PARTS // 3
    first = _reach(found.parts[:, :third])
    before, after = _reach(found.parts[:, third : 2 * third]), _reach(found.parts[:, 2 * third :])
    whole = found.ends == cell_batch.COMPLETED
    rests = (found.ends == cell_batch.SETTLED) | (whole & (after < _DYING * before))
    grows = whole & ~rests & (after > few)
    if linear:
        grows &= (after >= _DYING * first) | (after > _STEADY * before)
    if held:
        grows &= after > _GROWING * before
    grows |= found.ends == cell_batch.LEFT_RANGE
    return np.where(grows, GROWS, np.where(rests, DECAYS, BUZZES)).astype(np.int8)


def _reach(parts: np.ndarray) -> np.ndarray:
    """Return the peak-to-peak motion in m over several parts (n, k, 3)."""
    return parts[:, :, cell_batch.HIGH].max(axis=1) - parts[:, :, cell_batch.LOW].min(axis=1)


_EXPECTED = 0.05  # progress shows 50 % when this fraction of a map's cells has been rendered
_STIFFEST = 1e9
_PRECISION = 1e-4


def rendered(setting: LoopSettings, real: bool = False) -> Rendered:
    """Return device, loop and hand that render a setting's spring.

    If ``real`` is true, the device has friction and sensor steps. The velocity estimator is designed for the
    device's sensor in both cases.
    """
    quantum = setting.quantum or USUAL_QUANTUM
    return Rendered(simulated_handle(setting, real), setting, setting.grip, quantum)


def classes(
    setting: LoopSettings, damping: np.ndarray, stiffness: np.ndarray, *, real: bool = False, **sweeping: Any
) -> np.ndarray:
    """Return DECAYS, BUZZES or GROWS (m, n) int8 for every stiffness (m,) N/m and damping (n,) N·s/m.

    If both axes ascend, only a few cells are rendered, as described in ``few_cells``. ``sweeping`` contains
    the executor and progress for ``sweep``, for cells without an exact limit. Raise ParameterError for an
    invalid value, and any exception of ``progress``.
    """
    columns, lines = checked_row(damping, DAMPING), checked_row(stiffness, STIFFNESS)
    what, count, judged = rendered(setting, real), lines.size * columns.size, 0
    progress = sweeping.pop("progress", no_progress)

    def report(done: int, _of: int) -> None:  # an estimate, because the number of remaining cells is unknown
        progress(int(count * (judged + done) / (judged + done + _EXPECTED * count)), count)

    def judge_some(k: np.ndarray, b: np.ndarray) -> np.ndarray:
        nonlocal judged
        cells = list(zip(k.tolist(), b.tolist(), strict=True))
        found = sweep(partial(_classes, what), cells, progress=report, **sweeping)
        judged += len(cells)
        return np.array(found, dtype=np.int8)

    found = _grid(what, columns, lines, judge_some)
    progress(count, count)
    return found


def maps(
    settings: Sequence[LoopSettings],
    damping: np.ndarray,
    stiffness: np.ndarray,
    *,
    real: bool = False,
    **sweeping: Any,
) -> np.ndarray:
    """Return the ``classes`` (s, m, n) int8 of many settings by one sweep, in which each cell is a whole map.

    Raise ParameterError for an invalid value, and any exception of ``progress``.
    """
    columns, lines = checked_row(damping, DAMPING), checked_row(stiffness, STIFFNESS)
    cells = [rendered(setting, real) for setting in settings]
    found = sweep(partial(_grids, columns, lines), cells, **sweeping)
    return np.array(found, dtype=np.int8).reshape(len(settings), lines.size, columns.size)


def boundary(
    setting: LoopSettings, damping: np.ndarray, *, real: bool = False, **sweeping: Any
) -> np.ndarray:
    """Return the largest stiffness (n,) in N/m at which no motion grows, for every damping (n,) in N·s/m.

    It is found by bisection to a relative accuracy of 1e-4. It is 0 if the spring of ``softest`` is unstable,
    and inf if it exceeds 1 GN/m. Raise ParameterError for an invalid value, and any exception of
    ``progress``.
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
    """Return the classes (m, n) of stiffness (m,) and damping (n,); exact limits are used for a linear loop.

    ``judge`` returns the classes of stiffness (k,) and damping (k,).
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
    """Yield a cell (row, column) in every narrow stable or unstable strip of the linear loop.

    Only strips that a lattice may miss are included. There are no strips for a nonlinear velocity estimate.
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
    """Return the largest stiffness in N/m at which the motion does not grow, for a damping in N·s/m."""
    least, beyond = softest(what), math.inf
    if what.linear_estimate and not what.loop.controller:
        beyond = in_first_gap(stable_intervals(what.exact, np.array([damping]))[0], least)
    return largest_stable(lambda k: judge(what, [k], [damping])[0] != GROWS, least, beyond)


def in_first_gap(intervals: Intervals, softest: float = SOFTEST) -> float:
    """Return the middle in N/m between the limit and the next stable interval; inf without a next one."""
    limit = max(first_end(intervals), softest)
    return next((math.sqrt(limit * low) for low, _ in intervals if low > limit), math.inf)


def largest_stable(
    stable: Callable[[float], bool], softest: float = SOFTEST, beyond: float = math.inf
) -> float:
    """Return the stiffness in N/m up to which ``stable`` is true; 0 if never, inf if always.

    The relative accuracy is 1e-4. Stiffnesses below ``softest`` are not tried. ``beyond`` is a stiffness
    known to be too large, which is checked again.
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
    """Return the largest stable virtual stiffness in N/m, found by simulating the spring.

    The arguments are those of ``stiffness_limit``; a hand rests at the centre. The result is 0 if the softest
    spring is unstable, and inf if it exceeds 1 GN/m. The softest spring has 1 mN/m, or more for a mass that
    needs more than 5 million samples for 80 rad. The criterion is that of this module, for an ideal device:
    with a nonlinear estimator, a limit cycle of up to five sensor counts is treated as stable. The relative
    accuracy is 1e-4. Raise ParameterError for an invalid argument.
    """
    loop = checked_loop(mass, viscous, damping, rate, delay, estimator, hand, quantum)
    device = SimulatedHapkit(mass, viscous, 0.0, 0.0, math.inf)
    settings = LoopSettings(rate, delay, estimator)
    return stiffest(Rendered(device, settings, loop.grip, quantum=quantum or USUAL_QUANTUM), damping)


def measure_points(
    setting: LoopSettings, damping: np.ndarray, *, real: bool = False, **sweeping: Any
) -> Points:
    """Return the boundary by simulation, with bisection in each column; for ``sweeping`` see ``boundary``."""
    found = boundary(setting, damping, real=real, **sweeping)
    inside = found * (1.0 - 2.0 * _PRECISION)
    swing = swings(rendered(setting, real), inside, damping) if setting.controller else None
    return Points(np.asarray(damping), found, real, setting.controller, swing)


def cell_centres(end: float, count: int) -> np.ndarray:
    """Return the centres (count,) of equal cells from 0 to ``end``."""
    return (np.arange(count) + 0.5) * (end / count)


def measure_cells(
    setting: LoopSettings, damping: np.ndarray, stiffness: np.ndarray, *, real: bool = False, **sweeping: Any
) -> Cells:
    """Return the class of every cell of the plane by simulation; for ``sweeping`` see ``classes``."""
    found = classes(setting, damping, stiffness, real=real, **sweeping)
    return Cells(np.asarray(damping), np.asarray(stiffness), found, real, setting.controller)
