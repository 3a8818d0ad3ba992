"""Every drawn object is within 1.5 px of its position in the law and shows the law's state."""

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtGui import QColor

from hapkit_studio.gui.scenes import base as scenes
from hapkit_studio.gui.scenes import cat, force_arrow, friction, hard_surface, stage
from hapkit_studio.gui.scenes.base import Motion
from hapkit_studio.gui.scenes.force_arrow import HEAD
from hapkit_studio.gui.scenes.parts import BALL
from tests.gui.scenes.scene_support import LIBRARY, each_size, has, paint, scene_of, shot, state_of

NEAR = 1.5  # permitted deviation of a drawn object in px


def edges(mask, row):
    """Return the first and last column of a row in a mask, measured at the centres of the columns."""
    columns = np.flatnonzero(mask[row])
    return columns[0] + 0.5, columns[-1] + 0.5


def amber(picture):
    return has(picture, "obj", 2)


def outline(picture, row):
    """Return the middle of an object's left and of its right outline in a row of pixels."""
    outer, inner = edges(has(picture, "objline"), row), edges(amber(picture), row)
    return [(a + b) / 2 for a, b in zip(outer, inner, strict=True)]


def middle_row(picture):
    return int(np.flatnonzero(amber(picture).any(axis=1)).mean())


# arrow and number -------------------------------------------------------------------------------


def arrow(view, stage, picture):
    """Return the columns (n,) of the arrow's centre line; the force's number has the same colour."""
    columns = np.flatnonzero(has(picture, "applied", 2)[int(stage.knob_middle)]) + 0.5
    number = next(box for box in view.text_boxes() if box.bottom() < stage.top)
    return columns[(columns < number.left()) | (columns > number.right())]


@each_size
@pytest.mark.parametrize("side", [-1, 1])
def test_an_outward_force_arrow_and_its_number_stay_in_the_picture(qtbot, size, side):
    view, stage = scene_of(qtbot, "spring", size)
    for place, force in itertools.product((0.03, 0.041, 0.046, 0.05), (0.02, 0.8, 3.0)):
        columns = arrow(view, stage, shot(view, side * place, (), side * force))
        tip = (side * (columns - stage.width / 2)).max()
        assert place * 1e3 * stage.per_mm < tip < stage.width / 2 - 2 * stage.u
        assert np.ptp(columns) > 0.6 * HEAD * stage.u
        number = next(box for box in view.text_boxes() if box.bottom() < stage.top)
        assert number.left() >= 2
        assert number.right() <= stage.width - 2


@pytest.mark.parametrize(("force", "says"), [(0.0049, "0.00 N"), (0.0051, "+0.01 N"), (-0.0051, "−0.01 N")])
def test_an_arrow_is_drawn_if_and_only_if_the_number_is_not_zero(qtbot, force, says):
    view, stage = scene_of(qtbot, "free")
    columns = arrow(view, stage, shot(view, 0.0, (), force))
    assert view._motion.force_text == says
    assert bool(len(columns)) == (says != "0.00 N")


def test_force_and_depth_numbers_are_steady_and_agree_with_the_drawing(qtbot, monkeypatch):
    """Numbers are steady for changes below 0.02 N and 0.1 mm; a depth is never negative."""
    monkeypatch.setattr(force_arrow, "EACH_MS", 10**9)
    written, paint_text = [], stage.paint_text
    monkeypatch.setattr(stage, "paint_text", lambda *given: (written.append(given[3]), paint_text(*given)))
    view, _ = scene_of(qtbot, "wall")

    def force_text(force, position=0.0):
        view.update_state(position, force, force, None, False, False, np.zeros(0))
        return view._motion.force_text

    assert [force_text(force) for force in (0.5, 0.5198, 0.5202, 0.0, 0.0049, 0.0051, -0.3)] == [
        "+0.50 N", "+0.50 N", "+0.52 N", "0.00 N", "0.00 N", "+0.01 N", "−0.30 N",
    ]  # fmt: skip
    assert [force_text(-1.0, 1e-3 * mm) for mm in (4.95, 7.5, 7.599, 7.601)] == ["−1.00 N"] * 4
    for mm in (4.95, 5.04, 7.5, 7.599, 7.601):
        force_text(-1.0, 1e-3 * mm)
        view.grab()
    depths = [text for text in written if text.startswith("d =")]
    assert depths == ["d = 0.04 mm", "d = 2.50 mm", "d = 2.50 mm", "d = 2.60 mm"]
    monkeypatch.setattr(force_arrow, "EACH_MS", 0)
    assert force_text(-1.01, 0.0076) == "−1.01 N"


