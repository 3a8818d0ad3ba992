"""A peer review never changes the reviewed data, and a damaged review does not hide the other reviews."""

import html.parser
import json
import re
from dataclasses import replace

import pytest

from hapkit_studio.analysis import pointing
from hapkit_studio.cli import main
from hapkit_studio.lessons import experiments, library, review
from hapkit_studio.lessons.hand_in import hand_in, read, save_played
from hapkit_studio.lessons.play import play_lesson
from hapkit_studio.lessons.report import report
from hapkit_studio.lessons.review import Comment, ReviewError

KEY = "virtual_spring"
EVIL = "<script>alert(1)</script>"


@pytest.fixture(scope="module")
def lesson():
    return library().lessons[KEY]


@pytest.fixture(scope="module")
def original(tmp_path_factory, lesson):
    path = tmp_path_factory.mktemp("handed") / "ada.hapkit"
    save_played(path, lesson, play_lesson(lesson), "Ada L")
    return path.read_bytes()


@pytest.fixture
def handed(tmp_path, original):
    path = tmp_path / "ada.hapkit"
    path.write_bytes(original)
    return read(path)


@pytest.fixture
def no_figures(monkeypatch):
    """Leave figures out of reports, because they take a second each."""
    monkeypatch.setattr("hapkit_studio.lessons.report._drawn", lambda _draw, text: f"<p>{text}</p>")


def reviewed(handed, lesson, name, points, **more):
    """Write a review with points for each row of the rubric; return its path."""
    one = review.blank(handed, lesson, name)
    rows = tuple(replace(row, points=given) for row, given in zip(one.rows, points, strict=True))
    path = review.path_of(handed.path, name)
    review.write(path, replace(one, rows=rows, **more))
    return path


def test_a_review_is_read_as_written_and_the_data_are_unchanged(handed, lesson, original):
    count = len(lesson.rubric)
    comments = Comment("why?", time=1.5), Comment("good", step=2), Comment("well done")
    path = reviewed(handed, lesson, "Bob", [1] * count, comments=comments)
    found = review.read(path)
    assert found.comments == comments
    assert [row.criterion for row in found.rows] == [one.text for one in lesson.rubric]
    assert (found.points, found.most) == (count, sum(one.points for one in lesson.rubric))
    assert [one.place for one in found.comments] == ["at 1.50 s", "step 2", ""]
    assert handed.path.read_bytes() == original
    assert path.stat().st_size < 4096


def test_several_reviews_are_shown_together_with_their_mean(handed, lesson):
    most = [one.points for one in lesson.rubric]
    reviewed(handed, lesson, "Bob", most)
    reviewed(handed, lesson, "Eve", [0] * len(most))
    reviewed(handed, lesson, "Zoë", [None] * len(most))
    found = review.reviews_of(handed)
    assert [one.reviewer for one in found.found.values()] == ["Bob", "Eve", "Zoë"]
    assert found.mean == pytest.approx(0.5)  # this is the mean of the two complete reviews
    assert found.errors == ()


def test_a_review_of_other_answers_is_noticed(handed, lesson):
    reviewed(handed, lesson, "Bob", [1] * len(lesson.rubric))
    hand_in(handed.path, lesson, "Ada L", {})
    found = review.reviews_of(read(handed.path))
    assert found.found == {}
    (error,) = found.errors
    assert "was written for different answers" in error


def test_a_review_is_found_by_its_answers_if_the_file_was_renamed(handed, lesson):
    reviewed(handed, lesson, "Bob", [1] * len(lesson.rubric))
    handed.path.rename(handed.path.with_name("other.hapkit"))
    found = review.reviews_of(read(handed.path.with_name("other.hapkit")))
    assert len(found.found) == 1


def test_the_author_replies_in_the_reviews_file(handed, lesson):
    path = reviewed(handed, lesson, "Bob", [1] * len(lesson.rubric))
    before = review.read(path)
    review.reply(path, "Thank you.\nI will.")
    assert review.read(path) == replace(before, replies=("Thank you. I will.",))
    with pytest.raises(ReviewError, match="text of the reply"):
        review.reply(path, " ")


def test_a_review_never_replaces_another_file(handed, lesson):
    path = reviewed(handed, lesson, "Bob", [1] * len(lesson.rubric))
    with pytest.raises(ReviewError, match="exists already"):
        reviewed(handed, lesson, "Bob", [0] * len(lesson.rubric))
    assert review.read(path).points == len(lesson.rubric)


