"""The difference between two renderings of a scene that one hand feels, in just-noticeable differences (JND).

Instants less than 20 ms apart are not distinguished: a value that the other run reaches within 20 ms is no
difference, and the last 20 ms of a run are not compared. Forces are averaged over 20 ms; faster changes count
as vibration. A released hand feels neither force nor vibration, but the person sees the handle's position.
THRESHOLDS lists one JND per sense with its source.
"""

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np

from hapkit_studio.dynamics.hand import Hand
from hapkit_studio.haptics import rows

FORCE_SHARE, FORCE = 0.06, 0.015  # JND of a force: this fraction of the force, and at least this many N
PLACE = 0.4e-3  # m: JND of a position
MOMENT = 0.020  # s: shorter times are not distinguished
# Frequency in Hz, and the smallest amplitude in m at which most people feel that a cylinder in their hand
# vibrates; interpolated on logarithmic axes. Shape and minimum: Brisben et al.; amplitudes: from memory.
# Below 20 Hz the arm follows the movement, so slower movements are compared by their position.
VIBRATION = (
    (20.0, 17.9e-6), (26.0, 10e-6), (100.0, 0.5e-6),
    (150.0, 0.05e-6), (200.0, 0.05e-6), (250.0, 0.1e-6), (400.0, 1e-6),
)  # fmt: skip
LOWEST, HIGHEST = 20.0, 400.0  # Hz: range of vibration
WINDOW = 0.25  # s: length of the window for a vibration's spectrum
RATE = 1000.0  # Hz: rate at which rows are compared
# ratio of most people's threshold to that of the most sensitive people
STRICT_PLACE, STRICT_VIBRATION = 4.0 / 3.0, 10.0


FROM_MEMORY = " (source not checked)"  # marks a source that was not checked
THRESHOLDS = (
    ("Force", "a change of 6 %", "no smaller change", "Jones 1989, abstract; others say 7 %"),
    ("Small force", "a change of 15 mN", "no smaller change", "none, the value was chosen for this program"),
    (
        "Position", "0.4 mm", "0.3 mm",
        "Ho and Srinivasan 1996: a difference of 0.4 ± 0.1 mm in thickness between two fingers",
    ),
    (
        "Vibration",
        "10 µm at 26 Hz, 0.5 µm at 100 Hz, 0.05 µm at 150 to 200 Hz, 0.1 µm at 250 Hz, 1 µm at 400 Hz",
        "a tenth of these amplitudes",
        f"amplitudes{FROM_MEMORY}; Brisben, Hsiao and Johnson 1999, abstract: a vibrating cylinder in the "
        "hand is felt best at 150 to 200 Hz; some of the 19 people felt even less than 0.01 µm",
    ),
    ("Event, such as a click", "whether it occurs, or that it is 20 ms early or late", "no shorter time",
        f"Levitin and others 1999{FROM_MEMORY}"),
)  # fmt: skip
"""JND of each sense: of most people, of the most sensitive people, and the source."""


@dataclass(frozen=True)
class Difference:
    """Perceived differences in JND, imperceptible below 1; inf if an event occurs in one run only."""

    force: float = 0.0
    place: float = 0.0
    vibration: float = 0.0
    event: float = 0.0

    @property
    def most(self) -> float:
        """Return the largest difference."""
        return max(astuple(self))

    @property
    def strict(self) -> "Difference":
        """Return the differences in JND of the most sensitive people."""
        place, vibration = STRICT_PLACE * self.place, STRICT_VIBRATION * self.vibration
        return replace(self, place=place, vibration=vibration)

    @property
    def word(self) -> str:
        """Return the name of the sense with the largest difference."""
        found = max(vars(self), key=lambda name: getattr(self, name))
        return "position" if found == "place" else found


def least_amplitude(frequency: np.ndarray) -> np.ndarray:
    """Return the smallest perceptible amplitude in m of a vibration at frequencies in Hz."""
    known, found = np.log(np.array(VIBRATION)).T
    return np.exp(np.interp(np.log(frequency), known, found))


