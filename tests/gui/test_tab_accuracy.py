"""The accuracy view: the answer in words, every method in chart and table, points told under the pointer."""

import math

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from hapkit_studio.analysis.accuracy import Accuracy, Chart, Default, Method, Point, Scene, Sheet
from hapkit_studio.analysis.accuracy.points import mark_front
from hapkit_studio.charts.methods import look
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.dynamics.stick_slip import MODELS
from hapkit_studio.palette import TOKENS
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
def page(idle_window):
    idle_window.views.show("accuracy")
    return idle_window.views.page("accuracy")


def test_before_it_is_measured_it_says_so(page):
    assert page.verdict.words.text() == "Run to see what each method costs."
    assert not page.bar.export.isEnabled()
    assert page.scenes.isHidden()


def test_the_answer_and_whether_the_default_is_it(page):
    page.show_result(made_up("verlet"))
    assert page.verdict.words.text().startswith("Cheapest within 2")
    assert page.verdict.words.text().endswith("at a 1 ms step: Verlet, 4.0 µs per simulated second.")
    assert "It is the default." in page.side.words.text()
    page.show_result(made_up("rk4"))
    assert "RK4, costs 3.0 times as much" in page.side.words.text()
    page.show_result(made_up("verlet", tolerance=1e-9))
    assert page.verdict.words.text() == "Nothing is within 1·10⁻⁹ at a 1 ms step."


def test_the_point_under_the_pointer_is_told(page):
    page.show_result(made_up("verlet"))
    place = page.chart.at(4.0, 0.002).toPoint()
    QTest.mouseMove(page.chart.viewport(), place + QPoint(3, 3))
    QTest.mouseMove(page.chart.viewport(), place)
    page.show_point(page.chart.point_near(page.chart.at(4.0, 0.002)))
    assert page.point.text() == "Verlet at 1 ms: 0.20 %, 4.0 µs per second"
    assert page.chart.point_near(page.chart.frame().topRight()) is None


def test_a_row_of_the_table_lets_its_line_stand_out(page):
    page.show_result(made_up("verlet"))
    page.grab()
    heard = []
    page.table.chosen.connect(heard.append)
    QTest.mouseClick(page.table, Qt.MouseButton.LeftButton, pos=QPoint(40, 24 + 15))
    QTest.mouseClick(page.table, Qt.MouseButton.LeftButton, pos=QPoint(40, 24 + 15))
    assert heard == ["rk4", ""]  # the most accurate one comes first


def test_every_error_is_drawn_somewhere_in_the_frame(page):
    page.show_result(made_up("verlet"))
    box = page.chart.frame()
    for found in page.sheet.points:
        assert box.contains(page.chart.spot(found))
        assert page.chart.point_near(page.chart.spot(found)) is found


def test_a_chart_that_was_not_measured_shows_no_other_charts_points(page):
    page.show_result(made_up("verlet"))
    page.charts.button(1).click()
    assert page.sheet is None
    assert page.verdict.words.text() == "Run to see what each method costs."
    page.charts.button(0).click()
    assert page.sheet is not None


@pytest.mark.parametrize("size", [(1280, 720), (1440, 900), (1920, 1080)])
def test_nothing_is_cut_off(idle_window, page, qapp, size):
    page.show_result(made_up("verlet"))
    idle_window.resize(*size)
    for _ in range(3):
        qapp.processEvents()
    assert cut_off(idle_window) == []


def test_methods_of_a_chart_differ_in_marker_or_colour():
    for family in (INTEGRATORS, tuple(ESTIMATORS), tuple(MODELS)):
        looks = [look(method) for method in family]
        assert len(set(looks)) == len(looks)
        assert {token for _, token in looks} <= set(TOKENS)
