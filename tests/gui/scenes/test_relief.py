"""Grounds that are shown: the tip rests on what is painted, and what is painted is the force's own energy."""

import numpy as np
import pytest

from hapkit_studio.gui.scenes import base as scenes
from hapkit_studio.gui.scenes.base import Motion
from hapkit_studio.gui.scenes.parts import BALL
from tests.gui.scenes.scene_support import LIBRARY, SIZES, each_size, has, scene_of, shot

GROUNDS = [
    ("bump_valley", {}),
    ("bump_valley", {"profile": "cosine", "width": 0.012, "peak_force": 2.0}),
    ("texture", {"kind": "grating", "wavelength": 0.012}),
    ("texture", {"kind": "sandpaper", "wavelength": 0.02, "seed": 7.0}),
    ("detents", {}),
    ("detents", {"pitch": 0.012, "half_width": 0.005, "stiffness": 150.0}),
]


def painted(view, stage):
    """Return positions (n,) in mm and the rows (n,) of the painted line's middle, the handle out of sight."""
    line = has(shot(view, 0.09), "matline", 60)
    columns = np.arange(int(stage.x(-49.0)), int(stage.x(49.0)))
    return stage.mm(columns + 0.5), np.array([middle(line[: int(stage.rail) - 2, c]) for c in columns])


def middle(column):
    """Return the middle of the lowest run in a column, so that marks above the ground do not count."""
    rows = np.flatnonzero(column)
    return np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)[-1].mean() + 0.5


def energy(key, values, mm):
    """Return the work (n,) in J that the law's force takes from −50 mm on, its state at the start."""
    x = np.linspace(-0.05, 0.05, 20001)
    force = LIBRARY[key].curve(values, x)
    work = np.concatenate([[0.0], np.cumsum(-0.5 * (force[1:] + force[:-1]) * np.diff(x))])
    return np.interp(1e-3 * mm, x, work)


@pytest.mark.parametrize(("key", "given"), GROUNDS)
def test_the_painted_ground_is_the_forces_energy(qtbot, key, given):
    view, stage = scene_of(qtbot, key, (1100, 330), given)
    mm, rows = painted(view, stage)
    work = energy(key, LIBRARY[key].values(given), mm)
    height = stage.rail - rows
    scale, level = np.polyfit(work, height, 1)
    assert scale > 0.0
    assert np.abs(height - (scale * work + level)).max() < 0.05 * np.ptp(height) + 1.5


@each_size
@pytest.mark.parametrize(("key", "given"), [*GROUNDS, ("texture", {"kind": "bands"})])
def test_the_ball_touches_the_painted_ground_and_is_never_in_it(qtbot, key, given, size):
    view, stage = scene_of(qtbot, key, size, given)
    values, scene = LIBRARY[key].values(given), scenes.named(key)
    mm, rows = painted(view, stage)
    for position in np.linspace(-45.0, 45.0, 61):
        row = scene.tip(stage, values, Motion(position=position))
        gap = np.hypot((mm - position) * stage.per_mm, rows - row).min()
        assert 3.0 * stage.u < gap < BALL * stage.u + 1.5
        assert np.interp(position, mm, rows) > row


def ball_radius(picture, stage, row):
    across = has(picture, "handle")[int(row)]
    return across.sum() / 2 / stage.u


def test_the_ball_is_drawn_where_the_stem_ends(qtbot):
    view, stage = scene_of(qtbot, "bump_valley")
    row = scenes.named("bump_valley").tip(stage, view._values, Motion(position=-25.0))
    picture = shot(view, -0.025)
    assert ball_radius(picture, stage, row) == pytest.approx(BALL - 1.2, abs=1.0)
    assert ball_radius(picture, stage, row - 12 * stage.u) == pytest.approx(2.25, abs=0.8)


@pytest.mark.parametrize(("picture", "sign"), [("same", 1), ("opposite", -1), ("flat", 0)])
@pytest.mark.parametrize("profile", ["gaussian", "cosine"])
def test_the_picture_agrees_with_the_force_or_contradicts_it(qtbot, picture, sign, profile):
    given = {"picture": picture, "profile": profile}
    view, stage = scene_of(qtbot, "bump_valley", (1100, 330), given)
    mm, rows = painted(view, stage)
    force = LIBRARY["bump_valley"].curve(LIBRARY["bump_valley"].values(given), 1e-3 * mm)
    uphill = np.gradient(-rows, mm)
    felt = np.abs(force) > 0.2
    assert felt.sum() > 100
    if sign == 0:
        assert np.ptp(rows) < 1.0
    else:
        assert (sign * uphill[felt] * force[felt] < 0.0).mean() > 0.97


def test_a_higher_peak_is_a_higher_hill_and_it_always_fits(qtbot):
    for size in SIZES:
        heights = []
        for peak in (0.2, 0.7, 1.5, 3.0):
            view, stage = scene_of(qtbot, "bump_valley", size, {"peak_force": peak, "width": 0.04})
            rows = painted(view, stage)[1]
            heights.append(np.ptp(rows))
            assert stage.top < rows.min() - 1.0
            assert rows.max() + 1.0 < stage.rail
        assert heights == sorted(heights)
        assert heights[0] < 0.8 * heights[1] < 0.8 * heights[2]


@each_size
@pytest.mark.parametrize("wavelength", [0.02, 0.005, 0.0025])
def test_ridges_are_as_far_apart_as_they_are(qtbot, wavelength, size):
    view, stage = scene_of(qtbot, "texture", size, {"kind": "grating", "wavelength": wavelength})
    mm, rows = painted(view, stage)
    high = rows < np.mean([rows.min(), rows.max()])
    climbs = mm[1:][high[1:] & ~high[:-1]]
    assert np.diff(climbs) == pytest.approx(1e3 * wavelength, abs=2.0 / stage.per_mm)
    assert len(climbs) == pytest.approx(98.0 / (1e3 * wavelength), abs=1.0)


@each_size
def test_bands_are_half_a_wavelength_wide_and_where_they_damp(qtbot, size):
    view, stage = scene_of(qtbot, "texture", size, {"kind": "bands", "wavelength": 0.008})
    shaded = has(shot(view, 0.09), "mat2", 2)[int(stage.rail - 0.2 * stage.band)]
    law, values = LIBRARY["texture"].force, LIBRARY["texture"].values({"wavelength": 0.008})
    for mm in np.arange(-49.0, 49.0, 0.37):
        if min(mm % 4.0, 4.0 - mm % 4.0) > 1.5 / stage.per_mm:
            assert shaded[int(stage.x(mm))] == (law.plain(values, 1e-3 * mm, 0.1) != 0.0)


@pytest.mark.parametrize("kind", ["bands", "grating"])
def test_the_finest_texture_is_either_resolved_or_one_even_strip(qtbot, kind):
    for size, resolved in (((500, 150), False), ((1100, 330), True)):
        view, stage = scene_of(qtbot, "texture", size, {"kind": kind, "wavelength": 0.0005})
        columns = slice(int(stage.x(-40.0)), int(stage.x(10.0)))
        row = stage.rail - 0.40 * stage.band + (5.0 * stage.u if kind == "bands" else 0.0)
        tones = shot(view, 0.09)[int(row), columns].sum(axis=1)
        assert (np.ptp(tones) > 30) == resolved
