"""The set-up dialog is completed for each kit and with mistakes: results, messages and drawings."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QLabel, QPushButton

from hapkit_studio import lab
from hapkit_studio.devices import calibration_file, profiles
from hapkit_studio.devices.hapkit import PACKET
from hapkit_studio.devices.padding import Padding
from hapkit_studio.devices.profiles import quantum_of
from hapkit_studio.gui.wizard import step_sensor
from hapkit_studio.protocol.messages import Force, Origin
from tests.devices.paddle_kit import PaddleKit
from tests.gui.shell.test_fits import misfits
from tests.gui.wizard.support import PACE

PLACES = (0.0, -0.02, 0.02, 0.0)


@pytest.mark.slow
def test_a_kit_with_all_settings_wrong_is_set_up(played, tmp_path):
    play = played(sense=-1, direction=-1, magnet=700.0, torque=0.7 * 0.0183)
    dialog, kit = play.dialog, play.kit
    connect, sensor, scale, direction, strength, friction, save = dialog.steps
    play.press(connect.take)
    dialog.next.click()
    play.end_to_end()
    play.press(sensor.start_button)
    assert sensor.result.key == "inverted"
    dialog.next.click()
    taken(play)
    play.press(scale.apply)
    assert scale.result.good
    dialog.next.click()
    play.let_go()
    play.press(direction.push)
    assert direction.result.good
    assert kit.settings_now.direction == -1
    dialog.next.click()
    for mass in (0.0, 0.05, 0.1):
        assert strength.mass.si == pytest.approx(mass)
        play.hang(mass)
        play.press(strength.carry)
        kit.weight = 0.0
    play.press(strength.use)
    assert kit.settings_now.motor_constant == pytest.approx(0.7 * 0.0183, rel=0.05)
    dialog.next.click()
    play.let_go()
    play.press(friction.sweep)
    assert "±" in friction.found["mass"].text()
    dialog.next.click()
    save.label.setText("red 7")
    play.press(save.save)
    assert kit.stored.label == "red 7"
    assert kit.origin == Origin.STORED
    (file,) = (tmp_path / "calibrations").glob("*.toml")
    assert calibration_file.read(file).sense == -1
    assert [step.result is not None for step in dialog.steps] == [True] * 7
    save.undo.click()
    assert kit.stored.label == "red 7"  # the dialog asks for confirmation first
    play.press(save.undo_all)
    assert kit.stored.label == "Hapkit"
    assert [step.result for step in dialog.steps] == [None] * 7
    assert not any(done for done, _words in dialog.notes().values())
    assert all(dialog.list.item(row).toolTip() == "This step is not done yet." for row in range(7))
    assert friction.found["mass"].text() == "–"
    assert dialog.index == 0


@pytest.mark.slow
def test_texts_fit_controls_have_names_and_a_skipped_step_states_its_assumption(played, qtbot):
    play = played()
    dialog = play.dialog
    dialog.resize(860, 560)
    for index in range(7):
        qtbot.wait(20)
        step = dialog.step
        assert dialog.index == index
        assert step.width() <= step.parentWidget().width(), "it does not scroll sideways"
        for label in step.findChildren(QLabel):
            if label.isVisible() and label.text() and not label.wordWrap():
                assert label.sizeHint().width() <= label.width() + 1, label.text()
        for button in step.findChildren(QPushButton):
            assert button.text()
            assert button.sizeHint().width() <= button.width() or not button.isVisible(), button.text()
        if index < 6:
            assert step.if_skipped in step.hint.text()
            dialog.skip.click()
            assert "This step was skipped." in dialog.list.item(index).toolTip()
    assert all(step.if_skipped in dialog.step.assumptions.text() for step in dialog.steps[:-1])
    rows = dialog.list
    place = rows.visualItemRect(rows.item(3)).center()
    qtbot.mouseClick(rows.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert dialog.index == 3
    dialog.back.click()  # this selects the previous step, not the step that was selected before
    assert dialog.index == rows.currentRow() == 2


@pytest.mark.slow
def test_a_missing_supply_offers_the_search_and_a_simulated_hand_can_be_dragged(played, qtbot):
    play = played(supply=0.0)
    dialog, kit = play.dialog, play.kit
    dialog.go(3)
    step = dialog.step
    play.press(step.push)
    assert step.result.key == "no motion"
    assert "supply" in step.box.remedy.text()
    assert step.find_dead_band.isVisible()
    play.press(step.find_dead_band)
    assert "supply" in step.box.label.text()

    led = []
    kit.move_hand = led.append
    dialog.go(2)
    view = dialog.step.handle
    middle = view.rect().center()
    qtbot.mouseClick(view, Qt.MouseButton.LeftButton, pos=middle)
    assert led == []
    kit.simulated_hand = True
    view.set_hand_enabled(dialog.board.has_hand)
    for leave in (view.let_go.click, lambda: dialog.go(1)):
        qtbot.mouseClick(view, Qt.MouseButton.LeftButton, pos=middle)
        assert led[-1] == pytest.approx(0.0, abs=3e-4)
        leave()
        assert led[-1] is None
    kit.simulated_hand = False


class EncoderKit(PaddleKit):
    """A kit with a 16-bit encoder on the motor, which starts at 0 and counts in both directions."""

    def __init__(self, **truth):
        board = profiles.named("hapkit-encoder").board
        super().__init__(board, sector=board.sector_radius, **truth)
        self.count_length = quantum_of(board)

    def _raw(self):
        return self._steps() % 2**16

    def _sample(self):
        board = self.settings_now
        return replace(super()._sample(), count=board.sense * (self._steps() - board.zero))

    def _steps(self):
        return math.floor(self.x / self.count_length)


def taken(play):
    """Move the handle to every mark of the visible step, and measure there."""
    for place in PLACES:
        play.lead(place)
        assert play.dialog.step.place.si == pytest.approx(place)
        play.press(play.dialog.step.take)


@pytest.mark.slow
def test_radii_and_marks_are_checked_against_each_other(played):
    play = played()
    play.dialog.go(2)
    step = play.dialog.step

    def use_pulley(radius):
        step.radii["pulley_radius"].show_si(radius)
        play.press(step.set_radii)
        assert not step.set_radii.isEnabled()  # the board already has these values

    use_pulley(0.010)
    taken(play)
    assert "10.0 mm looks like the pulley's diameter" in step.box.label.text()
    assert "Enter 5.0 mm for the pulley" in step.box.remedy.text()
    assert play.dialog.focusWidget() not in (step.take, step.apply)
    use_pulley(0.005)
    assert len(play.dialog.board.subject.marks) == len(PLACES)
    assert "the radii give 20.74" in step.box.label.text()
    assert play.dialog.focusWidget() is step.apply
    play.press(step.apply)
    assert step.result.good
    assert play.dialog.focusWidget() is play.dialog.next
    # the applied scale shows which radius was wrong
    use_pulley(0.010)
    assert step.result is None
    play.press(step.apply)
    assert play.kit.settings_now.pulley_radius == pytest.approx(0.005, rel=0.01)
    assert "The pulley's radius rp is now 5.0" in step.box.label.text()
    assert "instead of 10.00 mm" in step.box.label.text()
    assert step.result.good
    assert "skip" not in step.hint.text()


@pytest.mark.slow
def test_marks_on_the_wrong_side_are_red_and_give_no_scale(played):
    play = played()
    play.dialog.go(2)
    step = play.dialog.step
    for place in PLACES:
        assert not step.apply.isEnabled()
        play.lead(abs(place))  # +20 mm instead of −20 mm
        play.press(step.take)
    assert "wrong side" in step.box.label.text()
    assert step.box.property("tone") == "danger"
    assert not step.apply.isEnabled()


def test_an_unusual_scale_must_be_confirmed_before_saving(played):
    """The usual pulley has a radius of 5 mm, and the scale is proportional to it."""
    play = played()
    dialog, save = play.dialog, play.dialog.save_step

    def enter_save(pulley):
        dialog.go(2)
        dialog.step.radii["pulley_radius"].show_si(pulley)
        play.press(dialog.step.set_radii)
        dialog.go(6)
        return save.save.isEnabled(), save.confirm.isVisible()

    assert enter_save(1.19 * 0.005) == (True, False)
    assert enter_save(1.21 * 0.005) == (False, True)
    assert "1.21 × as far as with the most similar kit, Hapkit 3.0" in save.box.label.text()
    save.confirm.click()
    assert save.save.isEnabled()
    assert enter_save(1.5 * 0.005) == (False, True)  # the new scale is not confirmed yet
    save.confirm.click()
    play.press(save.save)
    assert save.result.good


def test_the_dialog_fits_a_small_screen(played, qapp, monkeypatch):
    """The dialog fits the tests' screen of 800 × 800 px, and then a screen of 900 × 500 px."""
    dialog = played().dialog
    room = dialog.screen().availableSize()
    assert dialog.width() <= room.width()
    assert dialog.height() <= room.height() - 40
    dialog.close()
    monkeypatch.setattr(type(dialog.screen()), "availableSize", lambda _screen: QSize(900, 500))
    small = played().dialog
    for index in range(len(small.steps)):
        small.go(index)
        qapp.processEvents()
        assert small.width() <= 900
        assert small.height() <= 460
        # buttons are left out: their widths are tested above, and the style sheet sets their height
        assert [text for text in misfits(small) if not text.startswith("button")] == [], small.step.name


