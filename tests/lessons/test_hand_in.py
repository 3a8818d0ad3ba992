"""Handing in, reporting and grading evaluate answers again, and detect edits of a file."""

import csv
import html.parser
import io
import json
import re
import sqlite3
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio import environments, resources
from hapkit_studio.cli import main
from hapkit_studio.haptics import rows
from hapkit_studio.lessons import library
from hapkit_studio.lessons.grade import COLUMNS, as_csv, as_html, grade, grade_file
from hapkit_studio.lessons.hand_in import hand_in, read, save_played
from hapkit_studio.lessons.parse import read as read_lesson
from hapkit_studio.lessons.play import play_lesson, play_step
from hapkit_studio.lessons.report import report
from hapkit_studio.sessions.chunk import pack
from hapkit_studio.sessions.columns import encode
from hapkit_studio.sessions.file import SessionError, SessionWriter, checksum
from hapkit_studio.sessions.session import Session

KEY = "virtual_spring"
CHECKS = ("1.1", "2.2", "3.5")


@pytest.fixture(scope="module")
def lesson():
    return library().lessons[KEY]


@pytest.fixture(scope="module")
def played(lesson):
    return play_lesson(lesson)


@pytest.fixture
def handed(tmp_path, lesson, played):
    path = tmp_path / "ada.hapkit"
    save_played(path, lesson, played, "Ada L")
    return path


def edit_event(path, change, key):
    """Change an answer's JSON, and correct its checksum."""
    with closing(sqlite3.connect(path)) as database:
        for row, time, kind, what in database.execute("SELECT id, time, kind, what FROM event").fetchall():
            answer = json.loads(what)
            if kind == "answer" and answer["key"] == key:
                text = json.dumps(change(answer), ensure_ascii=False)
                values = (text, checksum((time, kind, text)), row)
                database.execute("UPDATE event SET what = ?, crc = ? WHERE id = ?", values)
        database.commit()


def edit_samples(path, factor=1.01):
    """Multiply every force of the law, and write a new file with correct checksums."""
    edited = path.with_name("edited.hapkit")
    with closing(Session(path)) as session, SessionWriter.whole(edited) as writer:
        for event in session.events:
            writer.note(event)
        for number in range(len(session.counts)):
            chunk = session.chunk(number)
            forces = {"force": encode(factor * chunk.values("force"))}
            writer.add(replace(chunk, columns={**chunk.columns, **forces}))
    edited.replace(path)


def states(path, lesson):
    return {row.task.split()[0]: row.state for row in grade_file(path, {lesson.key: lesson}) if row.task}


def test_a_handed_in_file_contains_lesson_student_answers_and_stamps(handed, lesson):
    found = read(handed)
    assert (found.lesson, found.student, found.stamp) == (KEY, "Ada L", lesson.stamp)
    assert set(found.answers) == {task.key for _, _, task in lesson.tasks()}
    assert all(len(found.answers[key].result.stamp) == 64 for key in CHECKS)
    assert found.damage == ()


def test_every_answer_is_confirmed_from_the_files_own_samples(handed, lesson):
    assert set(states(handed, lesson).values()) == {"correct"}


def test_each_check_is_evaluated_on_the_samples_of_its_own_step(tmp_path, lesson, played):
    """The third step's work would also pass the first check, but is not used for it."""
    path = tmp_path / "ada.hapkit"
    third = play_step(lesson.steps[0], begin=9.0)
    save_played(path, lesson, [*played[:2], (lesson.steps[2], third)], "Ada")
    found = read(path)
    first, second = found.answers["1.1"].result, found.answers["2.2"].result
    # the steps start at 0, 4.1 and 9 s, and each has a run of 3.6 s
    assert first.correct
    assert second.correct
    assert first.stop < 4.1 < second.start < 9.0


def test_an_interval_that_passed_earlier_is_evaluated_instead_of_the_newest(handed, lesson):
    """The window stores the interval with which a check first passed."""
    hand_in(handed, lesson, "Ada L", {}, {"1.1": (0.1, 3.0)})
    found = read(handed).answers["1.1"].result
    assert found.correct
    assert found.start == pytest.approx(0.1, abs=0.0011)
    assert found.stop == pytest.approx(3.0, abs=0.0011)
    assert states(handed, lesson)["1.1"] == "correct"
    assert states(handed, lesson)["2.3"] == "missing"  # the lesson is handed in again, without answers


def test_an_edited_value_is_detected(handed, lesson):
    edit_event(handed, lambda answer: {**answer, "value": 81.5}, "1.1")
    (row,) = [row for row in grade_file(handed, {KEY: lesson}) if row.task.startswith("1.1 ")]
    assert row.state == "edited"
    assert "The file says 81.5 N/m" in row.reason
    assert "Stiffness: 80" in row.reason