@pytest.mark.parametrize("side", [1, -1])
def test_the_force_number_does_not_cover_the_hands_ring(qtbot, side):
    view, stage = scene_of(qtbot, "bump_valley", (620, 180))
    for force, away in itertools.product((0.58, 1.9), (12.0, 14.0, 18.0, 25.0)):
        place = 40.0 - 14.0 * force / 1.9
        paint(view, 1e-3 * side * place, (), side * force, 1e-3 * side * (place - away))
        ring, half = stage.x(side * (place - away)), 8 * stage.u
        boxes = [box for box in view.text_boxes() if box.bottom() < stage.top]
        assert boxes
        assert not any(box.left() < ring + half and ring - half < box.right() for box in boxes)


# objects ----------------------------------------------------------------------------------------


@each_size
def test_puck_and_block_are_drawn_at_their_positions(qtbot, size):
    """The puck is 10 mm wide; the block is 14.5 mm wide and starts at the object's position."""
    for key, first, wide, places in (
        ("puck", -5.0, 10.0, (-0.035, -0.0123, 0.0217)),
        ("mass_spring_damper", 0.0, 14.5, (-0.03, -0.0051, 0.0244)),
    ):
        view, stage = scene_of(qtbot, key, size)
        for place in places:
            picture = shot(view, -0.048, state_of(key, object=place, started=1.0))
            rows = np.flatnonzero(amber(picture).any(axis=1))
            left, right = outline(picture, int(rows.mean() if key == "puck" else rows[0] + 12))
            assert left == pytest.approx(stage.x(1e3 * place + first), abs=NEAR)
            assert right == pytest.approx(stage.x(1e3 * place + first + wide), abs=NEAR)


@pytest.mark.parametrize("size", [(500, 150), (916, 150), (916, 180), (1100, 236), (1600, 330)])
def test_the_puck_is_round_and_stays_below_the_knob(qtbot, size):
    view, stage = scene_of(qtbot, "puck", size)
    seen = amber(shot(view, -0.048, state_of("puck", object=0.0, started=1.0)))
    (rows, columns) = (np.flatnonzero(seen.any(axis=axis)) for axis in (1, 0))
    assert np.ptp(rows) == pytest.approx(np.ptp(columns), abs=2 * NEAR)
    assert rows[0] > stage.knob_top + stage.knob_height


def test_a_pushed_object_is_indented_by_the_handles_depth(qtbot):
    for key, place, handle, right in (("puck", 0.012, 8.0, 17.0), ("mass_spring_damper", 0.01, 12.5, 24.5)):
        view, stage = scene_of(qtbot, key)
        picture = shot(view, 1e-3 * handle, state_of(key, object=place, side=1.0, started=1.0)
                       if key == "puck" else state_of(key, object=place, started=1.0))  # fmt: skip
        found = edges(amber(picture), middle_row(picture))
        assert found[0] == pytest.approx(stage.x(handle) + 2.25 * stage.u, abs=2 * NEAR)
        assert found[1] == pytest.approx(stage.x(right), abs=2 * NEAR)


def test_the_arrow_shows_the_pucks_direction_and_speed(qtbot):
    view, stage = scene_of(qtbot, "puck")

    def arrow(velocity):
        state = state_of("puck", object=0.0, object_velocity=velocity, side=1.0, started=1.0)
        return np.flatnonzero(has(shot(view, -0.03, state), "velocity").any(axis=0)) + 0.5

    assert (arrow(0.3) > stage.x(5.0)).all()
    assert (arrow(-0.3) < stage.x(-5.0)).all()
    assert np.ptp(arrow(0.3)) > 1.5 * np.ptp(arrow(0.15))
    assert len(arrow(0.0)) == 0


