"""What every failure must show: it holds inside its limit, fails outside, charts, is felt; the command."""

import json

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.analysis.failures import failures, named
from hapkit_studio.analysis.failures.base import MEASURED, OTHER, THEORY, show
from hapkit_studio.cli import main
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.studio import LoopChoice
from hapkit_studio.haptics.settings import LoopSettings

KEYS = list(failures())
FELT = [key for key in KEYS if failures()[key].live]
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
        time, trace = found.trace
        assert len(time) == len(trace) > 4
        assert np.isfinite(trace).all()
        assert np.all(np.diff(time) > 0.0)
        assert found.words
        assert "\n" not in found.words


@pytest.mark.parametrize("key", KEYS)
def test_its_chart_has_a_boundary_and_measures_what_theory_says(key):
    """Within 6 % of the theory's range."""
    told, failure = [], failures()[key]
    chart = failure.curve(failure.case(), lambda done, of: told.append((done, of)))
    assert told == [(k, told[-1][1]) for k in range(1, told[-1][1] + 1)]
    assert any(line.role == MEASURED for line in chart.lines)
    for line in chart.lines:
        assert line.role in (THEORY, MEASURED, OTHER)
        assert line.x.shape == line.y.shape
        assert np.isfinite(line.y).sum() >= 0.4 * len(line.y)
    low, high = min(line.x.min() for line in chart.lines), max(line.x.max() for line in chart.lines)
    assert low <= next(iter(chart.marks.values())) <= high
    if chart.plot.log_y:
        assert all(np.all(line.y[np.isfinite(line.y)] > 0.0) for line in chart.lines)

    theory = [line for line in chart.lines if line.role == THEORY]
    if not theory:
        assert key in ("chatter", "limit_cycle", "bounce")
        return
    (points,) = (line for line in chart.lines if line.role == MEASURED)
    seen = np.isfinite(points.y)
    order = np.argsort(theory[0].x)
    want = np.interp(points.x[seen], theory[0].x[order], theory[0].y[order])
    assert np.abs(points.y[seen] - want).max() <= 0.06 * np.ptp(theory[0].y)


def assert_can_be_set(failure, tried):
    """Check that the window takes what is felt live in each (options, knob's value)."""
    for options, value in tried:
        live = failure.live(value, failure.case(options))
        assert environments.named(live.environment).values(live.values)
        choice = LoopChoice(**live.loop)
        LoopSettings().changed(choice.rate, choice.delay, choice.spec)
        assert GRIPS[live.grip] is not None
        assert live.advice


@pytest.mark.parametrize("key", FELT)
def test_what_is_felt_live_can_be_set_by_a_person(key):
    failure = failures()[key]
    assert_can_be_set(failure, [({}, failure.knob.low), ({}, failure.knob.high)])


@pytest.mark.slow
@pytest.mark.parametrize("key", FELT)
def test_so_it_can_under_every_condition(key):
    failure = failures()[key]
    ends = [{p.key: end} for p in failure.options for end in (p.low, p.high)]
    assert_can_be_set(failure, [(options, failure.knob.high) for options in ends])


@pytest.mark.parametrize("key", KEYS)
def test_its_knob_is_bounded(key):
    failure = failures()[key]
    assert failure.knob.low <= failure.inside(failure.case()) < failure.outside(failure.case())
    assert failure.outside(failure.case()) <= failure.knob.high
    with pytest.raises(ParameterError, match=f"{failure.knob.label} goes from"):
        failure.try_at(2.0 * failure.knob.high)
    with pytest.raises(ParameterError, match="has no parameter 'nothing'"):
        failure.try_at(failure.knob.default, {"nothing": 1.0})


@pytest.mark.slow
def test_without_a_key_it_is_a_table_of_all(capsys):
    assert main(("break-it",)) == 0
    out, err = capsys.readouterr()
    assert err == ""
    for key, failure in failures().items():
        assert f"{key:<18}{failure.title}" in out
    assert out.count("inside  holds") == out.count("outside fails") == len(failures())


def test_one_failure_in_words_with_its_options_another_try_and_a_picture(capsys, tmp_path):
    path = tmp_path / "broken.png"
    words = ("break-it", "course", "-p", "method=explicit_euler", "--at", "0.001", "--plot", str(path))
    assert main(words) == 0
    out = capsys.readouterr().out
    assert "limit: step 0.7692 ms" in out
    assert "1 ms fails: grows by 0.075 1/s" in out
    assert f"wrote {path}" in out
    assert path.read_bytes()[:4] == b"\x89PNG"


def test_one_object_has_both_sides_of_the_limit(capsys):
    assert main(("break-it", "sampled_spring", "-p", "mass=0.05", "-p", "rate=1000", "--json")) == 0
    (row,) = json.loads(capsys.readouterr().out)["failures"]
    assert row["limit"] == pytest.approx(1001.67, abs=0.01)
    assert (row["knob"], row["knob_unit"]) == ("stiffness", "N/m")
    assert row["inside"]["value"] == pytest.approx(0.99 * row["limit"])
    assert (row["inside"]["holds"], row["outside"]["holds"], row["as_theory_says"]) == (True, False, True)
    assert row["inside"]["measure"] < 0.0 < row["outside"]["measure"]
    assert row["options"] == {"mass": 0.05, "viscous": 0.5, "damping": 0.0, "rate": 1000.0, "delay": 0.0}
