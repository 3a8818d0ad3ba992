"""The line that says what the simulated device models, and its switch."""

from dataclasses import replace

import pytest

from hapkit_studio import environments
from hapkit_studio.gui.panel.loop import ModelLine

FREE = environments.named("free")
WHOLE = "Modelled: everything"
TERMS = "mass, damping, friction, sensor steps"


def scene(*needs):
    return replace(FREE, needs=needs)


@pytest.fixture
def line(qtbot):
    made = ModelLine()
    qtbot.addWidget(made)
    made.resize(268, 80)
    return made


@pytest.mark.parametrize(
    ("needs", "model", "words", "tip"),
    [
        (
            ("mass", "viscous", "coulomb"),
            "scene",
            "Modelled: mass, damping, friction",
            "without sensor steps:",
        ),
        (("mass", "viscous", "coulomb"), "everything", WHOLE, "2 %"),
        (("mass", "viscous", "coulomb", "quantization"), "scene", WHOLE, f"Free needs {TERMS}:"),
        (("quantization", "sampling"), "scene", "Modelled: mass, sensor steps", "2 %"),
        ((), "scene", WHOLE, "not judged yet"),
    ],
)
def test_says_what_is_modelled_and_what_is_left_out(line, needs, model, words, tip):
    line.show_model(scene(*needs), model, simulated=True)
    assert line.words.text() == words
    assert tip in line.toolTip()


def test_the_switch_is_there_where_it_makes_a_difference(line):
    line.show_model(scene("mass"), "everything", simulated=True)
    assert line.switch.index == 1
    assert not line.switch.isHidden()
    for needs in ((), ("viscous", "coulomb", "quantization")):
        line.show_model(scene(*needs), "scene", simulated=True)
        assert line.switch.isHidden()
    line.show_model(scene("mass"), "scene", simulated=False)
    assert line.isHidden()


def test_a_person_switches_and_showing_does_not(kept_window):
    line, studio = kept_window.loop.model, kept_window.studio
    studio.choose("free")
    line.show_model(studio.environment, "everything", simulated=True)
    assert studio.loop.model == "scene"
    line.switch.button(0).click()
    line.switch.button(1).click()
    assert studio.loop.model == "everything"
