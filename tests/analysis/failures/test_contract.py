"""What every failure must show: it holds inside its limit, fails outside, charts, and can be felt live."""

from functools import cache

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.analysis.failures import failures, named
from hapkit_studio.analysis.failures.base import MEASURED, OTHER, THEORY, show
from hapkit_studio.analysis.sweeps import Cancelled
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.studio import LoopChoice
from hapkit_studio.haptics.settings_writer import LoopSettings

KEYS = list(failures())
# Of these the limit is sharp: a hundredth inside it they hold, a hundredth outside they fail.
SHARP = {
    "sampled_spring",
    "integrators",
    "course",
    "filters",
    "filtered_damping",
    "jitter",
    "limit_cycle",
    "texture_steepness",
    "texture_speed",
    "texture_samples",
    "texture_counts",
    "tunnelling",
}


def test_the_library_is_found_in_order():
    assert len(KEYS) == 15
    assert [f.order for f in failures().values()] == sorted(f.order for f in failures().values())
    assert {key for key in KEYS if failures()[key].margin == 0.01} == SHARP
    with pytest.raises(ParameterError, match="There is no failure 'spring'; there are: sampled_spring"):
        named("spring")


@pytest.mark.parametrize("key", KEYS)
def test_it_holds_inside_and_fails_outside(key):
    shown = show(failures()[key], chart=False)
    assert shown.as_theory_says
    assert shown.inside.value < shown.limit < shown.outside.value
    for one in (shown.inside, shown.outside):
        found = one.evidence
        assert len(found.time) == len(found.trace) > 4
        assert np.isfinite(found.trace).all()
        assert np.all(np.diff(found.time) > 0.0)
        assert found.words
        assert "\n" not in found.words


@cache
def charted(key):
    """Return a failure's chart, and how its progress was told."""
    told = []
    failure = failures()[key]
    return failure.curve(failure.case(), lambda done, of: told.append((done, of))), told


@pytest.mark.parametrize("key", KEYS)
def test_its_chart_has_measurement_boundary_and_words(key):
    chart, told = charted(key)
    assert told == [(k, told[-1][1]) for k in range(1, told[-1][1] + 1)]
    assert any(line.role == MEASURED for line in chart.lines)
    for line in chart.lines:
        assert line.role in (THEORY, MEASURED, OTHER)
        assert line.x.shape == line.y.shape
        assert np.isfinite(line.y).sum() >= 0.4 * len(line.y)
    low, high = min(line.x.min() for line in chart.lines), max(line.x.max() for line in chart.lines)
    assert low <= chart.marks[0].x <= high
    if chart.log_y:
        assert all(np.all(line.y[np.isfinite(line.y)] > 0.0) for line in chart.lines)


@pytest.mark.parametrize("key", KEYS)
def test_what_the_chart_measures_lies_on_its_theory(key):
    """Within 5 % of the theory's range: the points of one line, the curve of the other."""
    chart, _ = charted(key)
    theory = [line for line in chart.lines if line.role == THEORY]
    if not theory:
        assert key in ("chatter", "limit_cycle", "bounce")
        return
    (points,) = (line for line in chart.lines if line.role == MEASURED)
    seen = np.isfinite(points.y)
    order = np.argsort(theory[0].x)
    want = np.interp(points.x[seen], theory[0].x[order], theory[0].y[order])
    assert np.abs(points.y[seen] - want).max() <= 0.06 * np.ptp(theory[0].y)


@pytest.mark.parametrize("key", KEYS)
def test_a_chart_can_be_cancelled(key):
    def cancel(done, of):
        raise Cancelled("enough")

    with pytest.raises(Cancelled):
        failures()[key].curve(failures()[key].case(), cancel)


@pytest.mark.parametrize("key", KEYS)
def test_what_is_felt_live_can_be_set_by_a_person(key):
    failure = failures()[key]
    if failure.live is None:
        assert key in ("limit_cycle", "texture_counts")
        return
    extremes = [{}] + [{p.key: end} for p in failure.options for end in (p.low, p.high)]
    for case in map(failure.case, extremes):
        for value in (failure.knob.low, failure.knob.default, failure.knob.high):
            live = failure.live(value, case)
            assert environments.named(live.environment).values(live.values)
            wish = LoopChoice(**live.loop)
            LoopSettings().changed(wish.rate, wish.delay, wish.spec)
            assert live.grip in GRIPS
            assert live.advice


@pytest.mark.parametrize("key", KEYS)
def test_its_words_are_short_and_its_knob_is_bounded(key):
    failure = failures()[key]
    assert failure.title[0].isupper()
    assert not failure.title.endswith(".")
    assert len(failure.summary) <= 110
    assert 2 <= failure.explanation.count(". ") + 1 <= 6
    assert failure.knob.low <= failure.inside(failure.case()) < failure.outside(failure.case())
    assert failure.outside(failure.case()) <= failure.knob.high
    with pytest.raises(ParameterError, match=f"{failure.knob.label} goes from"):
        failure.try_at(2.0 * failure.knob.high)
    with pytest.raises(ParameterError, match="has no parameter 'nothing'"):
        failure.try_at(failure.knob.default, {"nothing": 1.0})
