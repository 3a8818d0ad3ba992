import math

import pytest

import hapkit_studio as hs
from hapkit_studio.analysis.identify import from_run, identify
from hapkit_studio.analysis.identify.estimates import Estimate
from hapkit_studio.analysis.identify.recording import Handle, Setup
from hapkit_studio.analysis.identify.words import line, measured, plain
from hapkit_studio.dynamics.hand import GRIPS
from tests.analysis.identify.motions import shaken


@pytest.mark.parametrize(
    ("key", "value", "half", "text"),
    [
        ("stiffness", 287.31, 4.2, "287 ± 4"),
        ("stiffness", 287.31, 1.6, "287.3 ± 1.6"),
        ("stiffness", 299.98, 0.02, "300.0 ± 0.1"),
        ("stiffness", 1234.0, 260.0, "1,234 ± 260"),
        ("damping", -0.4496, 0.0131, "−0.450 ± 0.013"),
        ("damping", -0.0001, 0.02, "0.000 ± 0.020"),
        ("mass", 0.0441, 0.0012, "44.1 ± 1.2"),
        ("centre", 0.00502, 0.0001, "5.02 ± 0.10"),
        ("coulomb", 0.1004, 0.004, "0.100 ± 0.004"),
    ],
)
def test_a_number_is_written_as_fine_as_it_is_known(key, value, half, text):
    assert measured(Estimate(key, value, half)) == text


def test_what_was_set_and_what_was_rendered():
    estimate = Estimate("stiffness", 287.31, 4.2, asked=300.0)
    assert line(estimate, "rendered") == "Stiffness: you set 300 N/m, you rendered 287 ± 4 N/m."
    assert line(Estimate("mass", 0.0441, 0.0012, asked=0.044), "handle") == (
        "Mass: the device has 44 g, identified 44.1 ± 1.2 g."
    )
    assert line(Estimate("damping", 1.0, 0.1), "rendered") == "Damping: 1.00 ± 0.10 N·s/m."


def test_the_hands_mass_is_told_apart_from_the_handles():
    estimate = Estimate("mass", 0.0936, 0.0012, asked=0.094)
    setup = Setup(handle=Handle(0.044, 0.5, 0.1), grip=GRIPS["medium"])
    assert line(estimate, "handle", setup) == (
        "Mass: 44 g of the handle and 50 g of the hand, identified 93.6 ± 1.2 g."
    )
    alone = Estimate("mass", 0.0441, 0.0012, asked=0.044)
    assert line(alone, "handle", setup) == "Mass: the device has 44 g, identified 44.1 ± 1.2 g."


def test_large_numbers_are_written_in_thousands():
    estimate = Estimate("stiffness", -12345.6, 260.0, asked=12000.0)
    assert line(estimate, "rendered") == "Stiffness: you set 12,000 N/m, you rendered −12,346 ± 260 N/m."
    assert plain(-1234.0, estimate) == "−1,234"
    assert plain(0.0, estimate) == "0"


def test_what_is_not_told_says_what_to_do():
    estimate = Estimate("damping", 0.0, math.inf, told=False, advice="Cannot tell. Move faster.")
    assert line(estimate, "rendered") == "Damping: Cannot tell. Move faster."


def test_the_loop_is_named_as_the_reason():
    found = shaken(1, values={"stiffness": 400.0}, delay=1e-3)
    text = "\n".join(found.sentences(found.rendered))
    assert "you set 0 N·s/m, you rendered −0.6" in text
    assert "That is what the loop makes of it, −0.6" in text
    assert "1.5 ms on average: that takes 400 N/m × 1.5 ms = 0.6 N·s/m." in text


def test_a_force_that_is_not_the_laws_is_said():
    found = shaken(1, values={"stiffness": 400.0}, delay=1e-3)
    part = found.rendered
    moved = Estimate("stiffness", 350.0, 2.0, 400.0, 400.0)
    other = type(part)(**{**vars(part), "estimates": (moved,)})
    assert "something else acts too" in "\n".join(found.sentences(other))


def test_the_passivity_controller_is_named():
    run = hs.simulate("spring", {"stiffness": 900.0}, hand="pluck", seconds=3.0, delay=2e-3, controller=True)
    found = identify(from_run(run))
    text = "\n".join(found.sentences(found.rendered))
    assert "something else acts too" in text
    assert "The passivity controller damped in" in text
    assert found.surprises(found.rendered)
