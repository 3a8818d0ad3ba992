"""What the stability page says: with controller or friction, beyond what was measured, before any line."""

from dataclasses import replace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability.kb_plane import plane
from hapkit_studio.analysis.stability.margin import Margin
from hapkit_studio.gui.tabs.stability.verdict import kind_at, verdict
from hapkit_studio.gui.widgets.theme import theme
from tests.gui.drawing_support import drawn, spot
from tests.gui.stability_support import follow, made_up
from tests.gui.window_support import PATIENCE_MS


@pytest.fixture
def page(window, qtbot):
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


def test_beyond_what_was_measured_with_friction_there_is_no_colour(page):
    width, top = page.lines.plane.width, page.lines.plane.top
    page.real.setChecked(True)
    page.show_result(made_up(page.lines.plane.setting, True, (0.5 * width, 0.5 * top)))
    assert page.bar.status.text().startswith("Measured to")
    drawn(page.chart)
    picture = page.chart.canvas.grab().toImage()
    for x, y, token in ((0.97, 0.03, "plot"), (0.04, 0.97, "plot"), (0.4, 0.03, "stable")):
        at = spot(page.chart, x * width, y * top) * picture.devicePixelRatio()
        seen = {picture.pixelColor(at.x() + i, at.y() - j).name() for i in range(3) for j in range(3)}
        assert theme.color(token).name() in seen, (x, y)
        assert len({theme.color(other).name() for other in ("plot", "stable", "unstable")} & seen) == 1


def test_conditions_tell_friction_and_steps_and_stay_in_a_small_window(page, window, qapp):
    def told():
        return {name.text(): value.text() for name, value in page.beside.conditions._labels if name.text()}

    setting = page.lines.plane.setting
    assert told()["Mass"] == f"{setting.mass:g} kg"
    assert told()["Viscous damping"] == f"{setting.viscous:g} N·s/m"
    assert "Dry friction" not in told()
    page.real.setChecked(True)
    assert told()["Dry friction"] == f"{setting.coulomb:g} N"
    assert told()["Sensor step"] == f"{1e6 * setting.quantum:.3g} µm"

    look_in_small_windows(page, window, qapp)


def look_in_small_windows(page, window, qapp):
    for size in ((1280, 720), (960, 600)):
        window.resize(*size)
        for _ in range(3):
            qapp.processEvents()
        beside = page.beside
        beside.ensureWidgetVisible(beside.conditions._labels[0][0])
        assert beside.conditions.isVisible(), size
        assert not beside.conditions._labels[0][0].visibleRegion().isEmpty(), size


def test_before_any_line_nothing_is_shown_without_words(idle_window):
    idle_window.views.show("stability")
    page = idle_window.views.page("stability")
    assert page.beside.lines.text() == ""
    assert not any(part.isVisible() for part in page.beside._above)
    assert not page.side.hands_heading.isVisible()
    assert not page.side.hands.isVisible()


def test_before_any_line_it_says_what_is_missing(page):
    page._forget_lines()
    assert page.beside.headline.text() == "Computing"
    page.facts.delay = None
    page._forget_lines()
    assert page.beside.headline.text() == "Measuring the delay"


def test_dragging_over_the_limit_is_continuous_though_a_banner_moves_the_map(page, window, qtbot):
    top, limit = page.lines.plane.top, page.lines.plane.margin.limit
    port = page.chart.canvas
    start, beyond = (spot(page.chart, 2.0, k) for k in (620.0, 0.5 * (limit + top)))
    QTest.mousePress(port, Qt.MouseButton.LeftButton, pos=start)
    beyond, before = port.mapToGlobal(beyond), port.mapToGlobal(start).y()
    QTest.mouseMove(port, port.mapFromGlobal(beyond))
    reached = window.studio.values["stiffness"]
    assert reached > limit
    qtbot.waitUntil(lambda: port.mapToGlobal(start).y() != before, timeout=PATIENCE_MS)
    QTest.mouseMove(port, port.mapFromGlobal(beyond))
    assert window.studio.values["stiffness"] == reached
    QTest.mouseRelease(port, Qt.MouseButton.LeftButton, pos=start)
