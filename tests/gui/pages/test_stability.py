"""The stability map in the window: its dot follows the settings, clicks set sliders, limits are measured."""

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QToolTip

from hapkit_studio.analysis.stability.kb_plane import (
    exact_boundary,
    friction_boundary,
    hands,
    passivity_line,
)
from hapkit_studio.analysis.stability.objects import contact_limit
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments import discover
from hapkit_studio.gui.pages import measuring as measuring_page
from hapkit_studio.gui.pages.stability import page as stability
from hapkit_studio.gui.pages.stability.map_data import measuring
from hapkit_studio.gui.pages.stability.page import reading
from hapkit_studio.gui.pages.stability.trial import map_parameters
from hapkit_studio.gui.state.studio import Studio
from tests.gui.pages.drawing_support import click, drawn, outside, point, spot, texts
from tests.gui.pages.stability_support import follow, made_up
from tests.gui.shell.test_layout import cut_off, resize
from tests.gui.window_support import PATIENCE_MS, put_back


@pytest.fixture
def window(reset_window):
    """Return the window with the running simulated device."""
    return reset_window


@pytest.fixture
def wall_page(window, qtbot):
    """Return the visible page with the wall and the loop of a new window."""
    page = window.views.page("stability")
    page.job._needs = ""
    page.hands.show_index(0)
    page.real.setChecked(False)
    page.lines, page.results.all = None, []
    page._worker.forget()  # allows the same request again
    page._worker._waiting.setInterval(PATIENCE_MS)  # answers are late on a busy machine
    page.bar.show_text("")
    page.chart.show_drawing(lambda _figure, _colors: ())
    window.views.show("stability")
    follow(page, qtbot)
    return page


def in_force(window):
    """Set a wall of 620 N/m and 2 N·s/m with the IIR filter and no delay."""
    window.studio.set_loop(estimator="iir")
    window.studio.set_values({"stiffness": 620.0, "damping": 2.0, "damping_mode": 1.0})


@pytest.fixture
def page(window, qtbot, request):
    """Return the visible page with a different wall and loop."""
    in_force(window)
    return request.getfixturevalue("wall_page")


@pytest.fixture
def alone(window, qtbot):
    """Return a page outside a window; the page is hidden and draws nothing."""
    in_force(window)
    made = stability.StabilityPage(window.studio, window.live)
    made.job._needs = ""
    made.set_shown(True)
    follow(made, qtbot)
    yield made
    made.set_shown(False)
    made.end()
    made.deleteLater()


def axes_of(page):
    """Return the upper ends of the map's axes."""
    (axes,) = drawn(page.chart)
    return axes.get_xlim()[1], axes.get_ylim()[1]


@pytest.mark.slow
def test_the_map_judges_the_current_loop_and_the_dot_follows_the_sliders(page, window, qtbot):
    setting, column = LoopSettings(estimator="iir"), page.verdict_column
    limits = hands(setting, 2.0)
    assert (page.lines.plane.setting, page.lines.plane.hands) == (setting, limits)
    assert column.heading.text() == "Stable"
    assert (
        f"In your hand, the handle is stable, {limits['medium'] / 620.0:.0f} × below the limit."
        in column.answers.text
    )
    assert f"{limits['firm']:,.0f} N/m" in dict(page.verdict_column.limits.pairs).values()
    before, axes = axes_of(page), page.chart.figure.axes[0]
    for stiffness in (800.0, 700.0):
        window.studio.set_value("stiffness", stiffness)
        assert follow(page, qtbot).margin.stiffness == stiffness
    assert page.chart.figure.axes == [axes], "nothing was drawn anew"
    assert page._dot.label.get_text() == "700 N/m, 2.0 N·s/m"
    assert axes_of(page) == before
    window.studio.set_value("stiffness", 5000.0)
    follow(page, qtbot)
    assert axes_of(page)[1] > 5000.0
    assert column.answers.text.endswith("the handle moves away and cannot buzz."), "it leaves the wall"


