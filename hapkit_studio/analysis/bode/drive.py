"""How the handle is driven for a Bode diagram: multisines about a place, and what is at their frequencies.

A multisine repeats after a whole number of samples, and each tone has a whole number of swings in it, so that
nothing leaks from one frequency to another (Pintelon and Schoukens, System Identification, 2012). Several
motions with the same tones in other phases tell what is linear from what is not.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

MOTIONS = 4
PERIOD, SETTLE = 1.0, 0.5  # s of a motion that are looked at, and s before, in which it fades in
HIGHEST = 0.8  # of half the rate
_TONES = 32
# Hz: up to here all tones go as far, beyond as fast, as no handle goes at tens of m/s.
_EVEN = 200.0
_LOOKS = 4  # instants in a swing of the fastest tone, to find how far all go together


@dataclass(frozen=True)
class Drive:
    """Motions about a place in m, by an amplitude in m at most, for a loop of a rate in Hz; over and over."""

    place: float
    amplitude: float
    rate: float

    @cached_property
    def samples(self) -> int:
        """Return the samples of a period."""
        return round(PERIOD * self.rate)

    @property
    def period(self) -> float:
        """Return the s after which a motion repeats."""
        return self.samples / self.rate

    @cached_property
    def settle(self) -> float:
        """Return the s in which a motion fades in, a whole number of samples."""
        return round(SETTLE * self.rate) / self.rate

    @property
    def slot(self) -> float:
        """Return the s from one motion to the next."""
        return self.settle + self.period

    @cached_property
    def tones(self) -> np.ndarray:
        """Return the frequencies (n,) in Hz, even on a logarithmic axis, each a whole number of swings."""
        most = int(0.5 * HIGHEST * self.samples)
        return np.unique(np.rint(np.geomspace(1, most, _TONES))) / self.period

    @cached_property
    def _phases(self) -> np.ndarray:
        return np.random.default_rng(0).uniform(0.0, 2.0 * math.pi, (MOTIONS, self.tones.size))

    @cached_property
    def _shares(self) -> np.ndarray:
        """Return how far each tone goes in each motion (MOTIONS, n), all together up to 1."""
        even = np.minimum(1.0, _EVEN / self.tones)
        instants = np.arange(_LOOKS * self.samples) / (_LOOKS * self.rate)
        peaks = [np.abs(self._sum(instants, even, phases)).max() for phases in self._phases]
        return even / np.array(peaks)[:, np.newaxis]

    def _sum(self, times: np.ndarray, shares: np.ndarray, phases: np.ndarray) -> np.ndarray:
        found = np.zeros_like(times)
        for tone, share, phase in zip(self.tones, shares, phases, strict=True):
            found += share * np.sin(2.0 * math.pi * tone * times + phase)
        return found

    def position(self, times: np.ndarray) -> np.ndarray:
        """Return where the handle is (n,) in m at times (n,) in s; before the first motion at its place."""
        turn, since = np.divmod(times, self.slot)
        found = np.zeros_like(times)
        for which in range(MOTIONS):
            mine = (turn % MOTIONS == which) & (times >= 0.0)
            fade = np.sin(0.5 * math.pi * np.minimum(since[mine] / self.settle, 1.0)) ** 2
            found[mine] = fade * self._sum(since[mine], self._shares[which], self._phases[which])
        return self.place + self.amplitude * found

    def begin(self, motion: int) -> float:
        """Return the time in s from which a motion is looked at, for a period."""
        return motion * self.slot + self.settle


def component(tones: np.ndarray, times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the complex amplitudes (n,) at tones in Hz of values (m,) at times (m,) over a period."""
    return 2.0 / len(times) * np.exp(-2j * math.pi * np.outer(tones, times)) @ values


def staircase(tones: np.ndarray, edges: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the complex amplitudes (n,) at tones in Hz of a staircase of values (m,) between edges (m + 1,).

    Exact: of the staircase as it is over continuous time, not of its samples.
    """
    turn = 2j * math.pi * tones
    steps = -np.diff(np.exp(-np.outer(turn, edges)), axis=1)
    return 2.0 / (edges[-1] - edges[0]) * (steps @ values) / turn
