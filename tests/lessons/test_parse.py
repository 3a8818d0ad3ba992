"""Lesson files: their content is read, and every mistake gives one line with file and line number."""

import random
import re
import string

import pytest

from hapkit_studio.lessons import LessonError, library
from hapkit_studio.lessons.lesson import Check, Formula, Hint, Plot, Question, Text
from hapkit_studio.lessons.parse import read

GOOD = """+++
title = "A wall"
aim = "Press."
minutes = 5
environments = ["wall"]
lock = ["damping"]
rubric = [{text = "Done", points = 2}]
+++

Words before the first step.

## Press

Some text with `$K$`.

```math
F = -K d
```

```set
values = {stiffness = 300.0}
loop = {delay = 0.002}
```

```check
title = "Press at least 3 mm."
measure = "slope"
expect = "stiffness"
percent = 5
needs = {depth = 0.003}
```

```question
text = "How stiff?"
value = 300
unit = "N/m"
tolerance = 5
```

```plot
over = "position"
```

```hint
Slowly.
```

```play
hand = [[0, 0], [1, 18]]
seconds = 1.5
```
"""


def lesson_of(tmp_path, text):
    path = tmp_path / "mine.md"
    path.write_text(text, encoding="utf-8")
    return read(path)


def refusal(tmp_path, text):
    """Return the reason why a lesson is rejected, or "" if it is accepted."""
    try:
        lesson_of(tmp_path, text)
    except LessonError as error:
        return str(error)
    return ""


def test_every_block_of_a_step_is_read_in_order(tmp_path):
    lesson = lesson_of(tmp_path, GOOD)
    (step,) = lesson.steps
    kinds = [type(block) for block in step.blocks]
    assert kinds == [Text, Formula, Check, Question, Plot, Hint]
    assert step.scene.values["stiffness"] == 300.0
    assert step.scene.loop.delay == 0.002
    assert step.scene.lock == ("damping",)
    (play,) = step.plays
    assert play.path[1] == pytest.approx((1.0, 0.018))
    assert lesson.rubric[0].points == 2
    assert [task.key for _, _, task in lesson.tasks()] == ["1.1", "1.2"]
    assert len(lesson.intro) == 1


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("+++\ntitle", "title", "line 1: a lesson must begin with a header"),
        ('title = "A wall"\n', "", "line 2: title is missing"),
        ("minutes = 5", "minutes = -5", "line 4: minutes is -5; it must be a number from 1 to 600 min"),
        ("minutes = 5", "minutes = = 5", "line 4"),
        ('["wall"]', '["walls"]', "line 5: environments must contain only"),
        ('lock = ["damping"]', 'lock = ["dampings"]', "line 6: lock must contain only"),
        ("## Press", "# Press", "line 12: a step must begin with ##"),
        ("stiffness = 300.0", "stiffness = 99999.0", "line 21: Stiffness must be between 0 and 5,000 N/m"),
        ("stiffness = 300.0", "stifness = 300.0", "line 21"),
        ("delay = 0.002", "delay = -1", "line 22"),
        ("delay = 0.002", "delays = 1", "line 22: the loop has rate, delay"),
        ('"slope"', '"slop"', "line 27: measure must be one of stiffness"),
        ('expect = "stiffness"', 'expect = "stiff"', "line 28: a parameter must be one of"),
        ("percent = 5\n", "", "line 28: expect needs tolerance or percent"),
        ("depth = 0.003", "deep = 0.003", "line 30: needs must contain only depth"),
        ("depth = 0.003", "depth = nan", "line 30: depth is nan"),
        ("percent = 5\n", "percent = 5\nat_most = 9.0\n", "line 28: expect excludes at_least"),
        ("percent = 5\n", "percent = 5\ntolerance = 9.0\n", "line 29: a check must have either tolerance"),
        ('expect = "stiffness"\npercent = 5', "at_most = 1\nat_least = 2", "line 29: at_least is 2, more"),
        ('expect = "stiffness"', "expect = 0", "line 29: a percentage of zero is zero"),
        ("percent = 5\n", "percent = 5\nwhere = {damping_mode = [0, 1]}\n", "line 30: Damping acts must be"),
        ("percent = 5\n", 'percent = 5\nwhere = {stiffness = "300"}\n', "line 30: where is '300'"),
        ("percent = 5\n", 'percent = 5\nwhere = {rate = "fast"}\n', "line 30: where is 'fast'"),
        ("percent = 5\n", "percent = 5\nwhere = {estimator = [0, 1]}\n", "line 30: estimator is [0, 1]"),
        ("percent = 5\n", 'percent = 5\nwhere = {estimator = "x"}\n', "line 30: The velocity estimator"),
        ("```question", "```quiz", "line 33: a block must be one of set, check"),
        ("tolerance = 5", "tolerance = 5\nhelp = 1", "line 38: the name 'help' is not known here"),
        ('over = "position"', 'over = "depth"', "line 41: over must be one of"),
        ("[1, 18]]", "[0, 18]]", "line 49: the times of the hand's path must increase"),
        ("[1, 18]]", "[1, 180]]", "line 49: hand is 180; it must be a number from -60 to 60 mm"),
        ("seconds = 1.5", "seconds = 500", "line 50: seconds is 500"),
    ],
)
def test_a_mistake_is_reported_with_its_line(tmp_path, old, new, text):
    assert old in GOOD
    with pytest.raises(LessonError, match=re.escape(text)) as caught:
        lesson_of(tmp_path, GOOD.replace(old, new))
    assert str(caught.value).startswith("mine.md")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("value = 300\n", 'answer = "300"\n', "line 35: an answer needs options"),
        ("value = 300\n", "", "line 36: a tolerance needs a value"),
    ],
)
def test_a_question_that_would_never_be_judged_is_a_mistake(tmp_path, old, new, words):
    assert words in refusal(tmp_path, GOOD.replace(old, new))