@pytest.mark.slow
def test_an_encoder_counts_both_ways(played, monkeypatch):
    monkeypatch.setattr(step_sensor, "RECORD_SECONDS", 5.5)
    play = played(kit=EncoderKit(pace=PACE))
    sensor = play.dialog.steps[1]
    play.dialog.go(1)
    play.end_to_end()
    play.press(sensor.start_button)
    reach = math.floor(0.048 / play.kit.count_length)
    low, high = (int(n) for n in re.findall(r"-?\d+", sensor.box.label.text().replace("−", "-"))[:2])
    assert (low, high) == (pytest.approx(-reach, abs=2), pytest.approx(reach, abs=2))
    bottom, top = sensor.plot.getViewBox().viewRange()[1]
    assert bottom == -top < low
    assert np.ptp(sensor.plot.values) < 3 * reach
    play.dialog.go(6)
    play.press(play.dialog.save_step.save)
    assert "in the middle:" in play.dialog.save_step.box.label.text()  # the text says how to power on


class LateKit(PaddleKit):
    """A kit that receives nothing for 40 ms, once, during a push."""

    late, mute = False, 0

    def send_messages(self, *messages):
        pushed = max((abs(m.force) for m in messages if isinstance(m, Force)), default=0.0)
        if self.late and pushed and self.pwm:
            self.late, self.mute = False, 40
        if not self.mute or not pushed:
            super().send_messages(*messages)
        self.mute = max(self.mute - 1, 0)


