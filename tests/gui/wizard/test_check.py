"""Test my Hapkit in the window, and how both are opened."""

import pytest
from PySide6.QtCore import Qt

from hapkit_studio.gui.wizard.board_dialog import BoardDialog
from hapkit_studio.gui.wizard.check import CheckDialog
from hapkit_studio.gui.wizard.setup import SetupDialog
from hapkit_studio.protocol.messages import Origin
from tests.gui.window_support import PATIENCE_MS


def test_cancel_and_esc_end_the_checks_and_each_has_its_result_in_words(checked, qtbot):
    play = checked(direction=-1)
    play.kit.origin = Origin.STORED
    dialog = play.dialog
    for end, words in (
        (dialog.close_button.click, "Cancelled"),
        (lambda: qtbot.keyClick(dialog, Qt.Key.Key_Escape), "Stopped"),
    ):
        dialog.test.click()
        qtbot.waitUntil(lambda: dialog.board.runner.progress[0] > 0.02)
        end()
        play.wait()
        assert words in dialog.box.words.text()
        assert play.kit.pwm == 0
    dialog.release.click()
    dialog.test.click()
    qtbot.waitUntil(lambda: dialog.report is not None, timeout=PATIENCE_MS)
    assert dialog.report.dangerous
    assert dialog.box.words.text() == dialog.report.words
    for key, verdict in dialog.report.results.items():
        assert verdict.words in dialog.rows[key][1].text()
    dialog.close()
    assert play.kit.pwm == 0


@pytest.mark.slow
def test_a_healthy_kit_is_said_to_be_well_and_no_bar_stays(checked, qtbot):
    play = checked()
    play.kit.origin = Origin.STORED
    dialog = play.dialog
    dialog.test.click()
    dialog.box.show_progress(5.0, 10.0)
    assert dialog.box.bar.isVisible()
    qtbot.waitUntil(lambda: dialog.report is not None, timeout=PATIENCE_MS)
    assert dialog.report.good
    assert dialog.box.words.text() == "Your Hapkit works as it should."
    assert dialog.box.sign.name == "check"
    for key, verdict in dialog.report.results.items():
        assert verdict.words in dialog.rows[key][1].text()
    qtbot.waitUntil(dialog.box.bar.isHidden, timeout=PATIENCE_MS)
    dialog.close()
    assert play.kit.pwm == 0


def test_neither_is_offered_without_a_board(window):
    actions = window.actions_by_key
    actions.refresh()
    assert not actions.qt["device.setup"].isEnabled()
    assert not actions.qt["device.check"].isEnabled()


def test_one_of_them_at_a_time_has_the_board(checked, idle_window):
    play = checked()
    assert SetupDialog.open_over(idle_window) is play.dialog
    assert CheckDialog.open_over(idle_window) is play.dialog
    play.dialog.close()
    assert [dialog for dialog in idle_window.findChildren(BoardDialog) if dialog.isVisible()] == []