@pytest.mark.slow
def test_a_click_sets_both_sliders_and_undo_restores_both(page, window, qtbot):
    studio, (width, top) = window.studio, axes_of(page)
    click(page.chart, 0.5 * width, 0.25 * top)
    assert studio.values["damping"] == pytest.approx(0.5 * width, abs=0.06 + 0.005 * width)
    assert studio.values["stiffness"] == pytest.approx(0.25 * top, abs=6.0 + 0.005 * top)
    margin = follow(page, qtbot).margin
    assert (margin.stiffness, margin.damping) == (studio.values["stiffness"], studio.values["damping"])
    click(page.chart, 0.2 * width, 0.2 * top, Qt.MouseButton.RightButton)
    assert studio.values["damping"] == margin.damping
    QTest.keyClick(page, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert (studio.values["stiffness"], studio.values["damping"]) == (620.0, 2.0)


@pytest.mark.slow
def test_the_pointer_reads_the_limit_and_dragging_sets_the_sliders_up_to_the_frame(page, window):
    plane = page.lines.plane
    limit = float(plane.exact[60])
    here, there = reading(page.lines, float(plane.damping[60]), 0.5 * limit)
    assert there == f"Stiffness 2.0 × below the limit of {limit:,.0f} N/m"
    assert here.endswith(f"{plane.damping[60]:.1f} N·s/m")
    point(page.chart, 0.5 * plane.width, 0.5 * limit)
    assert "the limit of " in QToolTip.text()
    width, top = axes_of(page)
    canvas, start = page.chart.canvas, spot(page.chart, 0.3 * width, 0.3 * top)
    QTest.mousePress(canvas, Qt.MouseButton.LeftButton, pos=start)
    QTest.mouseMove(canvas, spot(page.chart, 0.4 * width, 0.5 * top))
    assert window.studio.values["stiffness"] == pytest.approx(0.5 * top, rel=0.02)
    QTest.mouseMove(canvas, QPoint(start.x(), -500))
    assert 0.98 * top <= window.studio.values["stiffness"] <= top
    QTest.mouseRelease(canvas, Qt.MouseButton.LeftButton, pos=start)


@pytest.mark.slow
def test_the_pages_sliders_are_hatched_like_those_of_the_panel(page, window, qtbot):
    studio = window.studio
    studio.set_loop(estimator="difference", rate=300.0)
    studio.choose("spring")
    studio.set_values({"stiffness": 300.0, "damping": 0.0})
    (held,) = friction_boundary(LoopSettings(rate=300.0), np.zeros(1))
    hatched = {"stiffness": [(pytest.approx(held, rel=1e-3), 2000.0)]}
    qtbot.waitUntil(
        lambda: hatched["stiffness"] == studio.unstable_ranges.get("stiffness"), timeout=PATIENCE_MS
    )
    for rows in (window.panel.parameters.rows, page.side.rows.rows):
        assert hatched["stiffness"] == list(rows["stiffness"].slider._ranges)
    studio.choose("detents")
    assert studio.unstable_ranges == {}, "another scene's ranges are not known yet"


def damper_grows(setting, damping):
    """Return True if a sampled damper in N·s/m makes the motion of a released handle grow.

    The answer follows from the eigenvalues of the exact transition matrix of one period.
    """
    dt, mass, own = setting.period, setting.mass, setting.viscous
    keeps = np.exp(-own * dt / mass)
    rolls = (1.0 - keeps) * mass / own  # displacement per initial speed, in s
    goes, speeds = (
        damping / dt * k for k in ((dt - rolls) / own, (1.0 - keeps) / own)
    )  # changes of position and speed per m of motion between two samples
    step = [[1.0 - goes, rolls, goes], [-speeds, keeps, speeds], [1.0, 0.0, 0.0]]
    return np.abs(np.linalg.eigvals(step)).max() > 1.0 + 1e-6


@pytest.mark.slow
def test_without_stiffness_the_limits_are_those_of_the_damping(wall_page, window, qtbot):
    column = wall_page.verdict_column
    window.studio.set_loop(estimator="difference")
    window.studio.choose("damping")
    follow(wall_page, qtbot)
    setting, pairs = wall_page.lines.plane.setting, dict(column.limits.pairs)
    assert column.limits_heading.text() == "Limits of the damping"
    assert {text.split()[1] for text in pairs.values()} == {"N·s/m"}
    limits = {name: float(text.split()[0].replace(",", "")) for name, text in pairs.items()}
    assert not damper_grows(setting, 0.99 * limits["No hand"])
    assert damper_grows(setting, 1.01 * limits["No hand"])
    assert limits["Passive"] == pytest.approx(setting.viscous, abs=0.06), "Colgate: b₀ > |b|"
    assert limits["No hand"] < limits["Light grip"] < limits["Firm grip"]
    window.studio.choose("free")
    qtbot.waitUntil(lambda: "has no stiffness" in column.out.text())
    assert column.heading.text() == "Stable"
    assert column.limits.pairs == []
    assert not any("N/m, " in word for word in texts(wall_page.chart)), "there is no dot"
    assert "has no stiffness or damping to set" in wall_page.side.try_hint.text()


def test_every_limit_beside_the_map_agrees_with_theory(wall_page):
    setting, pairs = wall_page.lines.plane.setting, dict(wall_page.verdict_column.limits.pairs)
    bare = replace(setting, hand="released")
    (passive,), (held,) = passivity_line(bare, np.zeros(1)), friction_boundary(bare, np.zeros(1))
    expected = {"Passive": passive, "No hand": 2.0 * bare.viscous * bare.rate, "No hand, friction": held}
    for name, limit in expected.items():
        assert float(pairs[name].split()[0].replace(",", "")) == pytest.approx(limit, rel=0.005)
    assert list(pairs)[2:5] == ["Light grip", "Medium grip", "Firm grip"]
    assert wall_page.verdict_column.why.isVisible()


@pytest.mark.parametrize(
    ("key", "stiffness", "damping"),
    [
        ("wall", "stiffness", "damping"),
        ("damping", None, "damping"),
        ("puck", "contact_stiffness", "contact_damping"),
        ("bump_valley", None, None),
    ],
)
def test_a_click_sets_the_parameters_of_the_impedance(key, stiffness, damping):
    environment = discover()[key]
    pair = map_parameters(environment, environment.values({}))
    found = tuple(p.key if p else None for p in (pair.stiffness, pair.damping))
    assert found == (stiffness, damping)
    assert set(pair.values(123.0, 4.0)) == {key for key in found if key}
    assert set(pair.values(9e9, -3.0).values()) <= {5000.0, 0.0}, "beyond a slider it goes to its end"


@pytest.mark.slow
def test_a_puck_shows_limits_of_handle_and_object_that_are_not_on_the_map(wall_page, window, qtbot):
    window.studio.choose("puck")
    plane = follow(wall_page, qtbot)
    values, column = window.studio.values, wall_page.verdict_column
    limits = {h: contact_limit(replace(plane.setting, hand=h), "puck", values) for h in GRIPS}
    assert plane.hands == limits
    assert plane.margin.limit == limits["released"] < 0.95 * hands(plane.setting, 0.0)["released"]
    pairs = dict(column.limits.pairs)
    assert list(pairs.values()) == [f"{limit:,.0f} N/m" for limit in limits.values()]
    assert "This map is for a wall" in column.out.text()


@pytest.mark.slow
def test_an_adaptive_window_has_no_exact_limit_but_can_be_measured(page, window, qtbot):
    window.studio.set_loop(estimator="foaw")
    follow(page, qtbot)
    assert "there is no exact limit" in page.verdict_column.out.text()
    assert "Exact boundary" not in texts(page.chart)
    assert page.bar.run.isEnabled()
    assert reading(page.lines, 1.0, 100.0)[1] == "No exact limit"


def test_without_a_device_nothing_is_judged(shared_window):
    shared_window.views.show("stability")
    page = shared_window.views.page("stability")
    column = page.verdict_column
    assert column.heading.text() == "Stability not judged yet"
    assert (column.lines.text(), column.conditions.pairs, column.limits.pairs) == ("", [], [])
    assert not column.limits_heading.isVisible()
    assert not page.side.release.isEnabled()
    assert not page.bar.export.isEnabled()
    page.bar.run.click()
    assert page.bar.status.text() == "Connect a device first."
    assert not page.job.running


def test_a_lost_device_pales_the_map_and_a_hidden_page_requests_nothing(alone, window, qtbot, monkeypatch):
    page = alone
    with monkeypatch.context() as gone:
        gone.setattr(window.studio.device, "engine", None)
        window.studio.engine_changed.emit()
        assert page.lines is None
        assert page.chart.pale
        assert page.verdict_column.heading.text() == "Stability not judged yet"
    window.studio.engine_changed.emit()
    follow(page, qtbot)
    assert not page.chart.pale
    page.set_shown(False)
    window.studio.set_value("stiffness", 900.0)
    page.wait()
    assert page.lines.question.stiffness == 620.0
    page.set_shown(True)
    assert follow(page, qtbot).margin.stiffness == 900.0


@pytest.mark.slow
def test_every_hand_has_a_boundary_and_nothing_is_cut_off(page, window, qapp, qtbot):
    page.hands.button(1).click()
    medium = follow(page, qtbot)
    assert medium.setting.hand == medium.margin.hand == "medium"
    window.studio.set_value("stiffness", 5000.0)
    page.hands.button(2).click()
    plane = follow(page, qtbot)
    assert list(page.lines.hands) == ["released", "light", "medium", "firm"]
    assert plane.margin.limit == min(plane.hands.values())
    assert max(limits.max() for limits in page.lines.hands.values()) <= plane.top
    assert {"light grip", "medium grip", "firm grip"} <= set(texts(page.chart))
    page.bar.show_text("Measured 100 × 100 cells in 12.3 s")
    column = page.verdict_column
    for size in ((1280, 720), (800, 560)):
        resize(qapp, window, size)
        assert cut_off(page) == [], size
        assert outside(page.chart) == [], size
        assert not page.side.isVisible() or cut_off(page.side) == [], size
        column.ensureWidgetVisible(column.conditions)
        assert not column.isVisible() or not column.conditions.visibleRegion().isEmpty(), size


# measuring


def test_the_measured_boundary_is_the_exact_one_and_progress_reaches_the_end():
    reports = []
    setting = LoopSettings(viscous=0.18, delay=1e-3)
    found = measuring(setting, False, (4.0, 3000.0), side=4)(lambda done, of: reports.append((done, of)))
    assert found.points.stiffness == pytest.approx(exact_boundary(setting, found.points.damping), rel=0.01)
    limits = exact_boundary(setting, found.cells.damping)
    assert np.array_equal(found.cells.classes == 0, found.cells.stiffness[:, np.newaxis] < limits)
    assert found.text((4.0, 3000.0)).startswith("Measured 4 × 4 cells in ")
    assert found.text((8.0, 3000.0)) == "Measured only up to 4 N·s/m and 3,000 N/m"
    assert reports == sorted(reports)
    assert reports[-1][0] == reports[-1][1]


@pytest.mark.slow
def test_a_measurement_pales_under_other_conditions(wall_page, window, qtbot):
    page = wall_page
    page.show_result(made_up(page.lines.plane.setting, axes=(12.0, 3000.0)))
    assert page.bar.status.text() == "Measured 4 × 3 cells in 3.1 s"
    assert {"Measured boundary: beyond this map", "buzzes without growing"} <= set(texts(page.chart))
    window.studio.set_value("stiffness", 500.0)
    follow(page, qtbot)
    assert not page._map.outdated, "another dot is no other condition"
    pairs = lambda: dict(page.verdict_column.conditions.pairs)  # noqa: E731
    setting = page.lines.plane.setting
    assert (pairs()["Mass"], "Dry friction" in pairs()) == (f"{setting.mass:g} kg", False)
    page.real.setChecked(True)
    assert page._map.outdated
    assert page.bar.status.text() == "Measurement out of date"
    assert pairs()["Dry friction"] == f"{setting.coulomb:g} N"
    assert pairs()["Sensor step"] == f"{1e6 * setting.quantum:.3g} µm"
    page.real.setChecked(False)
    assert not page._map.outdated
    window.studio.set_loop(estimator="iir")
    follow(page, qtbot)
    assert page._map.outdated


@pytest.mark.slow
def test_measurements_with_and_without_the_controller_are_shown_together(wall_page, window, qtbot):
    page = wall_page
    plain = page.lines.plane.setting
    controlled = replace(plain, controller=True)
    page.show_result(made_up(plain))
    page.show_result(made_up(controlled))
    beyond = {f"{name}: beyond this map" for name in ("Measured boundary", "Bounded")}
    assert beyond <= set(texts(page.chart))
    page.show_result(made_up(controlled))
    assert {m.setting.controller for m in page.results.all} == {False, True}
    assert len(page.results.all) == 2
    assert not page.outdated, "the controller is off, and there is a map without it"
    page.side.controller.click()
    assert follow(page, qtbot).setting.controller
    assert page.results.last.setting == controlled
    assert not page.outdated
    page.show_result(made_up(replace(plain, rate=500.0)))
    assert [m.setting.rate for m in page.results.all] == [500.0]
    window.studio.set_loop(controller=False)
    assert not page.side.controller.isChecked()


def test_a_measurement_waits_for_the_lines(alone, qtbot, monkeypatch):
    page = alone
    monkeypatch.setattr(stability, "measuring", lambda *args: lambda _progress: made_up(args[0]))
    lines, page.lines = page.lines, None
    page.bar.run.click()
    assert not page.job.running
    page.show_lines(lines)
    qtbot.waitUntil(lambda: len(page.results.all) == 1)


@pytest.mark.slow
def test_the_handle_is_pulled_and_released(alone, window, qtbot, monkeypatch):
    page = alone
    put_back(window)
    follow(page, qtbot)
    places = []
    monkeypatch.setattr(window.studio, "move_hand", places.append)
    window.studio.set_loop(hand="released")
    page.trial._timer.setInterval(1)
    page.side.release.click()
    assert window.studio.grip == "medium", "without a grip nothing would be pulled"
    assert not page.side.release.isEnabled()
    qtbot.waitUntil(lambda: places[-1:] == [None])
    wall = window.studio.values["position"]
    assert wall < places[0] <= wall + 0.0151
    assert window.studio.grip == "released"
    page.trial._timer.setInterval(PATIENCE_MS)
    page.side.release.click()
    page.set_shown(False)
    assert places[-1] is None, "leaving the page lets go"
    assert not page.trial.holding
    monkeypatch.setattr(Studio, "hand_is_ours", False)
    page.set_shown(True)
    assert not page.side.release.isEnabled()
    assert "On a real Hapkit, let go of the handle with your hand" in page.side.try_hint.text()


@pytest.mark.slow
def test_picture_and_numbers_are_those_shown(alone, tmp_path, monkeypatch):
    page = alone
    page.show_result(made_up(page.lines.plane.setting))
    taken = []
    monkeypatch.setattr(measuring_page, "choose_file", lambda *_args, **_given: taken.append(page.exports()))
    page.bar.export.click()
    figure, numbers = taken[0]
    assert numbers()["measured"]["stiffness"] == [800.0, 900.0, 1000.0]
    assert numbers()["stiffness"] == page.lines.plane.margin.stiffness
    figure(str(tmp_path / "map.png"))
    assert (tmp_path / "map.png").stat().st_size > 20_000
    page.real.setChecked(True)
    page.bar.export.click()
    assert taken[1][1]()["measured"] is None