def test_stiffness_is_drawn_as_a_coil_and_damping_as_a_dashpot(qtbot):
    for missing, seen in (("", (True, True)), ("stiffness", (False, True)), ("damping", (True, False))):
        view, stage = scene_of(qtbot, "mass_spring_damper", given={missing: 0.0} if missing else {})
        picture = shot(view, -0.04, state_of("mass_spring_damper", object=0.01, started=1.0))
        rows = np.flatnonzero(amber(picture).any(axis=1))
        between = has(picture, "matline")[:, int(stage.x(27.0)) : int(stage.x(45.0))]
        half = int(0.52 * rows[0] + 0.48 * rows[-1])
        assert (between[rows[0] : half].any(), between[half : int(stage.rail) - 4].any()) == seen


@pytest.mark.parametrize(("key", "place"), [("puck", -0.0811), ("mass_spring_damper", 0.0811)])
def test_an_arrow_points_to_an_object_outside_the_picture(qtbot, key, place):
    view, stage = scene_of(qtbot, key)
    picture = shot(view, 0.0, state_of(key, object=place, started=1.0))
    columns = np.flatnonzero(amber(picture)[int(stage.top) : int(stage.rail)].any(axis=0))
    edge = 0 if place < 0 else 880
    assert len(columns) > 0
    assert (np.abs(columns - edge) < 25 * stage.u).all()
    assert any(abs(box.center().x() - edge) < 200 and stage.top < box.top() for box in view.text_boxes())


def test_the_button_is_drawn_in_each_state_and_clicks_are_counted(qtbot):
    view, stage = scene_of(qtbot, "button")
    for handle, face in ((-0.03, 5.0), (0.0085, 8.5), (0.0119, 11.9), (0.0049, 5.0)):
        left, right = edges(amber(shot(view, handle, state_of("button"))), int(stage.rail - 0.5 * stage.band))
        covered = 2.25 * stage.u if 1e3 * handle >= face else 0.9 * stage.u
        assert left == pytest.approx(stage.x(face) + covered, abs=2 * NEAR)
        assert right == pytest.approx(stage.x(face + 7.0), abs=2 * NEAR)
    out, count = shot(view, 0.0105, state_of("button")), len(view.text_boxes())
    assert (out != shot(view, 0.0105, state_of("button", pressed=1.0))).any()
    shot(view, 0.0105, state_of("button", pressed=1.0, downs=1.0))
    assert len(view.text_boxes()) == count + 1


def test_bristles_lean_with_the_tether_and_a_label_says_that_they_stick(qtbot):
    view, stage = scene_of(qtbot, "friction", given={"kinetic_force": 0.0})
    row = int(stage.rail - 0.34 * stage.band - 4.5 * stage.u)

    def held(stretch, slides=0.0):
        return shot(view, 0.01, state_of("friction", anchor=0.01 + stretch, slides=slides, started=1.0))

    ends = [np.flatnonzero(has(held(s), "objline", 60)[row]).mean() for s in (-0.0015, 0.0, 0.0008)]
    assert ends[1] == pytest.approx(stage.x(10.0), abs=NEAR)
    # the bristle is a parabola; its displacement in this row is 0.70 of the displacement of its end
    assert np.diff(ends) == pytest.approx(0.70 * stage.per_mm * np.array([1.5, 0.8]), abs=2 * NEAR)
    held(0.001, slides=-1.0)
    count = len(view.text_boxes())
    held(0.001)
    assert len(view.text_boxes()) == count + 1