@pytest.mark.parametrize("part", ["start", "stop"])
def test_a_shifted_interval_is_detected(handed, lesson, part):
    edit_event(handed, lambda answer: {**answer, part: answer[part] - 0.01}, "1.1")
    assert states(handed, lesson)["1.1"] == "edited"


def test_a_wrong_answer_edited_to_correct_is_detected(tmp_path, lesson, played):
    path = tmp_path / "bob.hapkit"
    save_played(path, lesson, played[:1], "Bob")  # the student did the first step only
    assert states(path, lesson)["2.2"] == "missing"
    edit_event(
        path, lambda answer: {**answer, "state": "correct", "value": 120.0, "start": 0.6, "stop": 3.6}, "2.2"
    )
    assert states(path, lesson)["2.2"] == "edited"


@pytest.mark.parametrize("state", ["correct", "wrong"])
def test_a_result_without_an_interval_is_detected(handed, lesson, state):
    edit_event(handed, lambda said: {**said, "state": state, "start": None}, "1.1")
    (row,) = [row for row in grade_file(handed, {KEY: lesson}) if row.task.startswith("1.1 ")]
    assert (row.state, row.value) == ("edited", "")
    assert row.reason == f"The file says {state}, but not which interval was evaluated."


def test_a_lesson_about_an_environment_of_ones_own_is_handed_in_and_graded(tmp_path):
    own = replace(environments.named("spring"), key="my_spring", title="My spring")
    text = (
        resources.path("templates", "lesson.md").read_text(encoding="utf-8").replace('"wall"', '"my_spring"')
    )
    text = text.replace("Press at least 3 mm into the wall", "Pull").replace("depth = 0.003, ", "")
    path = tmp_path / "mine.md"
    path.write_text(text, encoding="utf-8")
    lesson = read_lesson(path, {**environments.discover(), own.key: own})
    handed = tmp_path / "ada.hapkit"
    found = save_played(handed, lesson, play_lesson(lesson), "Ada L")
    assert [result.state for _, result in found] == ["correct", "correct"]
    assert states(handed, lesson) == {"1.1": "correct", "1.2": "correct"}
    assert not re.search(r">(edited|not passed|not measured)<", report(read(handed), lesson))


def test_a_file_name_in_capital_letters_is_graded(handed, lesson):
    handed.rename(handed.with_name("BOB.HAPKIT"))
    assert {row.file for row in grade(handed.parent, {KEY: lesson})} == {"BOB.HAPKIT"}


def test_edited_samples_are_detected_in_every_check(handed, lesson):
    edit_samples(handed)
    found = states(handed, lesson)
    assert {found[key] for key in CHECKS} == {"edited"}


def test_an_edited_question_is_judged_again(handed, lesson):
    edit_event(handed, lambda answer: {**answer, "given": ["7"]}, "2.3")
    assert states(handed, lesson)["2.3"] == "edited"


def test_a_broken_checksum_is_reported(handed, lesson):
    with closing(sqlite3.connect(handed)) as database:
        database.execute("UPDATE chunk SET crc = crc + 1 WHERE id = 2")
        database.commit()
    rows = grade_file(handed, {KEY: lesson})
    assert any(row.state == "damaged" and "checksum" in row.reason for row in rows)


FIELDS = ("key", "state", "text", "value", "half", "start", "stop", "stamp", "given")
NASTY = (None, True, -1, 1e300, "", "x" * 30_000, "\x1b[31m\u202e", [], [1], ["a"] * 5000, {}, {"a": [{}]})


@pytest.mark.slow
@pytest.mark.parametrize("field", FIELDS)
def test_an_answer_of_any_type_gives_a_row_or_one_reason(handed, lesson, field):
    whole = handed.read_bytes()
    for key in ("1.1", "2.3"):
        for value in NASTY:
            handed.write_bytes(whole)
            edit_event(handed, lambda answer, v=value: {**answer, field: v}, key)
            rows = grade_file(handed, {KEY: lesson})
            assert rows
            for row in rows:
                assert all(cell.isprintable() for cell in row.cells())
                assert len(row.reason) < 5000


def test_a_missing_lesson_is_named(handed):
    (row,) = grade_file(handed, {})
    assert row.state == "damaged"
    assert "There is no lesson virtual_spring" in row.reason


def test_a_changed_lesson_is_reported_if_an_answer_is_not_correct(handed, lesson):
    other = replace(lesson, stamp="0" * 16)
    edit_event(handed, lambda answer: {**answer, "value": 1.0}, "1.1")
    rows = {row.task.split()[0]: row for row in grade_file(handed, {KEY: other})}
    assert "The lesson was changed" in rows["1.1"].reason
    assert "The lesson was changed" not in rows["2.2"].reason


