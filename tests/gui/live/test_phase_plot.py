"""The plot of force over position or velocity: theory, initial range, and a measured curve that fades."""

from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.gui.live.history import channels
from hapkit_studio.gui.live.phase_canvas import Band
from hapkit_studio.gui.live.plots.declared import Trace, phase_plots, time_plots
from hapkit_studio.gui.widgets import strokes
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import LIBRARY, canvas_of, colored, telemetry

GRID = np.linspace(-60.0, 60.0, 401)


def shown_reach(phase):
    low, high = phase.canvas.view.viewRange()[0]
    assert low == -high
    return high


def drawn(phase, token):
    """Return x (n,) in mm and force (n,) in N of the pixels in a token's colour, and px per mm and per N."""
    found = pixels(phase, token)
    phase.canvas.measure()
    left, across, bottom, up = phase.canvas._map
    return (found[:, 0] + 0.5 - left) / across, (found[:, 1] + 0.5 - bottom) / up, across, up


def pixels(phase, token):
    """Draw the newest data; return columns and rows (n, 2) of the pixels in a token's colour."""
    phase.canvas.refresh()
    return colored(phase.canvas.viewport().grab().toImage(), token)


def use(phase, key, **given):
    phase.set_environment(LIBRARY[key], LIBRARY[key].values(given), 3.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_initial_range_includes_everything_that_the_motor_can_render(side):
    """The range ends beyond the curve's last bend or, for a sine, beyond its fifth turning point.

    With a period of 16 mm, the fifth turning point is at 36 mm, and the range with its margin is 39.6 mm.
    """
    x = side * GRID
    stiff = -np.maximum(x - 5.0, 0.0) - 5.0 * np.maximum(x - 30.0, 0.0)
    bends = (18.0, 20.0), (20.0, 25.0), (27.0, 30.0), (29.0, 35.0), (44.0, 45.0), (50.0, 20.0)
    cases = [(0.1 * np.maximum(x - place, 0.0), reach) for place, reach in bends]
    cases += [(stiff, 20.0), (0.05 * stiff, 35.0)]
    cases += [
        (np.sin(2.0 * np.pi * GRID / long), reach)
        for long, reach in ((5.0, 20.0), (16.0, 40.0), (17.0, 45.0))
    ]
    for force, reach in cases:
        for branches in ([force], [0.0 * GRID, force]):
            assert Band(GRID, np.array(branches)).reach(20.0, 45.0, 3.0) == reach


def test_the_label_of_a_limit_avoids_the_curve(phase):
    """A spring reaches the limit of 3 N on both sides, a wall on the right only, and the free law nowhere."""
    for key, given, sides in (
        ("spring", {"stiffness": 300.0}, (-1.0, 1.0)),
        ("wall", {"stiffness": 400.0}, (0.0, 1.0)),
        ("free", {}, (0.0, 0.0)),
    ):
        use(phase, key, **given)
        assert tuple(np.sign([phase.canvas.band.side(3.0), phase.canvas.band.side(-3.0)])) == sides, key
    use(phase, "spring", stiffness=300.0)
    found = pixels(phase, "danger")
    box = phase.canvas.measure()
    upper = found[(found[:, 1] < phase.canvas.pixel(0.0, 3.0).y() - 4) & (found[:, 1] > box.top())]
    assert upper[:, 0].min() > box.center().x()


def test_a_choice_switches_to_the_plot_with_a_theory_unless_one_was_chosen_by_hand(phase, qtbot):
    use(phase, "texture", kind="bands")
    for kind, wanted in (("grating", "force_position"), ("bands", "force_velocity")):
        use(phase, "texture", kind=kind)
        qtbot.waitUntil(lambda wanted=wanted: phase.canvas.plot_of.key == wanted)
        assert phase.plots[phase.switch.index].key == wanted
        assert phase.canvas.band.force.size
    phase.switch.chosen.emit(1)
    use(phase, "texture", kind="sandpaper")
    qtbot.waitUntil(lambda: not phase.canvas.band.force.size)
    assert phase.canvas.plot_of.key == "force_velocity"
    use(phase, "wall")
    assert phase.canvas.plot_of.key == "force_position"


def test_the_theory_is_the_law_force_over_its_variable(phase):
    grid = 1e-3 * phase.canvas.band.x
    assert (grid[0], grid[-1]) == pytest.approx((-0.06, 0.06))
    force = -400.0 * np.maximum(grid - 0.005, 0.0)
    np.testing.assert_allclose(phase.canvas.band.force[0], force, atol=1e-12)
    use(phase, "damping", damping=6.0)
    assert phase.canvas.plot_of.key == "force_velocity"
    velocity, force = phase.canvas.band.x, phase.canvas.band.force
    np.testing.assert_allclose(force[0], -6.0 * velocity / 1e3, atol=1e-12)
    phase.choose(0)
    assert not phase.canvas.band.force.size


def test_the_band_reaches_every_peak_of_detents_and_fills_a_fine_grating(phase, qapp):
    """At the edge of each detent, 3 mm from its centre, a stiffness of 400 N/m gives 1.20 N.

    Waves of 0.6 mm are too narrow to be drawn one by one, so the curve becomes a filled band.
    """
    for given in ({}, {"pitch": 0.0173}):
        use(phase, "detents", **given)
        phase._compute()
        x, force, _, up = drawn(phase, "theory")
        low, high = phase.canvas.view.viewRange()[0]
        pitch = 1e3 * LIBRARY["detents"].values(given)["pitch"]
        for n in range(round(low / pitch + 0.4), round(high / pitch - 0.4) + 1):
            near = np.abs(x - n * pitch) < 4.5
            assert force[near].max() == pytest.approx(1.2, abs=2.0 / abs(up))
            assert force[near].min() == pytest.approx(-1.2, abs=2.0 / abs(up))
    use(phase, "texture", wavelength=0.6e-3, amplitude=0.3)
    phase._compute()
    _, force, _, up = drawn(phase, "theory")
    box, inside = phase.canvas.measure(), np.abs(force) < 0.27
    assert inside.sum() > 0.95 * (box.width() - 4.0) * 0.54 * abs(up)
    assert np.abs(force).max() < 0.3 + 6.0 / abs(up)


def test_a_feature_narrower_than_the_curve_step_appears_when_zoomed(phase, qapp):
    """A notch of 20 µm at 7.05 mm is drawn in a plot that is 1 mm wide."""
    notch = lambda values, x: np.where(np.abs(x - 7.05e-3) < 10e-6, 0.4, 0.0)  # noqa: E731
    phase.set_environment(replace(LIBRARY["wall"], over_position=notch), LIBRARY["wall"].values(), 3.0)
    phase.view.set_locked(True)
    phase.canvas.view.setRange(xRange=(6.5, 7.5), yRange=(-1.0, 1.0), padding=0)
    x, force, across, up = drawn(phase, "theory")
    assert force.max() == pytest.approx(0.4, abs=5.0 / abs(up))
    assert x[force > 0.2].mean() == pytest.approx(7.05, abs=2.0 / across)


def test_a_changed_theory_is_visible_unless_the_axes_were_fitted_by_hand(phase, qtbot):
    view = phase.canvas.view
    left = LIBRARY["wall"].values({"side": 1.0})
    assert view.viewRange()[1][1] < 3.0
    phase.set_environment(LIBRARY["wall"], left, 3.0)
    qtbot.waitUntil(lambda: view.viewRange()[1][1] > 3.0)
    phase.fit()
    fitted = view.viewRange()
    phase.set_environment(LIBRARY["wall"], left | {"stiffness": 2000.0}, 3.0)
    qtbot.waitUntil(lambda: phase.canvas.band.force.max() > 80.0)
    assert view.viewRange() == fitted


@pytest.mark.parametrize(
    ("key", "given", "place"),
    [
        ("wall", {"position": -0.031, "side": "left"}, -31.0),
        ("spring", {"center": 0.013}, 13.0),
        ("bump_valley", {}, -15.0),  # the bump at −25 mm is 20 mm wide
        ("texture", {}, None),  # ridges are everywhere
    ],
)
def test_fitted_axes_include_the_nearest_landmark(phase, plots, history, key, given, place):
    """The handle rests at −8 mm; the axis ends at a margin beyond the wall or the spring's centre."""
    there = telemetry(12_000, 14_000)
    there[:, rows.POSITION], there[:, rows.APPLIED_FORCE] = -0.008, 0.0
    history.append(there)
    use(phase, key, **given)
    phase._compute()
    plots.set_environment(LIBRARY[key], LIBRARY[key].values(given), 3.0)
    for part in (plots, phase):
        part.refresh()
        part.fit()
    places = sorted((-8.0, -8.0 if place is None else place))
    half = 1.15 * (places[1] - places[0]) / 2.0
    for low, high in (phase.canvas.view.viewRange()[0], canvas_of(plots, "position").view.viewRange()[1]):
        assert low < places[0]
        assert places[1] < high
        # tolerance: two steps of the curve, 0.7 mm; the smallest range is an eighth of the reach, 5.1 mm
        assert high - low < max(2.0 * half + 0.7, 5.1)


def test_fitted_forces_include_the_curve_up_to_the_motor_limit(phase, history):
    """A wall of 5000 N/m has 25 N at a depth of 5 mm, but the axis ends at 1.35 times the limit of 3 N."""
    there = telemetry(12_000, 14_000)
    there[:, rows.POSITION], there[:, rows.APPLIED_FORCE] = 0.010, 0.0
    history.append(there)
    for stiffness, least in ((200.0, -1.0), (5000.0, -1.35 * 3.0)):
        use(phase, "wall", stiffness=stiffness)
        phase._compute()
        phase.fit()
        low, high = phase.canvas.view.viewRange()[1]
        assert low == pytest.approx(least * 1.075, abs=0.05)
        assert high == pytest.approx(-least * 0.075, abs=0.05)


def test_every_branch_of_a_loop_is_drawn_and_ends_where_undefined(phase, qtbot):
    """The loop has two branches and ends at 10 mm; the band follows both branches, but not beyond 10 mm."""
    loop = lambda values, x: np.where(x < 0.010, np.array([[1.0], [-1.0]]), np.nan)  # noqa: E731
    phase.set_environment(replace(LIBRARY["wall"], over_position=loop), LIBRARY["wall"].values(), 3.0)
    assert phase.plots[phase.switch.index].key == "force_position"
    low, high = phase.canvas.view.viewRange()[1]
    assert low < -1.0
    assert high > 1.0
    x, force, across, up = drawn(phase, "theory")
    assert {round(f) for f in force} == {-1, 1}
    assert np.abs(np.abs(force) - 1.0).max() < 5.0 / abs(up)
    assert x.max() < 10.0 + 6.0 / across


def test_the_measured_force_is_drawn_at_its_samples(phase, history):
    x, force, across, up = drawn(phase, "applied")
    expected = np.maximum(-0.4 * np.maximum(x - 5.0, 0.0), -3.0)
    now = history.latest()
    near_dot = np.hypot((x - 1e3 * now["position"]) * across, (force - now["applied_force"]) * up)
    off = np.abs(force - expected)[near_dot > 7] * abs(up)
    assert len(off) > 50
    assert off.max() <= 3.5 + 0.4 * abs(up) / across


def test_another_environment_starts_with_an_empty_plot_even_while_paused(phase, history):
    """The motion in the wall is not drawn for the damping environment."""
    assert len(pixels(phase, "applied")) > 500
    for paused in (True, False):
        phase.view.set_paused(paused)
        history.end_environment()
        use(phase, "spring")
        dot = pixels(phase, "applied")
        assert np.ptp(dot[:, 0]) < 16
    history.append(telemetry(3000, 14_000))
    assert len(pixels(phase, "applied")) > 2 * len(dot)


def test_older_parts_are_paler_and_the_oldest_disappear(phase, history):
    still = telemetry(12_000, 14_000)
    still[:, rows.POSITION], still[:, rows.APPLIED_FORCE] = -0.01, 0.0
    history.append(still[:3000])
    phase.fit()
    row, darkest = int(phase.canvas.pixel(0.0, -1.5).y()), []
    for part in (slice(0), slice(3000, 7000), slice(7000, None)):
        history.append(still[part])
        phase.canvas.refresh()
        image = phase.canvas.viewport().grab().toImage()
        darkest.append(min(image.pixelColor(x, row).green() for x in range(60, image.width() - 20)))
    assert darkest == sorted(set(darkest))


def test_pausing_keeps_the_picture(phase, history):
    phase.view.set_paused(True)
    more = telemetry(500, 14_000)
    more[:, rows.APPLIED_FORCE] = 2.9
    history.append(more)
    phase.canvas.refresh()
    assert phase.canvas.view.viewRange()[1][1] < 2.0
    phase.view.set_paused(False)
    phase.canvas.refresh()
    assert phase.canvas.view.viewRange()[1][1] > 2.9


def test_dashes_cover_their_fraction_of_a_line_and_no_gaps():
    x = np.concatenate([np.linspace(0, 85, 30), [np.nan], np.linspace(100, 134, 12)])
    ends = strokes.dashed(x, np.where(np.isnan(x), np.nan, 10.0))
    lengths = ends[:, 2] - ends[:, 0]
    assert lengths == pytest.approx(np.full(14, 5.0))
    assert not ((ends[:, 0] < 86) & (ends[:, 2] > 99)).any()


def test_plots_are_discovered_by_file():
    assert {"position", "velocity", "force"} <= {plot.key for plot in time_plots()}
    assert {"force_position", "force_velocity"} <= {plot.key for plot in phase_plots()}
    for plot in time_plots():
        assert all(trace.channel in channels() for trace in plot.traces)


def test_a_plot_of_an_unknown_signal_lists_the_known_ones():
    with pytest.raises(ValueError, match=r"^There is no signal asked; the signals are tick, time, "):
        Trace("asked", "asked", "asked")


def test_a_widening_axis_keeps_the_older_curve(phase, history, qapp):
    """With a push that grows in every frame, the older part of the curve stays visible."""
    push = telemetry(4000, 14_000)
    push[:, rows.POSITION] = 0.0
    push[:, rows.APPLIED_FORCE] = np.linspace(0.0, 12.0, 4000)
    widenings = 0
    for part in range(0, 4000, 100):
        history.append(push[part : part + 100])
        before = phase.canvas.view.viewRange()
        phase.canvas.refresh()
        widenings += phase.canvas.view.viewRange() != before
        image = phase.canvas.viewport().grab().toImage()
        x, force = 11.0, -0.4 * 6.0
        place = phase.canvas.pixel(x, force)
        near = [
            image.pixelColor(round(place.x()) + a, round(place.y()) + b) for a in (-1, 0) for b in (-1, 0, 1)
        ]
        assert min(color.lightness() for color in near) < 170
    assert widenings > 5


STIFFNESS, AWAY, DELAY = 300.0, 5e-3, 60e-3  # N/m, m, s


def swing(phase):
    """Fill the history with 2.2 s at 1 kHz of a handle that oscillates at 1 Hz on a spring."""
    use(phase, "spring", stiffness=STIFFNESS)
    history = phase.view.live
    history.clear()
    new = telemetry(2200)
    new[:, rows.POSITION] = AWAY * np.sin(2.0 * np.pi * new[:, rows.HOST_TIME])
    new[:, rows.APPLIED_FORCE] = -STIFFNESS * new[:, rows.POSITION]
    history.append(new)


def off_the_line(phase):
    """Return the distance of the drawn curve from the spring's line in N, and the size of a pixel in N."""
    x, force, _, up = drawn(phase, "applied")
    return np.abs(force + 1e-3 * STIFFNESS * x).max(), 1.0 / abs(up)


def test_as_felt_a_delayed_spring_is_a_loop_with_the_energy_per_cycle(phase):
    """The drawn loop has the half width w = k a sin(2π f (t_d + T/2)) in N and the area π a w in J.

    k is the stiffness, a the amplitude, f the frequency, t_d the delay, and T the sample period.
    """
    swing(phase)
    phase.set_delay(DELAY)
    away, pixel = off_the_line(phase)
    assert away < 6.0 * pixel, "as computed: on the line, the newest sample's dot aside"
    assert phase.cycle.text() == ""
    phase.felt.setChecked(True)
    wide = STIFFNESS * AWAY * np.sin(2.0 * np.pi * (DELAY + 0.5e-3))
    away, pixel = off_the_line(phase)
    assert away == pytest.approx(wide, abs=6.0 * pixel)
    assert away > 10.0 * pixel
    assert phase.cycle.text() == f"The scene gives {1e3 * np.pi * AWAY * wide:.2g} mJ per cycle"
    phase.choose(1)
    assert not phase.felt.isVisibleTo(phase)


def test_without_a_known_delay_nothing_is_drawn_as_felt(phase):
    swing(phase)
    phase.felt.setChecked(True)
    phase.set_delay(None)
    assert not phase.felt.isEnabled()
    assert phase.cycle.text() == ""
    away, pixel = off_the_line(phase)
    assert away < 6.0 * pixel


def test_as_felt_shows_only_samples_of_the_current_delay(phase):
    swing(phase)
    phase.felt.setChecked(True)
    phase.set_delay(DELAY)
    assert len(phase.canvas._recent().x) == 2200
    phase.set_delay(0.5 * DELAY)
    assert len(phase.canvas._recent().x) <= 1
