"""Safety: E-stop and Cancel at every step; no accidental key starts the motor."""

import threading

import pytest
import shiboken6
from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QApplication, QPushButton, QWidget

from hapkit_studio.analysis.calibrate.calibration import NO_DIRECTION
from hapkit_studio.devices import calibration_file, profiles
from hapkit_studio.devices.virtual_board import VirtualBoard, built
from hapkit_studio.errors import NoDataError
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.protocol.messages import Sensor
from tests.devices.paddle_kit import PaddleKit
from tests.gui.wizard.support import PACE, Played

JOBS = [(1, "start_button"), (2, "take")]
MOTIONS = [(3, "push"), (4, "carry"), (4, "push"), (5, "sweep")]


def pushes(kit):
    return [force for force in kit.forces if force]


def test_no_key_starts_the_motor_and_esc_always_stops_it(played, idle_window, qtbot):
    play = played(idle_window)
    dialog, kit = play.dialog, play.kit
    dialog.skip.setFocus()
    for repeats, step in ((True, 0), (False, 1)):
        enter = QKeyEvent(
            QEvent.Type.KeyPress, Qt.Key.Key_Return, Qt.KeyboardModifier.NoModifier, "\r", repeats
        )
        QApplication.sendEvent(dialog, enter)
        assert dialog.index == step
    dialog.go(4)
    dialog.step.mass.setFocus()
    qtbot.keyClick(dialog.step.mass, Qt.Key.Key_Return)
    assert not dialog.board.busy
    for index in range(7):
        dialog.go(index)
        widgets = (dialog, dialog.list, dialog.skip, *dialog.step.findChildren(QWidget))
        takes_keys = [w for w in widgets if w.isVisible() and w.focusPolicy() != Qt.FocusPolicy.NoFocus]
        for widget in {type(w): w for w in takes_keys}.values():
            qtbot.keyClick(widget, Qt.Key.Key_Escape)
            assert dialog.studio.stopped, widget
            assert dialog.isVisible()
            dialog.studio.release_stop()
    for directed in (False, True):
        if directed:
            play.direct()
        before = len(pushes(kit))
        for index in (3, 4, 5):
            dialog.list.setCurrentRow(index)
            focused = dialog.focusWidget()
            assert not (isinstance(focused, QPushButton) and focused.property("motor"))
            if not dialog.next.hasFocus():
                qtbot.keyClick(dialog, Qt.Key.Key_Return)
                assert dialog.index == index
            assert not dialog.board.busy
        assert len(pushes(kit)) == before
    # choosing another device returns the board to the window
    studio, actions = play.window.studio, play.window.actions_by_key
    studio.device.open(studio.device.entries()[0])
    assert kit.hello is None
    qtbot.waitUntil(lambda: studio.engine is not None)
    actions.refresh()
    assert not any(actions.qt[key].isEnabled() for key in ("device.setup", "device.check")), "it is no board"


def test_strength_and_sweep_require_the_direction(played):
    play = played()
    dialog = play.dialog
    for index, names in ((4, ("carry", "push")), (5, ("sweep",))):
        dialog.go(index)
        assert not any(getattr(dialog.step, name).isEnabled() for name in names)
        assert dialog.step.box.label.text() == NO_DIRECTION
    play.direct()
    dialog.go(5)
    assert dialog.step.sweep.isEnabled()
    # a later change of the position's sign invalidates the direction test
    work = dialog.board.subject
    dialog.steps[2].run_job("…", lambda w: w._change(sense=-1), lambda _none: dialog.steps[2].changed.emit())
    play.wait()
    assert work.direction is None
    assert dialog.steps[3].result is None
    assert not dialog.step.sweep.isEnabled()
    dialog.close()
    assert play.window.studio.stopped, "a board with other settings comes back stopped"


def test_e_stop_and_cancel_end_the_job_of_every_step_and_it_can_be_repeated(played, qtbot):
    play = played()
    dialog, kit, studio = play.dialog, play.kit, play.window.studio
    play.direct()
    play.lead(0.0)
    kit.pace = 1e-3
    stop, cancel = ("Stopped", dialog.stop.click), ("Cancelled", dialog.close_button.click)
    for index, name in JOBS + MOTIONS:
        dialog.go(index)
        button = getattr(dialog.step, name)
        on_scale = (index, name) == (4, "push")
        if index == 4:
            dialog.step.method.button(on_scale).click()
        for text, end in (stop, cancel) if (index, name) in MOTIONS else (cancel,):
            button.click()
            assert dialog.close_button.text() == "Cancel"
            assert dialog.focusWidget() is (dialog.step.enough if on_scale else dialog.stop)
            assert not dialog.list.isEnabled()
            qtbot.waitUntil(lambda: dialog.board.runner.progress[0] > 0.02)
            end()
            qtbot.waitUntil(lambda: not dialog.board.busy)
            assert kit.pwm == 0
            assert text in dialog.step.box.label.text()
            assert dialog.close_button.text() == "Close"
            assert dialog.list.isEnabled()
            assert dialog.isVisible()
            if text == "Stopped":
                assert kit.stopped
                play.press(button)  # nothing moves until the stop is released
                assert kit.pwm == 0
                dialog.release.click()
                assert not studio.stopped
        if on_scale:
            button.click()
            qtbot.waitUntil(lambda: kit.pwm != 0)
            dialog.step.enough.click()
            play.wait()
            assert kit.pwm == 0
            assert dialog.step.take.isEnabled()


