"""The accuracy view: the answer in words, every method in chart and table, points told under the pointer."""

import math

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest

from hapkit_studio.analysis import accuracy
from hapkit_studio.analysis.accuracy.plan import (
    Accuracy,
    Chart,
    Default,
    Method,
    Point,
    Scene,
    Sheet,
    mark_front,
)
from hapkit_studio.charts.accuracy import AccuracyAxes, marker_and_color
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.dynamics.stick_slip import MODELS
from hapkit_studio.gui.pages.accuracy import CHARTS, columns
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.palette import TOKENS
from tests.gui.pages.drawing_support import drawn, leave, outside
from tests.gui.pages.drawing_support import point as point_at
from tests.gui.test_layout import cut_off

LABELS = {"verlet": "Verlet", "rk4": "RK4", "explicit_euler": "Explicit Euler"}


def point(method: str, step_ms: float, error: float, cost: float) -> Point:
    return Point("integrators", "damped", method, step_ms * 1e-3, error, cost, label=LABELS[method])


def made_up(default: str, tolerance: float = 0.02) -> Accuracy:
    """Return a chart whose answer is known: Verlet at 1 ms, 4 µs, off by 0.2 %; nothing is cheaper."""
    points = mark_front(
        [
            point("explicit_euler", 1.0, 0.5, 2000.0),
            point("explicit_euler", 0.5, math.inf, 4000.0),
            point("verlet", 1.0, 0.002, 4000.0),
            point("verlet", 0.5, 0.0005, 8000.0),
            point("rk4", 1.0, 2e-6, 12000.0),
            point("rk4", 0.5, 0.0, 24000.0),
        ]
    )
    scene = Scene("damped", "Damped mass", "largest error", tolerance, "felt", Default(default))
    methods = tuple(Method(key, label) for key, label in LABELS.items())
    return Accuracy(
        (Chart("integrators", "Integrators", (Sheet("integrators", scene, methods, points),)),), 0.9
    )


@pytest.fixture
def page(shared_window):
    """Return the page in sight, its first chart chosen and measured, none measured by itself."""
    shown = shared_window.views.page("accuracy")
    shown.begun.update(dict(CHARTS))
    shared_window.views.show("accuracy")
    shown.charts.button(0).click()
    shown.show_result(made_up("verlet"))
    return shown


def test_the_answer_and_whether_the_default_is_it(page):
    assert page.answer.words.text().startswith("In this scene the cheapest method within 2")
    assert page.answer.words.text().endswith("at a 1 ms step is Verlet: 4.0 µs per simulated second.")
    assert "It is the default." in page.side.words.text()
    page.show_result(made_up("rk4"))
    said = "The default, RK4, costs 3.0 times as much as Verlet; its error here is 2·10⁻⁴ %."
    assert page.side.words.text() == said, "of one scene nothing is said twice"
    page.show_result(made_up("verlet", tolerance=1e-9))
    assert page.answer.words.text() == "In this scene no method is within 1·10⁻⁷ % at a 1 ms step."


def test_every_error_is_drawn_somewhere_in_the_frame_and_told(page):
    assert outside(page.chart) == cut_off(page) == []
    frame = AccuracyAxes(page.sheet)
    for found in page.sheet.points:
        point_at(page.chart, *frame.place(found))
        assert page.point.text().startswith(f"{found.label} at "), found
    point_at(page.chart, 4.0, 0.2)  # %
    assert page.point.text() == "Verlet at 1 ms: 0.20 %, 4.0 µs per second"
    leave(page.chart)
    assert page.point.text() == ""


def test_a_row_of_the_table_lets_its_line_stand_out_and_shows_its_motion(page):
    # the most accurate one comes first; a second click chooses none
    for width, titles in ((3.0, ["position, mm", "error, %"]), (1.5, [])):
        row = page.table.visualRect(page.table.model().index(0, 0)).center()
        QTest.mouseClick(page.table.viewport(), Qt.MouseButton.LeftButton, pos=row)
        axes, *traces = drawn(page.chart)
        color = theme.color(marker_and_color("rk4")[1]).name()
        widths = {line.get_linewidth() for line in axes.lines if line.get_color() == color.upper()}
        assert width in widths
        assert [each.get_ylabel() for each in traces] == titles
        if traces:
            page.point.setText("")
            point_at(page.chart, 0.5, 9.0, axes=1)
            assert page.point.text() == ""  # no method's cost is there


