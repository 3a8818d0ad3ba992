"""Every scene at the ends of its parameters, in every size and theme: it paints, and its words have room."""

import itertools

import numpy as np
import pytest

from hapkit_studio.gui.widgets.theme import theme
from tests.gui.scenes.scene_support import LIBRARY, corners, each_size, paint, scene_of, shot

POSITIONS = (-0.05, -0.0301, -0.012, 0.0004, 0.0085, 0.0243, 0.05)
THEMES = ("light", "dark", "contrast")
EACH = 3


def situations(environment):
    """Return ever new forces, positions and states: none yet, the first, anything, a broken one."""
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


@each_size
@pytest.mark.parametrize("key", sorted(LIBRARY))
def test_no_words_overlap_or_leave_the_card_at_any_corner(qtbot, key, size):
    view, _ = scene_of(qtbot, key, size)
    some, every = situations(LIBRARY[key]), corners(LIBRARY[key])
    for i, mode in enumerate(THEMES):
        theme.set_mode(mode)
        for values in every[i :: len(THEMES)]:
            view.set_values(values)
            for force, position, state in itertools.islice(some, EACH):
                hand = None if force == 0.0 else position - 0.008 * np.sign(force)
                paint(view, position, state, force, hand)
                assert view.text_boxes()
                assert in_order(view.text_boxes(), *size), (values, state, position)


@pytest.mark.parametrize("key", sorted(LIBRARY))
def test_a_scene_stays_the_same_until_something_changes(qtbot, key):
    view, _ = scene_of(qtbot, key)
    state = np.array(LIBRARY[key].force.initial_state)
    view._motion.trail.extend([9.0] * 12)
    first = shot(view, 0.009, state)
    assert (first == shot(view, 0.009, state)).all()
    assert (first != shot(view, 0.012, state)).any()


@pytest.mark.parametrize("key", sorted(LIBRARY))
def test_each_theme_has_its_own_ground(qtbot, key):
    view, _ = scene_of(qtbot, key)
    grounds = set()
    for mode in THEMES:
        theme.set_mode(mode)
        grounds.add(tuple(shot(view, -0.02)[6, 840]))
    assert len(grounds) == 3


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("force", [0.58, 1.9])
def test_the_force_is_not_written_over_the_hands_ring(qtbot, side, force):
    view, stage = scene_of(qtbot, "bump_valley", (620, 180))
    for away in (12.0, 14.0, 18.0, 25.0):
        place = 40.0 - 14.0 * force / 1.9
        paint(view, 1e-3 * side * place, (), side * force, 1e-3 * side * (place - away))
        ring, half = stage.x(side * (place - away)), 8 * stage.u
        boxes = [box for box in view.text_boxes() if box.bottom() < stage.top]
        assert boxes
        assert not any(box.left() < ring + half and ring - half < box.right() for box in boxes)
