"""The page Break it: choosing, the knob, other conditions, what Export writes."""

import json

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.analysis.failures import failures
from hapkit_studio.charts.failures import scaled
from hapkit_studio.gui.pages.break_it.failure_list import _words
from hapkit_studio.gui.pages.break_it.feel import Feel
from hapkit_studio.gui.pages.break_it.page import record_exports
from hapkit_studio.gui.pages.break_it.record import Record
from hapkit_studio.haptics import rows
from tests.gui.pages.break_it_fixtures import settled
from tests.gui.pages.drawing_support import click, drawn
from tests.gui.window_support import PATIENCE_MS
from tests.wide import wide


@pytest.fixture
def page(break_it_page):
    """Return the page, its first failure measured."""
    return break_it_page


def test_the_failure_in_sight_is_tried_on_both_sides_of_its_limit(page):
    record = page.record
    assert record.limit == 200.0
    assert record.signs == (True, False)
    assert record.below.value == pytest.approx(198.0)
    assert record.above.value == pytest.approx(202.0)
    assert page.verdict.words.text() == "Decays by 0.01 1/s"
    assert page.verdict.more.text() == "198 N/m, 0.99 of the limit 200 N/m. In truth it decays by 1 1/s."
    titles = [axes.get_title(loc="left").replace("\n", " ") for axes in drawn(page.detail.chart)[:2]]
    assert titles[0].startswith("✓")
    assert "decays by 0.01 1/s" in titles[0]
    assert titles[1].startswith("✕")
    assert "grows by 0.01 1/s" in titles[1]
    assert page.side.heading.text() == "A spring too stiff"
    assert "b<sub>h</sub>" in page.side.formula.text()
    spoken = page.list.currentItem().data(Qt.ItemDataRole.AccessibleTextRole)
    assert spoken == "A spring too stiff. Inside the limit it holds, outside it fails"


def test_buttons_slider_box_and_chart_turn_the_knob(page, qtbot):
    page.knob.outside.click()
    settled(page, qtbot)
    assert page.record.here.value == pytest.approx(202.0)
    assert page.verdict.words.text() == "Grows by 0.01 1/s"
    page.knob.slider.setFocus()
    for _ in range(4):
        QTest.keyClick(page.knob.slider, Qt.Key.Key_Right)
    settled(page, qtbot)
    assert page.record.here.value == pytest.approx(210.0)
    assert page.record.above.value == pytest.approx(210.0)
    assert page.knob.box.text() == "210"
    assert page.knob.slider.accessibleName() == "Stiffness, 210 N/m, 105 % of the limit"
    page.knob.box.entered.emit(150.0)
    settled(page, qtbot)
    assert page.record.share == pytest.approx(0.75)
    assert page.record.below.value == pytest.approx(150.0)
    assert page.record.above.value == pytest.approx(210.0)
    click(page.detail.chart, 260.0, 0.2, axes=2)
    settled(page, qtbot)
    assert page.record.here.value == pytest.approx(260.0, rel=0.01)
    click(page.detail.chart, 2.0, 0.2, axes=0)
    assert page.record.share == pytest.approx(1.3, rel=0.01), "a click on a trace turns nothing"
    page.detail.chart.dragged.emit(900.0, 0.0)
    assert page.record.share == pytest.approx(1.5)


def test_a_value_that_cannot_be_tried_stays_in_the_box(page):
    page.knob.box.entered.emit(5000.0)
    assert page.knob.box.property("invalid") is True
    assert page.knob.box.toolTip() == "Stiffness goes from 1 to 1000 N/m."
    assert page.record.share == pytest.approx(0.99)


def test_a_knob_in_seconds_is_shown_in_milliseconds(page, qtbot):
    page.list.choose("step")
    qtbot.waitUntil(lambda: page.record.complete, timeout=PATIENCE_MS)
    assert page.knob.unit.text() == "ms"
    assert page.knob.inside.text() == "5 % inside"
    assert page.verdict.more.text().startswith("1.9 ms, 0.95 of the limit 2 ms.")
    assert not page.verdict.feel.isVisible()
    page.detail.picked.disconnect()
    heard = []
    page.detail.picked.connect(heard.append)
    page.detail.chart.clicked.emit(3.0, 0.0)
    assert heard == [pytest.approx(1.5)]


