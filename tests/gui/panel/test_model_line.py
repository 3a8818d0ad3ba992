"""The line that states what the simulated device models, and its switch."""

from dataclasses import replace

import pytest

from hapkit_studio import environments
from hapkit_studio.gui.panel.loop import ModelLine

FREE = environments.named("free")
WHOLE = "All parts of the device are simulated"


def scene(*needs):
    return replace(FREE, needs=needs)


@pytest.fixture
def line(qtbot):
    made = ModelLine()
    qtbot.addWidget(made)
    made.resize(268, 80)
    return made


@pytest.mark.parametrize(
    ("needs", "model", "text", "tip"),
    [
        (("mass", "viscous"), "scene", "Simulated: mass, damping and sensor steps", "without friction,"),
        (("mass", "viscous"), "everything", WHOLE, "nobody would feel"),
        (
            ("mass", "viscous", "coulomb"),
            "scene",
            WHOLE,
            "In the scene Free, the device is simulated with damping and friction.",
        ),
        (("delay", "sampling"), "scene", "Simulated: mass and sensor steps", "nobody would feel"),
        (
            ("mass", "coulomb"),
            "frictionless",
            "Simulated: mass, damping and sensor steps",
            "nobody would feel",
        ),
        ((), "scene", WHOLE, "not known which of them Free needs"),
    ],
)
def test_modelled_and_omitted_terms_are_stated(line, needs, model, text, tip):
    line.show_model(scene(*needs), {}, model, modelled=True)
    assert line.label.text() == text
    assert tip in line.toolTip()


def test_a_real_device_shows_no_model(line):
    line.show_model(scene("mass"), {}, "everything", modelled=True)
    assert line.switch.index == 1
    line.show_model(scene("mass"), {}, "scene", modelled=False)
    assert line.isHidden()


def test_only_the_user_changes_the_model_not_the_display(reset_window):
    line, studio = reset_window.loop.model, reset_window.studio
    studio.choose("free")
    line.show_model(studio.environment, studio.values, "everything", modelled=True)
    assert studio.loop.model == "scene"
    line.switch.button(0).click()
    line.switch.button(1).click()
    assert studio.loop.model == "everything"


@pytest.mark.parametrize(
    ("stiffness", "text"), [(None, "Simulated: mass, damping and sensor steps"), (100.0, WHOLE)]
)
def test_with_other_parameters_everything_is_modelled(line, stiffness, text):
    """The list of needed terms was found for a scene's defaults; a softer wall may also need friction."""
    wall = replace(environments.named("wall"), needs=("mass", "viscous"))
    line.show_model(wall, wall.values({"stiffness": stiffness} if stiffness else {}), "scene", modelled=True)
    assert line.label.text() == text


def test_friction_can_be_switched_off_with_one_click_and_undone(reset_window):
    window, studio = reset_window, reset_window.studio
    studio.choose("spring")
    facts, button = window.stability.facts, window.loop.model.switch.button(2)
    button.click()
    assert studio.loop.model == "frictionless"
    assert (studio.engine.modelled.coulomb_force, facts.setting().coulomb) == (0.0, 0.0)
    window.history.undo()
    # 0.10 N is the usual Hapkit's friction
    assert (studio.loop.model, facts.setting().coulomb) == ("scene", 0.10)
