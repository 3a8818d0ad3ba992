"""Late and irregular loops: the stiffness up to which a spring's motion dies out in the mean square.

At every sample a period and a lateness of its force are drawn, independently of all before. With the loop's
map A from one sample to the next, the mean of the state's products goes on by E[A x A] (Kronecker), and dies
out where that map's roots lie inside the unit circle. Then a single motion dies out as well, almost surely
(Feng and others, IEEE Trans. Automatic Control 37(1), 1992); it may still do so a little above the limit,
where a few that grow make the mean.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability.limits import checked_loop
from hapkit_studio.analysis.stability.objects import first_limit
from hapkit_studio.dynamics.sample_matrix import radius, sample_matrix, spring, used, without_law
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import headless, rows

# Of the limit without jitter: how far up it is looked for, in so many steps.
_FAR, _SCAN = 1.5, 76
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
    late = np.minimum(setting.delay % period + np.maximum(lateness, 0.0), (1.0 - _SAME) * period)
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
    top = _FAR * (setting.viscous + damping + (setting.grip.damping if setting.grip else 0.0))
    top /= 0.5 * setting.period + setting.delay
    scan = np.linspace(0.0, top, _SCAN)[1:]
    return first_limit(lambda k: radius(none + k * (one + k * two)) < 1.0, scan)


def growth(
    setting: Setting, damping: float, stiffness: float, timing: Timing, runs: int = 300, seed: int = 0
) -> float:
    """Return the growth in 1/s of the mean square of so many motions let go, drawn and rendered by the tick.

    Of the mean energy between the second and the last quarter. The same seed draws the same timings.
    """
    rng = np.random.default_rng(seed)
    taken = 2.5 * (setting.mass / setting.viscous) + 12.0 * math.sqrt(setting.mass / stiffness)
    count = 4 * math.ceil(0.25 * taken * setting.rate)
    values = {"stiffness": stiffness, "damping": damping, "center": 0.0}
    device = setting.device(real=False, position=1e-3)
    scene = headless.Scene(
        environments.named("spring"), values, device, replace(setting.loop, delay=0.0),
        designed_for=setting.quantum or None,
    )  # fmt: skip
    energy, out = np.zeros(count), headless.new_rows(count)
    for _ in range(runs):
        drawn = rng.integers(len(timing.periods), size=count)
        r, body = scene.prepare()
        headless.run_irregular(r, body, timing.periods[drawn], timing.late[drawn], out)
        x, v = out[:, rows.TRUE_POSITION], out[:, rows.TRUE_VELOCITY]
        energy += setting.mass * v * v + stiffness * x * x
    quarters = energy.reshape(4, -1).mean(axis=1)
    return float(np.log(quarters[3] / quarters[1]) / (0.5 * count * timing.periods.mean()))
