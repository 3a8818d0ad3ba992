"""The page Break it: choice, knob, conditions, cancelling, errors, export."""

import json
import math

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from hapkit_studio.analysis.failures import failures
from hapkit_studio.charts.failures import scaled
from hapkit_studio.formatting import unbroken
from hapkit_studio.gui.pages.break_it.lists import known_text
from hapkit_studio.gui.pages.break_it.record import Record
from tests.gui.pages.break_it_support import measured, settled
from tests.gui.pages.drawing_support import click, drawn, outside
from tests.gui.shell.test_layout import cut_off, settle


@pytest.fixture
def page(break_it_page):
    """Return the page with its first failure measured."""
    return break_it_page


def spoken(page):
    """Return what a screen reader says for the chosen row."""
    return page.list.currentItem().data(Qt.ItemDataRole.AccessibleTextRole)


@pytest.mark.slow
def test_the_chosen_failure_is_tried_on_both_sides_of_its_limit_and_exported(page, tmp_path):
    record = page.record
    assert (record.limit, record.signs) == (200.0, (True, False))
    assert (record.inside.value, record.outside.value) == pytest.approx((198.0, 202.0))
    assert page.verdict.label.text() == "Decays by 0.01 1/s"
    assert page.verdict.more.text() == "198 N/m, 0.99 of the limit 200 N/m. In truth it decays by 1 1/s."
    first, second, curve = drawn(page.detail.chart)
    titles = [axes.get_title(loc="left").replace("\n", " ") for axes in (first, second)]
    assert [title[0] for title in titles] == ["✓", "✕"]
    assert unbroken("decays by 0.01 1/s") in titles[0]
    assert unbroken("grows by 0.01 1/s") in titles[1]
    assert [t.get_text() for t in curve.get_legend().get_texts()] == ["formula", "measured", "neither"]
    assert page.side.heading.text() == "A spring too stiff"
    assert "b<sub>h</sub>" in page.side.formula.text()
    assert spoken(page) == "A spring too stiff. Inside the limit the method works, outside the limit it fails"
    assert page.list.currentItem().text() == "A spring too stiff\nLimit 200 N/m\ninside ✓   outside ✕"
    figure, numbers = page.exports()
    found = json.loads(json.dumps(numbers()))
    assert found["limit"] == 200.0
    assert (found["inside"]["holds"], found["outside"]["holds"]) == (True, False)
    assert found["options"] == {"damping": 2.0, "hand": "none"}
    assert [line["label"] for line in found["chart"]["lines"]] == ["formula", "measured"]
    figure(str(tmp_path / "failure.png"))
    assert (tmp_path / "failure.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.slow
def test_buttons_slider_box_and_chart_turn_the_knob_and_conditions_move_the_limit(page, qtbot):
    QTest.keyClick(page.knob.outside, Qt.Key.Key_Return)
    settled(page, qtbot)
    assert page.record.here.value == pytest.approx(202.0)
    assert page.verdict.label.text() == "Grows by 0.01 1/s"
    page.knob.row.slider.setFocus()
    QTest.keyClick(page.knob.row.slider, Qt.Key.Key_Right)
    settled(page, qtbot)
    assert page.record.here.value == page.record.outside.value == pytest.approx(203.0)
    assert page.knob.row.box.text() == "203"
    assert page.knob.row.slider.accessibleName() == "Stiffness, 203 N/m"
    page.knob.row.box.entered.emit(150.0)
    settled(page, qtbot)
    assert page.record.share == pytest.approx(0.75)
    assert (page.record.inside.value, page.record.outside.value) == pytest.approx((150.0, 203.0))
    click(page.detail.chart, 260.0, 0.2, axes=2)
    settled(page, qtbot)
    assert page.record.here.value == pytest.approx(260.0, rel=0.01)
    click(page.detail.chart, 2.0, 0.2, axes=0)
    assert page.record.share == pytest.approx(1.3, rel=0.01), "a click on a trace turns nothing"
    page.detail.chart.dragged.emit(900.0, 0.0)
    assert page.record.share == pytest.approx(1.5)
    curve = drawn(page.detail.chart)[2]
    page.turn(0.8)
    assert page.detail.chart.figure.axes[2] is curve, "nothing was drawn anew"
    assert list(page.detail._marker.artists[0].get_xdata()) == [160.0, 160.0]
    page.knob.row.box.entered.emit(5000.0)
    assert page.knob.row.box.property("invalid") is True
    assert page.knob.row.error.text() == "Stiffness must be between 100 and 300 N/m."
    assert page.record.share == pytest.approx(0.8)
    page.turn(0.99)
    page.side.changed.emit("damping", 4.0)
    assert page.record.old == {"inside", "outside", "chart", "limit", "here"}
    assert not page.knob.isEnabled()
    assert page.record.chart is not None
    qtbot.waitUntil(lambda: page.record.complete and page.record.limit == 400.0)
    settled(page, qtbot)
    assert page.record.here.value == pytest.approx(396.0)
    assert page.knob.isEnabled()


@pytest.mark.slow
def test_a_knob_in_seconds_is_shown_in_milliseconds_and_run_all_tries_the_rest(page, gate, qtbot):
    page.list.setFocus()
    QTest.keyClick(page.list, Qt.Key.Key_End)
    assert page.record.failure.key == "step"
    assert page.verdict.label.text() == "This value was not tried yet"
    assert not page.knob.isEnabled()
    measured(page, qtbot)
    assert (page.knob.row.unit.text(), page.knob.inside.text()) == ("ms", "5 % inside the limit")
    assert page.verdict.more.text().startswith("1.9 ms, 0.95 of the limit 2 ms.")
    assert not page.verdict.feel.isVisible()
    heard = []
    page.detail.picked.connect(heard.append)
    page.detail.chart.clicked.emit(3.0, 0.0)
    assert heard == [pytest.approx(1.5)]
    gate.go_on.set()
    page.all.click()
    assert not page.all.isEnabled()
    qtbot.waitUntil(lambda: not page.job.running)
    both = (True, False)
    done = {key: record.signs for key, record in page.records.items()}
    assert done == {"grows": both, "slow": both, "refuses": (None, None), "step": both, "mapped": both}
    assert page.records["refuses"].wrong.startswith("Damping of 2 N·s/m")
    assert page.all.isEnabled()


def test_a_limit_without_a_unit_names_its_quantity():
    for key, value, text in (
        ("integrators", 1.64, "Limit ω·dt 1.64"),
        ("bounce", 0.4, "Limit lateness 0.4"),
        ("sampled_spring", 1001.9, "Limit 1,002 N/m"),
    ):
        record = Record(failures()[key])
        record.limit = value
        assert known_text(record, busy=False) == text


def test_tiny_traces_have_ticks_that_can_be_read():
    for most, factor, power in (
        (1.05e-4, 1e6, "$10^{-6}$"), (2e-3, 1e3, "$10^{-3}$"), (0.02, 1.0, ""), (0.0, 1.0, ""),
    ):  # fmt: skip
        assert scaled(np.array([-0.5 * most, most])) == (pytest.approx(factor), power)


@pytest.mark.slow
def test_cancel_ends_the_work_and_keeps_partial_results(page, gate, qtbot):
    page.list.choose("slow")
    qtbot.waitUntil(gate.begun.is_set)
    qtbot.waitUntil(lambda: page.record.signs == (True, False))
    assert page.bar.run.text() == "Cancel"
    page.bar.run.click()
    gate.go_on.set()
    page.job.wait()
    qtbot.waitUntil(lambda: page.bar.status.text() == "The measurement was cancelled")
    assert page.record.chart is None
    assert page.record.signs == (True, False)
    assert not page.bar.export.isEnabled()
    for comes_back in (lambda: page.set_shown(True), lambda: page.choose("slow")):
        comes_back()
        assert not page._settle.isActive()  # a cancelled measurement starts again only on request
    page.bar.run.click()
    qtbot.waitUntil(lambda: page.record.complete)


@pytest.mark.slow
def test_a_failure_that_cannot_be_tried_shows_one_line(page, qtbot):
    page.list.choose("refuses")
    assert page.knob.row.box.text() == ""
    qtbot.waitUntil(lambda: bool(page.record.wrong) and not page.job.running)
    assert page.verdict.label.text() == "Damping of 2 N·s/m has no limit here: choose 1 N·s/m or less."
    assert page.bar.status.text() == "The failure could not be tried"
    assert spoken(page) == "A limit that nobody knows. Could not be tried"
    page.list.choose("grows")
    assert page.verdict.label.text() == "Decays by 0.01 1/s"
    assert page.knob.row.box.text() == "198"
    failure, before = page.record.failure, page.record.failure.probe
    object.__setattr__(failure, "probe", lambda value, case: 1 / 0)
    page.turn(1.2)
    qtbot.waitUntil(lambda: "division by zero" in page.verdict.label.text())
    object.__setattr__(failure, "probe", before)
    page.turn(1.3)
    qtbot.waitUntil(lambda: page.verdict.label.text() == "Grows by 0.3 1/s")
    for bound, what in ((math.inf, "works"), (0.0, "fails")):
        object.__setattr__(failure, "limit", lambda case, bound=bound: bound)
        page.run()
        text = f"There is no limit under these conditions: every value {what}. Change a condition."
        qtbot.waitUntil(lambda text=text: page.verdict.label.text() == text)
        assert not page.verdict.feel.isEnabled()


@pytest.mark.slow
def test_in_the_window_nothing_is_cut_off_and_space_presses_no_button(gate, idle_window, qtbot, qapp):
    idle_window.views.show("break_it")
    page = idle_window.views.page("break_it")
    measured(page, qtbot)
    page.knob.outside.setFocus()
    QTest.keyClick(page.knob.outside, Qt.Key.Key_Space)
    assert page.record.share == pytest.approx(0.99)
    for size in ((1280, 720), (1440, 900), (1920, 1080)):
        for key in ("grows", "refuses", "step"):
            page.choose(key)
            settle(qapp, idle_window, size)
            assert outside(page.detail.chart) == [], (size, key)
            qtbot.waitUntil(lambda: not page.job.running)
            qtbot.waitUntil(lambda: cut_off(idle_window) == [])  # results that arrive later must fit, too
        assert idle_window.rect().contains(page.mapTo(idle_window, page.rect().bottomRight()))
        bars = page.detail.verticalScrollBar(), page.detail.horizontalScrollBar()
        assert [bar.maximum() for bar in bars] == [0, 0]


@pytest.mark.slow
def test_the_map_replaces_the_curve_and_is_exported(page, qtbot, tmp_path):
    detail = page.detail
    assert not detail.which.isVisibleTo(page)
    page.choose("mapped")
    measured(page, qtbot)
    assert detail.which.isVisibleTo(page)
    detail.which.button(1).click()
    (axes,) = drawn(detail.chart)
    assert axes.get_xlabel() == "stiffness over damping"
    ring = next(line for line in axes.lines if line.get_markersize() > 14.0)
    assert ring.get_xdata()[0] == pytest.approx(99.0)
    page.turn(1.2)
    assert ring.get_xdata()[0] == pytest.approx(120.0)
    figure, _numbers = page.exports()
    figure(str(tmp_path / "map.png"))
    assert (tmp_path / "map.png").stat().st_size > 10_000
    page.choose("grows")
    assert len(drawn(detail.chart)) == 3