def test_sliding_bristles_lean_by_the_kinetic_force():
    """A sliding tether is stretched by force over stiffness: 0.4 N over 500 N/m is 0.8 mm."""
    state = {"anchor": 0.0, "slides": -1.0, "before": 0.02, "started": 1.0}
    values = LIBRARY["friction"].values()
    assert friction.stretch(values, SimpleNamespace(position=20.0, state=state)) == pytest.approx(-0.8)
    assert friction.stretch({**values, "model": 3.0}, SimpleNamespace(position=1.0, state=state)) == -1.0


# grounds ----------------------------------------------------------------------------------------

GROUNDS = [
    ("bump_valley", {"profile": "cosine", "width": 0.012, "peak_force": 2.0}),
    ("texture", {"kind": "grating", "wavelength": 0.012}),
    ("texture", {"kind": "sandpaper", "wavelength": 0.02, "seed": 7.0}),
    ("detents", {"pitch": 0.012, "half_width": 0.005, "stiffness": 150.0}),
]


def painted(view, stage):
    """Return positions (n,) in mm and pixel rows (n,) of the ground line's centre; the handle is at 90 mm."""
    line = has(shot(view, 0.09), "matline", 60)
    columns = np.arange(int(stage.x(-49.0)), int(stage.x(49.0)))
    return stage.mm(columns + 0.5), np.array([middle(line[: int(stage.rail) - 2, c]) for c in columns])


def middle(column):
    """Return the middle of the lowest run of pixels in a column; marks above the ground are ignored."""
    rows = np.flatnonzero(column)
    return np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)[-1].mean() + 0.5


def energy(key, values, mm):
    """Return the law's work (n,) in J from −50 mm to each position, starting in its initial state."""
    x = np.linspace(-0.05, 0.05, 20001)
    force = LIBRARY[key].curve(values, x)
    work = np.concatenate([[0.0], np.cumsum(-0.5 * (force[1:] + force[:-1]) * np.diff(x))])
    return np.interp(1e-3 * mm, x, work)


@pytest.mark.parametrize(("key", "given"), GROUNDS)
def test_the_ground_shows_the_forces_energy_and_the_ball_lies_on_it(qtbot, key, given):
    view, stage = scene_of(qtbot, key, (1100, 330), given)
    values, scene = LIBRARY[key].values(given), scenes.named(key)
    mm, rows = painted(view, stage)
    height, work = stage.rail - rows, energy(key, values, mm)
    scale, level = np.polyfit(work, height, 1)
    assert scale > 0.0
    assert np.abs(height - (scale * work + level)).max() < 0.05 * np.ptp(height) + 1.5
    for position in np.linspace(-45.0, 45.0, 61):
        row = scene.tip(stage, values, Motion(position=position))
        gap = np.hypot((mm - position) * stage.per_mm, rows - row).min()
        assert 3.0 * stage.u < gap < BALL * stage.u + 1.5
        assert np.interp(position, mm, rows) > row


@pytest.mark.parametrize(("picture", "sign"), [("same", 1), ("opposite", -1), ("flat", 0)])
def test_the_picture_changes_with_the_sign_of_the_force(qtbot, picture, sign):
    given = {"picture": picture}
    view, stage = scene_of(qtbot, "bump_valley", (1100, 330), given)
    mm, rows = painted(view, stage)
    force = LIBRARY["bump_valley"].curve(LIBRARY["bump_valley"].values(given), 1e-3 * mm)
    uphill, felt = np.gradient(-rows, mm), np.abs(force) > 0.2
    assert felt.sum() > 100
    if sign == 0:
        assert np.ptp(rows) < 1.0
    else:
        assert (sign * uphill[felt] * force[felt] < 0.0).mean() > 0.97


@each_size
def test_damping_bands_are_half_a_wavelength_wide_and_at_the_right_place(qtbot, size):
    given = {"kind": "bands", "wavelength": 0.008}
    view, stage = scene_of(qtbot, "texture", size, given)
    shaded = has(shot(view, 0.09), "mat2", 2)[int(stage.rail - 0.2 * stage.band)]
    law, values = LIBRARY["texture"].force, LIBRARY["texture"].values(given)
    for mm in np.arange(-49.0, 49.0, 0.37):
        if min(mm % 4.0, 4.0 - mm % 4.0) > 1.5 / stage.per_mm:
            assert shaded[int(stage.x(mm))] == (law.plain(values, 1e-3 * mm, 0.1) != 0.0)


