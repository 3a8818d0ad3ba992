"""The stability map in the window: a dot that follows, clicks that set sliders, words, what is missing."""

from dataclasses import replace

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability.kb_plane import hands, plane
from hapkit_studio.analysis.stability.margin import Margin
from hapkit_studio.environments import discover
from hapkit_studio.gui.pages.stability.page import reading
from hapkit_studio.gui.pages.stability.trial import contact, map_parameters
from hapkit_studio.gui.pages.stability.verdict import kind_at, verdict
from hapkit_studio.gui.widgets.theme import theme
from tests.gui.pages.drawing_support import click, drawn, outside, point, spot, words
from tests.gui.pages.stability_support import follow, made_up
from tests.gui.test_layout import cut_off
from tests.gui.window_support import PATIENCE_MS


@pytest.fixture
def page(window, qtbot):
    """Return the page in sight: the wall at 620 N/m and 2 N·s/m, iir, no delay."""
    window.studio.set_loop(estimator="iir", options=())
    window.studio.set_values({"stiffness": 620.0, "damping": 2.0, "damping_mode": 1.0})
    window.views.show("stability")
    shown = window.views.page("stability")
    follow(shown, qtbot)
    return shown


def press(page, damping, stiffness, button=Qt.MouseButton.LeftButton):
    """Click a point of the map."""
    click(page.chart, damping, stiffness, button)


def test_it_judges_the_loop_in_force(page):
    setting = Setting(estimator="iir")
    limits = hands(setting, 2.0)
    assert page.lines.plane.setting == setting
    assert page.lines.plane.hands == limits
    assert page.verdict_column.headline.text() == f"{limits['released'] / 620.0:.1f} × below"
    assert page.verdict_column.hand.text() == "the limit; released hand, without dry friction."
    shown = page.side.hands
    assert f"{limits['firm']:,.0f} N/m" in [label.text() for pair in shown._labels for label in pair]

    read_with_the_pointer(page)


def read_with_the_pointer(page):
    plane = page.lines.plane
    limit = plane.exact[60]
    here, there = reading(page.lines, float(plane.damping[60]), 0.5 * float(limit))
    assert there == f"limit {limit:,.0f} N/m: 2.0 × below"
    assert here.endswith(f"{plane.damping[60]:.1f} N·s/m")
    point(page.chart, 0.5 * plane.width, 0.5 * float(limit))
    assert any(words.startswith("limit ") for artist in page.chart._reading for words in said(artist))


def said(artist):
    """Return an artist's lines of words."""
    return artist.get_text().split("\n") if hasattr(artist, "get_text") else []


def axes_of(page):
    """Return the ranges of the map, across and up."""
    (axes,) = drawn(page.chart)
    return axes.get_xlim(), axes.get_ylim()


def test_the_dot_follows_the_sliders_the_axes_stay_and_the_way_out_is_said(page, window, qtbot):
    before = axes_of(page)
    for stiffness in (800.0, 1000.0, 700.0):
        window.studio.set_value("stiffness", stiffness)
        assert follow(page, qtbot).margin.stiffness == stiffness
        assert axes_of(page) == before
    window.studio.set_value("stiffness", 5000.0)
    limit = follow(page, qtbot).margin.limit
    assert axes_of(page)[1][1] > 5000.0
    assert page.verdict_column.headline.text() == f"{5000.0 / limit:.1f} × above"
    assert page.verdict_column.out.text() == f"Lower stiffness below {limit:,.0f} N/m."


def test_a_click_brings_both_sliders_there(page, window, qtbot):
    (_, width), (_, top) = axes_of(page)
    press(page, 0.5 * width, 0.25 * top)
    values = window.studio.values
    assert values["damping"] == pytest.approx(0.5 * width, abs=0.06 + 0.005 * width)
    assert values["stiffness"] == pytest.approx(0.25 * top, abs=6.0 + 0.005 * top)
    margin = follow(page, qtbot).margin
    assert (margin.stiffness, margin.damping) == (values["stiffness"], values["damping"])
    press(page, 0.2 * width, 0.2 * top, Qt.MouseButton.RightButton)
    assert window.studio.values["damping"] == values["damping"]
    go_back(page, window)


def go_back(page, window):
    """Go one step back from the click, and no further; not in another environment."""
    page.undo.shortcut.activated.emit()
    back = window.studio.values["stiffness"], window.studio.values["damping"]
    assert back == (620.0, 2.0)
    window.studio.set_value("stiffness", 700.0)
    page.undo.shortcut.activated.emit()
    assert window.studio.values["stiffness"] == 700.0
    press(page, 1.0, 300.0)
    window.studio.choose("spring")
    now = window.studio.values["stiffness"]
    page.undo.shortcut.activated.emit()
    assert window.studio.values["stiffness"] == now


