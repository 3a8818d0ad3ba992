"""Late and irregular loops: the stiffness up to which a spring's motion dies out in the mean square.

At every sample a period and a lateness of its force are drawn, independently of all before. With the loop's
map A from one sample to the next, the mean of the state's products goes on by E[A x A] (Kronecker), and dies
out where that map's roots lie inside the unit circle. Then a single motion dies out as well, almost surely
(Feng and others, IEEE Trans. Automatic Control 37(1), 1992); it may still do so a little above the limit,
where a few that grow make the mean.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability.limits import checked_loop, simple_rule
from hapkit_studio.analysis.stability.objects import first_limit
from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.dynamics.sample_matrix import radius, sample_matrix, spring, used, without_law
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import headless, rows

Progress = Callable[[int, int], None]

# Of the simple rule's limit: how far up one is looked for, in so many steps; measured, in so many halvings.
_FAR, _SCAN = 1.5, 76
_TRIED, _FINER = 13, 9
# So much of the recorded lateness is all of it.
_WHOLE = 0.95
# Timings closer than this share of a period are one.
_SAME = 1e-3


@dataclass(frozen=True)
class Timing:
    """What may be drawn, each pair as likely: periods (n,) and how late their forces act (n,), both in s.

    A force is late by less than its period, besides the loop's own whole periods of delay.
    """

    periods: np.ndarray
    late: np.ndarray

    def common(self, period: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the different pairs (k, 2), to a thousandth of a period, and their shares (k,)."""
        step = _SAME * period
        pairs = np.rint(np.column_stack([self.periods, self.late]) / step)
        found, count = np.unique(pairs, axis=0, return_counts=True)
        return found * step, count / count.sum()


def late_by(setting: Setting, lateness: np.ndarray) -> Timing:
    """Return the timing of samples that come on time, their forces later by lateness (n,) than the delay.

    What would come later than the next sample does, comes with it.
    """
    period = setting.period
    late = np.minimum(setting.parted[1] + np.maximum(lateness, 0.0), (1.0 - _SAME) * period)
    return Timing(np.full(len(late), period), late)