@pytest.mark.parametrize("name", ["", "  ", "a\x1bb", "a" * 101])
def test_a_reviewers_name_is_one_printable_line(handed, lesson, name):
    with pytest.raises(ReviewError):
        review.blank(handed, lesson, name)


@pytest.mark.parametrize("name", ["../../x", "Zoë", "a/b", "con:", "x" * 90])
def test_a_review_is_in_the_folder_of_its_session(handed, name):
    path = review.path_of(handed.path, name)
    assert path.parent == handed.path.parent
    assert re.fullmatch(r"ada reviewed by [\w -]+\.review", path.name)


def test_a_reply_that_makes_a_review_too_large_to_be_read_leaves_it_unchanged(handed, lesson):
    comments = (Comment("x" * 1000),) * 64
    path = reviewed(handed, lesson, "Bob", [1] * len(lesson.rubric), comments=comments[:60])
    while path.stat().st_size < 64_800:
        review.reply(path, "y" * 500)
    before = path.read_bytes()
    with pytest.raises(ReviewError, match=r"would have .* bytes; the limit is 65,536 bytes"):
        review.reply(path, "y" * 1000)
    assert path.read_bytes() == before
    assert review.read(path).reviewer == "Bob"
    with pytest.raises(ReviewError, match="Shorten the comments"):
        reviewed(handed, lesson, "Cy", [1] * len(lesson.rubric), comments=comments)
    assert not review.path_of(handed.path, "Cy").exists()


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"version": 2}, "version is 2"),
        ({"rows": [{"criterion": "a", "most": 3, "points": 4}]}, "row 1: points is 4"),
        ({"rows": [{"criterion": "a", "most": 3, "points": -1}]}, "row 1: points is -1"),
        ({"rows": [{"criterion": "a", "most": 3, "points": True}]}, "row 1: points is True"),
        ({"rows": [{"criterion": "a", "most": 101}]}, "row 1: most is 101"),
        ({"rows": [3]}, "row 1 is 3"),
        ({"rows": {}}, "rows must be a list"),
        ({"comments": [{"text": "a", "time": -1.0}]}, "comment 1: time is -1.0"),
        ({"comments": [{"text": "a", "step": 0}]}, "comment 1: step is 0"),
        ({"comments": [{"text": "a" * 1001}]}, "comment 1: text is"),
        ({"comments": [{"text": "a"}] * 101}, "at most 100"),
        ({"replies": ["a\x1bb"]}, "reply 1 is"),
        ({"reviewer": None}, "reviewer is None"),
        ({"answers": "0" * 65}, "answers is"),
    ],
)
def test_a_wrong_value_is_named_in_one_line(handed, lesson, change, text):
    path = reviewed(handed, lesson, "Bob", [1] * len(lesson.rubric))
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    with pytest.raises(ReviewError, match=re.escape(text)) as caught:
        review.read(path)
    assert str(caught.value).startswith(path.name)
    assert "\n" not in str(caught.value)
    assert len(review.reviews_of(handed).errors) == 1