# the hard surface -------------------------------------------------------------------------------


def test_the_drawn_line_is_the_decaying_sine(qtbot):
    frequency, decay = 90.0, 60.0
    given = {"frequency": frequency, "decay": decay, "amplitude": 12.0, "limit": 3.0}
    view, stage = scene_of(qtbot, "hard_surface", (1100, 330), given)
    picture = shot(view, -0.03, state_of("hard_surface", since=-1.0, speed=0.2))
    top, low = int(stage.top) + 6, int(stage.rail - 22 * stage.u)
    line = (has(picture, "matline", 40) | has(picture, "handle", 40))[top:low]
    left = stage.x(5.0) + 9.0 * stage.u
    columns = np.arange(math.ceil(left) + 1, int(stage.x(48.0)) - 1)
    rows = np.array([top + np.flatnonzero(line[:, c]).mean() + 0.5 for c in columns])
    seconds = (columns + 0.5 - left) / stage.per_mm * 2e-3  # the scale bar of 20 ms is 10 mm long
    newtons = 12.0 * 0.2 * np.exp(-decay * seconds) * np.sin(2 * math.pi * frequency * seconds)
    scale, level = np.polyfit(newtons, rows, 1)
    assert scale < 0.0
    assert np.abs(rows - level - scale * newtons).max() < 0.06 * np.ptp(rows) + 1.5


def test_each_material_has_its_own_frequency_and_decay():
    values = LIBRARY["hard_surface"].values
    found = [hard_surface.sound(values({"material": material})) for material in ("rubber", "wood")]
    assert found == [(5.1, 60.0, 18.0), (6.6, 80.0, 100.0)]


# the cat ----------------------------------------------------------------------------------------

MOODS = {
    "at rest": {},
    "content": {"contentment": 0.2},
    "purring": {"contentment": 0.6},
    "annoyed": {"contentment": -0.6},
    "swat": {"contentment": -0.55, "swat": 0.15},
    "sulking": {"contentment": -0.4, "sulk": 3.0},
}


def cat_state(position=0.0, bend=0.0, **given):
    """Return the cat's state; ``bend`` is the hair's deflection in m."""
    return state_of("cat", **({"anchor": position - bend, "push": 1.0, "started": 1.0} | given))


def seen(picture, stage, color, left, right, low, high):
    """Return how many pixels of a colour lie between left and right (mm), low and high (share of height)."""
    wanted = [color.red(), color.green(), color.blue()]
    rows = slice(int(cat.y(stage, high)), int(cat.y(stage, low)))
    part = picture[rows, int(stage.x(left)) : int(stage.x(right))]
    return int((np.abs(part - wanted).max(axis=2) <= 2).sum())


def test_the_cats_appearance_shows_its_mood(qtbot):
    """When the cat purrs, its eyes are closed and arcs are drawn. When it swats, its ears and a paw move."""
    view, stage = scene_of(qtbot, "cat")
    accent, row = QColor("#0A5AA8"), {}
    for mood, given in MOODS.items():
        picture = shot(view, -0.01, cat_state(-0.01, **given))
        assert cat.read(view._motion).word == mood
        row[mood] = (
            seen(picture, stage, cat.color("iris"), -46.0, -30.0, 0.3, 0.9) > 0,
            seen(picture, stage, accent, -34.5, -28.0, 0.3, 0.62) > 0,
            seen(picture, stage, cat.color("fur"), -44.0, -33.0, 0.93, 1.09) > 30,
            seen(picture, stage, cat.color("cream"), -20.0, -8.0, 0.6, 0.85) > 40,
        )
    assert row == {
        "at rest": (True, False, True, False), "content": (True, False, True, False),
        "purring": (False, True, True, False), "annoyed": (True, False, False, False),
        "swat": (True, False, False, True), "sulking": (True, False, False, False),
    }  # fmt: skip
