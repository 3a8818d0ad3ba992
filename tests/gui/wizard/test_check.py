"""Tests of the dialog *Test my Hapkit*: the checks, their results, and how the dialogs are opened."""

import pytest
from PySide6.QtCore import Qt

from hapkit_studio.gui.wizard.check import CheckDialog
from hapkit_studio.gui.wizard.setup import SetupDialog
from hapkit_studio.protocol.messages import Origin


def test_cancel_and_esc_end_the_checks_and_each_result_is_a_text(played, qtbot):
    play = played(kind=CheckDialog, direction=-1)
    play.kit.origin = Origin.STORED
    dialog = play.dialog
    for opens in (SetupDialog, CheckDialog):
        assert opens.open_over(play.window.studio, play.window, play.window.closed) is dialog, (
            "one of them at a time has the board"
        )
    for end, text in (
        (dialog.close_button.click, "Cancelled"),
        (lambda: qtbot.keyClick(dialog, Qt.Key.Key_Escape), "Stopped"),
    ):
        dialog.test.click()
        qtbot.waitUntil(lambda: dialog.board.runner.progress[0] > 0.02)
        end()
        play.wait()
        assert text in dialog.box.label.text()
        assert play.kit.pwm == 0
    dialog.release.click()
    dialog.test.click()
    qtbot.waitUntil(lambda: dialog.report is not None)
    assert dialog.report.dangerous
    assert dialog.box.label.text() == dialog.report.text
    for key, verdict in dialog.report.results.items():
        assert verdict.text in dialog.rows[key][1].text()
    dialog.close()
    assert play.kit.pwm == 0


@pytest.mark.slow
def test_a_healthy_kit_passes_and_no_progress_bar_remains(played, qtbot):
    play = played(kind=CheckDialog)
    play.kit.origin = Origin.STORED
    dialog = play.dialog
    dialog.test.click()
    dialog.box.show_progress(5.0, 10.0)
    assert dialog.box.bar.isVisible()
    qtbot.waitUntil(lambda: dialog.report is not None)
    assert dialog.report.good
    assert dialog.box.sign.name == "check"
    qtbot.waitUntil(dialog.box.bar.isHidden)
