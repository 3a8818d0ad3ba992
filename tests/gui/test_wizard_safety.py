"""What keeps a hand safe in Set up my Hapkit: no key starts the motor by chance, no step runs out of turn."""

import pytest
from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QApplication, QPushButton

from hapkit_studio.analysis.calibrate.calibration import NO_DIRECTION
from hapkit_studio.devices import profiles
from hapkit_studio.errors import NoDataError
from hapkit_studio.protocol.messages import Sensor
from tests.gui.window_support import PATIENCE_MS


@pytest.mark.parametrize("directed", [False, True])
def test_no_step_gives_the_keyboard_to_a_button_that_starts_the_motor(played, qtbot, directed):
    play = played()
    if directed:
        play.direct()
    before = len([force for force in play.kit.forces if force])
    for index in (3, 4, 5):
        play.shell.list.rows[index].click()
        focused = play.shell.focusWidget()
        assert not (isinstance(focused, QPushButton) and focused.property("motor"))
        if not play.shell.next.hasFocus():
            qtbot.keyClick(play.shell, Qt.Key.Key_Return)
            assert play.shell.pages.currentIndex() == index
        assert not play.shell.desk.busy
    assert len([force for force in play.kit.forces if force]) == before


def test_a_key_held_down_presses_nothing(played):
    play = played()
    play.shell.next.setFocus()
    for repeats, step in ((True, 0), (False, 1)):
        enter = QKeyEvent(
            QEvent.Type.KeyPress, Qt.Key.Key_Return, Qt.KeyboardModifier.NoModifier, "\r", repeats
        )
        QApplication.sendEvent(play.shell, enter)
        assert play.shell.pages.currentIndex() == step


def test_strength_and_sweep_wait_for_the_direction(played):
    play = played()
    shell = play.shell
    for index, names in ((4, ("carry", "press")), (5, ("sweep",))):
        shell.go(index)
        assert not any(getattr(shell.step, name).isEnabled() for name in names)
        assert shell.step.box.words.text() == NO_DIRECTION
    play.direct()
    shell.go(5)
    assert shell.step.sweep.isEnabled()
    # what turns the position round afterwards takes that back
    work = shell.desk.subject
    shell.steps[2].do("…", lambda w: w._change(sense=-1), lambda _none: shell.steps[2].changed.emit())
    play.wait()
    assert work.direction is None
    assert shell.steps[3].verdict is None
    assert not shell.step.sweep.isEnabled()


def test_while_the_motor_moves_only_the_stop_is_left(played, qtbot):
    play = played()
    shell = play.shell
    play.direct()
    shell.go(5)
    play.kit.pace = 1e-3
    shell.step.sweep.click()
    qtbot.waitUntil(lambda: play.kit.pwm != 0, timeout=PATIENCE_MS)
    assert shell.stop.hasFocus() or shell.focusWidget() is shell.stop
    assert not any(row.isEnabled() for row in shell.list.rows)
    qtbot.mouseClick(shell.list.rows[1], Qt.MouseButton.LeftButton)
    assert shell.focusWidget() is shell.stop
    assert shell.pages.currentIndex() == 5
    shell.stop.click()
    play.wait()
    assert all(row.isEnabled() for row in shell.list.rows)
    shell.release.click()


def test_a_board_that_does_not_answer_leaves_try_again_and_close(played, qtbot):
    play = played()
    shell = play.shell
    silent = NoDataError("The Hapkit does not answer.")

    def fails(_work):
        raise silent

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(shell.desk, "_turn", lambda bench: fails(bench))
        shell.desk._job = fails
        qtbot.waitUntil(lambda: shell.foot.again.isVisible(), timeout=PATIENCE_MS)
    assert shell.foot.shut.isVisible()
    assert not shell.next.isEnabled()
    assert not shell.list.isEnabled()
    assert play.kit.hello is None
    shell.foot.again.click()
    play.wait()
    assert shell.next.isVisible()
    assert shell.next.isEnabled()
    assert not shell.foot.again.isVisible()
    assert play.kit.pwm == 0


def test_enter_while_the_board_starts_does_not_stop_it(played, qtbot, monkeypatch):
    from tests.gui import wizard_support

    monkeypatch.setattr(
        wizard_support.Played, "wait", lambda self: qtbot.keyClick(self.shell, Qt.Key.Key_Return)
    )
    play = played()
    assert not play.window.studio.stopped


def test_undo_asks_and_may_be_left(played):
    play = played()
    play.press(play.shell.connect_step.take)
    play.shell.go(6)
    save = play.shell.save_step
    save.undo.click()
    assert save.sure.isVisible()
    assert play.shell.focusWidget() is save.stay
    save.stay.click()
    assert save.undo.isVisible()
    assert not save.sure.isVisible()
    assert play.shell.connect_step.verdict is not None


@pytest.mark.parametrize("changed", [False, True])
def test_a_board_with_other_settings_comes_back_stopped(played, changed):
    play = played()
    step = play.shell.steps[2]
    step.do(
        "…", lambda work: work._change(zero=work.board.zero + (400 if changed else 0)), lambda _none: None
    )
    play.wait()
    play.shell.close()
    assert play.window.studio.stopped is changed


def test_after_the_stop_it_is_said_what_to_do(played):
    play = played()
    play.shell.go(3)
    play.shell.stop.click()
    play.press(play.shell.step.push)
    assert "Release E-stop" in play.shell.step.box.remedy.text()
    play.shell.release.click()


def test_a_kit_chosen_by_mistake_is_given_back(played):
    play = played()
    step = play.shell.connect_step
    for key, sensor in (("hapkit-hall", Sensor.AS5048A), ("hapkit3", Sensor.MAGNETORESISTIVE)):
        step.kits.setCurrentIndex(step.kits.findData(key))
        play.press(step.take)
        assert play.shell.desk.subject.board.sensor == sensor
        assert profiles.named(key).title in step.box.words.text()