def mean_square_limit(setting: Setting, damping: float, timing: Timing) -> float:
    """Return the stiffness in N/m up to which a motion's mean square dies out; raise ParameterError."""
    if not setting.linear:
        raise ParameterError("The velocity filter is not linear: there is no mean-square limit.")
    loop = checked_loop(
        setting.mass, setting.viscous, 0.0, setting.rate, setting.delay, setting.estimator, setting.hand,
        setting.quantum,
    )  # fmt: skip
    pairs, share = timing.common(setting.period)
    maps = [(without_law(loop, 0, *pair), pair[0]) for pair in pairs.tolist()]
    both = [sample_matrix(free, spring(k, damping), 0, period) for k in (0.0, 1.0) for free, period in maps]
    free, sprung = np.split(used(np.array(both)), 2)
    slope = sprung - free

    def products(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        size = a.shape[-1] ** 2
        return np.einsum("n,nac,nbd->abcd", share, a, b, optimize=True).reshape(size, size)

    none, one, two = products(free, free), products(free, slope), products(slope, slope)
    one = one + products(slope, free)
    scan = np.linspace(0.0, _farthest(setting, damping), _SCAN)[1:]
    return first_limit(lambda k: radius(none + k * (one + k * two)) < 1.0, scan)


def growth(
    setting: Setting, damping: float, stiffness: float, timing: Timing, runs: int = 300, seed: int = 0
) -> float:
    """Return the growth in 1/s of the mean square of so many motions let go, drawn and rendered by the tick.

    Of the mean energy between the second and the last quarter. The same seed draws the same timings.
    """
    rng = np.random.default_rng(seed)
    grip = setting.grip or Grip(0.0, 0.0, 0.0)
    mass, held = setting.mass + grip.mass, stiffness + grip.stiffness
    taken = 2.5 * (mass / (setting.viscous + grip.damping)) + 12.0 * math.sqrt(mass / held)
    count = 4 * math.ceil(0.25 * taken * setting.rate)
    values = {"stiffness": stiffness, "damping": damping, "center": 0.0}
    scene = headless.Scene(
        environments.named("spring"), values, setting.device(real=False, position=1e-3), setting.loop,
        designed_for=setting.quantum or None,
    )  # fmt: skip
    hand, whole = np.array([grip.mass, grip.damping, grip.stiffness]), setting.parted[0]
    energy, out = np.zeros(count), headless.new_rows(count)
    with np.errstate(all="ignore"):  # far from a limit a motion grows to infinity, or dies out altogether
        for _ in range(runs):
            drawn = rng.integers(len(timing.periods), size=count)
            r, body = scene.prepare()
            periods = timing.periods[drawn]
            headless.run_irregular(r, body, hand, periods, whole * periods + timing.late[drawn], out)
            x, v = out[:, rows.TRUE_POSITION], out[:, rows.TRUE_VELOCITY]
            energy += mass * v * v + held * x * x
        quarters = energy.reshape(4, -1).mean(axis=1)
        ratio = quarters[3] / max(quarters[1], np.finfo(float).tiny)
        return float(np.log(ratio) / (0.5 * count * timing.periods.mean()))


def measured_limit(setting: Setting, damping: float, timing: Timing) -> float:
    """Return the stiffness in N/m up to which so many motions let go lose energy, by simulation alone."""
    scan = np.linspace(0.0, _farthest(setting, damping), _TRIED)[1:]
    return first_limit(lambda k: growth(setting, damping, k, timing) < 0.0, scan, _FINER)


def _farthest(setting: Setting, damping: float) -> float:
    """Return in N/m how far up a limit is looked for, by the simple rule."""
    return _FAR * float(simple_rule(setting, np.array([damping]))[0])


@dataclass(frozen=True)
class Cost:
    """What a loop's lateness costs: limits (n,) in N/m over its size, from none to more than was recorded.

    late (n,): in s, by how much the forces come later in the mean; measured (n,): the limits by simulation,
    empty where that was not asked. here: which of them is the recorded one; whole: all of that is in it, none
    came later than the next sample.
    """

    setting: Setting
    damping: float
    late: np.ndarray
    limits: np.ndarray
    measured: np.ndarray
    here: int
    whole: bool

    @property
    def words(self) -> str:
        """Return what the recorded lateness costs, at least: "12 N/m: 453 instead of 465 N/m"."""
        steady, late = round(self.limits[0]), round(self.limits[self.here])
        if late >= steady:
            return f"nothing: {late:,} N/m"
        return f"{'' if self.whole else 'at least '}{steady - late:,} N/m: {late:,} instead of {steady:,} N/m"


def cost(
    setting: Setting, damping: float, lateness: np.ndarray, steps: int = 1, progress: Progress | None = None
) -> Cost:
    """Return what a recorded lateness (n,) in s costs on a handle that samples on time.

    In so many steps up to it; with more than one, as many beyond it. progress: called as progress(done, of)
    the limits are measured as well. Raise ParameterError.
    """
    sizes = np.arange(2 * steps + 1 if steps > 1 else 2) / steps
    timings = [late_by(setting, size * lateness) for size in sizes.tolist()]
    limits = np.array([mean_square_limit(setting, damping, timing) for timing in timings])
    if not np.isfinite(limits).all():
        top = _farthest(setting, damping)
        raise ParameterError(f"There is no limit up to {top:,.0f} N/m that jitter could lower.")
    measured = []
    if progress is not None:
        for done, timing in enumerate(timings, 1):
            measured.append(measured_limit(setting, damping, timing))
            progress(done, len(timings))
    late = np.array([timing.late.mean() for timing in timings]) - setting.parted[1]
    whole = late[steps] >= _WHOLE * np.maximum(lateness, 0.0).mean()
    return Cost(setting, damping, late, limits, np.array(measured), steps, bool(whole))
