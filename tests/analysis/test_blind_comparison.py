"""Blind comparison: can a judge distinguish a scene from the same scene without its unneeded terms?

The judge shares no code with the search for unneeded terms. It gets two tables of rows in random order, and
is not told which terms are missing. All pairs are in one shuffled deck; labels are read after judging.

Motions are each hand's script, random throws, and releases at random instants.

Thresholds are one just-noticeable difference (JND) each:

| quantity | one JND | source |
|---|---|---|
| force between fingers and handle | 6 %, at least 15 mN | Jones, J. Motor Behavior 1989 |
| position | 0.4 mm | Ho and Srinivasan 1996 |
| vibration of a held handle | 10, 0.5, 0.05, 0.1 µm at 26, 100, 150–200, 250 Hz | from memory |
| event | its presence, or 20 ms | Levitin et al. 1999 |
"""

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view
from scipy.signal import butter, sosfilt

from hapkit_studio import environments
from hapkit_studio.devices.simulated import TERMS, SimulatedHapkit
from hapkit_studio.dynamics.hand import Hand, hand_named
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.base import Environment
from hapkit_studio.haptics import headless, rows

LIBRARY = environments.discover()
FAST, RATE = 16_000, 1000  # rates in Hz: a quasi-continuous loop, and a typical student's loop
# Instants within MOMENT samples are not distinguished; vibration is summed over SUMMED samples (Verrillo
# 1965).
MOMENT, SUMMED = 20, 250
SECONDS, DRAWN = 2.0, 24
BANDS = 1000.0 * 2.0 ** (np.arange(-16, -3) / 3.0)  # centres in Hz of the third octaves from 25 to 400 Hz
LEAST = np.exp(
    np.interp(
        np.log(BANDS),
        np.log([25.0, 26.0, 100.0, 150.0, 200.0, 250.0, 400.0]),
        np.log([10.8e-6, 1e-5, 5e-7, 5e-8, 5e-8, 1e-7, 1e-6]),
    )
)


# These terms count as unneeded although they are near the threshold. damping: 0.7 JND alone, but more
# together with the others. hard_surface: perceptible at one of 200 speeds of a throw. friction: perceptible
# after a release at one of 240 instants (1.6 JND at 0.28 s of a pluck, 1.5 JND at 0.08 s of a stroke).
HARDLY = {
    "damping": {"delay"},
    "hard_surface": {"quantization"},
    "friction": {"quantization", "sampling"},
}


# --- the judge


def judged(one: np.ndarray, two: np.ndarray, counts: Sequence[int]) -> dict[str, float]:
    """Return the perceived difference in JND by sense.

    For a released handle, only the position and the number of events are compared.
    """
    pair = one, two
    found = {"place": furthest(*(t[:, rows.TRUE_POSITION] for t in pair), 0.0, 0.4e-3)}
    found["event"] = max((events(*(t[:, column] for t in pair)) for column in counts), default=0.0)
    held = int(np.isfinite(one[:, rows.HAND_TARGET]).sum())
    if held:
        forces = [sliding_window_view(t[:held, rows.HAND_FORCE], MOMENT).mean(axis=1) for t in pair]
        found["force"] = furthest(*forces, 0.06, 0.015)
        places = [t[:held, rows.TRUE_POSITION] for t in pair]
        found["vibration"] = max(
            furthest(*(level(p, f) for p in places), 0.0, a) for f, a in zip(BANDS, LEAST, strict=True)
        )
    return found


def furthest(one: np.ndarray, two: np.ndarray, share: float, least: float) -> float:
    """Return the largest distance in JND between two series that may differ in time by up to MOMENT."""
    return max(beyond(one, two, share, least), beyond(two, one, share, least))


def beyond(values: np.ndarray, other: np.ndarray, share: float, least: float) -> float:
    around = sliding_window_view(np.pad(other, MOMENT, mode="edge"), 2 * MOMENT + 1)
    nearest = np.clip(values, around.min(axis=1), around.max(axis=1))
    return float((np.abs(values - nearest) / np.maximum(share * np.abs(values), least)).max())


