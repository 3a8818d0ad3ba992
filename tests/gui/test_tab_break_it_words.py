"""The page Break it: what list, side and traces say; and a spring felt with the mouse for real."""

import numpy as np
import pytest

from hapkit_studio.analysis.failures import failures
from hapkit_studio.charts.failures import scaled
from hapkit_studio.gui.tabs.break_it.feel import Feel
from hapkit_studio.gui.tabs.break_it.list import _words
from hapkit_studio.gui.tabs.break_it.record import Record
from hapkit_studio.haptics import rows
from tests.gui.window_support import PATIENCE_MS
from tests.wide import wide


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
