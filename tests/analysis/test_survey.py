"""Each point of a survey is the exact limit of its loop; results survive any interruption."""

import itertools
import json
import math
import os
import signal
import sqlite3
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import closing
from multiprocessing import get_context

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.analysis import survey
from hapkit_studio.analysis.survey import Axes, SurveyError
from hapkit_studio.charts.survey import survey_figure
from hapkit_studio.cli import main
from hapkit_studio.commands import base
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import StudioError
from tests.analysis.sweep_tasks import Serial

HELD = 0.05, 4.0, 200.0
AXES = Axes(("difference", "kalman"), (500.0, 2000.0), (0.0, 1e-3), ((0.0, 0.0, 0.0), HELD), (0.0, 1.5, 4.0))


class Stops(Executor):
    """An executor that computes some chunks, then stops like a killed program."""

    def __init__(self, chunks: int):
        self.left, self.serial = chunks, Serial()

    def submit(self, fn, /, *args, **kwargs):
        self.left -= 1
        if self.left >= 0:
            return self.serial.submit(fn, *args, **kwargs)
        lost: Future = Future()
        lost.cancel()
        lost.set_running_or_notify_cancel()
        return lost


def test_each_point_is_the_limit_of_its_loop_and_hand(tmp_path):
    path = tmp_path / "limits.survey"
    assert survey.compute(path, AXES, Serial()) == 16
    axes, limits = survey.read(path)
    assert axes == AXES
    usual = LoopSettings()
    places = (enumerate(values) for values in (AXES.estimators, AXES.rates, AXES.delays, AXES.damping))
    for (e, estimator), (r, rate), (d, delay), (b, damping) in itertools.product(*places):
        for h, hand in enumerate((None, "medium")):
            wanted = hs.stiffness_limit(
                usual.mass, usual.viscous, damping=damping, rate=rate, delay=delay, estimator=estimator,
                hand=hand, quantum=usual.quantum,
            )  # fmt: skip
            assert limits[e, r, d, h, b] == pytest.approx(wanted, rel=1e-6)


def test_an_interrupted_survey_resumes_without_recomputing(tmp_path, monkeypatch):
    path, computed = tmp_path / "limits.survey", []
    rows = Axes.limits
    monkeypatch.setattr(Axes, "limits", lambda axes, row: computed.append(row) or rows(axes, row))
    with pytest.raises(
        StudioError,
        match=r"A part of the work was lost: .* kept in limits\.survey. Run the same command again\.",
    ):
        survey.compute(path, AXES, Stops(2))
    there = len(computed)
    assert 0 < there < 16
    _, partial = survey.read(path)
    assert survey.known(partial) == 3 * there
    reports = []
    assert survey.compute(path, AXES, Serial(), lambda done, of: reports.append((done, of))) == 16 - there
    assert (reports[0], reports[-1]) == ((there, 16), (16, 16))
    assert sorted(computed) == list(range(16))
    assert survey.compute(path, AXES, Serial()) == 0


@pytest.mark.slow
def test_a_killed_worker_loses_only_its_chunks(tmp_path):
    path, axes = tmp_path / "limits.survey", survey.usual_axes(2, 2)
    killed = []
    with ProcessPoolExecutor(2, get_context("spawn")) as programs:

        def kill(done, _of):
            if done and not killed:
                killed.append(next(iter(programs._processes)))
                os.kill(killed[0], signal.SIGKILL)

        with pytest.raises(StudioError, match="a worker was killed"):
            survey.compute(path, axes, programs, kill)
    _, before = survey.read(path)
    assert 0 < survey.known(before) < before.size
    survey.compute(path, axes, Serial())
    _, after = survey.read(path)
    assert survey.known(after) == after.size
    there = ~np.isnan(before)
    np.testing.assert_array_equal(after[there], before[there])


def test_other_surveys_and_foreign_files_give_a_one_line_error(tmp_path):
    path = tmp_path / "limits.survey"
    survey.compute(path, AXES, Serial())
    before = path.read_bytes()
    with pytest.raises(
        SurveyError, match=r"contains 2 estimators × 2 rates × 2 delays × 2 hands × 3 dampings"
    ):
        survey.compute(path, survey.usual_axes(3, 2), Serial())
    assert path.read_bytes() == before
    for name, content in (
        ("foreign", b"not a database " * 90),
        ("cut", before[:5000]),
        ("mixed", before[::-1]),
    ):
        path = tmp_path / name
        path.write_bytes(content)
        with pytest.raises(SurveyError, match=f"^{name} .*$") as error:
            survey.compute(path, AXES, Serial())
        assert "\n" not in str(error.value)
        assert path.read_bytes() == content
    good, bad = np.ones(3, "<f4").tobytes(), np.array([1.0, math.nan, 1.0], "<f4").tobytes()
    for number, blob in ((3, b"12345678"), (3, None), (3, "text"), (3, bad), (16, good), (-5, good)):
        damaged = tmp_path / f"damaged{number}"
        damaged.write_bytes(before)
        with sqlite3.connect(damaged) as database:
            database.execute("INSERT OR REPLACE INTO limits VALUES (?, ?)", (number, blob))
        for use in (survey.read, lambda path: survey.compute(path, AXES, Serial())):
            with pytest.raises(SurveyError, match=f"its row {number} is damaged; there are rows 0 to 15"):
                use(damaged)
        damaged.unlink()
    with sqlite3.connect(tmp_path / "other.db") as other:
        other.execute("CREATE TABLE limits (a)")
    with pytest.raises(SurveyError, match=r"^other.db is not a survey\.$"):
        survey.read(tmp_path / "other.db")
    with pytest.raises(SurveyError, match="There is no survey"):
        survey.read(tmp_path / "none")