def level(place: np.ndarray, frequency: float) -> np.ndarray:
    """Return the amplitude in m in a third octave, from the energy over 0.25 s."""
    edges = frequency * 2.0 ** np.array([-1.0 / 6.0, 1.0 / 6.0])
    band = sosfilt(butter(3, edges, "bandpass", fs=RATE, output="sos"), place - place[0])
    energy = np.convolve(band * band, np.full(SUMMED, 2.0 / SUMMED))
    return np.sqrt(np.maximum(energy, 0.0))


def events(one: np.ndarray, two: np.ndarray) -> float:
    times = [np.flatnonzero(np.diff(column) >= 1.0) for column in (one, two)]
    if len(times[0]) != len(times[1]):
        return math.inf
    return float(np.abs(times[0] - times[1]).max(initial=0)) / MOMENT


# --- the deck


def rendered(scene: Environment, gone: Iterable[str], hand: Hand, speed: float) -> np.ndarray:
    """Return the rows at RATE of a scene that a hand moves, with its defaults, without the terms ``gone``."""
    without, seconds = set(gone), SECONDS if hand.release in (0.0, math.inf) else SECONDS + hand.release
    device = SimulatedHapkit(initial_velocity=speed).without(without)
    rate = FAST if "sampling" in without else RATE
    loop = LoopSettings(rate, 0.0 if "delay" in without else 1e-3, ("iir", {"cutoff": 35.5}))
    made = headless.Scene(scene, scene.values(), device, loop, true_velocity="filter" in without)
    each = rate // RATE
    return headless.render(made, hand, round(seconds * RATE) * each + 1)[0][::each]


def hands(scene: Environment, rng: np.random.Generator) -> Iterator[tuple[Hand, float]]:
    """Yield hands and the handle's initial speed in m/s: scripts, a push, throws, releases."""
    yield hand_named("push"), 0.0  # the push exceeds the force limit
    for name in scene.hands:
        hand = hand_named(name)
        if hand.release <= 0.0:
            yield from ((hand, speed) for speed in (0.5, *rng.uniform(0.3, 0.7, DRAWN)))
        else:
            yield hand, 0.0
            yield from ((replace(hand, release=moment), 0.0) for moment in rng.uniform(0.15, SECONDS, DRAWN))


def deck(scene: Environment) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Return pairs of tables in random order, with the name of the missing term, or "all"."""
    rng, cards = np.random.default_rng(sum(map(ord, scene.key))), []
    spared = {term for term in TERMS if term not in scene.needs}
    missing = {"all": spared} | {term: {term} for term in TERMS}
    for hand, speed in hands(scene, rng):
        whole = rendered(scene, (), hand, speed)
        stays = hand.mass > 0.0 and math.isinf(hand.release)
        for label, gone in missing.items():
            # without its own mass, only a handle that stays in the hand can move
            if label != "mass" or stays:
                pair = [whole, rendered(scene, gone, hand, speed)]
                rng.shuffle(pair)
                cards.append((label, *pair))
    rng.shuffle(cards)
    return cards


@pytest.mark.slow
@pytest.mark.parametrize("key", LIBRARY)
def test_unneeded_terms_are_imperceptible_and_needed_ones_perceptible(key):
    scene = LIBRARY[key]
    counts = [rows.STATE + scene.state_names.index(name) for name in scene.counts]
    felt: dict[str, float] = defaultdict(float)
    for label, one, two in deck(scene):
        felt[label] = max(felt[label], *judged(one, two, counts).values())
    assert felt.pop("all") < 1.0
    assert {term for term, jnd in felt.items() if jnd > 1.0} <= set(scene.needs)
    assert {term for term in scene.needs if felt[term] < 0.75} <= HARDLY.get(key, set())


def test_the_judge_detects_10_percent_of_force_and_half_a_millimetre():
    table = np.zeros((500, rows.ROW_WIDTH))
    table[:, rows.HAND_TARGET], table[:, rows.HAND_FORCE] = 0.0, 1.0
    for column, change in ((rows.HAND_FORCE, 0.06), (rows.TRUE_POSITION, 0.4e-3)):
        for share, detected in ((0.99, False), (1.01, True)):
            other = table.copy()
            other[:, column] += share * change
            found = {sense: jnd for sense, jnd in judged(other, table, ()).items() if sense != "vibration"}
            assert (max(found.values()) > 1.0) == detected