@pytest.mark.parametrize(
    ("texts", "words"),
    [
        ([f"Row {n}" for n in range(51)], "a rubric may have at most 50 rows, not 51"),
        (["Row", "Row"], "two rows of the rubric have the same text"),
        ([f"Row {n}" for n in range(50)], ""),
    ],
)
def test_a_rubric_fits_into_a_review(tmp_path, texts, words):
    rows = ", ".join(f'{{text = "{text}", points = 2}}' for text in texts)
    rubric = re.sub(r"(?ms)^rubric = .*?\]$", f"rubric = [{rows}]", GOOD, count=1)
    assert rubric != GOOD
    assert (words in refusal(tmp_path, rubric)) if words else refusal(tmp_path, rubric) == ""


def test_html_in_a_lesson_stays_text(tmp_path):
    from hapkit_studio.lessons.parse import markdown

    shown = markdown().render(
        "<script>alert(1)</script> and <b>bold</b> ![x](http://a/b.png) [a](javascript:x)"
    )
    assert "<script" not in shown
    assert "<img" not in shown
    assert 'href="javascript' not in shown


@pytest.mark.parametrize(
    ("url", "links"),
    [
        ("https://a.b", True),
        ("HTTP://a.b", True),
        ("javascript:x", False),
        ("ms-msdt:/id", False),
        ("smb://a/b", False),
        ("file:///a", False),
        ("data:image/png;base64,a", False),
        ("//a/b", False),
        ("a.exe", False),
    ],
)
def test_only_web_pages_are_links(url, links):
    from hapkit_studio.lessons.parse import markdown

    shown = markdown().render(f"[text]({url})\n\n[ref]\n\n[ref]: {url}\n\n<{url}>")
    assert ("href" in shown) is links


def test_only_the_bad_lesson_is_rejected(tmp_path):
    (tmp_path / "good.md").write_text(GOOD)
    (tmp_path / "bad.md").write_text(GOOD.replace('"slope"', '"slop"'))
    found = library(tmp_path)
    assert "good" in found.lessons
    assert "first_touch" in found.lessons
    assert "bad" not in found.lessons
    (error,) = found.errors
    assert error.startswith("bad.md, line 27")


@pytest.mark.parametrize("size", [70_000, 65_000])
def test_a_large_or_deep_file_is_rejected_quickly(tmp_path, size):
    with pytest.raises(LessonError):
        lesson_of(tmp_path, GOOD + "x" * size if size > 65_536 else "+++\na = " + "[" * (size - 10))


def test_thousands_of_nested_quotes_are_read_or_rejected(tmp_path):
    lesson_of(tmp_path, GOOD + "\n" + ">" * 5000 + " deep\n" + "*" * 5000 + "[" * 5000)


def test_damaged_lessons_give_one_line_each(tmp_path):
    """The test has 300 files with a few characters or lines changed, from fixed seeds."""
    refused = 0
    for seed in range(300):
        chance = random.Random(seed)
        text = list(GOOD)
        for _ in range(chance.randint(1, 12)):
            at = chance.randrange(len(text))
            what = chance.randrange(3)
            if what == 0:
                text[at] = chance.choice(string.printable + "\x00\u202eλ")
            elif what == 1:
                del text[at : at + chance.randint(1, 40)]
            else:
                text[at:at] = text[chance.randrange(len(text)) :][: chance.randint(1, 60)]
        message = refusal(tmp_path, "".join(text))
        refused += bool(message)
        assert not message or message.startswith("mine.md"), message
        assert len(message.splitlines()) <= 1, message
    assert refused > 150


def test_no_shipped_lesson_has_an_error():
    found = library()
    assert found.errors == ()
    assert len(found.lessons) == 15  # fourteen lessons and the tour
    for lesson in found.lessons.values():
        assert lesson.path.read_text(encoding="utf-8").count("\n") <= 150, lesson.key
        assert any(step.checks for step in lesson.steps), lesson.key
        assert lesson.rubric, lesson.key
        for step in lesson.steps:
            assert step.plays or not step.checks, f"{lesson.key}: {step.title} has no play block"
