"""A student's progress is evaluated on rows and stored in a file; edits of the file do not count."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio.analysis import pointing
from hapkit_studio.analysis.pointing import Subject
from hapkit_studio.haptics import rows
from hapkit_studio.lessons import experiments, library
from hapkit_studio.lessons.grade import grade_file
from hapkit_studio.lessons.hand_in import read
from hapkit_studio.lessons.lesson import Check
from hapkit_studio.lessons.play import play_lesson
from hapkit_studio.lessons.progress import Evaluated, Progress, evaluate_rows, load
from hapkit_studio.lessons.recent import Rows
from hapkit_studio.sessions.file import SessionError

ABOUT = {"device": "Simulated Hapkit", "quantum_m": 20.7e-6}
NOTHING = Rows((), ())


def rows_of(played, shift=0.0):
    """Return the rows of a step done by a scripted student; their times are increased by ``shift`` s."""
    tables = [table + shift * np.eye(1, rows.ROW_WIDTH, rows.HOST_TIME) for table in played.tables]
    starts = [float(table[0, rows.HOST_TIME]) for table in tables]
    return Rows(
        tuple(tables),
        tuple((start, ABOUT, dict(s)) for start, s in zip(starts, played.settings, strict=True)),
    )


def checks_of(number, step):
    return [(number, check) for check in step.checks]


@pytest.fixture(scope="module")
def lesson():
    return library().lessons["virtual_spring"]


@pytest.fixture(scope="module")
def played(lesson):
    return play_lesson(lesson)


def complete(lesson, played, steps=None):
    """Return the progress of a student who has done the first ``steps`` steps, by default all of them."""
    found = Progress(lesson)
    for number, (step, one) in enumerate(played[:steps], 1):
        found.answers |= one.answers
        for key, result in evaluate_rows(checks_of(number, step), rows_of(one, 1e4), {}).items():
            found.note(key, result)
    return found


def test_all_tasks_are_done_by_a_student_who_does_everything(lesson, played):
    tasks = len(list(lesson.tasks()))
    found = complete(lesson, played)
    assert found.counts == (tasks, tasks)
    assert all(found.step_done(at) for at in range(len(lesson.steps)))
    assert complete(lesson, played, 1).step_done(0)
    assert not complete(lesson, played, 1).step_done(1)


def test_an_interval_is_that_of_its_rows(lesson, played):
    """The rows' clock started long before the step, and the interval's ends are times of this clock."""
    step, one = played[0]
    given = rows_of(one, 1e4)
    (found,) = evaluate_rows(checks_of(1, step), given, {}).values()
    table = given.table
    inside = (table[:, rows.HOST_TIME] >= found.start) & (table[:, rows.HOST_TIME] <= found.stop)
    assert found.part.step == 1
    np.testing.assert_array_equal(found.part.table, table[inside])
    assert found.stop - found.start == pytest.approx(found.result.stop - found.result.start, abs=1e-6)


def test_a_file_restores_everything_and_is_graded_as_correct(tmp_path, lesson, played):
    path = tmp_path / "lesson.hapkit"
    before = complete(lesson, played)
    before.step = 2
    before.save(path, "Ada", NOTHING)
    after = load(path, lesson, {})
    assert (after.step, after.answers, after.counts) == (2, before.answers, before.counts)
    assert {row.state for row in grade_file(path, {lesson.key: lesson})} <= {"correct", "review"}
    after.save(
        path, "Ada", NOTHING
    )  # the computer was restarted, so the loaded rows have times of another clock
    assert load(path, lesson, {}).counts == before.counts
    assert [p.name for p in tmp_path.iterdir()] == ["lesson.hapkit"]


def test_an_open_step_without_an_interval_keeps_its_answers(tmp_path, lesson, played):
    """The student answered questions only; the file contains the newest second, which passes no check."""
    path = tmp_path / "lesson.hapkit"
    _, one = played[-1]
    found = Progress(lesson, step=len(played) - 1, answers=dict(one.answers))
    found.save(path, "", rows_of(played[0][1]))
    after = load(path, lesson, {})
    assert after.answers == found.answers
    assert not any(one.result.correct for one in after.evaluated.values())
    assert read(path).samples.time[-1] == pytest.approx(1.0, abs=0.01)


def test_a_step_that_was_not_opened_does_not_pass_with_the_rows_of_another(tmp_path, lesson, played):
    path = tmp_path / "lesson.hapkit"
    complete(lesson, played, 1).save(path, "", NOTHING)
    graded = {row.task.split()[0]: row for row in grade_file(path, {lesson.key: lesson})}
    later = [task.key for number, _, task in lesson.tasks() if number > 1 and isinstance(task, Check)]
    assert later
    assert all(graded[key].state == "missing" for key in later)
    assert graded[later[0]].reason == "Nothing was recorded in this step."


def test_without_a_single_sample_nothing_is_written(tmp_path, lesson):
    path = tmp_path / "lesson.hapkit"
    with pytest.raises(SessionError, match="There is nothing to save yet"):
        Progress(lesson, answers={"1.2": "x"}).save(path, "", NOTHING)
    assert not list(tmp_path.iterdir())


def test_a_passed_check_stays_passed_and_a_later_pass_takes_its_place(lesson, played):
    step, one = played[0]
    ((key, passed),) = evaluate_rows(checks_of(1, step), rows_of(one), {}).items()
    found = Progress(lesson)
    assert found.note(key, passed)
    wrong = Evaluated(replace(passed.result, state="wrong", text="too high"))
    assert not found.note(key, wrong)
    assert found.evaluated[key] is passed
    later = Evaluated(replace(passed.result, text="301 N/m"), passed.part, 5.0, 6.0)
    assert found.note(key, later)
    assert found.evaluated[key].start == 5.0


def test_without_rows_there_is_no_interval(lesson, played):
    step, _ = played[0]
    (found,) = evaluate_rows(checks_of(1, step), NOTHING, {}).values()
    assert (found.result.state, found.part) == ("waiting", None)
    assert math.isnan(found.start)


def test_an_experiments_trials_are_handed_in_with_the_answers(tmp_path, lesson, played):
    """A recording is copied unchanged. It is refused if it has no trials, is given twice, or is missing."""
    recording, other, path = (tmp_path / f"{name}.hapkit" for name in ("trials", "other", "lesson"))
    targets = pointing.plan(rounds=2, seed=3)[:6]
    trials = experiments.save_pointing(recording, Subject(), targets, seed=1)
    complete(lesson, played, 1).save(other, "", NOTHING)
    before = complete(lesson, played)
    before.save(path, "Ada", NOTHING, [recording, other, recording, tmp_path / "gone.hapkit"])
    found = read(path)
    assert list(found.experiments.trials) == trials
    assert found.experiments.remarks == ()
    assert found.lesson == lesson.key
    assert {row.state for row in grade_file(path, {lesson.key: lesson})} <= {"correct", "review"}
    assert load(path, lesson, {}).counts == before.counts
