"""The page Break it: running, cancelling, what cannot be tried; in the window nothing is cut off."""

import math

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests.gui.pages.break_it_fixtures import measured
from tests.gui.pages.drawing_support import outside
from tests.gui.test_layout import cut_off, settle
from tests.gui.window_support import PATIENCE_MS


@pytest.fixture
def page(break_it_page):
    """Return the page, its first failure measured."""
    return break_it_page


@pytest.fixture
def seen(gate, idle_window, qtbot):
    """Return the page in the window."""
    idle_window.views.show("break_it")
    found = idle_window.views.page("break_it")
    measured(found, qtbot)
    return found


def test_cancel_ends_the_work_and_keeps_what_had_come(page, gate, qtbot):
    page.list.choose("slow")
    qtbot.waitUntil(gate.begun.is_set, timeout=PATIENCE_MS)
    qtbot.waitUntil(lambda: page.record.signs == (True, False), timeout=PATIENCE_MS)
    assert page.bar.run.text() == "Cancel"
    page.bar.run.click()
    gate.go_on.set()
    page.job.wait()
    qtbot.waitUntil(lambda: page.bar.status.text() == "Cancelled")
    assert page.record.chart is None
    assert page.record.signs == (True, False)
    assert not page.bar.export.isEnabled()
    for comes_back in (lambda: page.set_shown(True), lambda: page.choose("slow")):
        comes_back()
        assert not page._settle.isActive()  # what was cancelled begins again only when a person says so
    page.bar.run.click()
    qtbot.waitUntil(lambda: page.record.complete, timeout=PATIENCE_MS)


def test_run_all_tries_the_rest_and_one_that_cannot_be_keeps_no_other_back(page, gate, qtbot):
    gate.go_on.set()
    page.all.click()
    assert not page.all.isEnabled()
    qtbot.waitUntil(lambda: not page.job.running, timeout=PATIENCE_MS)
    done = {key: record.signs for key, record in page.records.items()}
    both = (True, False)
    assert done == {"grows": both, "slow": both, "refuses": (None, None), "step": both}
    assert page.records["refuses"].wrong.startswith("Damping of 2 N·s/m")
    assert page.all.isEnabled()


def test_before_a_limit_is_known_the_knob_shows_no_number(page):
    page.list.choose("refuses")
    assert page.knob.box.text() == ""
    assert not page.knob.slider.known
    assert page.knob.slider.accessibleName() == "Stiffness, its limit is not known yet"
    page.list.choose("grows")
    assert page.knob.box.text() == "198"


def test_enter_presses_the_buttons_that_have_the_focus(page):
    for button in (page.all, page.knob.inside, page.knob.outside, page.verdict.feel, page.verdict.back):
        assert button.autoDefault()
    page.knob.outside.setFocus()
    QTest.keyClick(page.knob.outside, Qt.Key.Key_Return)
    assert page.record.share == pytest.approx(1.01)


def test_a_failure_that_raises_is_said_in_one_line(page, qtbot):
    page.list.choose("refuses")
    qtbot.waitUntil(lambda: bool(page.record.wrong), timeout=PATIENCE_MS)
    qtbot.waitUntil(lambda: not page.job.running, timeout=PATIENCE_MS)
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


def test_space_presses_no_button_and_controls_have_names(seen):
    seen.knob.outside.setFocus()
    QTest.keyClick(seen.knob.outside, Qt.Key.Key_Space)
    assert seen.record.share == pytest.approx(0.99)
    for part in (
        seen.list,
        seen.detail.chart,
        seen.knob.box,
    ):
        assert part.accessibleName()


@pytest.mark.slow
def test_nothing_is_cut_off(seen, idle_window, qapp):
    for size in ((1280, 720), (1366, 768), (1440, 900), (1920, 1080)):
        for key in ("grows", "refuses", "step"):
            seen.choose(key)
            settle(qapp, idle_window, size)
            assert outside(seen.detail.chart) == [], (size, key)
            qapp.processEvents()  # what came meanwhile is laid out, too
            assert cut_off(idle_window) == [], (size, key)
        corner = seen.mapTo(idle_window, seen.rect().bottomRight())
        assert idle_window.rect().contains(corner)
        bars = seen.detail.verticalScrollBar(), seen.detail.horizontalScrollBar()
        assert [bar.maximum() for bar in bars] == [0, 0]