def test_dragging_takes_the_sliders_along_and_stops_at_the_frame(page, window):
    (_, width), (_, top) = axes_of(page)
    canvas, start = page.chart.canvas, spot(page.chart, 0.3 * width, 0.3 * top)
    QTest.mousePress(canvas, Qt.MouseButton.LeftButton, pos=start)
    QTest.mouseMove(canvas, spot(page.chart, 0.4 * width, 0.5 * top))
    assert window.studio.values["stiffness"] == pytest.approx(0.5 * top, rel=0.02)
    QTest.mouseMove(canvas, QPoint(start.x(), -500))
    assert 0.98 * top <= window.studio.values["stiffness"] <= top
    QTest.mouseRelease(canvas, Qt.MouseButton.LeftButton, pos=start)


def test_the_dot_moves_alone_while_the_map_stays(page, window, qtbot):
    drawn(page.chart)
    axes = page.chart.figure.axes[0]
    window.studio.set_value("stiffness", 700.0)
    follow(page, qtbot)
    assert page.chart.figure.axes == [axes], "nothing was drawn anew"
    assert page._dot.words.get_text() == "700 N/m, 2.0 N·s/m"


@pytest.mark.parametrize(
    ("key", "stiffness", "damping"),
    [
        ("wall", "stiffness", "damping"),
        ("spring", "stiffness", "damping"),
        ("damping", None, "damping"),
        ("puck", "contact_stiffness", "contact_damping"),
        ("bump_valley", None, None),
        ("free", None, None),
    ],
)
def test_which_parameters_a_click_sets(key, stiffness, damping):
    environment = discover()[key]
    pair = map_parameters(environment, environment.values({}))
    found = tuple(p.key if p else None for p in (pair.stiffness, pair.damping))
    assert found == (stiffness, damping)
    assert set(pair.values(123.0, 4.0)) == {key for key in found if key}
    assert pair.words.startswith("Click" if any(found) else "No slider")


def test_a_point_beyond_a_slider_takes_it_to_its_end():
    wall = discover()["wall"]
    pair = map_parameters(wall, wall.values({}))
    assert pair.values(9e9, -3.0) == {"stiffness": 5000.0, "damping": 0.0}
    wide = wall.values({"damping_mode": "none"})
    assert map_parameters(wall, wide).damping is None


def test_where_the_force_is_met_first():
    wall, spring, free = (discover()[key] for key in ("wall", "spring", "free"))
    place, way = contact(wall, wall.values({"position": 0.012}))
    assert (place, way) == (pytest.approx(0.012, abs=0.0006), 1.0)
    place, way = contact(wall, wall.values({"position": 0.012, "side": "left"}))
    assert (place, way) == (pytest.approx(0.012, abs=0.0006), -1.0)
    assert contact(spring, spring.values({}))[0] == pytest.approx(0.0, abs=1e-9)
    assert contact(free, free.values({})) == (0.0, 1.0)


def test_an_environment_without_stiffness_has_no_dot(page, window, qtbot):
    window.studio.choose("free")
    qtbot.waitUntil(lambda: window.studio.environment.key == "free", timeout=PATIENCE_MS)
    qtbot.waitUntil(lambda: page.verdict_column.headline.text() == "No limit applies", timeout=PATIENCE_MS)
    assert not any("N/m, " in word for word in words(page.chart))
    assert "renders no stiffness" in page.side.try_words.text()
    press(page, 0.5, 500.0)
    assert page.verdict_column.headline.text() == "No limit applies"


@pytest.mark.slow
def test_an_adaptive_window_has_no_exact_limit_and_can_be_measured(page, window, qtbot):
    window.studio.set_loop(estimator="foaw", options=())
    follow(page, qtbot)
    assert page.verdict_column.headline.text() == "No exact limit"
    assert "Exact boundary" not in words(page.chart)
    assert page.bar.run.isEnabled()
    assert reading(page.lines, 1.0, 100.0)[1] == "No exact limit"


def test_every_hand_has_its_boundary(page, qtbot):
    page.hands.button(1).click()
    medium = follow(page, qtbot)
    assert medium.setting.hand == medium.margin.hand == "medium"
    page.hands.button(2).click()
    plane = follow(page, qtbot)
    assert list(page.lines.hands) == ["released", "light", "medium", "firm"]
    assert plane.margin.limit == min(plane.hands.values())
    assert max(limits.max() for limits in page.lines.hands.values()) <= plane.top
    assert {"light grip", "medium grip", "firm grip"} <= set(words(page.chart))


