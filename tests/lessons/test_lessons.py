"""A scripted student completes every included lesson; every check rejects wrong data with a sentence."""

import pytest

from hapkit_studio.lessons import evaluate, library
from hapkit_studio.lessons.evaluate import CORRECT
from hapkit_studio.lessons.play import play_step
from tests.lessons.made import (
    elsewhere,
    larger,
    other_state,
    pushed,
    shifted,
    slower,
    slowing,
    still,
    stronger,
)

QUICK = ("first_touch", "virtual_spring", "button")
KEYS = [key if key in QUICK else pytest.param(key, marks=pytest.mark.slow) for key in library().lessons]
# these measurements are proportional to the force
BY_FORCE = ("slope", "stiffness", "damping", "friction", "peak_force")
BY_SIZE = (
    "travel", "rest", "largest_push", "oscillation_amplitude", "stick_slip_amplitude", "spatial_period",
    "peak_speed",
)  # fmt: skip
BY_TIME = (
    "oscillation_frequency", "vibration", "purring", "transient_frequency", "transient_decay",
    "object_growth", "object_frequency",
)  # fmt: skip
# checks of these measurements pass for a handle at rest
SATISFIED_AT_REST = ("rest", "position")


def off_by_twice_the_tolerance(check, samples, value):
    """Return samples whose measured value must fail a check.

    The value is wrong by twice the tolerance, or is half of the check's minimum or twice its maximum.
    """
    if check.measure == "position":
        return shifted(samples, 2.0 * check.tolerance)
    if check.measure == "work":
        low, high = check.between
        return pushed(samples, 2.0 * ((check.tolerance or 0.0) + abs(value)) / (high - low))
    if check.measure == "object_restitution":
        return slowing(samples)
    if check.measure == "clicks":
        return other_state(samples, 0.0)
    if check.measure == "energy_per_bounce":
        return stronger(samples, -1.0)
    if check.expect is not None:
        expected = check.expect if isinstance(check.expect, float) else samples.scene[1][check.expect]
        tolerance = check.tolerance or 0.01 * check.percent * abs(expected)
        factor = (abs(expected) + 2.0 * tolerance) / abs(value)
    elif check.at_least is not None:
        factor = 0.5 * check.at_least / value
    else:
        factor = 2.0 * check.at_most / max(value, 1e-9)
    if check.measure in BY_FORCE:
        return stronger(samples, factor)
    if check.measure in BY_SIZE:
        if check.measure == "rest" and value == 0.0:
            samples.position[::2] += 2.0 * check.at_most
            return samples
        return larger(samples, factor)
    if check.measure in BY_TIME:
        return slower(samples, 1.0 / factor)
    if check.measure == "stick_slip_period":
        return slower(samples, factor)
    assert check.measure == "object_speed", check.measure
    return other_state(samples, factor)


def useful(result):
    """Return True if a result has a sentence that names the fault or the remedy."""
    return result.state != CORRECT and len(result.text) > 20 and result.text.endswith(".")


@pytest.mark.parametrize("key", KEYS)
def test_a_lesson_is_completed_headless(key):
    lesson = library().lessons[key]
    for step in lesson.steps:
        played = play_step(step)
        for question in step.questions:
            state, text = question.judge(played.answers[question.key])
            assert state in ("correct", "review"), text
            assert question.judge("")[0] == "waiting"
            if question.kind != "text":
                wrong = next(o for o in (*question.options, "-12345") if o != question.answer)
                state, text = question.judge(wrong)
                assert state == "wrong"
                assert len(text) > 10, question.text
        for check in step.checks:
            samples = played.samples()
            found = evaluate(check, samples)
            assert found.correct, f"{check.title}: {found.text}"

            wrong = evaluate(check, off_by_twice_the_tolerance(check, played.samples(), found.value))
            assert useful(wrong), f"{check.title}: {wrong.text}"

            short = still(samples) if check.measure not in SATISFIED_AT_REST else samples.between(0.0, 0.2)
            little = evaluate(check, short)
            assert useful(little), f"{check.title}: {little.text}"

            other = "free" if check.environment != "free" else "spring"
            away = evaluate(check, elsewhere(samples, other))
            assert useful(away), f"{check.title}: {away.text}"
            assert "Choose" in away.text
