"""The list of own files: never executes what was not trusted and tried out."""

from hapkit_studio.workshop import folder, library, trust, trying
from tests.workshop.student import END, text


def put(name, whole):
    """Save a file in the folder and return its path."""
    path = folder.own_folder() / name
    folder.save(path, whole)
    return path


def marking(mark):
    """Return a file's text that leaves a mark when it is executed."""
    return text(beside=f"import pathlib\npathlib.Path({str(mark)!r}).touch()\n")


def test_an_empty_folder_and_none_at_all():
    assert library.own() == []
    folder.own_folder()
    assert library.own() == []


def test_only_what_is_trusted_and_tried_is_executed(tmp_path):
    mark = tmp_path / "executed"
    whole = marking(mark)
    path = put("my_law.py", whole)
    (entry,) = library.own()
    assert (entry.file, entry.trusted, entry.tried, entry.environment) == (path, False, False, None)
    assert (entry.title, entry.problem) == ("My law", None)
    trust.trust(whole)
    (entry,) = library.own()
    assert (entry.trusted, entry.tried, entry.environment) == (True, False, None)
    assert not mark.exists()
    assert trying.try_file(path).ok
    mark.unlink()
    (entry,) = library.own()
    assert (entry.trusted, entry.tried, entry.title) == (True, True, "Mine")
    assert entry.environment.key == "mine"
    assert mark.exists()


def test_a_trial_is_not_trust():
    path = put("my_law.py", text())
    assert trying.try_file(path).ok
    (entry,) = library.own()
    assert (entry.trusted, entry.tried, entry.environment) == (False, True, None)


def test_a_change_from_outside_ends_trust_and_trial():
    path = put("my_law.py", text())
    trust.trust(text())
    assert trying.try_file(path).ok
    assert library.own()[0].environment
    path.write_text(text() + "# changed\n", encoding="utf-8")
    (entry,) = library.own()
    assert (entry.trusted, entry.tried, entry.environment) == (False, False, None)


def test_a_second_file_of_the_same_key_is_kept_out():
    for name in ("a.py", "b.py"):
        assert trying.try_file(put(name, text())).ok
    trust.trust(text())
    first, second = library.own()
    assert first.environment.key == "mine"
    assert second.environment is None
    assert str(second.problem) == 'The key "mine" is also that of a.py: change one of them.'


def test_a_file_that_cannot_be_read_is_listed_with_its_problem():
    path = put("broken.py", "a = 1\n")
    path.write_bytes(b"a = 1\nb = '\xff'\n")
    (entry,) = library.own()
    assert (entry.problem.line, entry.environment, entry.trusted) == (2, None, False)
    assert "UTF-8" in entry.problem.text


def test_ready_ones_come_first_by_title():
    for name, title in (("c.py", "Alpha"), ("b.py", "beta"), ("d.py", "Gamma")):
        whole = text(end=END.replace('key="mine"', f'key="{title.lower()}"').replace('"Mine"', f'"{title}"'))
        trust.trust(whole)
        assert trying.try_file(put(name, whole)).ok
    put("a.py", "not trusted")
    assert [e.title for e in library.own()] == ["Alpha", "beta", "Gamma", "A"]
