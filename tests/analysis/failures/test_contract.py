"""Every demonstration of a failure works inside its limit, fails outside, has charts, and can be felt."""

import json

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.analysis.failures import failures, named
from hapkit_studio.analysis.failures.base import MEASURED, OTHER, THEORY, show
from hapkit_studio.cli import main
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import ParameterError

KEYS = list(failures())


def test_the_library_is_discovered_in_order():
    assert len(KEYS) == 15
    assert [f.order for f in failures().values()] == sorted(f.order for f in failures().values())
    blurred = {key: f.margin for key, f in failures().items() if f.margin != 0.01}
    assert blurred == {"chatter": 0.4, "bounce": 0.2}  # these two limits are blurred; all others are sharp
    with pytest.raises(ParameterError, match="There is no failure 'spring'; available: sampled_spring"):
        named("spring")


@pytest.mark.slow
@pytest.mark.parametrize("key", KEYS)
def test_it_works_inside_fails_outside_and_agrees_with_theory(key):
    """The limit agrees with theory to within 6 % of the range of the theory's values."""
    reports, failure = [], failures()[key]
    shown = show(failure, progress=lambda done, of: reports.append((done, of)))
    assert shown.as_theory_says
    assert failure.knob.low <= shown.inside.value < shown.limit < shown.outside.value <= failure.knob.high
    for one in (shown.inside, shown.outside):
        time, trace = one.evidence.trace
        assert len(time) == len(trace) > 4
        assert np.isfinite(trace).all()
        assert np.all(np.diff(time) > 0.0)
        assert one.evidence.text
        assert "\n" not in one.evidence.text
    chart = shown.chart
    assert reports == [(k, reports[-1][1]) for k in range(1, reports[-1][1] + 1)]
    for line in chart.lines:
        assert line.role in (THEORY, MEASURED, OTHER)
        assert line.x.shape == line.y.shape
        assert np.isfinite(line.y).sum() >= 0.4 * len(line.y)
        assert not chart.plot.log_y or np.all(line.y[np.isfinite(line.y)] > 0.0)
    low, high = min(line.x.min() for line in chart.lines), max(line.x.max() for line in chart.lines)
    assert low <= next(iter(chart.marks.values())) <= high

    theory = [line for line in chart.lines if line.role == THEORY]
    points, *more = (line for line in chart.lines if line.role == MEASURED)
    if not theory:
        assert key in ("chatter", "limit_cycle", "bounce")
        return
    assert not more
    seen = np.isfinite(points.y)
    order = np.argsort(theory[0].x)
    want = np.interp(points.x[seen], theory[0].x[order], theory[0].y[order])
    assert np.abs(points.y[seen] - want).max() <= 0.06 * np.ptp(theory[0].y)


@pytest.mark.parametrize("ends", ["knob", pytest.param("options", marks=pytest.mark.slow)])
@pytest.mark.parametrize("key", [key for key in KEYS if failures()[key].live])
def test_the_live_settings_are_within_a_users_limits(key, ends):
    failure = failures()[key]
    tried = [({}, failure.knob.low), ({}, failure.knob.high)]
    if ends == "options":
        tried = [({p.key: end}, failure.knob.high) for p in failure.options for end in (p.low, p.high)]
    for options, value in tried:
        live = failure.live(value, failure.case(options))
        assert environments.named(live.environment).values(live.values)
        LoopSettings().changed(**live.loop)
        assert GRIPS[live.grip] is not None
        assert live.advice


@pytest.mark.slow
def test_without_a_key_it_is_a_table_of_all(capsys):
    assert main(("break-it",)) == 0
    out, err = capsys.readouterr()
    assert err == ""
    for key, failure in failures().items():
        assert f"{key:<18}{failure.title}" in out
    assert out.count("inside  holds") == out.count("outside fails") == len(failures())


@pytest.mark.slow
def test_one_failure_is_printed_with_its_options_another_trial_and_a_picture(capsys, tmp_path):
    path = tmp_path / "broken.png"
    args = ("break-it", "course", "-p", "method=explicit_euler", "--at", "0.001", "--plot", str(path))
    assert main(args) == 0
    out = capsys.readouterr().out
    assert "limit: step 0.7692 ms" in out
    assert "1 ms fails: the motion grows at 0.075 1/s" in out
    assert f"wrote {path}" in out
    assert path.read_bytes()[:4] == b"\x89PNG"


def test_the_json_has_both_sides_of_the_limit(capsys):
    assert main(("break-it", "sampled_spring", "-p", "mass=0.05", "-p", "rate=1000", "--json")) == 0
    (row,) = json.loads(capsys.readouterr().out)["failures"]
    assert row["limit"] == pytest.approx(1001.67, abs=0.01)
    assert (row["knob"], row["knob_unit"]) == ("stiffness", "N/m")
    assert row["inside"]["value"] == pytest.approx(0.99 * row["limit"])
    assert (row["inside"]["holds"], row["outside"]["holds"], row["as_theory_says"]) == (True, False, True)
    assert row["inside"]["measure"] < 0.0 < row["outside"]["measure"]
    assert row["options"] == {"mass": 0.05, "viscous": 0.5, "damping": 0.0, "rate": 1000.0, "delay": 0.0}
