"""What moves in a scene stands where the law has it, to a pixel and a half; what stays put stays."""

import numpy as np
import pytest

from tests.gui.scenes.scene_support import each_size, has, scene_of, shot, state_of

NEAR = 1.5  # px
WIDTH = 14.5  # mm: half of what is between the block at rest and 8 mm before the post


def amber(picture):
    return has(picture, "obj", 2)


def edges(mask, row):
    """Return the first and the last column of a row of a mask; a column's middle is at + 0.5."""
    columns = np.flatnonzero(mask[row])
    return columns[0] + 0.5, columns[-1] + 0.5


def outline(picture, row):
    """Return where an object's outline runs: between where its line begins and where its colour does."""
    outer, inner = edges(has(picture, "objline"), row), edges(amber(picture), row)
    return [(a + b) / 2 for a, b in zip(outer, inner, strict=True)]


def middle_row(picture):
    return int(np.flatnonzero(amber(picture).any(axis=1)).mean())


@each_size
@pytest.mark.parametrize("place", [-0.035, -0.0123, 0.0, 0.0217, 0.035])
def test_the_puck_is_as_large_and_where_the_law_has_it(qtbot, place, size):
    view, stage = scene_of(qtbot, "puck", size)
    picture = shot(view, -0.045, state_of("puck", object=place, side=1.0, started=1.0))
    left, right = outline(picture, middle_row(picture))
    assert left == pytest.approx(stage.x(1e3 * place - 5.0), abs=NEAR)
    assert right == pytest.approx(stage.x(1e3 * place + 5.0), abs=NEAR)


@each_size
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_handle_and_puck_touch_when_they_do(qtbot, side, size):
    view, stage = scene_of(qtbot, "puck", size)
    for gap in (0.0, 1.0, 3.0):
        handle = 0.004 - side * (0.005 + 1e-3 * gap)
        picture = shot(view, handle, state_of("puck", object=0.004, side=side, started=1.0))
        row = middle_row(picture)
        a, b = sorted((stage.x(1e3 * handle), stage.x(4.0 - side * 5.0)))
        between = has(picture, "scene", 3)[row, int(a) : int(b) + 1]
        stem, line = 2.25 * stage.u, 0.9 * stage.u
        assert between.sum() == pytest.approx(max(gap * stage.per_mm - stem - line, 0.0), abs=2 * NEAR)


def test_a_pushed_puck_is_pressed_in_and_a_wall_holds_it(qtbot):
    view, stage = scene_of(qtbot, "puck")
    picture = shot(view, 0.008, state_of("puck", object=0.012, side=1.0, started=1.0))
    left, right = edges(amber(picture), middle_row(picture))
    assert left == pytest.approx(stage.x(8.0) + 2.25 * stage.u, abs=2 * NEAR)
    assert right == pytest.approx(stage.x(17.0), abs=2 * NEAR)
    picture = shot(view, 0.0, state_of("puck", object=0.037, side=1.0, started=1.0))
    assert edges(amber(picture), middle_row(picture))[1] == pytest.approx(stage.x(40.0), abs=2 * NEAR)


@each_size
def test_the_walls_faces_stand_at_forty_millimetres(qtbot, size):
    view, stage = scene_of(qtbot, "puck", size)
    picture = shot(view, 0.0, state_of("puck", started=1.0, object=0.02, side=1.0))
    line = has(picture, "matline")[int(stage.top + stage.band / 2)]
    columns = np.flatnonzero(line) + 0.5
    for face in (-40.0, 40.0):
        near = columns[np.abs(columns - stage.x(face)) < 4 * stage.u]
        assert near.mean() == pytest.approx(stage.x(face), abs=NEAR)


@pytest.mark.parametrize(("speed", "side"), [(0.3, 1), (-0.3, -1)])
def test_the_arrow_points_where_the_puck_goes_and_longer_the_faster(qtbot, speed, side):
    view, stage = scene_of(qtbot, "puck")

    def arrow(velocity):
        state = state_of("puck", object=0.0, object_velocity=velocity, side=1.0, started=1.0)
        return np.flatnonzero(has(shot(view, -0.03, state), "velocity").any(axis=0)) + 0.5

    fast, slow = arrow(speed), arrow(speed / 2)
    assert (side * (fast - stage.x(0.0)) > 5.0 * stage.per_mm).all()
    assert np.ptp(fast) > 1.5 * np.ptp(slow)
    assert len(arrow(0.0)) == 0


def test_echoes_lie_behind_a_moving_puck_and_never_in_a_wall_or_beyond_the_handle(qtbot):
    view, stage = scene_of(qtbot, "puck")

    def shaded(place, velocity, handle):
        state = state_of("puck", object=place, object_velocity=velocity, side=1.0, started=1.0)
        still = shot(view, handle, state * (np.arange(len(state)) != 1))
        moves = shot(view, handle, state)
        row = middle_row(still)
        return (np.flatnonzero((still[row] != moves[row]).any(axis=1)) + 0.5 - stage.width / 2) / stage.per_mm

    behind = shaded(0.01, 0.3, -0.045)
    assert behind[behind < 5.0].min() < -10.0
    assert shaded(0.02, 0.3, 0.008).min() > 8.0
    assert shaded(-0.03, 0.3, -0.06).min() >= -40.0 - 0.5


