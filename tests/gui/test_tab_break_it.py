"""The page Break it: choosing, the knob, running, cancelling, a failure that cannot be tried."""

import json
import math

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QScrollArea

from hapkit_studio.analysis import failures as package
from hapkit_studio.gui import prepare
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.tabs.break_it import BreakItPage
from hapkit_studio.gui.tabs.break_it_export import exports
from tests.gui.break_it_support import Gate, library
from tests.gui.test_layout import cut_off, settle
from tests.gui.window_support import PATIENCE_MS


@pytest.fixture
def gate(monkeypatch):
    """Return the gate of the slow failure; the page knows the made-up failures alone, nothing is compiled."""
    made = Gate()
    monkeypatch.setattr(package, "failures", lambda: library(made))
    monkeypatch.setattr(prepare, "begin", lambda *_: None)
    yield made
    made.go_on.set()


@pytest.fixture
def page(gate, qtbot):
    """Return the page by itself, its first failure measured."""
    found = BreakItPage(Studio(list), None)
    qtbot.addWidget(found)
    found.resize(920, 430)
    found.show()
    found.set_shown(True)
    measured(found, qtbot)
    yield found
    gate.go_on.set()
    found.end()


@pytest.fixture
def seen(gate, idle_window, qtbot):
    """Return the page in the window."""
    idle_window.views.show("break_it")
    found = idle_window.views.page("break_it")
    measured(found, qtbot)
    return found


def measured(page, qtbot):
    """Wait until the failure in sight was measured."""
    qtbot.waitUntil(lambda: page.record.complete and not page.bench.job.running, timeout=PATIENCE_MS)


def settled(page, qtbot):
    """Wait until what the knob stands at was tried."""
    qtbot.waitUntil(lambda: "here" not in page.record.old, timeout=PATIENCE_MS)


def test_the_failure_in_sight_is_tried_on_both_sides_of_its_limit(page):
    record = page.record
    assert record.limit == 200.0
    assert record.signs == (True, False)
    assert record.below.value == pytest.approx(198.0)
    assert record.above.value == pytest.approx(202.0)
    assert page.verdict.words.text() == "Decays by 0.01 1/s"
    assert page.verdict.more.text() == "198 N/m, 0.99 of the limit 200 N/m. In truth it decays by 1 1/s."
    assert page.traces["below"].words.text() == "Decays by 0.01 1/s"
    assert page.traces["above"].words.text() == "Grows by 0.01 1/s"
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
    page.curve.chart.clicked.emit(260.0, 0.0)
    settled(page, qtbot)
    assert page.record.here.value == pytest.approx(260.0)
    page.curve.chart.dragged.emit(900.0, 0.0)
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
    page.curve.picked.disconnect()
    heard = []
    page.curve.picked.connect(heard.append)
    page.curve.chart.clicked.emit(3.0, 0.0)
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


def test_cancel_ends_the_work_and_keeps_what_had_come(page, gate, qtbot):
    page.list.choose("slow")
    qtbot.waitUntil(gate.begun.is_set, timeout=PATIENCE_MS)
    qtbot.waitUntil(lambda: page.record.signs == (True, False), timeout=PATIENCE_MS)
    assert page.bar.run.text() == "Cancel"
    page.bar.run.click()
    gate.go_on.set()
    page.bench.job.wait()
    qtbot.wait(1)
    assert page.bar.status.text() == "Cancelled"
    assert page.record.chart is None
    assert page.record.signs == (True, False)
    assert not page.bar.export.isEnabled()
    page.bar.run.click()
    qtbot.waitUntil(lambda: page.record.complete, timeout=PATIENCE_MS)


def test_run_all_tries_the_rest_and_one_that_cannot_be_keeps_no_other_back(page, gate, qtbot):
    gate.go_on.set()
    page.all.click()
    assert not page.all.isEnabled()
    qtbot.waitUntil(lambda: not page.bench.job.running, timeout=PATIENCE_MS)
    done = {key: record.signs for key, record in page.records.items()}
    both = (True, False)
    assert done == {"grows": both, "slow": both, "refuses": (None, None), "step": both}
    assert page.records["refuses"].wrong.startswith("Damping of 2 N·s/m")
    assert page.all.isEnabled()


def test_a_failure_that_raises_is_said_in_one_line(page, qtbot):
    page.list.choose("refuses")
    qtbot.waitUntil(lambda: bool(page.record.wrong), timeout=PATIENCE_MS)
    qtbot.waitUntil(lambda: not page.bench.job.running, timeout=PATIENCE_MS)
    assert page.verdict.words.text() == "Damping of 2 N·s/m has no limit here: choose 1 N·s/m or less."
    assert page.bar.status.text() == "Could not be tried"
    spoken = page.list.currentItem().data(Qt.ItemDataRole.AccessibleTextRole)
    assert spoken == "A limit that nobody knows. Could not be tried"
    page.list.choose("grows")
    assert page.verdict.words.text() == "Decays by 0.01 1/s"


@pytest.mark.parametrize(("bound", "what"), [(math.inf, "fails"), (0.0, "holds")])
def test_conditions_without_a_limit_are_said(page, qtbot, bound, what):
    object.__setattr__(page.record.failure, "limit", lambda case: bound)
    page.run()
    words = f"Nothing {what} under these conditions: change one."
    qtbot.waitUntil(lambda: page.verdict.words.text() == words, timeout=PATIENCE_MS)
    assert not page.verdict.feel.isEnabled()


def test_a_probe_that_raises_is_said_and_the_next_value_is_tried(page, qtbot, monkeypatch):
    before = page.record.failure.probe
    object.__setattr__(page.record.failure, "probe", lambda value, case: 1 / 0)
    page.turn(1.2)
    qtbot.waitUntil(lambda: "division by zero" in page.verdict.words.text(), timeout=PATIENCE_MS)
    object.__setattr__(page.record.failure, "probe", before)
    page.turn(1.3)
    qtbot.waitUntil(lambda: page.verdict.words.text() == "Grows by 0.3 1/s", timeout=PATIENCE_MS)


def test_export_writes_both_tries_and_the_lines(page, tmp_path):
    figure, numbers = exports(page.record)
    found = json.loads(json.dumps(numbers()))
    assert found["limit"] == 200.0
    assert (found["inside"]["holds"], found["outside"]["holds"]) == (True, False)
    assert found["options"] == {"damping": 2.0, "hand": "none"}
    assert [line["label"] for line in found["chart"]["lines"]] == ["formula", "measured"]
    figure(str(tmp_path / "failure.png"))
    assert (tmp_path / "failure.png").read_bytes()[:4] == b"\x89PNG"


def test_space_presses_no_button_and_controls_have_names(seen):
    seen.knob.outside.setFocus()
    QTest.keyClick(seen.knob.outside, Qt.Key.Key_Space)
    assert seen.record.share == pytest.approx(0.99)
    for part in (seen.list, seen.curve.chart, seen.traces["below"].chart, seen.knob.box, seen.curve.key):
        assert part.accessibleName()


def test_nothing_is_cut_off(seen, idle_window, qapp):
    for size in ((1280, 720), (1366, 768), (1440, 900), (1920, 1080)):
        for key in ("grows", "refuses", "step"):
            seen.choose(key)
            settle(qapp, idle_window, size)
            assert cut_off(idle_window) == [], (size, key)
        corner = seen.mapTo(idle_window, seen.rect().bottomRight())
        assert idle_window.rect().contains(corner)
        area = seen.findChild(QScrollArea)
        assert area.verticalScrollBar().maximum() == area.horizontalScrollBar().maximum() == 0