def test_a_file_that_was_not_handed_in_is_one_row(tmp_path, lesson):
    (tmp_path / "a.hapkit").write_bytes(b"nothing")
    rows = grade(tmp_path, {KEY: lesson})
    assert [row.state for row in rows] == ["damaged"]


def test_a_lesson_is_handed_in_only_from_a_complete_session(tmp_path, lesson):
    with pytest.raises(SessionError):
        hand_in(tmp_path / "missing.hapkit", lesson, "Ada", {})


@pytest.mark.slow
def test_grading_thirty_students_finds_the_three_that_edited(tmp_path, lesson, played):
    first = tmp_path / "student00.hapkit"
    save_played(first, lesson, played, "Student 0")
    for number in range(1, 30):
        (tmp_path / f"student{number:02}.hapkit").write_bytes(first.read_bytes())
    edit_event(
        tmp_path / "student05.hapkit", lambda answer: {**answer, "value": answer["value"] * 1.001}, "2.2"
    )
    edit_event(tmp_path / "student13.hapkit", lambda answer: {**answer, "value": 0.0143}, "3.5")
    edit_samples(tmp_path / "student21.hapkit", 1.001)
    rows = grade(tmp_path, {KEY: lesson})
    edited = {row.file for row in rows if row.state == "edited"}
    assert edited == {"student05.hapkit", "student13.hapkit", "student21.hapkit"}
    assert {row.state for row in rows} == {"correct", "edited"}


def test_the_tables_contain_every_row_and_escape_all_text(tmp_path, lesson, played):
    path = tmp_path / "x.hapkit"
    save_played(path, lesson, played, "=1+2 <script>alert(1)</script>")
    rows = grade_file(path, {KEY: lesson})
    read_back = list(csv.DictReader(io.StringIO(as_csv(rows))))
    assert len(read_back) == len(rows)
    assert tuple(read_back[0]) == COLUMNS
    assert read_back[0]["student"].startswith("'=")
    assert "<script" not in as_html(rows)


class Tags(html.parser.HTMLParser):
    """A parser that collects every tag and attribute of a page."""

    def __init__(self):
        super().__init__()
        self.tags, self.links = [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.links += [v for k, v in attrs if k in ("src", "href", "xlink:href", "data", "action") and v]


@pytest.mark.slow
def test_the_report_is_one_page_that_loads_nothing(tmp_path, lesson, played):
    path = tmp_path / "x.hapkit"
    save_played(path, lesson, played, '<img src="http://a.example/x.png">')
    page = report(read(path), lesson)
    tags = Tags()
    tags.feed(page)
    assert not {"script", "img", "link", "iframe", "object", "image"} & set(tags.tags)
    assert all(link.startswith("#") for link in tags.links)
    assert not re.search(r"url\((?!#)", page)
    assert "&lt;img src=" in page
    assert page.count("<figure>") == len([step for step in lesson.steps if step.checks])
    for _, _, task in lesson.tasks():
        assert f"{getattr(task, 'title', '') or task.text}"[:20] in page
    assert "Stiffness: 80.00 ± 0.01 N/m. This is correct: 80 N/m was set." in page


@pytest.mark.slow
def test_play_report_and_grade_on_the_command_line(tmp_path, capsys):
    path = tmp_path / "ada.hapkit"
    assert main(["lessons", "play", KEY, "--output", str(path), "--student", "Ada"]) == 0
    assert main(["lessons", "report", str(path)]) == 0
    assert (tmp_path / "ada.html").read_text().startswith("<!DOCTYPE html>")
    assert main(["lessons", "grade", str(tmp_path)]) == 0
    assert "1 file, 6 of 6 tasks correct." in capsys.readouterr().out
    assert (tmp_path / "grades.csv").read_text().startswith("student,file,lesson")
    edit_event(path, lambda answer: {**answer, "value": 1.0}, "1.1")
    assert main(["lessons", "grade", str(tmp_path)]) == 2
    assert "Edited: ada.hapkit." in capsys.readouterr().out


def test_a_recording_without_steps_is_handed_in(tmp_path, lesson):
    """A recording made outside a lesson has no events of steps, so every check uses all of its samples."""
    path = tmp_path / "ada.hapkit"
    time = np.arange(2000) / 1000.0
    with SessionWriter.whole(path) as writer:
        table = np.zeros((len(time), rows.ROW_WIDTH))
        table[:, rows.HOST_TIME] = table[:, rows.BOARD_TIME] = time
        writer.add(pack(table, 20.7e-6, 0))
    results = hand_in(path, lesson, "Ada", {})
    assert len(results) == len(list(lesson.tasks()))
    assert not any(result.correct for _, result in results)
