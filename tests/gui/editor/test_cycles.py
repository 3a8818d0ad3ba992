"""On request, the editor shows how many processor cycles each line of a law takes, until the line changes."""

import re

import pytest

from hapkit_studio.workshop.source import typed
from hapkit_studio.workshop.trying import TrialResult
from tests.gui.own_support import LAW_LINE, put, spring, wait_for_verdict


def saved(window, text):
    """Save a text and mark it as tried, without a trial process."""
    window.editor.page.code.setPlainText(text)
    window.editor.save()
    window.own.runner.cancel()
    window.own.runner.finished.emit((typed(window.editor.path, text), TrialResult()))


@pytest.fixture
def counting(home, make_window, qtbot):
    """Return a window without a device, in which the user's own law is active and its cycles are counted."""
    path = put(home, "test_spring.py", spring())
    window = make_window()
    window.editor.edit(path)
    wait_for_verdict(window, qtbot, lambda: saved(window, spring()))
    window.actions_by_key.run("environment.cycles")
    qtbot.waitUntil(lambda: bool(window.editor.page.code.counts))
    return window


def test_cycles_are_shown_until_their_line_changes(counting, qtbot):
    page = counting.editor.page
    assert list(page.code.counts) == [LAW_LINE]
    assert 100 < page.code.counts[LAW_LINE] < 1000
    text = page.cycles.text()
    assert re.match(
        r"One call of the law takes about \d+ cycles on the board, at most \d+\. "
        r"At 4,000 Hz, the law uses \d\d %",
        text,
    )
    assert page.cycles.isVisible()
    figure = page.code.counts[LAW_LINE]
    page.code.moveCursor(page.code.textCursor().MoveOperation.Start)
    page.code.insertPlainText("#\n")
    assert page.code.counts == {LAW_LINE + 1: figure}
    counting.studio.set_value("stiffness", 0.0)  # the same text gives different specialised code
    qtbot.waitUntil(lambda: page.cycles.text().startswith("These numbers are for the law that is running"))
    assert page.code.counts == {LAW_LINE + 1: figure}
    page.code.moveCursor(page.code.textCursor().MoveOperation.End)
    page.code.setPlainText(page.text.replace("-p.stiffness * x", "-2.0 * p.stiffness * x"))
    assert page.code.counts == {}
    wide = page.code.gutter.wanted_width
    page.count.click()
    assert page.code.counts is None
    assert page.code.gutter.wanted_width == page.code.gutter.width() < wide
    assert not page.cycles.isVisible()


@pytest.mark.slow
def test_a_law_with_an_error_keeps_the_old_cycles(counting, qtbot):
    page, text = counting.editor.page, counting.editor.page.cycles.text()
    broken = spring(force="-p.stifness * x")
    verdict = wait_for_verdict(counting, qtbot, lambda: saved(counting, broken))
    assert not verdict.ok
    assert LAW_LINE in page.code.marks
    qtbot.waitUntil(
        lambda: page.cycles.text().startswith(
            "These numbers are for the law that is running, without your changes. One call"
        )
    )
    assert page.cycles.text().endswith(text[1:])
    wait_for_verdict(counting, qtbot, lambda: saved(counting, spring()))
    qtbot.waitUntil(lambda: page.cycles.text() == text)
    assert LAW_LINE in page.code.counts


@pytest.mark.slow
def test_a_law_too_slow_for_the_board_is_counted(counting, qtbot):
    page = counting.editor.page
    loop = "def sum_of(x):\n    y = 0.0\n    for i in range(200):\n        y = y + x * y\n    return y\n"
    slow = spring(force="-p.stiffness * sum_of(x)").replace("@law\n", f"{loop}\n\n@law\n")
    wait_for_verdict(counting, qtbot, lambda: saved(counting, slow))
    qtbot.waitUntil(lambda: "Hz at most, but the board's slowest rate" in page.cycles.text())
    dearest = max(page.code.counts, key=page.code.counts.get)
    assert "y = y + x * y" in page.text.splitlines()[dearest - 1]


def test_an_untried_law_shows_a_message_instead_of_cycles(home, make_window):
    window = make_window()
    window.editor.edit(put(home, "test_spring.py", spring(force="-p.stifness * x")))
    window.actions_by_key.run("environment.cycles")
    assert window.editor.page.cycles.text() == "The cycles are not counted yet. Save and run the law first."
    assert window.editor.page.code.counts == {}
    window.editor.close()
    assert not window.actions_by_key.qt["environment.cycles"].isEnabled()
