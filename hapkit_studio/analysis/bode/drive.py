"""The excitation for a Bode diagram, and the Fourier components of signals at its frequencies.

A linear law is excited by multisines, which contain all tones at once. A nonlinear law is excited by single
sines, because superposition does not hold. The period of a motion is a whole number of samples, and
every tone has a whole number of cycles per period, which avoids leakage (Pintelon and Schoukens, System
Identification, 2012). Each point's confidence interval is computed from several motions with the same tones
and different phases.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

REPEATS = 4  # motions with the same tones and different phases
PERIOD, SETTLE = 1.0, 0.5  # s: evaluated period of a motion, and duration of the fade-in before it
HIGHEST = 0.8  # highest tone, as a fraction of the Nyquist frequency
_TONES, _SINES = 32, 16  # number of tones in a multisine; number of single sines
# Hz: below this frequency all tones have the same amplitude. Above it they have the same speed, because no
# handle moves at tens of m/s.
_EQUAL_AMPLITUDE = 200.0
_SAMPLES_PER_CYCLE = 4  # samples per cycle of the fastest tone, for finding the motion's peak


@dataclass(frozen=True)
class Drive:
    """Periodic motions about ``place`` in m with at most ``amplitude`` in m, for a loop rate in Hz.

    If ``sines`` is true, each motion has one tone. ``repeats`` is the number of motions for each set of
    tones.
    """

    place: float
    amplitude: float
    rate: float
    sines: bool = False
    repeats: int = REPEATS

    @cached_property
    def samples(self) -> int:
        """Return the samples per period."""
        return round(PERIOD * self.rate)

    @property
    def period(self) -> float:
        """Return the period of a motion in s."""
        return self.samples / self.rate

    @cached_property
    def settle(self) -> float:
        """Return the duration of the fade-in in s, which is a whole number of samples."""
        return round(SETTLE * self.rate) / self.rate

    @property
    def slot(self) -> float:
        """Return the time in s from one motion to the next."""
        return self.settle + self.period

    @property
    def motions(self) -> int:
        """Return the number of different motions."""
        return self.repeats * (self.tones.size if self.sines else 1)

    @cached_property
    def tones(self) -> np.ndarray:
        """Return the frequencies (n,) in Hz, spaced logarithmically, with whole cycles per period."""
        most, count = int(0.5 * HIGHEST * self.samples), _SINES if self.sines else _TONES
        return np.unique(np.rint(np.geomspace(1, most, count))) / self.period

    def tones_in(self, motion: int) -> np.ndarray:
        """Return the indices of the tones in a motion."""
        return np.array([motion // self.repeats]) if self.sines else np.arange(self.tones.size)

    @cached_property
    def _phases(self) -> np.ndarray:
        return np.random.default_rng(0).uniform(0.0, 2.0 * math.pi, (self.motions, self.tones.size))

    @cached_property
    def _amplitudes(self) -> np.ndarray:
        """Return the amplitude of each tone in each motion (motions, n); a motion's peak is at most 1."""
        even = np.minimum(1.0, _EQUAL_AMPLITUDE / self.tones)
        if self.sines:
            return np.broadcast_to(even, self._phases.shape)
        instants = np.arange(_SAMPLES_PER_CYCLE * self.samples) / (_SAMPLES_PER_CYCLE * self.rate)
        shares = np.empty_like(self._phases)
        for motion in range(self.motions):
            shares[motion] = even
            shares[motion] /= np.abs(self._sum(instants, motion, shares)).max()
        return shares

    def _sum(self, times: np.ndarray, motion: int, shares: np.ndarray) -> np.ndarray:
        found = np.zeros_like(times)
        for tone in self.tones_in(motion):
            angle = 2.0 * math.pi * self.tones[tone] * times + self._phases[motion, tone]
            found += shares[motion, tone] * np.sin(angle)
        return found

    def position(self, times: np.ndarray) -> np.ndarray:
        """Return the handle's position (n,) in m at times (n,) in s; it is ``place`` before the first motion.

        Consecutive motions are cross-faded, so that the handle never jumps.
        """
        turn, since = np.divmod(times, self.slot)
        fade = np.sin(0.5 * math.pi * np.minimum(since / self.settle, 1.0)) ** 2
        found = np.where(turn >= 0.0, fade * self._motion_at(turn, since), 0.0)
        fading = (turn >= 1.0) & (fade < 1.0)
        found[fading] += (1.0 - fade[fading]) * self._motion_at(turn[fading] - 1.0, since[fading] + self.slot)
        return self.place + self.amplitude * found

    def _motion_at(self, turn: np.ndarray, since: np.ndarray) -> np.ndarray:
        """Return the positions (n,) of motions ``turn`` (n,) at times (n,) in s since their start."""
        which = turn.astype(int) % self.motions
        if self.sines:
            tone = which // self.repeats
            angle = 2.0 * math.pi * self.tones[tone] * since + self._phases[which, tone]
            return self._amplitudes[which, tone] * np.sin(angle)
        found = np.empty_like(since)
        for motion in range(self.motions):
            mine = which == motion
            found[mine] = self._sum(since[mine], motion, self._amplitudes)
        return found

    def begin(self, motion: int) -> float:
        """Return the time in s at which a motion's evaluated period begins."""
        return motion * self.slot + self.settle


def component(tones: np.ndarray, times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the complex amplitudes (n,) at tones in Hz of values (m,) at times (m,) over a period."""
    return 2.0 / len(times) * np.exp(-2j * math.pi * np.outer(tones, times)) @ values


def staircase(tones: np.ndarray, edges: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the complex amplitudes (n,) at tones in Hz of a staircase of values (m,) between edges (m + 1,).

    The result is exact for the staircase in continuous time, not for its samples.
    """
    turn = 2j * math.pi * tones
    steps = -np.diff(np.exp(-np.outer(turn, edges)), axis=1)
    return 2.0 / (edges[-1] - edges[0]) * (steps @ values) / turn