def test_without_a_device_nothing_is_judged(idle_window):
    idle_window.views.show("stability")
    page = idle_window.views.page("stability")
    assert page.verdict_column.headline.text() == "Not judged yet"
    assert not page.side.release.isEnabled()
    assert not page.bar.export.isEnabled()
    page.bar.run.click()
    assert page.bar.status.text() == "Needs a device."
    assert not page.job.running


def test_a_device_that_goes_leaves_the_map_paler(page, window, qtbot):
    engine, window.studio.device.engine = window.studio.engine, None
    window.studio.engine_changed.emit()
    assert page.lines is None
    assert page.chart.pale
    assert page.verdict_column.headline.text() == "Not judged yet"
    drawn(page.chart)
    window.studio.device.engine = engine
    window.studio.engine_changed.emit()
    follow(page, qtbot)
    assert not page.chart.pale


def test_out_of_sight_nothing_is_asked(page, window, qtbot, monkeypatch):
    window.views.show("live")
    asked = []
    monkeypatch.setattr(page._worker, "ask", asked.append)
    window.studio.set_value("stiffness", 900.0)
    assert asked == []
    monkeypatch.undo()
    window.views.show("stability")
    assert follow(page, qtbot).margin.stiffness == 900.0


@pytest.mark.slow
def test_the_regions_have_their_colours_in_every_theme(page):
    for mode in ("light", "dark", "contrast"):
        theme.set_mode(mode)
        look_at_regions(page)


def look_at_regions(page):
    (_, width), (_, top) = axes_of(page)
    drawn(page.chart)
    picture = page.chart.canvas.grab().toImage()
    ratio = picture.devicePixelRatio()
    low = spot(page.chart, 0.985 * width, 0.015 * top) * ratio
    assert picture.pixelColor(low) == theme.color("stable")
    corner = spot(page.chart, 0.01 * width, 0.98 * top) * ratio
    around = {picture.pixelColor(corner.x() + i, corner.y() + j).name() for i in range(12) for j in range(12)}
    assert theme.color("unstable").name() in around
    assert len(around) > 1, "the unstable side is hatched as well"


def test_nothing_is_cut_off(page, window, qapp, qtbot):
    window.studio.set_value("stiffness", 5000.0)
    page.hands.button(2).click()
    follow(page, qtbot)
    page.bar.say("100 × 100 cells, 12.3 s")
    for size in ((1280, 720), (1440, 900), (1920, 1080), (960, 600), (800, 560)):
        window.resize(*size)
        for _ in range(3):
            qapp.processEvents()
        assert cut_off(page) == [], size
        assert outside(page.chart) == [], size
        assert not page.side.isVisible() or cut_off(page.side) == [], size


@pytest.fixture
def judging_page(window, qtbot):
    """Return the page in sight: the wall, 620 N/m and 2 N·s/m."""
    window.studio.set_values({"stiffness": 620.0, "damping": 2.0})
    window.views.show("stability")
    shown = window.views.page("stability")
    follow(shown, qtbot)
    return shown


def judged(stiffness, damping, controller=False, measured=None):
    """Return the verdict on a point; its limit is 1000 N/m."""
    found = plane(Setting(controller=controller), 0.0, 0.0, columns=2)
    return verdict(replace(found, margin=Margin(stiffness, damping, 1000.0)), measured)


def test_without_the_controller_the_exact_limit_is_the_verdict_and_says_what_it_leaves_out():
    said = judged(2000.0, 2.0)
    assert (said.headline, said.sign) == ("2.0 × above", ("cross", "danger"))
    assert said.words == "the limit; released hand, without dry friction."
    assert said.more == "Lower stiffness below 1,000 N/m."


def test_with_the_controller_the_exact_limit_is_not_the_verdict():
    said = judged(2000.0, 2.0, controller=True)
    assert said.sign == ("circle", "ink2")
    assert "without the controller" in said.words
    assert "Lower stiffness" not in said.more
    measured = made_up(Setting(controller=True))
    rests, buzzes, grows = (
        judged(*at, True, measured) for at in ((900.0, 2.0), (700.0, 10.0), (1900.0, 2.0))
    )
    assert (rests.headline, rests.sign[0]) == ("Comes to rest", "check")
    assert (buzzes.headline, grows.headline) == ("Buzzes", "Grows")
    assert grows.more == "Without it: 1.9 × above the limit."


