"""Every scene with what no law should give: no numbers, endless ones, states too short, values too far."""

import gc
import math
import time

import numpy as np
import pytest
from PySide6.QtGui import QPainter, QPixmap

from hapkit_studio.gui.scenes import base as scenes
from hapkit_studio.gui.scenes.base import Motion
from hapkit_studio.gui.scenes.stage import Stage
from tests.gui.scenes.scene_support import LIBRARY, paint, scene_of

ODD = (math.nan, math.inf, -math.inf, 0.0, -1.0, 0.5, 1e12, -1e12, 1e300, 5e-324)
LONGEST = 0.5  # s for one picture: a hundred times what one takes


@pytest.fixture(autouse=True)
def no_collection():
    """Keep the collector out of the time of a picture: what earlier tests left takes it up to a second."""
    gc.disable()
    yield
    gc.enable()


def states(key):
    """Return states of every length, all odd, and each number odd alone while the law has started."""
    names = LIBRARY[key].state_names
    first = np.array(LIBRARY[key].force.initial_state, dtype=float)
    if "started" in names:
        first[names.index("started")] = 1.0
    yield from (first[:n] for n in range(len(first) + 1))
    yield from (np.full(len(first) + 3, odd) for odd in ODD)
    for i in range(len(first)):
        for odd in ODD:
            yield np.where(np.arange(len(first)) == i, odd, first)


@pytest.mark.parametrize("key", sorted(LIBRARY))
def test_any_state_is_painted_and_in_time(qtbot, key):
    view, _ = scene_of(qtbot, key)
    for state in states(key):
        start = time.thread_time()
        paint(view, 0.012, state, -0.5, 0.02)
        assert time.thread_time() - start < LONGEST, state
        assert view.text_boxes()


@pytest.mark.parametrize("key", sorted(LIBRARY))
def test_any_row_is_painted_and_in_time(qtbot, key):
    view, _ = scene_of(qtbot, key)
    for odd in ODD:
        rows = ((odd, 0.5, 0.01), (0.01, odd, -0.01), (0.01, 0.5, odd), (odd, odd, odd))
        for position, force, hand in rows:
            start = time.thread_time()
            paint(view, position, LIBRARY[key].force.initial_state, force, hand)
            assert time.thread_time() - start < LONGEST, (position, force, hand)
            assert view.text_boxes()


@pytest.mark.slow
@pytest.mark.parametrize("key", sorted(LIBRARY))
def test_any_parameter_is_painted_and_in_time(key, qapp):
    picture = QPixmap(880, 236)
    keys, defaults = [p.key for p in LIBRARY[key].parameters], LIBRARY[key].values()
    odd_values = [dict.fromkeys(keys, odd) for odd in ODD]
    kinds = [{"kind": kind} for kind in range(3)] if key == "texture" else [{}]
    odd_values += [{**defaults, **kind, name: odd} for kind in kinds for name in keys for odd in ODD]
    for values in odd_values:
        start = time.thread_time()
        whole(scenes.named(key), picture, values)
        assert time.thread_time() - start < LONGEST, values


def whole(scene, picture, values):
    """Paint every part of a scene."""
    painter, stage, motion = QPainter(picture), Stage(880, 236), Motion(position=21.0, position_text=21.0)
    stage.begin(painter)
    scene.fixed(stage, values)
    scene.moving(stage, values, motion)
    if scene.tip:
        assert math.isfinite(scene.tip(stage, values, motion))
    scene.words(stage, values, motion)
    painter.end()


def test_a_parameter_is_read_within_its_limits():
    read = scenes.reader(LIBRARY["texture"])
    low, high, default = 0.0005, 0.02, 0.005
    cases = {0.0: low, -3.0: low, 1e12: high, math.nan: default, math.inf: default, 0.0123: 0.0123}
    assert {given: read({"wavelength": given}, "wavelength") for given in cases} == pytest.approx(cases)
    assert read({}, "wavelength") == default
