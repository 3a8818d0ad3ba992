"""Force over position: theory, measured force, age; strokes; discovery."""

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtGui import QColor, QImage, QPainter

from hapkit_studio.gui.live import strokes
from hapkit_studio.gui.live.history import CHANNELS
from hapkit_studio.gui.live.plots.declared import phase_plots, time_plots
from hapkit_studio.haptics import rows
from tests.gui.live.plot_support import LIBRARY, colored, settle, telemetry


def test_theory_is_the_laws_own_force(phase):
    grid = phase.plots[0].grid()
    x, force = phase.canvas.band.x, phase.canvas.band.force
    np.testing.assert_allclose(x, 1e3 * grid)
    np.testing.assert_allclose(force[0], -400.0 * np.maximum(grid - 0.005, 0.0), atol=1e-12)


def test_the_wall_is_shown_over_position_and_damping_over_velocity(phase):
    assert phase.switch.index == 0
    phase.set_environment(LIBRARY["damping"], LIBRARY["damping"].values({"damping": 6.0}), 3.0)
    assert phase.plots[phase.switch.index].key == "force_velocity"
    velocity, force = phase.canvas.band.x, phase.canvas.band.force
    np.testing.assert_allclose(force[0], -6.0 * velocity / 1e3, atol=1e-12)
    phase.choose(0)
    assert not phase.canvas.band.force.size


def test_friction_is_shown_over_velocity_and_texture_as_its_kind_is(phase):
    """Bands damp, a grating pushes by place."""
    for key, values, wanted in (
        ("friction", {}, "force_velocity"),
        ("texture", {"kind": "bands"}, "force_velocity"),
        ("texture", {"kind": "grating"}, "force_position"),
        ("hard_surface", {}, "force_position"),
        ("cat", {}, "force_position"),
    ):
        phase.set_environment(LIBRARY["free"], {}, 3.0)
        phase.set_environment(LIBRARY[key], LIBRARY[key].values(values), 3.0)
        assert phase.plots[phase.switch.index].key == wanted


def test_a_changed_parameter_moves_the_theory_soon(phase, qtbot):
    phase.set_environment(LIBRARY["wall"], LIBRARY["wall"].values({"stiffness": 100.0}), 3.0)
    qtbot.waitUntil(lambda: phase.canvas.band.force.min() == pytest.approx(-100.0 * 0.055))


def test_a_changed_theory_is_in_sight_unless_the_axes_were_fitted_by_hand(phase, qtbot):
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


def test_every_branch_of_a_loop_is_drawn_and_cut_where_it_has_no_value(phase, qtbot):
    """A loop of two branches that ends at 10 mm: the band is there on both, and nowhere beyond."""
    loop = lambda values, x: np.where(x < 0.010, np.array([[1.0], [-1.0]]), np.nan)  # noqa: E731
    phase.set_environment(replace(LIBRARY["wall"], over_position=loop), LIBRARY["wall"].values(), 3.0)
    assert phase.plots[phase.switch.index].key == "force_position"
    low, high = phase.canvas.view.viewRange()[1]
    assert low < -1.0
    assert high > 1.0
    settle(phase)
    found = colored(phase.canvas.viewport().grab().toImage(), "theory")
    phase.canvas.measure()
    left, across, bottom, up = phase.canvas._map
    x, force = (found[:, 0] + 0.5 - left) / across, (found[:, 1] + 0.5 - bottom) / up
    assert {round(f) for f in force} == {-1, 1}
    assert np.abs(np.abs(force) - 1.0).max() < 5.0 / abs(up)
    assert x.max() < 10.0 + 6.0 / across


def test_the_measured_force_lies_where_the_samples_say(phase, qapp):
    settle(phase)
    image = phase.canvas.viewport().grab().toImage()
    found = colored(image, "applied")
    phase.canvas.measure()
    left, across, bottom, up = phase.canvas._map
    x = (found[:, 0] + 0.5 - left) / across
    force = (found[:, 1] + 0.5 - bottom) / up
    expected = np.maximum(-0.4 * np.maximum(x - 5.0, 0.0), -3.0)
    near_dot = np.hypot(
        x * across - phase.canvas._history.last("position") * 1e3 * across,
        (force - phase.canvas._history.last("applied")) * up,
    )
    off = np.abs(force - expected)[near_dot > 7] * abs(up)
    assert len(off) > 50
    assert off.max() <= 3.5 + 0.4 * abs(up) / across


def test_another_environment_begins_with_an_empty_plot(phase, history):
    """What the handle did in the wall says nothing about damping."""
    settle(phase)
    assert len(colored(phase.canvas.viewport().grab().toImage(), "applied")) > 500
    phase.set_environment(LIBRARY["spring"], LIBRARY["spring"].values(), 3.0)
    settle(phase)
    dot = colored(phase.canvas.viewport().grab().toImage(), "applied")
    assert np.ptp(dot[:, 0]) < 16
    more = telemetry(3000, 14_000)
    history.append(more)
    settle(phase)
    assert len(colored(phase.canvas.viewport().grab().toImage(), "applied")) > 2 * len(dot)


def test_older_parts_are_paler_and_the_oldest_are_gone(phase, history):
    still = telemetry(12_000, 14_000)
    still[:, rows.POSITION], still[:, rows.APPLIED] = -0.01, 0.0
    history.append(still[:3000])
    phase.fit()
    limit_row = float(phase.canvas.to_pixels(0.0, -1.5)[1])

    def darkest():
        settle(phase)
        image = phase.canvas.viewport().grab().toImage()
        band = [image.pixelColor(x, int(limit_row)).green() for x in range(60, image.width() - 20)]
        return min(band)

    recent = darkest()
    history.append(still[3000:7000])
    phase.fit()
    older = darkest()
    history.append(still[7000:])
    phase.canvas.refresh()
    gone = darkest()
    assert recent < older < gone


def test_paused_keeps_the_picture(phase, history):
    phase.set_paused(True)
    more = telemetry(500, 14_000)
    more[:, rows.APPLIED] = 2.9
    history.append(more)
    phase.canvas.refresh()
    assert phase.canvas.view.viewRange()[1][1] < 2.0
    phase.set_paused(False)
    phase.canvas.refresh()
    assert phase.canvas.view.viewRange()[1][1] > 2.9


def test_dashes_cover_their_share_of_a_line_and_leave_gaps_alone():
    x = np.concatenate([np.linspace(0, 85, 30), [np.nan], np.linspace(100, 134, 12)])
    ends = strokes.dashed(x, np.where(np.isnan(x), np.nan, 10.0))
    lengths = ends[:, 2] - ends[:, 0]
    assert lengths == pytest.approx(np.full(14, 5.0))
    assert not ((ends[:, 0] < 86) & (ends[:, 2] > 99)).any()


def test_segments_are_painted(qapp):
    image = QImage(40, 20, QImage.Format.Format_RGB32)
    image.fill(QColor("white"))
    painter = QPainter(image)
    x = np.array([5.0, 20.0, np.nan, 25.0, 35.0])
    strokes.trace(painter, x, x * 0.0 + 10.0, QColor("black"))
    painter.end()
    dark = [x for x in range(40) if image.pixelColor(x, 10).lightness() < 128]
    assert dark == [*range(4, 21), *range(24, 36)]


def test_plots_are_found_by_their_files():
    assert [plot.key for plot in time_plots()] == ["position", "velocity", "force"]
    assert [plot.key for plot in phase_plots()] == ["force_position", "force_velocity"]
    for plot in time_plots():
        assert all(trace.channel in CHANNELS for trace in plot.traces)