def test_arrow_keys_walk_along_the_list_and_what_is_reached_is_measured(page, qtbot):
    page.list.setFocus()
    QTest.keyClick(page.list, Qt.Key.Key_End)
    assert page.record.failure.key == "step"
    assert page.verdict.words.text() == "Not tried yet"
    assert not page.knob.isEnabled()
    qtbot.waitUntil(lambda: page.record.complete, timeout=PATIENCE_MS)
    assert page.knob.isEnabled()


def test_other_conditions_move_the_limit_and_keep_the_old_results_paler(page, qtbot):
    page.side.changed.emit("damping", 4.0)
    assert page.record.old == {"below", "above", "chart", "limit", "here"}
    assert not page.knob.isEnabled()
    assert page.record.chart is not None
    qtbot.waitUntil(lambda: page.record.complete and page.record.limit == 400.0, timeout=PATIENCE_MS)
    settled(page, qtbot)
    assert page.record.here.value == pytest.approx(396.0)
    assert page.knob.isEnabled()


def test_lines_and_level_are_named_above_the_curve(page):
    curve = drawn(page.detail.chart)[2]
    assert [t.get_text() for t in curve.get_legend().get_texts()] == ["formula", "measured", "neither"]
    assert curve.get_ylabel() == "growth, 1/s"


def test_the_knob_moves_alone_while_it_is_turned(page):
    curve = drawn(page.detail.chart)[2]
    page.turn(0.8)
    assert page.detail.chart.figure.axes[2] is curve
    assert list(page.detail._stands.artists[0].get_xdata()) == [160.0, 160.0]


def test_export_writes_both_tries_and_the_lines(page, tmp_path):
    figure, numbers = record_exports(page.record)
    found = json.loads(json.dumps(numbers()))
    assert found["limit"] == 200.0
    assert (found["inside"]["holds"], found["outside"]["holds"]) == (True, False)
    assert found["options"] == {"damping": 2.0, "hand": "none"}
    assert [line["label"] for line in found["chart"]["lines"]] == ["formula", "measured"]
    figure(str(tmp_path / "failure.png"))
    assert (tmp_path / "failure.png").read_bytes()[:4] == b"\x89PNG"


def test_a_limit_without_a_unit_names_its_quantity():
    for key, value, words in (
        ("integrators", 1.64, "Limit ω·dt 1.64"),
        ("bounce", 0.4, "Limit lateness 0.4"),
        ("sampled_spring", 1001.9, "Limit 1002 N/m"),
    ):
        record = Record(failures()[key])
        record.limit = value
        assert _words(record, busy=False) == words


def test_the_conditions_say_whose_they_are(break_it_page):
    words = [label.text() for label in break_it_page.side.findChildren(type(break_it_page.side.why))]
    assert any("not of the one that is connected" in text for text in words)


@pytest.mark.parametrize(
    ("most", "factor", "power"),
    [(1.05e-4, 1e6, "$10^{-6}$"), (2e-3, 1e3, "$10^{-3}$"), (0.02, 1.0, ""), (0.0, 1.0, "")],
)
def test_tiny_traces_have_ticks_that_can_be_read(most, factor, power):
    found = scaled(np.array([-0.5 * most, most]))
    assert found[0] == pytest.approx(factor)
    assert found[1] == power


@pytest.mark.slow
@pytest.mark.parametrize(
    ("share", "swings"), wide([(0.99, False), (1.9, True)], lambda share, swings: swings)
)
def test_a_spring_pulled_and_let_go_does_what_the_advice_says(window, qtbot, share, swings):
    failure, studio = failures()["sampled_spring"], window.studio
    case = failure.case()
    live = failure.live(share * failure.limit(case), case)
    assert live.advice.startswith("Drag to 35 mm and let go. It")
    assert ("swings on by" in live.advice) == swings
    Feel(studio).put("sampled_spring", live)
    reader, seen = studio.engine.reader(), []

    def places():
        seen.extend(reader.read()[:, rows.TRUE_POSITION])
        return seen

    studio.move_hand(0.035)
    # against the motor's 3 N a medium grip stays 15 mm behind
    qtbot.waitUntil(lambda: max(places(), default=0.0) > 0.0195, timeout=PATIENCE_MS)
    studio.move_hand(None)
    start = len(places())
    qtbot.waitUntil(lambda: len(places()) > start + 3000, timeout=PATIENCE_MS)
    assert (np.ptp(seen[-300:]) > 1e-3) == swings
