"""A trial releases the handle at a distance from rest, and reports how the handle moves."""

from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.analysis.stability.behaviour import Behaviour, Centre, Lasting
from hapkit_studio.analysis.stability.kb_plane import plane
from hapkit_studio.analysis.stability.verdict import of_spring
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.gui.pages.stability.map_data import Lines, LinesRequest
from hapkit_studio.gui.pages.stability.page import reading
from hapkit_studio.gui.pages.stability.trial import (
    LEAST,
    MOST,
    USUAL,
    Released,
    TrialConditions,
    outcome_text,
    starting_distance,
)
from hapkit_studio.gui.pages.stability.verdict import kind_at, verdict
from hapkit_studio.haptics import rows
from tests.gui.pages.stability_support import follow, made_up

SWING = Lasting(0.002, 30.0)
CALM, LIVELY, FLUID = (
    Behaviour(),
    Behaviour(0.0016, SWING, SWING),
    Behaviour(0.0016, SWING, SWING, flick=20.0),
)
MIDDLE, SURFACE = Centre(0.0, 0.0), Centre(0.0, 0.0, returns=False)


def test_a_trial_starts_beyond_the_settling_push_and_within_its_limits():
    assert starting_distance(LIVELY) > 1.5 * LIVELY.push
    assert starting_distance(Behaviour(0.015, SWING, SWING)) == MOST
    assert starting_distance(Behaviour(0.0, SWING, SWING)) == LEAST
    assert starting_distance(CALM) == starting_distance(FLUID) == USUAL


@pytest.mark.parametrize(
    ("begin", "end", "does", "centre", "text"),
    [
        (0.01, 1e-6, CALM, MIDDLE, "The handle came to rest, as was predicted."),
        (0.0015, 1e-6, LIVELY, MIDDLE, "The handle came to rest, as was predicted."),
        (0.002, 1e-6, LIVELY, MIDDLE, "The handle came to rest, which was not predicted."),
        (0.002, 1e-6, FLUID, MIDDLE, "The handle came to rest, as was predicted."),
        (0.003, 0.02, LIVELY, MIDDLE, "The motion grew to ±18.8 mm, as was predicted."),
        (0.003, 0.02, CALM, MIDDLE, "The motion grew to ±18.8 mm, which was not predicted."),
        (0.002, 0.002, LIVELY, MIDDLE, "The handle keeps oscillating by ±2.0 mm, as was predicted."),
        (0.01, 0.002, CALM, MIDDLE, "The motion is still decaying. It is ±2.9 mm now."),
        (
            0.003,
            0.02,
            LIVELY,
            SURFACE,
            "The wall has pushed the handle away, and nothing brings the handle back.",
        ),
    ],
)
def test_the_outcome_is_described(begin, end, does, centre, text):
    """The amplitude of an oscillation of 10 Hz changes from ``begin`` to ``end`` in m within 1.5 s.

    The last peaks are at 1.425 s and 1.475 s. If the amplitude goes from 3 mm to 20 mm, they are 18.2 mm and
    19.4 mm. If it goes from 10 mm to 2 mm, the largest peaks of the last 0.4 s are 3.0 mm and 2.8 mm.
    """
    time = np.arange(1500) * 1e-3
    size = begin * (end / begin) ** (time / 1.5)
    held = TrialConditions(does, centre, 1800.0, 3.0, 20e-6)
    assert outcome_text(Released(time, size * np.sin(20.0 * np.pi * time)), held).startswith(text)
    assert outcome_text(Released(np.empty(0), np.empty(0)), held) == ""


def test_a_spring_that_is_stable_again_is_reported_by_verdict_and_map():
    """The handle has 0.044 kg and 0.5 N·s/m; the velocity has a second-order filter of 5 Hz."""
    slow = LoopSettings(estimator=("butterworth", {"cutoff": 5.0}))
    found = plane(slow, 80.0, 2.25, width=4.0, top=1000.0)
    low, high = found.margin.again[0]
    shown = verdict(replace(found, verdict=of_spring(slow, 80.0, 2.25)))
    assert shown.more.endswith(f"Stable again from {low:,.0f} to {high:,.0f} N/m.")
    inside = verdict(replace(found, verdict=of_spring(slow, 0.5 * (low + high), 2.25)))
    assert (
        f"After you let go, the handle is stable: stable again from {low:,.0f} to {high:,.0f} N/m."
        in inside.lines[0][0]
    )
    here = reading(Lines(LinesRequest(slow, 0.0, 0.0), found), 2.25, 0.5 * (low + high))
    assert "Stable from" in here[1]


def judged(stiffness, damping, controller=False, measured=None):
    """Return the verdict on a spring."""
    setting = LoopSettings(controller=controller)
    found = plane(setting, stiffness, damping, columns=2)
    return verdict(replace(found, verdict=of_spring(setting, stiffness, damping)), measured)


def test_the_column_states_the_behaviour_and_the_measurement_there():
    shown = judged(2000.0, 0.0)
    assert (shown.headline, shown.sign) == ("Buzzes if you let go", ("triangle", "warn"))
    sentence = (
        "If you displace the handle by more than 1.2 mm and let go, it buzzes at 30 Hz (±2.3 mm, held back "
        "by the motor's limit)."
    )
    assert shown.lines == ((sentence, "triangle", "warn"),)
    assert shown.more == "Reason: 2,000 N/m is above the limit of 1,002 N/m after you let go."
    shown = judged(900.0, 2.0, measured=made_up(LoopSettings(), real=True))
    assert shown.headline == "Stable"
    assert shown.more.endswith("N/m after you let go.\nMeasurement with friction: comes to rest.")
    shown = judged(900.0, 2.0, controller=True, measured=made_up(LoopSettings(controller=True)))
    assert "passivity controller is on. The limits do not include it" in shown.more
    assert shown.more.endswith("Measurement of an ideal handle: comes to rest.")


def test_a_class_is_that_of_its_cell_and_none_outside_the_axes():
    measured = made_up(LoopSettings())
    for row, stiffness in enumerate(measured.cells.stiffness):
        for column, damping in enumerate(measured.cells.damping):
            assert kind_at(measured, damping, stiffness) == measured.cells.classes[row, column]
    assert kind_at(measured, 12.0, 2000.0) == measured.cells.classes[-1, -1]
    assert kind_at(measured, 12.1, 500.0) is None
    assert kind_at(measured, 2.0, 2001.0) is None


@pytest.mark.slow
def test_the_report_is_cleared_after_a_change(window, qtbot):
    window.studio.choose("spring")
    window.studio.set_values({"stiffness": 1800.0, "damping": 0.0})
    window.views.show("stability")
    page = window.views.page("stability")
    does = follow(page, qtbot).verdict.does["released"]
    assert (page.trial_conditions.stiffness, page.trial_conditions.does) == (1800.0, does)
    assert not does.calm
    page.trial._conditions = page.trial_conditions
    seen = np.zeros((1500, rows.ROW_WIDTH))
    seen[:, rows.HOST_TIME] = 1e6 + np.arange(1500) * 1e-3
    seen[:, rows.POSITION] = 0.004 * 0.99 ** np.arange(1500)
    seen[:, rows.TICK] = np.arange(1500)
    page.trial._since = float(seen[0, rows.HOST_TIME])
    window.live.history.clear()
    window.live.history.append(seen)
    page.trial.judge()
    assert page.side.outcome.text() == "The handle came to rest, which was not predicted."
    assert not page.side.outcome.isHidden()
    window.studio.set_value("stiffness", 900.0)
    assert page.side.outcome.isHidden()
