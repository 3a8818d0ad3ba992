"""No scene costs more to paint than the ones that were there first, measured side by side."""

import time

import numpy as np
import pytest
from PySide6.QtGui import QPixmap

from tests.gui.scenes.scene_support import LIBRARY, scene_of
from tests.waiting import shortest

SIZE = (1100, 330)
FRAMES, ROUNDS = 12, 6
COSTLY = {
    "texture": {"kind": "grating", "wavelength": 0.0005},
    "hard_surface": {"frequency": 400.0, "decay": 5.0},
    "bump_valley": {"profile": "cosine"},
}


def seconds_for(view, picture, frames):
    """Return the processor seconds for so many frames of a handle that moves."""
    state = np.array(LIBRARY[view._scene.key].force.initial_state)
    if "started" in LIBRARY[view._scene.key].state_names:
        state[:4] = 0.012, 0.2, 0.0, 1.0
    start = time.thread_time()
    for i in range(frames):
        view.update_state(0.006 + 2e-4 * i, -1.2, -1.2, 0.02, False, False, state)
        view.render(picture)
    return time.thread_time() - start


@pytest.mark.parametrize("key", sorted(set(LIBRARY) - {"free", "spring", "wall", "damping", "cat"}))
def test_a_frame_costs_no_more_than_twice_the_springs(qtbot, key):
    spring, _ = scene_of(qtbot, "spring", SIZE)
    other, _ = scene_of(qtbot, key, SIZE, COSTLY.get(key))
    picture = QPixmap(*SIZE)
    for view in (spring, other):
        seconds_for(view, picture, 2)
    ratios = [
        seconds_for(other, picture, FRAMES) / seconds_for(spring, picture, FRAMES) for _ in range(ROUNDS)
    ]
    assert min(ratios) < 2.0


@pytest.mark.parametrize("key", ["texture", "bump_valley", "detents", "hard_surface"])
def test_what_stays_put_is_painted_once(qtbot, key):
    view, _ = scene_of(qtbot, key, SIZE, COSTLY.get(key))
    times = []
    picture = QPixmap(*SIZE)
    seconds_for(view, picture, 2)
    for _ in range(ROUNDS):
        start = time.thread_time()
        view._forget()
        seconds_for(view, picture, 1)
        times.append(time.thread_time() - start)
    limit = 0.7 * min(times)
    assert shortest(lambda: seconds_for(view, picture, FRAMES) / FRAMES, limit) < limit
