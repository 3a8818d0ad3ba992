"""Test my Hapkit in the window, and how both are opened."""

import pytest

from hapkit_studio.gui.wizard.opening import open_check, open_setup
from hapkit_studio.gui.wizard.shell import Shell
from hapkit_studio.protocol.messages import Origin
from tests.gui.window_support import PATIENCE_MS
from tests.gui.wizard_support import check


@pytest.mark.parametrize(("truth", "good"), [({}, True), ({"direction": -1}, False)])
def test_every_check_has_its_verdict_in_words(idle_window, qtbot, truth, good):
    play = check(idle_window, qtbot, **truth)
    play.kit.origin = Origin.STORED
    shell = play.shell
    shell.test.click()
    qtbot.waitUntil(lambda: shell.report is not None, timeout=PATIENCE_MS)
    assert shell.report.good is good
    assert shell.box.words.text() == shell.report.words
    assert shell.bar.value() == shell.bar.maximum()
    for key, verdict in shell.report.results.items():
        assert verdict.words in shell.rows[key][1].text()
    shell.close()
    assert play.kit.pwm == 0


def test_what_is_said_is_seen_whole(idle_window, qtbot):
    shell = check(idle_window, qtbot).shell
    for width in (820, 640):
        shell.resize(width, 600)
        qtbot.wait(20)
        words = shell.box.words
        assert words.height() >= words.heightForWidth(words.width())


def test_neither_is_offered_without_a_board(window):
    actions = window.actions_by_key
    actions.refresh()
    assert not actions.qt["device.setup"].isEnabled()
    assert not actions.qt["device.check"].isEnabled()


def test_one_of_them_at_a_time_has_the_board(idle_window, qtbot):
    play = check(idle_window, qtbot)
    assert open_setup(idle_window) is play.shell
    assert open_check(idle_window) is play.shell
    play.shell.close()
    assert [shell for shell in idle_window.findChildren(Shell) if shell.isVisible()] == []
