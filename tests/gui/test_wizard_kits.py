"""What the wizard says and draws, by kit and for mistakes: radii, weights, an encoder, letting go."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QRect, Qt

from hapkit_studio.devices import profiles
from hapkit_studio.devices.profiles import quantum_of
from hapkit_studio.gui.wizard.kit_drawing import KitDrawing
from hapkit_studio.gui.wizard.rail import Rail
from hapkit_studio.gui.wizard.sensor_plot import SensorPlot
from tests.devices.paddle_kit import PaddleKit
from tests.gui.wizard_support import PACE

PLACES = (0.0, -0.02, 0.02, 0.0)


class EncoderKit(PaddleKit):
    """An encoder on the motor: it begins at 0 and counts both ways, 16 bits."""

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
    """Have every mark taken on the step in sight."""
    for place in PLACES:
        play.lead(place)
        play.press(play.shell.step.take)


@pytest.fixture
def diameter(played):
    """Return a wizard at step 2 with the pulley's diameter for its radius, every mark taken."""
    play = played()
    play.shell.go(2)
    step = play.shell.step
    step.radii["pulley_radius"].show_metres(0.010)
    play.press(step.set_radii)
    taken(play)
    return play


def test_the_right_radius_is_checked_against_the_marks_there_are(diameter):
    play, step = diameter, diameter.shell.step
    assert "10.0 mm looks like the pulley's diameter" in step.box.words.text()
    assert "Type 5.0 mm for the pulley" in step.box.remedy.text()
    assert not step.set_radii.isEnabled()  # the board has what is shown
    assert play.shell.focusWidget() not in (step.take, step.apply)
    step.radii["pulley_radius"].show_metres(0.005)
    play.press(step.set_radii)
    assert len(play.shell.desk.subject.marks) == len(PLACES)
    assert "the radii make 20.74" in step.box.words.text()
    assert play.shell.focusWidget() is step.apply
    play.press(step.apply)
    assert step.verdict.good
    assert play.shell.focusWidget() is play.shell.next


def test_a_scale_in_force_says_which_radius_gave_way(diameter):
    play, step = diameter, diameter.shell.step
    play.press(step.apply)
    assert play.kit.settings_now.pulley_radius == pytest.approx(0.005, rel=0.01)
    assert "The pulley's radius rp counts as 5.0" in step.box.words.text()
    assert "now, not 10.00 mm" in step.box.words.text()
    assert step.verdict.good
    assert "assumed" not in play.shell.hint.text()


def test_an_encoder_counts_both_ways(played):
    play = played(kit=EncoderKit(pace=PACE))
    sensor = play.shell.steps[1]
    play.shell.go(1)
    play.end_to_end()
    play.press(sensor.begin)
    reach = math.floor(0.048 / play.kit.count_length)
    low, high = (int(n) for n in re.findall(r"-?\d+", sensor.box.words.text().replace("−", "-"))[:2])
    assert (low, high) == (pytest.approx(-reach, abs=2), pytest.approx(reach, abs=2))
    assert sensor.plot.bottom == -sensor.plot.top < low
    assert np.ptp(sensor.plot.values) < 3 * reach


@pytest.mark.parametrize(("kit", "words"), [(EncoderKit, "in the middle:"), (PaddleKit, "within 8")])
def test_how_to_switch_on_depends_on_the_sensor(played, kit, words):
    play = played(kit=kit(pace=PACE))
    play.shell.go(6)
    play.press(play.shell.save_step.save)
    assert words in play.shell.save_step.box.words.text()


def test_the_drawing_is_of_the_way_that_is_chosen(played):
    play = played()
    play.direct()
    play.shell.go(4)
    step = play.shell.step
    assert (step.drawing.weight, step.drawing.scale) == ("0", False)
    play.hang(0.0)
    play.press(step.carry)
    assert "hang 50 g on it" in step.box.remedy.text()
    assert step.drawing.weight == "50"
    step.way.button(1).click()
    assert (step.drawing.weight, step.drawing.scale) == (None, True)


def test_a_handle_that_ran_away_is_to_be_held_again(played):
    play = played()
    play.direct()
    play.shell.go(4)
    step = play.shell.step
    play.hang(0.1)
    play.kit.weight = -9.0  # N, more than a motor carries
    play.press(step.carry)
    assert step.verdict is None
    assert "Hold the handle in the middle again" in step.box.remedy.text()


def test_the_hand_lets_go_where_it_is(qtbot):
    rail, led = Rail(), []
    qtbot.addWidget(rail)
    rail.led.connect(led.append)
    rail.show_hand(True)
    rail.show()
    assert rail.let_go.isHidden()
    rail.lead(0.01)
    assert rail.let_go.isVisible()
    qtbot.mouseClick(rail.let_go, Qt.MouseButton.LeftButton)
    assert led == [0.01, None]
    assert rail.let_go.isHidden()


def ink(widget, box, token="applied"):
    """Return whether pixels of a colour are in a part of a widget."""
    from hapkit_studio.gui.widgets.theme import theme

    image = widget.grab(box).toImage()
    wanted = theme.color(token).rgb()
    return any(image.pixel(x, y) == wanted for x in range(image.width()) for y in range(image.height()))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_force_of_a_handle_at_the_end_keeps_its_number(qtbot, side):
    rail = Rail()
    qtbot.addWidget(rail)
    rail.resize(400, 166)
    rail.show_handle(side * 0.06, side * 1.0)
    handle = round(rail._x(side * 0.06))
    inner = QRect(handle - 110, 40, 80, 80) if side > 0.0 else QRect(handle + 30, 40, 80, 80)
    assert ink(rail, inner)
    outermost = QRect(397, 0, 3, 166) if side > 0.0 else QRect(0, 0, 3, 166)
    assert not ink(rail, outermost)


@pytest.mark.parametrize("value", [3, 1020])
def test_a_reading_that_stands_still_at_an_end_hides_neither_title_nor_scale(qtbot, value):
    plot = SensorPlot()
    qtbot.addWidget(plot)
    plot.resize(500, 130)
    title = QRect(10, 2, 200, 28)
    plain = plot.grab(title).toImage()
    plot.show_readings(np.linspace(0.0, 10.0, 500), np.full(500, value), 0, 1023)
    assert plot.grab(title).toImage() == plain


@pytest.mark.parametrize("wide", [300, 400, 800])
def test_words_of_a_drawing_are_never_small(qtbot, wide, monkeypatch):
    from PySide6.QtGui import QPainter

    sizes = []
    drawing = KitDrawing(usb=True, supply=True)
    qtbot.addWidget(drawing)
    drawing.resize(wide, wide // 2)
    draw = QPainter.drawText

    def noted(painter, *words):
        sizes.append(painter.font().pixelSize() * painter.transform().m11())
        return draw(painter, *words)

    monkeypatch.setattr(QPainter, "drawText", noted)
    drawing.grab()
    assert min(sizes) >= 11.0