class Page(html.parser.HTMLParser):
    """A parser that collects the tags and the text of a page."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.texts = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)

    def handle_data(self, data):
        self.texts.append(data)


def test_reviews_appear_in_the_report_with_every_text_escaped(handed, lesson, no_figures):
    reviewed(
        handed, lesson, EVIL, [1] * len(lesson.rubric),
        comments=(Comment(EVIL, time=2.0), Comment("see", step=1)), replies=(EVIL,),
    )  # fmt: skip
    found = Page(report(handed, lesson, review.reviews_of(handed)))
    assert "script" not in found.tags
    assert sum(EVIL in message for message in found.texts) >= 3
    text = " ".join(found.texts)
    assert "Reviews" in text
    assert f"step 1, {lesson.steps[0].title}" in text


def test_an_instructor_hides_names_in_the_lesson_or_the_report(handed, lesson, no_figures):
    reviewed(handed, lesson, "Bob", [1] * len(lesson.rubric))
    found = review.reviews_of(handed)
    for page in (
        report(handed, lesson, found, hide_names=True),
        report(handed, replace(lesson, hide_names=True), found),
    ):
        assert "Bob" not in page
        assert "Ada" not in page
        assert "ada.hapkit" not in page
        assert "Reviewer 1" in page
    assert "Bob" in report(handed, lesson, found)


def test_hidden_names_are_not_in_the_damage(handed, lesson, no_figures):
    damaged = replace(handed, damage=("ada.hapkit is damaged. Skipped: chunk 3.",))
    assert "ada.hapkit is damaged" in report(damaged, lesson)
    hidden = report(damaged, lesson, hide_names=True)
    assert "ada" not in hidden
    assert "The file is damaged. Skipped: chunk 3." in hidden


def test_the_command_hides_the_names_in_a_review_file(handed, lesson, capsys):
    path = reviewed(handed, lesson, "Bob", [1] * len(lesson.rubric))
    assert main(["lessons", "review", str(path), "--hide-names"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("Reviewer 1 on this work: ")
    assert "Bob" not in said


def test_the_header_hides_names(tmp_path):
    from hapkit_studio import resources
    from hapkit_studio.lessons.lesson import LessonError
    from hapkit_studio.lessons.parse import read as read_lesson

    text = resources.path("templates", "lesson.md").read_text(encoding="utf-8")
    path = tmp_path / "mine.md"
    for line, hidden in (("", False), ("hide_names = true\n", True), ("hide_names = false\n", False)):
        path.write_text(text.replace("+++\n", f"+++\n{line}", 1), encoding="utf-8")
        assert read_lesson(path).hide_names is hidden
    path.write_text(text.replace("+++\n", "+++\nhide_names = 1\n", 1), encoding="utf-8")
    with pytest.raises(LessonError, match=r"mine.md, line 2: hide_names must be true or false, not 1"):
        read_lesson(path)


def test_the_command_writes_shows_and_answers_a_review(handed, lesson, capsys):
    points = ",".join(["1"] * (len(lesson.rubric) - 1) + ["-"])
    write = ["lessons", "review", str(handed.path), "--reviewer", "Bob", "--points", points]
    assert main([*write, "--comment", "12.5 s: nice", "--comment", "step 2: why?"]) == 0
    path = review.path_of(handed.path, "Bob")
    assert review.read(path).comments == (Comment("nice", time=12.5), Comment("why?", step=2))
    assert main(write) == 2
    assert main(["lessons", "reply", str(path), "--comment", "thanks"]) == 0
    capsys.readouterr()
    assert main(["lessons", "review", str(handed.path)]) == 0
    output = capsys.readouterr().out
    assert "Bob on ada.hapkit" in output
    assert "at 12.50 s: nice" in output
    assert "reply: thanks" in output
    assert main(["lessons", "review", str(handed.path), "--hide-names", "--json"]) == 0
    output = capsys.readouterr().out
    assert "Bob" not in output
    assert json.loads(output)["reviews"][0]["reviewer"] == "Reviewer 1"


@pytest.mark.parametrize(
    ("comment", "words"),
    [
        ("", "A comment has no text"),
        ("step 1: ", "A comment has no text"),
        ("step 0: why?", "There is no step 0"),
        ("step 99: why?", "There is no step 99"),
    ],
)
def test_the_command_refuses_a_comment_on_nothing(handed, lesson, comment, words, capsys):
    points = ",".join(["1"] * len(lesson.rubric))
    write = ["lessons", "review", str(handed.path), "--reviewer", "Bob", "--points", points]
    assert main([*write, "--comment", comment]) == 2
    assert words in capsys.readouterr().err
    assert not list(handed.path.parent.glob("*.review"))


@pytest.mark.parametrize("points", ["1", "9,1,1", "1,1,-1", "x,1,1", "1,1,1,1", "1,1,", ""])
def test_the_command_refuses_points_that_the_rubric_does_not_have(handed, points, capsys):
    assert main(["lessons", "review", str(handed.path), "--reviewer", "Bob", "--points", points]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not list(handed.path.parent.glob("*.review"))


def test_a_report_shows_the_experiment_in_its_file(tmp_path, lesson):
    path = tmp_path / "ada.hapkit"
    targets = pointing.plan(distances=(0.01, 0.03), rounds=1, seed=0)
    experiments.save_pointing(path, pointing.Subject(), targets, seed=0)
    hand_in(path, lesson, "Ada", {})
    page = Page(report(read(path), lesson))
    text = " ".join(page.texts)
    assert "Pointing with friction" in text
    assert "ms/bit" in text
    assert "none" in text
    assert "svg" in page.tags
