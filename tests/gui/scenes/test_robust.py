"""Every scene is painted at the parameters' limits and for invalid rows, and its labels never overlap."""

import itertools
import math
import time

import numpy as np
import pytest
from PySide6.QtGui import QPixmap

from hapkit_studio.gui.scenes import base as scenes
from hapkit_studio.gui.widgets.theme import theme
from tests.gui.scenes.scene_support import LIBRARY, SIZES, corners, paint, scene_of, shot, state_of
from tests.waiting import shortest

EVERY = pytest.mark.parametrize("key", sorted(LIBRARY))
ODD = (math.nan, math.inf, -math.inf, -1.0, 1e12, -1e12, 1e300)
POSITIONS = (-0.05, -0.0301, -0.012, 0.0004, 0.0085, 0.0243, 0.05)
COSTLY = {
    "texture": {"kind": "grating", "wavelength": 0.0005},
    "hard_surface": {"frequency": 400.0, "decay": 5.0},
    "bump_valley": {"profile": "cosine"},
}


def broken_rows(key):
    """Yield rows (position, state, force, hand) with states of every length and with invalid numbers."""
    names, first = LIBRARY[key].state_names, np.array(LIBRARY[key].force.initial_state, dtype=float)
    started = np.where([name == "started" for name in names], 1.0, first)
    states = [started[:n] for n in range(len(first) + 1)] + [np.full(len(first) + 3, odd) for odd in ODD]
    states += [np.where(np.arange(len(first)) == i, odd, started) for i in range(len(first)) for odd in ODD]
    yield from ((0.012, state, -0.5, 0.02) for state in states)
    for odd in ODD:
        for position, force, hand in ((odd, 0.5, 0.01), (0.01, odd, -0.01), (0.01, 0.5, odd), (odd,) * 3):
            yield position, first, force, hand


def paint_bounded(view, inputs):
    """Paint all inputs (values, row) and assert that none takes much longer than the others.

    An input that took long is painted again: the garbage collector may have run during the first time.
    """

    def seconds(values, row):
        start = time.thread_time()
        if values is not None:
            view.set_values(values)
        paint(view, *row)
        return time.thread_time() - start

    inputs, took = list(inputs), []
    for values, row in inputs:
        took.append(seconds(values, row))
        assert view.text_boxes(), (values, row)
    longest = 200.0 * sorted(took)[len(took) // 2]
    assert all(seconds(*inputs[i]) < longest for i, spent in enumerate(took) if spent >= longest)


@EVERY
def test_invalid_rows_are_painted(qtbot, key):
    view, _ = scene_of(qtbot, key, SIZES[0])
    paint_bounded(view, ((None, row) for row in broken_rows(key)))


@pytest.mark.slow
@EVERY
def test_all_parameter_values_are_painted(qtbot, key):
    view, _ = scene_of(qtbot, key, SIZES[0])
    keys, defaults = [p.key for p in LIBRARY[key].parameters], LIBRARY[key].values()
    kinds = [{"kind": kind} for kind in range(3)] if key == "texture" else [{}]
    odd_values = [dict.fromkeys(keys, odd) for odd in ODD]
    odd_values += [{**defaults, **kind, name: odd} for kind in kinds for name in keys for odd in ODD]
    paint_bounded(view, ((values, (0.021,)) for values in odd_values))


def test_a_parameter_is_limited_to_its_range():
    values = scenes.named("texture").values
    low, high, default = 0.0005, 0.02, 0.005
    cases = {0.0: low, -3.0: low, 1e12: high, math.nan: default, math.inf: default, 0.0123: 0.0123}
    assert {given: values({"wavelength": given})["wavelength"] for given in cases} == pytest.approx(cases)


def situations(environment):
    """Yield forces, positions and states endlessly: empty, initial, random and invalid states."""
    rng, count = np.random.default_rng(5), len(environment.state_names)
    looks = itertools.cycle(itertools.product((-1.7, 0.0, 0.8), POSITIONS))
    while True:
        for state in (
            np.zeros(0),
            np.array(environment.force.initial_state),
            rng.uniform(-0.05, 0.05, count),
            np.where(rng.random(count) < 0.5, 1.0, rng.uniform(-0.3, 0.3, count)),
            np.full(count, np.nan),
        ):
            yield *next(looks), state


def in_order(boxes, width, height):
    inside = all(b.left() >= 0 and b.right() <= width and b.bottom() <= height + 4 for b in boxes)
    return inside and not any(a.intersects(b) for a, b in itertools.combinations(boxes, 2))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("size", "count"), [(SIZES[0], 1), pytest.param(SIZES[-1], 3, marks=pytest.mark.slow)]
)
@EVERY
def test_labels_never_overlap_and_stay_in_the_picture_for_all_values_and_themes(qtbot, key, size, count):
    view, _ = scene_of(qtbot, key, size)
    some, every = situations(LIBRARY[key]), corners(LIBRARY[key])
    grounds = set()
    for i, mode in enumerate(("light", "dark", "contrast")):
        theme.set_mode(mode)
        grounds.add(tuple(shot(view, -0.02)[6, size[0] - 40]))
        for values in every[i::3]:
            view.set_values(values)
            for force, position, state in itertools.islice(some, count):
                hand = None if force == 0.0 else position - 0.008 * np.sign(force)
                paint(view, position, state, force, hand)
                assert view.text_boxes()
                assert in_order(view.text_boxes(), *size), (values, state, position)
    assert len(grounds) == 3


@EVERY
def test_the_picture_changes_only_if_the_state_changes(qtbot, key):
    view, _ = scene_of(qtbot, key)
    state = np.array(LIBRARY[key].force.initial_state)
    view._motion.trail.extend([9.0] * 12)
    first = shot(view, 0.009, state)
    assert (first == shot(view, 0.009, state)).all()
    assert (first != shot(view, 0.012, state)).any()


def seconds_for(view, key, picture, frames):
    """Return the processor time in s for a number of frames with a moving handle."""
    known = {"object": 0.012, "object_velocity": 0.2, "contentment": 0.4, "started": 1.0}
    state = state_of(key, **{n: v for n, v in known.items() if n in LIBRARY[key].state_names})
    start = time.thread_time()
    for i in range(frames):
        view.update_state(0.006 + 2e-4 * i, -1.2, -1.2, 0.02, False, False, state)
        view.render(picture)
    return time.thread_time() - start


@pytest.mark.alone
@pytest.mark.parametrize("key", sorted(set(LIBRARY) - {"free", "spring", "wall", "damping"}))
def test_a_frame_costs_at_most_twice_the_springs_and_six_times_for_the_cat(qtbot, key):
    size, limit = (1100, 330), 6.0 if key == "cat" else 2.0
    (spring, _), (other, _) = scene_of(qtbot, "spring", size), scene_of(qtbot, key, size, COSTLY.get(key))
    picture = QPixmap(*size)
    for view, name in ((spring, "spring"), (other, key)):
        seconds_for(view, name, picture, 2)
    seconds = lambda view, name: seconds_for(view, name, picture, 12)  # noqa: E731
    ratio = lambda: seconds(other, key) / seconds(spring, "spring")  # noqa: E731
    assert shortest(ratio, limit) < limit
