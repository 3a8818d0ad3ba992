"""Where a plot opens, which one is shown, and what a change of environment does to the axes."""

import numpy as np
import pytest

from hapkit_studio.gui.live.canvas import widened
from hapkit_studio.gui.live.phase_layers import Band
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import LIBRARY, canvas_of, telemetry

GRID = np.linspace(-60.0, 60.0, 401)


def reach_of(*branches):
    """Return how far a plot of ±20 to ±45 opens over these branches under a limit of 3 N."""
    return Band(GRID, np.array(branches)).reach(20.0, 45.0, 3.0)


def shown_reach(phase):
    low, high = phase.canvas.view.viewRange()[0]
    assert low == -high
    return high


def use(phase, key, **given):
    phase.set_environment(LIBRARY[key], LIBRARY[key].values(given), 3.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_plot_opens_so_far_that_the_last_bend_is_inside(side):
    for place, wanted in ((18.0, 20.0), (20.0, 25.0), (27.0, 30.0), (29.0, 35.0), (44.0, 45.0), (50.0, 20.0)):
        assert reach_of(np.maximum(side * GRID - place, 0.0) * 0.1) == wanted
        assert reach_of(0.0 * GRID, np.maximum(side * GRID - place, 0.0) * 0.1) == wanted


def test_a_straight_line_a_plane_and_nothing_open_on_the_plots_own_reach():
    for force in (-0.2 * GRID, 0.0 * GRID, 0.0 * GRID + 1.0, 0.0 * GRID + np.nan):
        assert reach_of(force) == 20.0
    assert Band(np.empty(0), np.empty((0, 0))).reach(20.0, 45.0, 3.0) == 20.0


def test_what_the_motor_cannot_give_is_no_reason_to_open_wide():
    stiff = -np.maximum(GRID - 5.0, 0.0) - 5.0 * np.maximum(GRID - 30.0, 0.0)
    assert reach_of(stiff) == 20.0
    assert reach_of(0.05 * stiff) == 35.0


def test_of_waves_a_few_are_enough():
    """The fifth turn of a sine lies at 9/4 of its length: 2.25 · 16 · 1.1 = 39.6, 2.25 · 17 · 1.1 = 42.1."""
    for length, wanted in ((5.0, 20.0), (16.0, 40.0), (17.0, 45.0)):
        assert reach_of(np.sin(2.0 * np.pi * GRID / length)) == wanted


def test_both_hills_and_two_wells_to_each_side_are_in_sight(phase):
    """Bump and valley end at ±35 mm with their defaults; wells 3 mm to a side lie at multiples of 20 mm."""
    for key, least in (("bump_valley", 35.0), ("detents", 43.0)):
        use(phase, key)
        assert least < shown_reach(phase) <= 45.0
    for key in ("spring", "wall"):
        use(phase, key)
        assert shown_reach(phase) == 20.0


def test_a_wall_that_is_put_farther_out_stays_in_sight(phase, qtbot):
    assert shown_reach(phase) == 20.0
    use(phase, "wall", position=0.03)
    qtbot.waitUntil(lambda: shown_reach(phase) > 30.0)


def test_a_changed_choice_is_followed_to_the_plot_that_has_a_theory(phase, qtbot):
    use(phase, "texture")
    for kind, wanted in (
        ("grating", "force_position"),
        ("bands", "force_velocity"),
        ("sandpaper", "force_position"),
    ):
        use(phase, "texture", kind=kind)
        qtbot.waitUntil(lambda wanted=wanted: phase.canvas.plot_of.key == wanted)
        assert phase.plots[phase.switch.index].key == wanted
        assert phase.canvas.band.force.size


def test_a_plot_chosen_by_hand_stays_until_another_environment(phase, qtbot):
    use(phase, "texture")
    phase.switch.chosen.emit(1)
    use(phase, "texture", kind="grating")
    qtbot.waitUntil(lambda: not phase.canvas.band.force.size)
    assert phase.canvas.plot_of.key == "force_velocity"
    use(phase, "wall")
    assert phase.canvas.plot_of.key == "force_position"
    use(phase, "damping")
    use(phase, "texture", kind="bands")
    use(phase, "texture", kind="grating")
    qtbot.waitUntil(lambda: phase.canvas.plot_of.key == "force_position")


def ranges_of(plots):
    return [canvas_of(plots, key).view.viewRange()[1] for key in ("position", "velocity", "force")]


def calm(count, start):
    """Return rows of a handle at rest."""
    quiet = telemetry(count, start)
    quiet[:, rows.POSITION : rows.APPLIED + 1] = 0.0
    return quiet


OPENED = [[-12.0, 12.0], [-120.0, 120.0], [-1.2, 1.2]]


def test_value_axes_open_anew_once_older_parts_have_left_the_window(plots, history):
    """What was before the change, its cross-fade included, is shown whole for as long as it is in sight."""
    spike = telemetry(50, 14_000)
    spike[25, rows.APPLIED : rows.APPLIED + 1] = 2.9
    spike[25, rows.VELOCITY] = 0.9
    history.append(spike)
    plots.refresh()
    before = ranges_of(plots)
    assert before[1][1] > 900.0
    assert before[2][1] > 2.9
    plots.set_environment(LIBRARY["spring"], LIBRARY["spring"].values(), 3.0)
    quiet = calm(12_000, 14_050)
    quiet[:30, rows.APPLIED] = 2.9
    history.append(quiet[:9900])
    plots.refresh()
    assert ranges_of(plots) == before
    history.append(quiet[9900:])
    plots.refresh()
    assert ranges_of(plots) == OPENED


def test_value_axes_only_widen_for_changed_values(plots, history):
    plots.set_environment(LIBRARY["spring"], LIBRARY["spring"].values(), 3.0)
    quiet = calm(14_000, 14_000)
    quiet[12_000, rows.VELOCITY] = 0.5
    history.append(quiet[:11_000])
    plots.refresh()
    assert ranges_of(plots) == OPENED
    history.append(quiet[11_000:])
    plots.refresh()
    wide = ranges_of(plots)
    assert 500.0 < wide[1][1] < 900.0
    plots.set_environment(LIBRARY["spring"], LIBRARY["spring"].values({"stiffness": 100.0}), 3.0)
    plots.refresh()
    assert ranges_of(plots) == wide


def test_paused_axes_stay_as_they_are_until_the_view_is_live(plots, history):
    wide = ranges_of(plots)
    assert wide[0][1] > 15.0
    plots.set_paused(True)
    plots.set_environment(LIBRARY["spring"], LIBRARY["spring"].values(), 3.0)
    history.append(calm(11_000, 14_000))
    plots.refresh()
    assert ranges_of(plots) == wide
    plots.set_paused(False)
    plots.refresh()
    assert ranges_of(plots) == OPENED


def test_a_run_whose_clock_starts_again_is_in_sight_after_a_change(plots, phase, history):
    for part in (plots, phase):
        part.set_environment(LIBRARY["spring"], LIBRARY["spring"].values(), 3.0)
    again = telemetry(500)
    again[:, rows.POSITION] = 0.03
    history.append(again)
    plots.refresh()
    phase.canvas.refresh()
    assert canvas_of(plots, "position").view.viewRange()[1][1] > 30.0
    assert phase.canvas.view.viewRange()[0][1] > 30.0


def test_no_line_lies_on_the_frame():
    for value in (-0.93, -0.97, -0.999, -1.0):
        low, high = widened((-1.0, 1.0), value, 0.0)
        assert high == 1.0
        assert low < value - 0.1
        assert widened((low, high), value, 0.0) == (low, high)
    assert widened((-1.0, 1.0), -0.91, 0.91) == (-1.0, 1.0)


def test_a_position_at_the_edge_of_its_axis_has_room_below(plots, history):
    canvas = canvas_of(plots, "position")
    canvas.show_range(-40.02, 40.0)
    still = telemetry(200, 14_000)
    still[:, rows.POSITION] = -0.04001
    history.append(still)
    plots.refresh()
    canvas.measure()
    assert canvas.frame().bottom() - canvas.pixel(0.0, -40.01).y() > 4.0
