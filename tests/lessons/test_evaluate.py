"""A check finds an interval of the samples that it can evaluate, and returns an answer."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.lessons import evaluate
from hapkit_studio.lessons.evaluate import CORRECT, WAITING, WRONG
from hapkit_studio.lessons.lesson import Check, Question
from hapkit_studio.parameters import Parameter
from hapkit_studio.quantity import Quantity
from tests.lessons.made import RATE, elsewhere, larger, samples, still, stronger

CHECK = Check(
    "1.1", 1, "Press", "slope", "wall", expect="stiffness", percent=5.0,
    needs={"depth": 0.003, "seconds": 1.0}, wrong="Is the damping zero?",
)  # fmt: skip


def presses(*depths, stiffness=300.0, rendered=None, side="right"):
    """Return presses of 1.5 s each into a wall at 5 mm, with pauses of one second between them."""
    sign = 1.0 if side == "right" else -1.0
    parts = []
    for depth in depths:
        parts += [
            np.full(500, -0.005),
            0.005 + depth * np.sin(np.linspace(0.01, math.pi - 0.01, 1500)),
            np.full(500, -0.005),
        ]
    place = sign * np.concatenate(parts)
    wall = sign * 0.005
    inside = np.maximum(sign * (place - wall), 0.0)
    force = -sign * (stiffness if rendered is None else rendered) * inside
    return samples("wall", {"stiffness": stiffness, "position": wall, "side": side}, place, force)


@pytest.mark.parametrize("side", ["right", "left"])
def test_a_correct_press_is_answered_with_value_and_setting(side):
    found = evaluate(CHECK, presses(0.005, side=side))
    assert found.state == CORRECT
    assert found.text == "Slope: 300 N/m. This is correct: 300 N/m was set."
    assert found.start == pytest.approx(0.5, abs=0.01)
    assert found.stop == pytest.approx(2.0, abs=0.01)
    assert len(found.stamp) == 64


def test_the_newest_press_of_sufficient_depth_counts():
    found = evaluate(CHECK, presses(0.006, 0.005, 0.001))
    assert found.correct
    assert found.start == pytest.approx(3.0, abs=0.01)


def test_insufficient_depth_is_reported_with_both_numbers():
    found = evaluate(CHECK, presses(0.0008))
    assert found.state == WAITING
    assert found.text == "You pressed 0.8 mm deep. Press at least 3 mm deep."


def test_a_wrong_value_is_reported_with_its_difference_and_the_lessons_advice():
    found = evaluate(CHECK, presses(0.005, stiffness=300.0, rendered=330.0))
    assert found.state == WRONG
    assert found.text == "Slope: 330 N/m. This is 30 N/m too high: 300 N/m was set. Is the damping zero?"


@pytest.mark.parametrize(
    ("factor", "state"), [(0.951, CORRECT), (0.949, WRONG), (1.049, CORRECT), (1.051, WRONG)]
)
def test_the_tolerance_is_exact(factor, state):
    assert evaluate(CHECK, stronger(presses(0.005), factor)).state == state


def test_a_different_environment_is_reported():
    found = evaluate(CHECK, elsewhere(presses(0.005)))
    assert found.state == WAITING
    assert found.text == "The recording was made with Free. Choose Wall."


def test_a_setting_out_of_range_is_reported():
    check = replace(CHECK, where={"stiffness": (400.0, 500.0)})
    found = evaluate(check, presses(0.005))
    assert found.text == "Stiffness is 300 N/m. Set a value between 400 N/m and 500 N/m."
    check = replace(CHECK, where={"side": "left"})
    assert evaluate(check, presses(0.005)).text == "Side is right. Choose left."
    made = presses(0.005)
    log = [(0.0, {**made.log[0][1], "rate_Hz": 500.0, "delay_s": 0.005, "estimator": ["foaw", {}]})]
    for where, words in (
        ({"estimator": "iir"}, "Velocity is FOAW. Choose IIR."),
        ({"delay": (0.0, 0.001)}, "Added delay is 5 ms. Set a value between 0 ms and 1 ms."),
        ({"rate": (1000.0, 2000.0)}, "Servo rate is 500 Hz. Set a value between 1,000 Hz and 2,000 Hz."),
    ):
        assert evaluate(replace(CHECK, where=where), replace(made, log=log)).text == words


def test_a_recording_without_contact_is_reported():
    assert "Press at least 3 mm" in evaluate(CHECK, still(presses(0.005))).text


def test_a_recording_without_samples_is_reported():
    empty = presses(0.005).cut(slice(0, 0))
    assert evaluate(CHECK, empty).state == WAITING
    assert evaluate(CHECK, empty).text.endswith(".")


def test_an_interval_ends_at_a_change_of_settings():
    made = presses(0.005, 0.005)
    settings = made.log[0][1]
    weaker = {**settings, "parameters": {**settings["parameters"], "stiffness": 200.0}}
    changed = replace(made, log=[(0.0, settings), (3.7, weaker)])
    found = evaluate(CHECK, changed)
    # the second press has only 0.7 s before the change; after the change, the stiffness is not 300 N/m
    assert found.stop < 3.7 or found.state != CORRECT


def test_a_fault_ends_an_interval():
    made = presses(0.005)
    made.flags[1200] = 4
    found = evaluate(CHECK, made)
    assert found.state == WAITING
    assert found.text.startswith("The movement lasted")


def test_a_limit_applies_on_both_sides():
    check = Check("1.1", 1, "Move", "travel", "free", at_least=0.02, at_most=0.05)
    place = 0.02 * np.sin(math.tau * np.arange(4000) / RATE)
    made = samples("free", {}, place, 0.0 * place)
    assert evaluate(check, made).correct
    assert evaluate(check, larger(made, 0.4)).text == "Distance moved: 16 mm. At least 20 mm is needed."
    assert evaluate(check, larger(made, 2.0)).text == "Distance moved: 80 mm. At most 50 mm is allowed."


def test_the_stamp_depends_on_every_sample_and_setting():
    made = presses(0.005)
    stamp = made.stamp()
    assert presses(0.005).stamp() == stamp
    changed = presses(0.005)
    changed.applied_force[700] += 1e-6
    assert changed.stamp() != stamp
    settings = {**made.log[0][1], "rate_Hz": 999.0}
    assert replace(made, log=[(0.0, settings)]).stamp() != stamp


@pytest.mark.parametrize("seconds", [3.0, 4.0])
def test_a_window_is_as_long_as_the_check_requires(seconds):
    time = np.arange(6000) / 1000.0
    place = 0.005 * np.sin(math.tau * time)
    check = replace(CHECK, environment="spring", needs={"seconds": seconds})
    assert evaluate(check, samples("spring", {"stiffness": 300.0}, place, -300.0 * place)).correct
    short = samples("spring", {"stiffness": 300.0}, place[:2900], -300.0 * place[:2900])
    assert evaluate(check, short).state == WAITING


@pytest.mark.parametrize(
    ("value", "tolerance", "given", "state"),
    [
        (2.0, 0.1, "2.1", CORRECT),
        (2.0, 0.1, "1.9", CORRECT),
        (0.3, 0.1, "0,4", CORRECT),
        (1e-3, 1e-4, "1.1e-3", CORRECT),
        (0.3, 0.0, "0.3", CORRECT),
        (2.0, 0.1, "2.1001", WRONG),
        (2.0, 0.1, "1.8999", WRONG),
        (2.0, 0.1, "nan", WRONG),
        (2.0, 0.1, "inf", WRONG),
    ],
)
def test_a_number_at_the_edge_of_the_tolerance_is_correct(value, tolerance, given, state):
    question = Question("1.1", 1, "How much?", value=value, tolerance=tolerance)
    assert question.judge(given)[0] == state


@pytest.mark.parametrize(
    ("shown", "limits", "accepted"),
    [
        (2.1, (0.001, 0.0021), True),  # 2.1 / 1000 is more than 0.0021
        (4.1, (0.0041, 0.005), True),  # 4.1 / 1000 is less than 0.0041
        (2.1001, (0.001, 0.0021), False),
        (4.0999, (0.0041, 0.005), False),
    ],
)
def test_a_setting_at_the_edge_of_its_range_is_permitted(shown, limits, accepted):
    made = presses(0.005)
    said = {**made.log[0][1], "delay_s": Quantity(Parameter("delay", "Delay", "s", 0.0, 0.0, 0.1)).si(shown)}
    found = evaluate(replace(CHECK, where={"delay": limits}), replace(made, log=[(0.0, said)]))
    assert found.correct is accepted