WRONG_AXES = {
    "no list": 5,
    "four lists": [["kalman"], [1.0], [0.0], [[0, 0, 0]]],
    "empty": [[], [1.0], [0.0], [[0, 0, 0]], [0.0]],
    "unknown estimator": [["kalmann"], [1.0], [0.0], [[0, 0, 0]], [0.0]],
    "number as estimator": [[1], [1.0], [0.0], [[0, 0, 0]], [0.0]],
    "text as rate": [["kalman"], ["1000"], [0.0], [[0, 0, 0]], [0.0]],
    "rate 0": [["kalman"], [0.0], [0.0], [[0, 0, 0]], [0.0]],
    "infinite delay": [["kalman"], [1.0], [1e999], [[0, 0, 0]], [0.0]],
    "hand of two numbers": [["kalman"], [1.0], [0.0], [[0, 0]], [0.0]],
    "true as damping": [["kalman"], [1.0], [0.0], [[0, 0, 0]], [True]],
    "too many loops": [["kalman"], [1.0] * 1000, [0.0] * 1000, [[0, 0, 0]] * 1000, [0.0]],
}


@pytest.mark.parametrize("given", WRONG_AXES.values(), ids=WRONG_AXES)
def test_axes_in_a_file_are_checked_value_by_value(tmp_path, given, capsys):
    path = tmp_path / "x.survey"
    survey.compute(path, AXES, Serial())
    with closing(sqlite3.connect(path)) as database, database:
        database.execute("UPDATE about SET axes = ?", (json.dumps(given),))
    before = path.read_bytes()
    assert main(["survey", str(path), "--read"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("hapkit-studio: ")
    assert error.count("\n") == 1
    assert path.read_bytes() == before


def test_a_file_with_other_tables_is_not_a_survey(tmp_path):
    """A view in place of a table is refused, because its query could run for ever."""
    path = tmp_path / "x.survey"
    survey.compute(path, AXES, Serial())
    with closing(sqlite3.connect(path)) as database, database:
        database.execute("DROP TABLE limits")
        endless = "WITH RECURSIVE n(row) AS (SELECT 1 UNION ALL SELECT row + 1 FROM n)"
        database.execute(f"CREATE VIEW limits AS {endless} SELECT row, NULL AS limits FROM n")
    with pytest.raises(SurveyError, match=r"^x\.survey is not a survey\.$"):
        survey.read(path)


def test_more_loops_than_fit_into_memory_are_refused(tmp_path):
    with pytest.raises(SurveyError, match="at most 67,108,864 control loops"):
        survey.compute(tmp_path / "x.survey", survey.usual_axes(1000, 1000), Serial())


@pytest.mark.slow
def test_the_command_resumes_draws_and_reads(tmp_path, capsys):
    path, picture = tmp_path / "limits.survey", tmp_path / "limits.png"
    with pytest.raises(StudioError):
        survey.compute(path, survey.usual_axes(2, 1), Stops(1))
    survey_figure(survey.read(path), picture)  # the survey is drawn while it is unfinished
    assert picture.read_bytes()[:4] == b"\x89PNG"
    assert main(["survey", str(path), "--read"]) == 0
    assert "25 of 4,000 loops known" in capsys.readouterr().out
    args = ["survey", str(path), "--rates", "2", "--delays", "1", "--workers", "2", "--plot", str(picture)]
    assert main(args) == 0
    assert "4,000 of 4,000 loops known. 3,975 computed in " in capsys.readouterr().out
    assert main(["survey", str(path), "--rates", "0"]) != 0
    assert "must be a whole number, 1 or more" in capsys.readouterr().err


def test_the_remaining_time_ignores_earlier_results(monkeypatch, capsys):
    """600 of 1,000 results existed, and 100 took 10 s, so the last 300 take 30 s."""
    now = itertools.chain([0.0, 0.0, 10.0]).__next__
    monkeypatch.setattr(base.time, "monotonic", now)
    monkeypatch.setattr(base.sys.stderr, "isatty", lambda: True, raising=False)
    show = base.progress_line("rows")
    show(600, 1000)
    show(700, 1000)
    assert capsys.readouterr().err.strip() == f"rows: {'█' * 14}{'░' * 6} 700 of 1,000, 30 s left"


@pytest.mark.parametrize(("seconds", "text"), [(89.0, "89 s"), (91.0, "1.5 min"), (5401.0, "1.5 h")])
def test_durations_have_a_suitable_unit(seconds, text):
    assert base.span(seconds) == text
