"""Letting go on the stability page: how far the trial goes, and what is said of what it showed."""

import math

import numpy as np
import pytest

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.environments import discover
from hapkit_studio.gui.pages.stability.trial import (
    MOST,
    USUAL,
    Released,
    TrialConditions,
    grows_from,
    kept_share,
    one_sided,
    outcome_words,
    starting_distance,
)
from hapkit_studio.haptics import rows
from tests.gui.pages.stability_support import follow

# Without virtual damping the linear limit is 2 b / T but for a thousandth.
ABOVE = TrialConditions(Setting(), 1800.0, 1000.0)


@pytest.mark.parametrize(
    ("stiffness", "viscous", "coulomb", "amplitude"),
    [(2000, 0.5, 0.2, 2.546), (2000, 0.8, 0.2, 6.366), (4000, 1.0, 0.5, 2.251), (1000, 0.2, 0.1, 3.001)],
)
def test_friction_holds_what_starts_smaller(stiffness, viscous, coulomb, amplitude):
    """The amplitudes in mm are those of the energy balance, and within 2 % those of simulation."""
    setting = Setting(mass=0.05, viscous=viscous, coulomb=coulomb)
    held = TrialConditions(setting, stiffness, 2.0 * viscous / 1e-3)
    assert 1e3 * grows_from(held) == pytest.approx(amplitude, rel=0.01)


def test_without_friction_everything_grows_beyond_the_limit_and_nothing_below():
    assert grows_from(TrialConditions(Setting(coulomb=0.0), 1010.0, 1000.0)) == 0.0
    assert grows_from(TrialConditions(Setting(coulomb=0.0), 990.0, 1000.0)) == math.inf
    assert grows_from(TrialConditions(Setting(), 990.0, math.nan)) == math.inf


@pytest.mark.parametrize("ratio", [0.2, 0.5, 0.9])
def test_a_clamped_spring_keeps_a_share_of_its_stiffness(ratio):
    angle = np.linspace(0.0, 2.0 * np.pi, 200_001)[:-1]
    clipped = np.clip(np.sin(angle), -ratio, ratio)
    assert kept_share(ratio) == pytest.approx(2.0 * np.mean(clipped * np.sin(angle)), rel=1e-4)
    assert kept_share(1.3) == 1.0


def test_the_trial_begins_beyond_what_friction_holds():
    assert starting_distance(ABOVE) > 1.5 * grows_from(ABOVE)
    assert starting_distance(TrialConditions(Setting(coulomb=5.0), 1100.0, 1000.0)) == MOST
    assert (
        starting_distance(TrialConditions(Setting(), 500.0, 1000.0))
        == starting_distance(TrialConditions(Setting(), 500.0, math.nan))
        == USUAL
    )


def released(begin, end, force=0.0, one=False):
    """Return a swing of 10 Hz whose amplitude goes from begin to end in m over 1.5 s."""
    time = np.arange(1500) * 1e-3
    size = begin * (end / begin) ** (time / 1.5)
    return Released(time, size * np.sin(20.0 * np.pi * time), np.full(1500, force), one)


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


def test_a_wall_throws_the_handle_out():
    wall, spring, free = (discover()[key] for key in ("wall", "spring", "free"))
    assert one_sided(wall, wall.values({}))
    assert not one_sided(spring, spring.values({}))
    assert not one_sided(free, free.values({}))
    assert outcome_words(released(0.003, 0.02, one=True), ABOVE).startswith("A wall pushes the handle out")


def test_it_is_said_below_the_button_and_forgotten_when_something_changes(window, qtbot):
    window.studio.choose("spring")
    qtbot.waitUntil(lambda: window.studio.environment.key == "spring")
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