def test_a_board_without_an_answer_offers_try_again_and_close(played, qtbot):
    play = played()
    dialog = play.dialog
    silent = NoDataError("The Hapkit does not answer.")

    def fails(_work):
        raise silent

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(dialog.board, "_next_job", fails)
        dialog.board._job = fails
        qtbot.waitUntil(lambda: dialog.again.isVisible())
    assert dialog.close_button.isVisible()
    assert not dialog.next.isEnabled()
    assert not dialog.list.isEnabled()
    assert play.kit.hello is None
    dialog.again.click()
    play.wait()
    assert dialog.next.isVisible()
    assert dialog.skip.isEnabled()
    assert not dialog.again.isVisible()
    assert play.kit.pwm == 0


def test_a_kit_opened_by_mistake_is_returned_and_undoing_everything_asks_first(played):
    play = played()
    step, save = play.dialog.connect_step, play.dialog.save_step
    for key, sensor in (("hapkit-hall", Sensor.AS5048A), ("hapkit3", Sensor.MAGNETORESISTIVE)):
        step.kits.setCurrentIndex(step.kits.findData(key))
        play.press(step.take)
        assert play.dialog.board.subject.board.sensor == sensor
        assert profiles.named(key).title in step.box.label.text()
    play.dialog.go(6)
    save.undo.click()
    assert save.undo_all.isVisible()
    assert play.dialog.focusWidget() is save.keep
    save.keep.click()
    assert save.undo.isVisible()
    assert not save.undo_all.isVisible()
    assert step.result is not None
    play.dialog.close()
    assert not play.window.studio.stopped, "the board has the settings that it had"


@pytest.mark.parametrize("again", [False, True])
def test_an_e_stop_released_in_the_dialog_stays_released(played, again):
    play = played()
    studio, step = play.window.studio, play.dialog.connect_step
    studio.stop_state.restored = True
    play.dialog.stop.click()
    play.dialog.release.click()
    step.kits.setCurrentIndex(step.kits.findData("hapkit-hall"))
    play.press(step.take)
    if again:
        play.dialog.stop.click()
    play.dialog.close()
    assert studio.stopped == again
    assert not studio.stop_state.restored, "the loop asks for no second release"


def test_closing_in_the_middle_of_a_sweep_leaves_the_motor_off(played, qtbot):
    play = played()
    dialog, kit = play.dialog, play.kit
    play.direct()
    dialog.go(5)
    kit.pace = 1e-3
    dialog.step.sweep.click()
    qtbot.waitUntil(lambda: kit.pwm != 0)
    dialog.close()
    assert kit.pwm == 0
    assert kit.hello is None
    assert not any(thread.name == "wizard" for thread in threading.enumerate())
    assert play.window.studio.link.state != "idle"


def test_a_stop_before_the_dialog_opened_remains_and_enter_does_not_release_it(played, qtbot, monkeypatch):
    wait = Played.wait

    def press_enter_and_wait(play):
        qtbot.keyClick(play.dialog, Qt.Key.Key_Return)
        assert not play.window.studio.stopped
        play.window.studio.stop()
        wait(play)

    with monkeypatch.context() as patched:
        patched.setattr(Played, "wait", press_enter_and_wait)
        play = played()
    play.dialog.go(3)
    play.press(play.dialog.step.push)
    assert "Stopped" in play.dialog.step.box.label.text()
    assert "Release E-stop" in play.dialog.step.box.remedy.text()
    assert not any(play.kit.forces)


def test_a_failed_save_gives_a_message_and_can_be_repeated(played, monkeypatch):
    play = played()
    play.dialog.go(6)
    save = play.dialog.save_step

    def refuse_with(error):
        def refuse(*_words):
            raise error

        return refuse

    denied = PermissionError(13, "Permission denied", "x.toml")
    for target, name, error, text in (
        (play.kit, "save", NoDataError("Silent."), "Silent."),
        (calibration_file, "write", denied, "Permission denied: x.toml."),
    ):
        with monkeypatch.context() as patched:
            patched.setattr(target, name, refuse_with(error))
            play.press(save.save)
            assert save.result is None
            assert save.box.label.text() == text
    play.press(save.save)
    assert save.result.good
    assert "within 8" in save.box.label.text()  # the handle must be within 8 mm of the middle at power-on


def test_a_board_is_released_when_its_owner_is_destroyed(qtbot):
    kit, owner = PaddleKit(pace=PACE), QObject()
    board = BoardThread(lambda: kit, lambda runner: runner, owner)
    board.start()
    qtbot.waitUntil(lambda: board.runner is not None)
    shiboken6.delete(owner)
    qtbot.waitUntil(lambda: kit.hello is None)


@pytest.mark.slow
@pytest.mark.skipif(not built(), reason="the virtual board is not built")
def test_a_sweep_with_the_real_firmware_is_cancelled_stopped_and_repeated(played, qtbot):
    board = VirtualBoard("lockstep")
    dialog = (play := played(kit=board)).dialog
    dialog.go(3)
    play.press(dialog.step.push)
    assert dialog.step.result.good
    dialog.go(5)
    for button, text in ((dialog.close_button, "Cancelled"), (dialog.stop, "Stopped")):
        dialog.step.sweep.click()
        qtbot.waitUntil(lambda: dialog.board.runner.progress[0] > 0.05)
        button.click()
        play.wait()
        assert text in dialog.step.box.label.text()
        qtbot.waitUntil(lambda: dialog.board.runner.recent[-1].pwm == 0)
    dialog.release.click()
    dialog.step.sweep.click()
    qtbot.waitUntil(lambda: any(sample.pwm for sample in list(dialog.board.runner.recent)[-20:]))
    dialog.close()
    assert board.summary
