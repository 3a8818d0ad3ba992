"""The commands ``lessons list``, ``new``, ``check`` and ``play``; the reference page describes the files."""

import json
import re

import pytest

from hapkit_studio import resources
from hapkit_studio.cli import main
from hapkit_studio.lessons import library
from hapkit_studio.lessons.formulas import formula, svg
from hapkit_studio.lessons.measurements import MEASUREMENTS, NEEDS


def test_list_names_every_lesson_and_every_mistake(tmp_path, capsys):
    (tmp_path / "bad.md").write_text("+++\ntitle = 3\n+++\n")
    assert main(["lessons", "list", "--folder", str(tmp_path)]) == 0
    output = capsys.readouterr().out
    for key in library().lessons:
        assert key in output
    assert "bad.md, line 2: title is 3" in output


def test_a_new_lesson_is_complete_and_never_overwritten(tmp_path, capsys):
    path = tmp_path / "mine.md"
    assert main(["lessons", "new", str(path)]) == 0
    assert main(["lessons", "check", str(path)]) == 0
    assert "No mistake found" in capsys.readouterr().out
    assert main(["lessons", "play", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [one["state"] for one in found["results"]] == ["correct", "correct"]
    assert main(["lessons", "new", str(path)]) == 2
    assert "exists already" in capsys.readouterr().err


def test_play_reports_the_check_that_does_not_pass(tmp_path, capsys):
    path = tmp_path / "mine.md"
    main(["lessons", "new", str(path)])
    path.write_text(path.read_text().replace("[1, 18], [2.5, 18]", "[1, 5.5], [2.5, 5.5]"))
    capsys.readouterr()
    assert main(["lessons", "play", str(path)]) == 2
    output = capsys.readouterr().out
    assert re.search(r"You pressed 0\.\d+ mm deep\. Press at least 3 mm deep\.", output)
    assert "Not passed: 1.1." in output


def test_check_reports_the_line_of_a_formula(tmp_path, capsys):
    path = tmp_path / "mine.md"
    main(["lessons", "new", str(path)])
    path.write_text(path.read_text().replace("`$F = -K d$`", r"`$\frac{1$`"))
    assert main(["lessons", "check", str(path)]) == 2
    assert "mine.md, line 12: the formula cannot be read" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("tex", "reason"),
    [
        (r"\sqrt{" * 60 + "x" + "}" * 60, "its braces are nested too deeply"),
        (r"\phantom{x}", "it has nothing visible"),
        ("x+" * 501, "it has 1,002 characters; the limit is 1,000"),
    ],
)
def test_a_formula_that_cannot_be_drawn_is_shown_as_its_source(tex, reason):
    with pytest.raises(ValueError, match=reason):
        svg(tex)
    assert formula(tex) == f"<code>{tex}</code>"


def test_every_shipped_formula_is_rendered():
    from hapkit_studio.lessons.formulas import check_formulas

    for lesson in library().lessons.values():
        check_formulas(lesson)


def test_a_formula_is_drawn_as_an_outline_without_text_or_links():
    drawn = svg(r"\frac{a}{b} < 2")
    assert drawn.startswith("<svg")
    assert "<text" not in drawn
    assert "href" not in drawn


@pytest.mark.parametrize("name", [*MEASUREMENTS, *NEEDS])
def test_the_page_describes_every_name(name):
    page = resources.path("docs", "lessons.md").read_text(encoding="utf-8")
    assert f"`{name}`" in page