@each_size
@pytest.mark.parametrize("place", [-0.03, -0.0051, 0.0087, 0.0244])
def test_the_block_stands_where_the_law_has_it(qtbot, place, size):
    view, stage = scene_of(qtbot, "mass_spring_damper", size)
    picture = shot(view, -0.048, state_of("mass_spring_damper", object=place, started=1.0))
    row = int(np.flatnonzero(amber(picture).any(axis=1))[0] + 12)
    left, right = outline(picture, row)
    assert left == pytest.approx(stage.x(1e3 * place), abs=NEAR)
    assert right == pytest.approx(stage.x(1e3 * place + WIDTH), abs=NEAR)


def test_the_pushed_face_is_pressed_in_by_as_much_as_the_handle_is_inside(qtbot):
    view, stage = scene_of(qtbot, "mass_spring_damper")
    picture = shot(view, 0.0125, state_of("mass_spring_damper", object=0.01, started=1.0))
    row = middle_row(picture)
    assert edges(amber(picture), row)[0] == pytest.approx(stage.x(12.5) + 2.25 * stage.u, abs=2 * NEAR)
    dashes = has(picture, "objline")[:, int(stage.x(10.0)) - 2 : int(stage.x(10.0)) + 3].any(axis=1)
    assert 0.3 < dashes[int(stage.top) + 4 : int(stage.rail) - 4].mean() < 0.8


@pytest.mark.parametrize(
    ("given", "coil", "dashpot"),
    [({}, True, True), ({"stiffness": 0.0}, False, True), ({"damping": 0.0}, True, False)],
)
def test_a_coil_is_a_stiffness_and_a_dashpot_a_damping(qtbot, given, coil, dashpot):
    view, stage = scene_of(qtbot, "mass_spring_damper", given=given)
    picture = shot(view, -0.04, state_of("mass_spring_damper", object=0.01, started=1.0))
    rows = np.flatnonzero(amber(picture).any(axis=1))
    between = has(picture, "matline")[:, int(stage.x(27.0)) : int(stage.x(45.0))]
    half = int(0.52 * rows[0] + 0.48 * rows[-1])
    assert between[rows[0] : half].any() == coil
    assert between[half : int(stage.rail) - 4].any() == dashpot


@pytest.mark.parametrize(("key", "name"), [("puck", "puck"), ("mass_spring_damper", "block")])
@pytest.mark.parametrize("place", [-0.0811, 0.0811])
def test_an_object_out_of_sight_is_pointed_to(qtbot, key, name, place):
    view, stage = scene_of(qtbot, key)
    rows = slice(int(stage.top), int(stage.rail))
    picture = shot(view, 0.0, state_of(key, object=place, started=1.0))
    columns = np.flatnonzero(amber(picture)[rows].any(axis=0))
    edge = 0 if place < 0 else 880
    assert len(columns) > 0
    assert (np.abs(columns - edge) < 25 * stage.u).all()
    assert any(abs(box.center().x() - edge) < 200 and stage.top < box.top() for box in view.text_boxes())


@pytest.mark.parametrize("key", ["puck", "mass_spring_damper"])
def test_before_the_first_row_an_object_stands_where_it_will_begin(qtbot, key):
    view, stage = scene_of(qtbot, key)
    picture = shot(view, -0.04, ())
    first = edges(amber(picture), middle_row(picture))[0]
    assert first == pytest.approx(stage.x(10.0 if key == "mass_spring_damper" else 5.0), abs=2 * NEAR)


@pytest.mark.parametrize(("handle", "face"), [(-0.03, 5.0), (0.0049, 5.0), (0.0085, 8.5), (0.0119, 11.9)])
def test_the_cap_goes_with_the_handle_and_comes_back(qtbot, handle, face):
    view, stage = scene_of(qtbot, "button")
    picture = shot(view, handle, state_of("button"))
    left, right = edges(amber(picture), int(stage.rail - 0.5 * stage.band))
    covered = 2.25 * stage.u if 1e3 * handle >= face else 0.9 * stage.u
    assert left == pytest.approx(stage.x(face) + covered, abs=2 * NEAR)
    assert right == pytest.approx(stage.x(face + 7.0), abs=2 * NEAR)


def test_the_dome_snaps_and_clicks_are_counted(qtbot):
    view, _ = scene_of(qtbot, "button")
    out = shot(view, 0.0105, state_of("button"))
    words = len(view.text_boxes())
    snapped = shot(view, 0.0105, state_of("button", pressed=1.0))
    assert (out != snapped).any()
    shot(view, 0.0105, state_of("button", pressed=1.0, downs=1.0))
    assert len(view.text_boxes()) == words + 1