@pytest.mark.slow
def test_the_drawing_shows_the_selected_method_and_a_failed_mass_is_measured_again(played):
    play = played(kit=LateKit(pace=PACE))
    play.direct()
    play.dialog.go(4)
    step = play.dialog.step
    assert step.drawing.shown == {"side_down", "empty"}
    play.kit.late = True
    play.hang(0.0)
    play.press(step.carry)
    assert "This computer was late" in step.box.label.text()
    assert "Hold the handle in the middle again" in step.box.remedy.text()
    assert step.result is None
    play.hang(0.0)
    play.press(step.carry)
    assert "To carry 0 g," in step.box.label.text()
    assert "hang 50 g on the handle" in step.box.remedy.text()
    assert step.drawing.grams == "50"
    step.method.button(1).click()
    assert step.drawing.shown == {"upright", "plugged", "scale"}
    step.method.button(2).click()
    assert step.drawing.shown == {"upright", "plugged", "spring"}


def test_a_motion_above_the_labs_limit_is_refused_with_both_forces(played, monkeypatch):
    play = played()
    play.direct()
    limited = lab.LabSettings(force_limit=1.0)
    monkeypatch.setattr(lab, "settings", lambda: limited)
    play.hang(0.0)
    play.kit.forces.clear()
    # the sweep begins with a rising force that breaks the friction
    for index, button, force in ((4, "carry", 2.5), (4, "push", 1.5), (4, "pull", 2.0), (5, "sweep", 1.5)):
        play.dialog.go(index)
        step = play.dialog.step
        if index == 4:
            step.method.button(("carry", "push", "pull").index(button)).click()
        play.press(getattr(step, button))
        assert step.box.label.text().startswith(
            f"This measurement needs up to {force:g} N, but lab.toml limits the force to 1 N."
        )
        assert step.result is None
    assert set(play.kit.forces) <= {0.0}


@pytest.mark.slow
def test_springs_are_measured_one_after_the_other(played):
    play = played(torque=0.9 * 0.0183)
    play.direct()
    play.dialog.go(4)
    step = play.dialog.step
    step.method.button(2).click()
    for stiffness, next_step in ((100.0, "another spring"), (300.0, "Use this result")):
        assert not step.use_pulled.isEnabled()
        step.stiffness.setValue(stiffness)
        play.let_go()
        play.kit.spring = stiffness
        play.press(step.pull)
        assert f"spring of {stiffness:g} N/m was measured as {stiffness / 0.9:.0f}" in step.box.label.text()
        assert next_step in step.box.remedy.text()
    play.press(step.use_pulled)
    assert play.kit.settings_now.motor_constant == pytest.approx(0.9 * 0.0183, rel=0.01)
    assert "The motor gives 90 ± 4 %" in step.box.label.text()


@pytest.mark.parametrize(
    ("delays", "size", "text"),
    [
        (
            (9.0e-3, 3.1e-3),
            PACKET,
            "Each USB message is filled up to 62 bytes, so the delay is 3.1 ms instead of 9.0 ms.",
        ),
        (
            (1.0e-3, 1.2e-3),
            0,
            "The delay is 1.0 ms. Longer USB messages would make the delay 1.2 ms, so the messages stay "
            "short.",
        ),
    ],
)
def test_frames_are_sent_in_the_way_that_was_measured_as_faster(played, delays, size, text):
    dialog = played().dialog
    link = dialog.studio.device
    link.padding = PACKET - size
    dialog.board.subject.padding = Padding(*delays)
    dialog.reset()
    assert link.padding == size
    assert dialog.connect_step.frames.text() == text
