"""The verdict in words, and letting go: how far the trial goes, and what is said of what it showed."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability.behaviour import Centre
from hapkit_studio.analysis.stability.kb_plane import plane
from hapkit_studio.analysis.stability.verdict import of_spring
from hapkit_studio.gui.pages.stability.map_data import Lines, LinesQuestion
from hapkit_studio.gui.pages.stability.page import reading
from hapkit_studio.gui.pages.stability.trial import (
    MOST,
    USUAL,
    Released,
    TrialConditions,
    outcome_words,
    starting_distance,
)
from hapkit_studio.gui.pages.stability.verdict import kind_at, verdict
from hapkit_studio.haptics import rows
from tests.gui.pages.stability_support import follow, made_up

# Without virtual damping the linear limit is 2 b / T but for a thousandth.
ABOVE = TrialConditions(Setting(), 1800.0, 1000.0)


@pytest.mark.parametrize(
    ("stiffness", "viscous", "coulomb", "amplitude"),
    [(2000, 0.5, 0.2, 2.546), (4000, 1.0, 0.5, 2.251), (1000, 0.2, 0.1, 3.001)],
)
def test_friction_holds_what_starts_smaller(stiffness, viscous, coulomb, amplitude):
    """The amplitudes in mm are those of the energy balance, and within 2 % those of simulation."""
    setting = Setting(mass=0.05, viscous=viscous, coulomb=coulomb)
    held = TrialConditions(setting, stiffness, 2.0 * viscous / 1e-3)
    assert 1e3 * held.grows_from == pytest.approx(amplitude, rel=0.01)


def test_without_friction_everything_grows_beyond_the_limit_and_nothing_below():
    assert TrialConditions(Setting(coulomb=0.0), 1010.0, 1000.0).grows_from == 0.0
    assert TrialConditions(Setting(coulomb=0.0), 990.0, 1000.0).grows_from == math.inf
    assert TrialConditions(Setting(), 990.0, math.nan).grows_from == math.inf


def test_the_trial_begins_beyond_what_friction_holds():
    assert starting_distance(ABOVE) > 1.5 * ABOVE.grows_from
    assert starting_distance(TrialConditions(Setting(coulomb=5.0), 1100.0, 1000.0)) == MOST
    assert (
        starting_distance(TrialConditions(Setting(), 500.0, 1000.0))
        == starting_distance(TrialConditions(Setting(), 500.0, math.nan))
        == USUAL
    )


def released(begin, end, force=0.0):
    """Return a swing of 10 Hz whose amplitude goes from begin to end in m over 1.5 s."""
    time = np.arange(1500) * 1e-3
    size = begin * (end / begin) ** (time / 1.5)
    return Released(time, size * np.sin(20.0 * np.pi * time), np.full(1500, force))


@pytest.mark.parametrize(
    ("seen", "held", "said"),
    [
        (released(0.003, 0.02), ABOVE, "Grew, as the map says."),
        (released(0.003, 1e-6), ABOVE, "Came to rest: friction held it; it grows from 1.6 mm on."),
        (
            released(0.01, 1e-6),
            TrialConditions(Setting(), 1300.0, 1000.0, 3.0),
            "Came to rest: friction and the force limit of 3.0 N held it.",
        ),
        (
            released(0.01, 1e-6),
            TrialConditions(Setting(coulomb=3.0), 1300.0, 1000.0),
            "Came to rest: friction held it; more than 20 mm would grow.",
        ),
        (released(0.01, 1e-6), TrialConditions(Setting(), 500.0, 1000.0), "Came to rest, as the map says."),
        (released(0.01, 0.002), TrialConditions(Setting(), 500.0, 1000.0), "Dies away, as the map says."),
        (released(0.003, 0.02), TrialConditions(Setting(), 500.0, 1000.0), "Grew, the map says otherwise."),
        (
            released(0.01, 1e-6),
            TrialConditions(Setting(controller=True), 1800.0, 1000.0),
            "Came to rest, with the passivity controller.",
        ),
        (released(0.003, 0.02), TrialConditions(Setting(), 500.0, math.nan), "Grew."),
        (
            released(0.003, 0.02),
            replace(ABOVE, centre=Centre(0.0, 0.0, returns=False)),
            "A wall pushes the handle out, and nothing brings it back. Choose Spring to see it grow, or come "
            "to rest.",
        ),
        (Released(np.empty(0), np.empty(0), np.empty(0)), ABOVE, ""),
    ],
)
def test_what_happened_in_words(seen, held, said):
    assert outcome_words(seen, held) == said


def test_the_force_limit_is_named_where_it_holds_the_handle():
    held = TrialConditions(Setting(), 1800.0, 1000.0, 3.0)
    said = outcome_words(released(0.002, 0.002, 3.4), held)
    assert said == "Did not come to rest: the force limit of 3.0 N holds it at ±2.0 mm."
    assert outcome_words(released(0.002, 0.002, 2.9), held) == "Did not come to rest: still ±2.0 mm."
    assert "Now the force limit of 3.0 N holds it" in outcome_words(released(0.002, 0.008, 3.4), held)


def test_where_springs_are_stable_again_the_verdict_and_the_map_s_reading_say_so():
    """A handle of 0.044 kg and 0.5 N·s/m behind 5 Hz of second order."""
    slow = Setting(estimator=("butterworth", {"cutoff": 5.0}))
    found = plane(slow, 80.0, 2.25, width=4.0, top=1000.0)
    low, high = found.margin.again[0]
    said = verdict(replace(found, said=of_spring(slow, 80.0, 2.25)))
    assert said.more.endswith(f"Stable again from {low:,.0f} to {high:,.0f} N/m.")
    inside = verdict(replace(found, said=of_spring(slow, 0.5 * (low + high), 2.25)))
    assert f"Let go: calm, stable again from {low:,.0f} to {high:,.0f} N/m." in inside.lines[0][0]
    here = reading(Lines(LinesQuestion(slow, 0.0, 0.0), found), 2.25, 0.5 * (low + high))
    assert "Stable from" in here[1]


def judged(stiffness, damping, controller=False, measured=None):
    """Return the verdict on a spring."""
    setting = Setting(controller=controller)
    found = plane(setting, stiffness, damping, columns=2)
    return verdict(replace(found, said=of_spring(setting, stiffness, damping)), measured)


def test_the_column_says_what_the_handle_does_and_what_was_measured_there():
    said = judged(2000.0, 0.0)
    assert (said.headline, said.sign) == ("Buzzes when let go", ("triangle", "warn"))
    assert said.lines == (("Let go: settles below 1.2 mm, buzzes above.", "triangle", "warn"),)
    assert said.more.startswith("Let go ±2.3 mm at 30 Hz, at the motor's limit.")
    said = judged(900.0, 2.0, measured=made_up(Setting(), real=True))
    assert said.headline == "Calm"
    assert said.more == "Measured with friction: comes to rest."
    said = judged(900.0, 2.0, controller=True, measured=made_up(Setting(controller=True)))
    assert "leave the passivity controller out" in said.more
    assert said.more.endswith("Measured of an ideal handle: comes to rest.")


def test_a_class_is_that_of_its_cell_and_none_is_told_beyond_the_axes():
    measured = made_up(Setting())
    for row, stiffness in enumerate(measured.cells.stiffness):
        for column, damping in enumerate(measured.cells.damping):
            assert kind_at(measured, damping, stiffness) == measured.cells.classes[row, column]
    assert kind_at(measured, 12.0, 2000.0) == measured.cells.classes[-1, -1]
    assert kind_at(measured, 12.1, 500.0) is None
    assert kind_at(measured, 2.0, 2001.0) is None


def test_it_is_said_below_the_button_and_forgotten_when_something_changes(window, qtbot):
    window.studio.choose("spring")
    window.studio.set_values({"stiffness": 1800.0, "damping": 0.0})
    window.views.show("stability")
    page = window.views.page("stability")
    limit = follow(page, qtbot).hands["released"]
    assert (page.trial_conditions.stiffness, page.trial_conditions.limit) == (1800.0, limit)
    page.trial._held = page.trial_conditions
    seen = np.zeros((1500, rows.ROW_WIDTH))
    seen[:, rows.HOST_TIME] = 1e6 + np.arange(1500) * 1e-3
    seen[:, rows.POSITION] = 0.004 * 0.99 ** np.arange(1500)
    seen[:, rows.TICK] = np.arange(1500)
    page.trial._since = float(seen[0, rows.HOST_TIME])
    window.live.history.clear()
    window.live.history.append(seen)
    page.trial.judge()
    assert page.side.outcome.text().startswith("Came to rest: friction")
    assert not page.side.outcome.isHidden()
    window.studio.set_value("stiffness", 900.0)
    assert page.side.outcome.isHidden()