def difference_under(
    hand: Hand,
    reference: np.ndarray,
    other: np.ndarray,
    counts: Sequence[int] = (),
    force_share: float = FORCE_SHARE,
) -> Difference:
    """Return the perceived difference of two runs with a hand that may let go; see ``difference``."""
    held = math.ceil(min(hand.release * RATE, len(reference)))
    seen = difference(reference, other, held=False, counts=counts)
    felt = Difference()
    if held:
        felt = difference(reference[:held], other[:held], held=True, force_share=force_share)
    return replace(seen, force=felt.force, vibration=felt.vibration)


def difference(
    reference: np.ndarray,
    other: np.ndarray,
    *,
    held: bool,
    counts: Sequence[int] = (),
    force_share: float = FORCE_SHARE,
) -> Difference:
    """Return the perceived difference of two runs' rows (n, ROW_WIDTH) at RATE with the same hand.

    ``counts`` are the columns that count events. ``force_share`` is the JND of a force as a fraction of this
    force.
    """
    size = min(len(reference), len(other))
    first, second = reference[:size], other[:size]
    if not (
        np.isfinite(first[:, rows.TRUE_POSITION]).all() and np.isfinite(second[:, rows.TRUE_POSITION]).all()
    ):
        return Difference(place=math.inf)
    places = first[:, rows.TRUE_POSITION], second[:, rows.TRUE_POSITION]
    place = float((_differences(*places) / PLACE).max())
    event = max((_events(first[:, column], second[:, column]) for column in counts), default=0.0)
    if not held:
        return Difference(0.0, place, 0.0, event)
    forces = _averaged(first[:, rows.HAND_FORCE]), _averaged(second[:, rows.HAND_FORCE])
    apart = _differences(*forces)
    felt = np.maximum(force_share * np.abs(forces[0][: len(apart)]), FORCE)
    return Difference(float((apart / felt).max()), place, _vibration(*places), event)


def _samples(seconds: float) -> int:
    return round(seconds * RATE)


def _averaged(values: np.ndarray) -> np.ndarray:
    from scipy.ndimage import uniform_filter1d

    return uniform_filter1d(values, _samples(MOMENT), mode="nearest")


def _differences(one: np.ndarray, two: np.ndarray, reach: int = _samples(MOMENT)) -> np.ndarray:
    """Return the distance between two series (n, ...), with a tolerance of ``reach`` samples in time.

    The last ``reach`` samples are left out, because later values are unknown.
    """
    return np.maximum(_outside(one, two, reach), _outside(two, one, reach))[: max(len(one) - reach, 1)]


def _outside(values: np.ndarray, band: np.ndarray, reach: int) -> np.ndarray:
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    high = maximum_filter1d(band, 2 * reach + 1, axis=0, mode="nearest")
    low = minimum_filter1d(band, 2 * reach + 1, axis=0, mode="nearest")
    return np.maximum(np.maximum(values - high, low - values), 0.0)


def _vibration(*places: np.ndarray) -> float:
    """Return the largest difference of amplitude, over frequency and time, relative to the threshold."""
    frequency, one, two = *_spectrum(places[0]), _spectrum(places[1])[1]
    return float((_differences(one, two, 1) / least_amplitude(frequency)).max(initial=0.0))


def _spectrum(place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies (f,) in Hz and amplitudes (windows, f) in m, one window per MOMENT.

    The amplitudes are computed from the acceleration, in which movements of the arm are small.
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
    """Return the largest time between matching events over the threshold; inf if an event has no match."""
    found = [np.repeat(np.arange(1, len(c)), np.maximum(np.diff(c), 0.0).astype(int)) for c in (one, two)]
    if len(found[0]) != len(found[1]):
        return math.inf
    return float(np.abs(found[0] - found[1]).max(initial=0)) / (RATE * MOMENT)