def test_what_was_measured_with_friction_is_said_beside_the_exact_limit():
    said = judged(1400.0, 2.0, measured=made_up(Setting(), real=True))
    assert said.headline == "1.4 × above"
    assert said.more.endswith("Measured with friction: buzzes, does not grow.")
    assert judged(1400.0, 20.0, measured=made_up(Setting(), real=True)) == judged(1400.0, 20.0)


def test_a_class_is_that_of_its_cell_and_none_is_told_beyond_the_axes():
    measured = made_up(Setting())
    for row, stiffness in enumerate(measured.cells.stiffness):
        for column, damping in enumerate(measured.cells.damping):
            assert kind_at(measured, damping, stiffness) == measured.cells.classes[row, column]
    assert kind_at(measured, 12.0, 2000.0) == measured.cells.classes[-1, -1]
    assert kind_at(measured, 12.1, 500.0) is None
    assert kind_at(measured, 2.0, 2001.0) is None


@pytest.mark.slow
def test_beyond_what_was_measured_with_friction_there_is_no_colour(judging_page):
    width, top = judging_page.lines.plane.width, judging_page.lines.plane.top
    judging_page.real.setChecked(True)
    judging_page.show_result(made_up(judging_page.lines.plane.setting, True, (0.5 * width, 0.5 * top)))
    assert judging_page.bar.status.text().startswith("Measured to")
    drawn(judging_page.chart)
    picture = judging_page.chart.canvas.grab().toImage()
    for x, y, token in ((0.97, 0.03, "plot"), (0.04, 0.97, "plot"), (0.4, 0.03, "stable")):
        at = spot(judging_page.chart, x * width, y * top) * picture.devicePixelRatio()
        seen = {picture.pixelColor(at.x() + i, at.y() - j).name() for i in range(3) for j in range(3)}
        assert theme.color(token).name() in seen, (x, y)
        assert len({theme.color(other).name() for other in ("plot", "stable", "unstable")} & seen) == 1


def test_conditions_tell_friction_and_steps_and_stay_in_a_small_window(judging_page, window, qapp):
    def told():
        return {
            name.text(): value.text()
            for name, value in judging_page.verdict_column.conditions._labels
            if name.text()
        }

    setting = judging_page.lines.plane.setting
    assert told()["Mass"] == f"{setting.mass:g} kg"
    assert told()["Viscous damping"] == f"{setting.viscous:g} N·s/m"
    assert "Dry friction" not in told()
    judging_page.real.setChecked(True)
    assert told()["Dry friction"] == f"{setting.coulomb:g} N"
    assert told()["Sensor step"] == f"{1e6 * setting.quantum:.3g} µm"

    look_in_small_windows(judging_page, window, qapp)


def look_in_small_windows(page, window, qapp):
    for size in ((1280, 720), (960, 600)):
        window.resize(*size)
        for _ in range(3):
            qapp.processEvents()
        beside = page.verdict_column
        beside.ensureWidgetVisible(beside.conditions._labels[0][0])
        assert beside.conditions.isVisible(), size
        assert not beside.conditions._labels[0][0].visibleRegion().isEmpty(), size


def test_before_any_line_nothing_is_shown_without_words(idle_window):
    idle_window.views.show("stability")
    page = idle_window.views.page("stability")
    assert page.verdict_column.lines.text() == ""
    assert not any(part.isVisible() for part in page.verdict_column._above)
    assert not page.side.hands_heading.isVisible()
    assert not page.side.hands.isVisible()


def test_before_any_line_it_says_what_is_missing(judging_page):
    judging_page._forget_lines()
    assert judging_page.verdict_column.headline.text() == "Computing"
    judging_page.facts.delay = None
    judging_page._forget_lines()
    assert judging_page.verdict_column.headline.text() == "Measuring the delay"


def test_dragging_over_the_limit_is_continuous_though_a_banner_moves_the_map(judging_page, window, qtbot):
    top, limit = judging_page.lines.plane.top, judging_page.lines.plane.margin.limit
    port = judging_page.chart.canvas
    start, beyond = (spot(judging_page.chart, 2.0, k) for k in (620.0, 0.5 * (limit + top)))
    QTest.mousePress(port, Qt.MouseButton.LeftButton, pos=start)
    beyond, before = port.mapToGlobal(beyond), port.mapToGlobal(start).y()
    QTest.mouseMove(port, port.mapFromGlobal(beyond))
    reached = window.studio.values["stiffness"]
    assert reached > limit
    qtbot.waitUntil(lambda: port.mapToGlobal(start).y() != before, timeout=PATIENCE_MS)
    QTest.mouseMove(port, port.mapFromGlobal(beyond))
    assert window.studio.values["stiffness"] == reached
    QTest.mouseRelease(port, Qt.MouseButton.LeftButton, pos=start)
