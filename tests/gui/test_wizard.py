"""Set up my Hapkit: played through, safe at every moment, usable by keyboard, nothing cut off."""

import threading

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QPushButton

from hapkit_studio.devices import calibration_file
from hapkit_studio.protocol.messages import Origin
from tests.gui.window_support import PATIENCE_MS


def test_a_kit_with_everything_wrong_is_set_up(played, tmp_path):
    play = played(sense=-1, direction=-1, magnet=700.0, torque=0.7 * 0.0183)
    shell, kit = play.shell, play.kit
    connect, sensor, scale, direction, strength, paddle, save = shell.steps
    play.press(connect.take)
    shell.next.click()
    play.end_to_end()
    play.press(sensor.begin)
    assert sensor.verdict.key == "inverted"
    shell.next.click()
    for place in (0.0, -0.02, 0.02, 0.0):
        play.lead(place)
        assert scale.place.metres == pytest.approx(place)
        play.press(scale.take)
    play.press(scale.apply)
    assert scale.verdict.good
    shell.next.click()
    play.let_go()
    play.press(direction.push)
    assert direction.verdict.good
    assert kit.settings_now.direction == -1
    shell.next.click()
    for mass in (0.0, 0.05, 0.1):
        assert strength.mass.kilograms == pytest.approx(mass)
        play.hang(mass)
        play.press(strength.carry)
        kit.weight = 0.0
    play.press(strength.use)
    assert kit.settings_now.motor_constant == pytest.approx(0.7 * 0.0183, rel=0.05)
    shell.next.click()
    play.let_go()
    play.press(paddle.sweep)
    assert "±" in paddle.found["mass"].text()
    shell.next.click()
    save.label.setText("red 7")
    play.press(save.save)
    assert kit.stored.label == "red 7"
    assert kit.origin == Origin.STORED
    (file,) = (tmp_path / "calibrations").glob("*.toml")
    assert calibration_file.read(file).sense == -1
    assert [step.verdict is not None for step in shell.steps] == [True] * 7
    save.undo.click()
    assert kit.stored.label == "red 7"  # it asks first
    play.press(save.sure)
    assert kit.stored.label == "Hapkit"
    assert [step.verdict for step in shell.steps] == [None] * 7
    assert not any(done for done, _words in shell.notes().values())
    assert all(row.toolTip() == "not done yet" for row in shell.list.rows)
    assert paddle.found["mass"].text() == "–"
    assert shell.pages.currentIndex() == 0


def test_a_skipped_step_says_what_is_assumed(played):
    play = played()
    shell = play.shell
    for index in range(6):
        assert shell.step.assumed in shell.hint.text()
        shell.skip.click()
        assert shell.step.assumed
        assert "Left out" in shell.list.rows[index].toolTip()
    assert all(step.assumed in shell.step.assumptions.text() for step in shell.steps[:-1])


def test_force_is_zero_while_nothing_is_pressed(played, qtbot):
    play = played()
    for index in range(7):
        play.shell.go(index)
        qtbot.wait(30)
    assert set(play.kit.forces) == {0.0}


@pytest.mark.parametrize("by", ["button", "key"])
def test_e_stop_ends_a_sweep_and_holds(played, qtbot, by):
    play = played()
    shell, kit = play.shell, play.kit
    play.direct()
    shell.go(5)
    kit.pace = 1e-3
    shell.step.sweep.click()
    qtbot.waitUntil(lambda: kit.pwm != 0, timeout=PATIENCE_MS)
    if by == "button":
        shell.stop.click()
    else:
        qtbot.keyClick(shell, Qt.Key.Key_Escape)
    play.wait()
    assert kit.pwm == 0
    assert kit.stopped
    assert "Stopped" in shell.step.box.words.text()
    assert shell.isVisible()
    assert shell.release.isVisible()
    play.press(shell.step.sweep)
    assert kit.pwm == 0
    shell.release.click()
    assert not play.window.studio.stopped
    kit.pace = 2e-5
    play.press(shell.step.sweep)
    assert shell.step.verdict.good


def test_closing_in_the_middle_of_a_sweep_leaves_the_motor_off(played, qtbot):
    play = played()
    shell, kit = play.shell, play.kit
    play.direct()
    shell.go(5)
    kit.pace = 1e-3
    shell.step.sweep.click()
    qtbot.waitUntil(lambda: kit.pwm != 0, timeout=PATIENCE_MS)
    shell.close()
    assert kit.pwm == 0
    assert kit.hello is None
    assert not any(thread.name == "wizard" for thread in threading.enumerate())
    assert play.window.studio.link.state != "idle"


def test_enter_in_a_number_starts_nothing(played, qtbot):
    play = played()
    play.shell.go(4)
    play.shell.step.mass.setFocus()
    qtbot.keyClick(play.shell.step.mass, Qt.Key.Key_Return)
    qtbot.wait(50)
    assert set(play.kit.forces) == {0.0}
    play.shell.next.setFocus()
    qtbot.keyClick(play.shell.next, Qt.Key.Key_Return)
    assert play.shell.pages.currentIndex() == 5


def test_no_supply_offers_the_questions_and_the_search(played):
    play = played(supply=0.0)
    play.shell.go(3)
    step = play.shell.step
    play.press(step.push)
    assert step.verdict.key == "no motion"
    assert "supply" in step.box.remedy.text()
    assert step.search.isVisible()
    play.press(step.search)
    assert "supply" in step.box.words.text()


def test_another_device_chosen_meanwhile_gets_the_window_back(played, qtbot):
    play = played()
    studio = play.window.studio
    studio.device.open(studio.device.entries()[0])
    assert play.kit.hello is None
    qtbot.waitUntil(lambda: studio.engine is not None, timeout=PATIENCE_MS)


def test_the_hand_of_a_board_that_has_one_is_dragged_on_the_rail(played, qtbot):
    play = played()
    shell, kit = play.shell, play.kit
    led = []
    kit.move_hand = led.append
    shell.go(2)
    rail = shell.step.rail
    middle = rail.rect().center()
    qtbot.mouseClick(rail, Qt.MouseButton.LeftButton, pos=middle)
    assert led == []
    kit.hand = True
    rail.show_hand(shell.desk.hand_is_ours)
    qtbot.mousePress(rail, Qt.MouseButton.LeftButton, pos=middle)
    assert led[-1] == pytest.approx(0.0, abs=3e-4)
    rail.let_go.click()
    assert led[-1] is None
    kit.hand = None


@pytest.mark.parametrize("size", [(860, 560), (1060, 672)])
def test_words_are_whole_and_controls_named(played, qtbot, size):
    play = played()
    shell = play.shell
    shell.resize(*size)
    for index in range(7):
        shell.go(index)
        qtbot.wait(20)
        step = shell.step
        assert step.width() <= step.parentWidget().width(), "it does not scroll sideways"
        for label in step.findChildren(QLabel):
            if label.isVisible() and label.text() and not label.wordWrap():
                assert label.sizeHint().width() <= label.width() + 1, label.text()
        for button in step.findChildren(QPushButton):
            assert button.text()
            assert button.sizeHint().width() <= button.width() or not button.isVisible(), button.text()
