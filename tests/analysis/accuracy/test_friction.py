"""Friction models: periods and drifts of theory's tables, through the chart's own trials."""

import pytest

from hapkit_studio.analysis.accuracy import friction
from hapkit_studio.environments.friction import MODELS as RENDERED

# error of the period in % at 1 ms and 0.2 ms; None: no stick-slip of that kind
PERIODS = {
    "coulomb": (None, None),
    "smoothed": (5.8, 5.2),
    "karnopp": (0.1, 0.0),
    "karnopp_band": (0.0, 0.0),
    "projection": (0.1, 0.0),
    "tether": (0.9, 0.6),
    "lugre": (30.0, 31.0),
    "hayward_armstrong": (1.0, 61.0),
}


@pytest.mark.parametrize("model", PERIODS)
def test_the_period_of_each_model(model):
    for dt, wanted in zip((1e-3, 0.2e-3), PERIODS[model], strict=True):
        found = 100.0 * friction.trial_error(model, dt, held=False)
        assert found > 55.0 if wanted is None else found == pytest.approx(wanted, abs=0.7)


@pytest.mark.parametrize("model", ["karnopp", "karnopp_band", "stribeck", "projection"])
def test_what_knows_rest_never_drifts(model):
    assert [friction.trial_error(model, dt, held=True) for dt in friction.STEPS] == [0.0] * len(
        friction.STEPS
    )


def test_the_drift_of_what_does_not_in_micrometres_per_second():
    for model, low, high in (("lugre", 423.0, 441.0), ("smoothed", 3100.0, 3230.0), ("tether", 0.0, 0.1)):
        assert low <= 1e6 * friction.trial_error(model, 0.1e-3, held=True) <= high


def test_the_sign_of_the_velocity_creeps_by_half_a_steps_braking_at_most():
    """A step takes F_c T / m; the mean of two is no rest."""
    for dt in friction.STEPS:
        assert (
            0.0 < friction.trial_error("coulomb", dt, held=True) <= 0.5 * 0.95 * dt / 0.05 + 0.25 * dt / 0.05
        )


def test_on_a_handle_only_what_holds_on_to_an_anchor_holds():
    drift = {model: friction.handle_drift(model, 1e-3) for model in RENDERED}
    assert {model for model, error in drift.items() if error < 1e-5} == {"tether", "projection"}
    assert min(drift["coulomb"], drift["smoothed"]) > 1e-3
