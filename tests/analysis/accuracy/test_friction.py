"""Friction models: periods and drifts of theory's tables, through the chart's own trials."""

import pytest

from hapkit_studio.analysis.accuracy import friction
from hapkit_studio.environments.friction import MODELS as RENDERED


def test_the_period_is_as_far_off_as_the_models_own_tests_say():
    """In % at 1 ms and 0.2 ms."""
    for model, errors in {"projection": (0.1, 0.0), "lugre": (30.0, 31.0), "smoothed": (5.8, 5.2)}.items():
        found = [100.0 * friction.period_error(model, dt) for dt in (1e-3, 0.2e-3)]
        assert found == pytest.approx(errors, abs=0.7)
    assert friction.period_error("coulomb", 1e-3) > 0.55


def test_on_a_handle_only_what_holds_on_to_an_anchor_holds():
    drift = {model: friction.handle_drift(model, 1e-3) for model in RENDERED}
    assert {model for model, error in drift.items() if error < 1e-5} == {"tether", "projection"}
    assert min(drift["coulomb"], drift["smoothed"]) > 1e-3
