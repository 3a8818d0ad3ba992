"""The line that says what the simulated device models, and its switch."""

import itertools
from dataclasses import replace

import pytest

from hapkit_studio import environments
from hapkit_studio.devices.simulated import OPTIONAL
from hapkit_studio.gui.panel.parameter_panel import ModelLine

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
    ("needs", "model", "words"),
    [
        (("mass", "viscous", "coulomb"), "scene", "Modelled: mass, damping, friction"),
        (("mass", "viscous", "coulomb"), "everything", WHOLE),
        (("delay",), "scene", "Modelled: mass"),
        (("quantization", "sampling"), "scene", "Modelled: mass, sensor steps"),
        ((), "scene", WHOLE),
    ],
)
def test_names_what_is_modelled(line, needs, model, words):
    line.show_model(scene(*needs), model, simulated=True)
    assert line.words.text() == words


def test_says_what_is_left_out(line):
    line.show_model(scene("mass", "viscous", "coulomb"), "scene", simulated=True)
    assert "Free does without sensor steps:" in line.toolTip()
    assert "2 %" in line.toolTip()
    line.show_model(scene("mass", "viscous", "coulomb", "quantization"), "scene", simulated=True)
    assert f"Free needs {TERMS}:" in line.toolTip()
    line.show_model(scene(), "scene", simulated=True)
    assert "not judged yet" in line.toolTip()
    assert TERMS in line.toolTip()


def test_the_switch_is_there_where_it_makes_a_difference(line):
    line.show_model(scene("mass"), "everything", simulated=True)
    assert line.switch.index == 1
    assert not line.switch.isHidden()
    for needs in ((), ("viscous", "coulomb", "quantization")):
        line.show_model(scene(*needs), "scene", simulated=True)
        assert line.switch.isHidden()
    line.show_model(scene("mass"), "scene", simulated=False)
    assert line.isHidden()


def test_a_person_switches_and_showing_does_not(line, qtbot):
    seen = []
    line.chosen.connect(seen.append)
    line.show_model(scene("mass"), "everything", simulated=True)
    line.show_model(scene("mass"), "scene", simulated=True)
    assert seen == []
    line.switch.button(1).click()
    line.switch.button(0).click()
    assert seen == ["everything", "scene"]


@pytest.mark.parametrize(
    "spare", [(), *itertools.combinations(OPTIONAL, 1), *itertools.combinations(OPTIONAL, 2)]
)
def test_is_one_line_in_the_narrow_panel(line, spare):
    line.show_model(scene("mass", *(key for key in OPTIONAL if key not in spare)), "scene", simulated=True)
    line.resize(240, 80)
    line.show()
    words = line.words
    assert words.heightForWidth(240) == words.heightForWidth(1000)
    line.show_model(scene("mass"), "everything", simulated=True)
    assert line.switch.sizeHint().width() <= 240
    assert line.minimumSizeHint().width() <= 240
