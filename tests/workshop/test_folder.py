"""The folder of own environments is created on demand; files are never overwritten by accident or in part."""

import os

import pytest

from hapkit_studio import environments
from hapkit_studio.workshop import folder, reading, trying
from tests.workshop.student import saved, write


def test_the_folder_is_that_of_the_variable_and_created_on_demand(tmp_path):
    assert folder.own_files() == []
    assert not (tmp_path / "studio").exists()
    assert folder.own_folder() == tmp_path / "studio" / "environments"
    assert folder.own_folder().is_dir()


@pytest.mark.parametrize(
    ("title", "name"),
    [
        ("My spring", "my_spring.py"),
        ("Zwei Wände!", "zwei_wande.py"),
        ("  --  ", "environment.py"),
        ("弹簧", "environment.py"),
        ("3 walls", "my_3_walls.py"),
        ("../../etc/passwd", "etc_passwd.py"),
        ("NUL", "my_nul.py"),
        ("x" * 300, "x" * 40 + ".py"),
        ("wall", "wall_2.py"),
    ],
)
def test_a_title_gives_a_file_name(title, name):
    path = folder.new_path(title)
    assert path == folder.own_folder() / name
    assert not path.exists()


def test_a_new_name_is_unused():
    names = []
    for _ in range(3):
        path = folder.new_path("My spring")
        path.write_text("", encoding="utf-8")
        names.append(path.name)
    (folder.own_folder() / "Other.py").write_text("", encoding="utf-8")
    assert names == ["my_spring.py", "my_spring_2.py", "my_spring_3.py"]
    assert folder.new_path("other").name == "other_2.py"
    assert all(folder.new_path(key).stem not in environments.discover() for key in environments.discover())


def test_saving_writes_only_the_text():
    path = folder.new_path("mine")
    folder.save(path, "# −0.5 N·s/m\nx = 1\n")
    folder.save(path, "# −0.7 N·s/m\nx = 2\n")
    assert path.read_bytes() == "# −0.7 N·s/m\nx = 2\n".encode()
    assert [f.name for f in path.parent.iterdir()] == [path.name]


@pytest.mark.parametrize("fails", ["replace", "fsync"])
def test_the_old_file_survives_a_failed_save(monkeypatch, fails):
    path = folder.new_path("mine")
    folder.save(path, "old\n")

    def full(*args):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, fails, full)
    with pytest.raises(OSError, match="No space"):
        folder.save(path, "new\n" * 1000)
    assert path.read_text(encoding="utf-8") == "old\n"
    assert [f.name for f in path.parent.iterdir()] == [path.name]


def test_only_the_environments_own_key_and_title_are_filled_in():
    text = 'A = Name(key="k", title="t")\nE = Environment(about="µ", key="k", p=(P(key="k"),), title="t")\n'
    filled = folder.fill_template(folder.Template("x", "x", text), "Zwei Wände", "new")
    assert filled == text.replace('µ", key="k"', 'µ", key="new"').replace(
        '), title="t"', '), title="Zwei Wände"'
    )


ALL = folder.templates()


@pytest.mark.parametrize("template", ALL, ids=lambda t: t.key)
def test_a_template_passes_its_trial_without_a_remark(template, tmp_path):
    verdict = trying.try_out(saved(tmp_path, template.text))
    assert verdict.problems == verdict.warnings == ()
    assert verdict.calls >= 10_000


@pytest.mark.parametrize("template", ALL, ids=lambda t: t.key)
@pytest.mark.parametrize("title", ["Zwei Wände", 'My "best" one\\', "it's\n\ttwo lines", "𝕊 {} %s"])
def test_a_filled_template_has_its_own_title_and_key(template, title, tmp_path):
    made = reading.load(write(tmp_path, folder.fill_template(template, title, "another_one")))
    assert (made.title, made.key) == (title, "another_one")
    before = reading.load(write(tmp_path, template.text))
    assert made.parameters == before.parameters
    assert made.force.source == before.force.source
