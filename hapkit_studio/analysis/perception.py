"""How different two renderings of a scene feel to one hand, in just-noticeable differences (JND).

| what | one JND | source |
|---|---|---|
| force between fingers and handle | 6 % of it, at least 15 mN | Jones, J. Motor Behavior 1989 |
| place | 0.4 mm | Ho and Srinivasan 1996 |
| vibration of a handle that is held | the least amplitude felt at its frequency | Brisben et al. 1999 |
| an event, such as a click | its presence, or 20 ms | Levitin et al. 1999: touch and hearing |

Nobody tells moments 20 ms apart: a force or a place that the other run has within 20 ms is no difference.
Forces are averaged over as long; what is quicker is a vibration. Who has let go feels neither force nor
vibration, but sees where the handle is.
"""

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np

from hapkit_studio.haptics import rows

FORCE_SHARE, FORCE = 0.06, 0.015  # N
PLACE = 0.4e-3  # m
MOMENT = 0.020  # s
# Hz, and the least amplitude in m that is felt there of a cylinder in a hand; between them on a straight line
# of logarithms. Below 20 Hz a movement is followed by the arm, and told by its place.
_FREQUENCIES = (26.0, 100.0, 250.0)
_AMPLITUDES = (10e-6, 0.5e-6, 0.1e-6)
LOWEST, HIGHEST = 20.0, 400.0  # Hz
WINDOW = 0.25  # s of a vibration that are looked at together
RATE = 1000.0  # Hz at which rows are compared


@dataclass(frozen=True)
class Difference:
    """What is felt of a difference, each in JND: below 1 it is not; inf for an event of one run alone."""

    force: float = 0.0
    place: float = 0.0
    vibration: float = 0.0
    event: float = 0.0

    @property
    def most(self) -> float:
        """Return the largest of them."""
        return max(astuple(self))

    @property
    def word(self) -> str:
        """Return the name of the largest."""
        return max(vars(self), key=lambda name: getattr(self, name))


def least_amplitude(frequency: np.ndarray) -> np.ndarray:
    """Return the least amplitude in m of a vibration that is felt, at frequencies in Hz, of any shape."""
    known, found = np.log(_FREQUENCIES), np.log(_AMPLITUDES)
    at = np.log(frequency)
    below = found[0] + (at - known[0]) * (found[1] - found[0]) / (known[1] - known[0])
    return np.exp(np.where(at < known[0], below, np.interp(at, known, found)))


def difference(
    reference: np.ndarray, other: np.ndarray, *, held: bool, counts: Sequence[int] = ()
) -> Difference:
    """Return what a person tells apart in two runs' rows (n, ROW_WIDTH) at RATE, of the same hand.

    counts: the columns that count events.
    """
    size = min(len(reference), len(other))
    first, second = reference[:size], other[:size]
    if not (
        np.isfinite(first[:, rows.TRUE_POSITION]).all() and np.isfinite(second[:, rows.TRUE_POSITION]).all()
    ):
        return Difference(place=math.inf)
    places = first[:, rows.TRUE_POSITION], second[:, rows.TRUE_POSITION]
    place = float((_apart(*places) / PLACE).max())
    event = max((_events(first[:, column], second[:, column]) for column in counts), default=0.0)
    if not held:
        return Difference(0.0, place, 0.0, event)
    forces = _averaged(first[:, rows.HAND_FORCE]), _averaged(second[:, rows.HAND_FORCE])
    felt = np.maximum(FORCE_SHARE * np.abs(forces[0]), FORCE)
    return Difference(float((_apart(*forces) / felt).max()), place, _vibration(*places), event)


def _samples(seconds: float) -> int:
    return round(seconds * RATE)


def _averaged(values: np.ndarray) -> np.ndarray:
    from scipy.ndimage import uniform_filter1d

    return uniform_filter1d(values, _samples(MOMENT), mode="nearest")


def _apart(one: np.ndarray, two: np.ndarray, reach: int = _samples(MOMENT)) -> np.ndarray:
    """Return how far each of two series (n, ...) is from all that the other is within some samples."""
    return np.maximum(_outside(one, two, reach), _outside(two, one, reach))


def _outside(values: np.ndarray, band: np.ndarray, reach: int) -> np.ndarray:
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    high = maximum_filter1d(band, 2 * reach + 1, axis=0, mode="nearest")
    low = minimum_filter1d(band, 2 * reach + 1, axis=0, mode="nearest")
    return np.maximum(np.maximum(values - high, low - values), 0.0)


def _vibration(*places: np.ndarray) -> float:
    """Return the largest difference of amplitude at any frequency and time, over the least that is felt."""
    frequency, one, two = *_spectrum(places[0]), _spectrum(places[1])[1]
    return float((_apart(one, two, 1) / least_amplitude(frequency)).max(initial=0.0))


def _spectrum(place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies (f,) in Hz and amplitudes (windows, f) in m, a window every MOMENT.

    By acceleration, which a movement of the arm has little of.
    """
    size = _samples(WINDOW)
    frequency = np.fft.rfftfreq(size, 1.0 / RATE)
    wanted = (frequency >= LOWEST) & (frequency <= HIGHEST)
    bend = np.diff(place, 2)
    if len(bend) < size:
        return frequency[wanted], np.zeros((1, wanted.sum()))
    windows = np.lib.stride_tricks.sliding_window_view(bend, size)[:: _samples(MOMENT)]
    shape = np.hanning(size + 1)[:-1]
    found = np.abs(np.fft.rfft(windows * shape, axis=1))[:, wanted] * 2.0 / shape.sum()
    return frequency[wanted], found / (2.0 * np.sin(math.pi * frequency[wanted] / RATE)) ** 2


def _events(one: np.ndarray, two: np.ndarray) -> float:
    """Return how far the same events lie apart, over the least that is told; inf if one is missing."""
    found = [np.repeat(np.arange(1, len(c)), np.maximum(np.diff(c), 0.0).astype(int)) for c in (one, two)]
    if len(found[0]) != len(found[1]):
        return math.inf
    return float(np.abs(found[0] - found[1]).max(initial=0)) / (RATE * MOMENT)
