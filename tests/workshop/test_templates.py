"""Templates: short whole files, each ready for the loop, each with its own title and key once filled."""

import pytest

from hapkit_studio.workshop import folder, reading, trying
from tests.workshop.student import saved, write

ALL = folder.templates()


def test_there_are_four_the_simplest_first():
    assert [t.title for t in ALL] == ["spring", "wall", "two walls", "mass on a spring"]


@pytest.mark.parametrize("template", ALL, ids=lambda t: t.key)
def test_a_template_passes_its_trial_without_a_remark(template, tmp_path):
    verdict = trying.try_out(saved(tmp_path, template.text))
    assert verdict.problems == verdict.warnings == ()
    assert verdict.calls >= 10_000
    assert 0.0 < verdict.ns_per_call < 250.0


@pytest.mark.parametrize("template", ALL, ids=lambda t: t.key)
def test_a_template_can_be_read_by_a_beginner(template):
    lines = template.text.splitlines()
    assert len(lines) < 45
    assert max(map(len, lines)) <= 110
    assert sum(line.strip().startswith("#") for line in lines) >= 3


@pytest.mark.parametrize("template", ALL, ids=lambda t: t.key)
@pytest.mark.parametrize("title", ["Zwei Wände", 'My "best" one\\', "it's\n\ttwo lines", "𝕊 {} %s"])
def test_a_filled_template_has_its_own_title_and_key(template, title, tmp_path):
    made = reading.load(write(tmp_path, folder.fill_template(template, title, "another_one")))
    assert (made.title, made.key) == (title, "another_one")
    before = reading.load(write(tmp_path, template.text))
    assert made.parameters == before.parameters
    assert made.force.source == before.force.source


@pytest.mark.parametrize("template", ALL, ids=lambda t: t.key)
def test_every_slider_says_what_it_does(template, tmp_path):
    made = reading.load(write(tmp_path, template.text))
    assert all(p.help and p.label for p in made.parameters)
    assert made.summary
    assert made.formula