def test_the_table_is_sorted_by_a_click_on_a_head_and_copied(page):
    head = page.table.horizontalHeader()
    place = QPoint(head.sectionPosition(1) + 4, 4)
    QTest.mouseClick(head.viewport(), Qt.MouseButton.LeftButton, pos=place)
    costs = [row[1] for row in page.table.texts()[1:]]
    assert costs in (["2.0", "4.0", "12"], ["12", "4.0", "2.0"])
    page.table.setFocus()
    QTest.keyClick(page.table, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    lines = QGuiApplication.clipboard().text().split("\n")
    assert lines[0] == "Method\tµs per s\tError %"
    assert len(lines) == 4


def test_a_chart_that_was_not_measured_shows_no_other_charts_points(page):
    page.charts.button(1).click()
    assert page.sheet is None
    assert page.answer.words.text() == "Run to see what each method costs."
    assert (page.side.heading.text(), page.side.words.text()) == ("Velocity", "Not measured yet.")
    assert (page.bar.status.text(), page.bar.run.text()) == ("", "Run")
    assert not page.chart.isVisible()
    assert not page.table.isVisible()
    page.charts.button(0).click()
    assert page.sheet is not None
    assert (page.side.heading.text(), page.bar.run.text()) == ("Integrators", "Run again")
    assert page.bar.status.text() == "6 points, 0.9 s"


def test_each_chart_is_measured_by_itself_when_first_seen(page, shared_window, monkeypatch, qtbot):
    monkeypatch.setattr(page.job, "_needs", "")
    asked = []
    monkeypatch.setattr(accuracy, "compute", lambda keys, progress: asked.extend(keys) or made_up("rk4"))
    page._found.clear()
    page.begun.clear()
    shared_window.views.show("live")
    assert asked == []
    shared_window.views.show("accuracy")
    assert page.answer.words.text() == "Measuring what each method costs…"
    qtbot.waitUntil(lambda: not page.job.running)
    page.charts.button(1).click()
    qtbot.waitUntil(lambda: not page.job.running)
    assert asked == ["integrators", "velocity"]
    assert page.answer.words.text() == page.begin  # what came was of another chart
    page.charts.button(0).click()
    shared_window.views.show("live")
    shared_window.views.show("accuracy")
    assert asked == ["integrators", "velocity"]
    page.begun.update(dict(CHARTS))


SPEED = Scene("tremor", "Tremor", "RMS", 5e-3, "felt", Default("verlet"), unit="m/s")
RATE = Scene("wall", "Wall", "K / limit", 1.0, "safe", Default("verlet"), step_s=None, goal="stable")


def rows_of(page, scene: Scene, points: list[Point]) -> list[tuple[str, str, str]]:
    sheet = Sheet("servo", scene, (), tuple(points))
    page.table.show_rows(columns(sheet), points)
    return page.table.texts()


def test_a_table_has_one_unit_and_tells_rates_apart(page):
    head, row = rows_of(page, SPEED, [Point("c", "s", "verlet", 1e-3, 0.34e-3, 38e3, label="Kalman")])
    assert (head, row) == (("Method", "µs\nper s", "Error\nmm/s"), ("Kalman", "38", "0.34"))
    once = Point("c", "s", "verlet", 1e-3, 0.8, 48e3, label="At once")
    late = Point("c", "s", "rk4", 0.5e-3, 1.59, 91e3, label="1 ms later")
    head, first, second = rows_of(page, RATE, [once, late])
    assert head == ("Rate", "µs\nper s", "Of limit\n%")
    assert (first, second) == (("1 kHz", "48", "80"), ("2 kHz, 1 ms later", "91", "159"))


def test_methods_of_a_chart_differ_in_marker_or_colour():
    for family in (INTEGRATORS, tuple(ESTIMATORS), tuple(MODELS)):
        looks = [marker_and_color(method) for method in family]
        assert len(set(looks)) == len(looks)
        assert {token for _, token in looks} <= set(TOKENS)
