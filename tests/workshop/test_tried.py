"""What passed is remembered; what a file's versions of long ago left in the cache does not pile up."""

import os
import sys
from pathlib import Path

import pytest

from hapkit_studio import environments
from hapkit_studio.workshop import reading, tried, trying
from tests.workshop.student import text, write


def law_of(path):
    """Try out a file; return the file of its compiled law."""
    assert trying.try_file(path).ok
    return Path(reading.load(path).force.compiled().keepalive.__file__)


def machine_code(law):
    """Return the files that numba keeps of a compiled law."""
    return [f for f in law.parent.parent.rglob(f"{law.stem}.*") if f != law]


def versions(folder, factors):
    """Try out a file's versions one after another; return their laws."""
    return [law_of(write(folder, text(f"return {factor} * x"))) for factor in factors]


@pytest.fixture(autouse=True)
def few(monkeypatch):
    """Let a file keep two versions."""
    monkeypatch.setattr(tried, "KEPT", 2)


def test_old_versions_are_cleared_from_the_cache(tmp_path):
    other = law_of(write(tmp_path, text("return -11.0 * x"), "other.py"))
    first, second, third = versions(tmp_path, (11.25, 11.5, 11.75))
    assert not first.exists()
    assert not machine_code(first)
    for law in (second, third, other):
        assert law.exists()
        assert machine_code(law)
    texts = [text(f"return {factor} * x") for factor in (11.25, 11.5, 11.75)]
    assert [tried.has_passed(t, tmp_path / "mine.py") for t in texts] == [False, True, True]


def test_the_same_version_again_clears_nothing(tmp_path):
    laws = versions(tmp_path, (12.25, 12.5, 12.5, 12.25, 12.5))
    assert all(law.exists() for law in laws)
    again, oldest, _, newest = versions(tmp_path, (12.25, 12.5, 12.25, 12.75))
    assert (again.exists(), oldest.exists(), newest.exists()) == (True, False, True)


def test_what_a_file_left_that_is_gone_is_cleared(tmp_path):
    path = write(tmp_path, text("return 13.5 * x"), "other.py")
    law = law_of(path)
    path.unlink()
    law_of(write(tmp_path, text("return 13.25 * x")))
    assert not law.exists()
    assert len(list((tmp_path / "cache").rglob("*.txt"))) == 1


def test_a_law_of_another_file_is_not_cleared(tmp_path):
    path = write(tmp_path, text("return 14.5 * x"), "other.py")
    write(tmp_path, text("return 14.5 * x"))
    shared = law_of(path)
    assert law_of(tmp_path / "mine.py") == shared
    path.unlink()
    versions(tmp_path, (14.25,))
    assert shared.exists()


def test_a_built_in_law_is_not_cleared(tmp_path):
    """A copy of a built-in environment's file has the same compiled law."""
    spring = environments.named("spring")
    source = Path(spring.force.function.__code__.co_filename).read_text(encoding="utf-8")
    path = write(tmp_path, source.replace('key="spring"', 'key="springy"'), "copy.py")
    law = law_of(path)
    assert law == Path(spring.force.compiled().keepalive.__file__)
    path.unlink()
    versions(tmp_path, (15.5,))
    assert law.exists()


def test_a_file_that_fails_is_not_remembered(tmp_path):
    whole = text("return 1.0 / (x - x)")
    path = write(tmp_path, whole)
    assert not trying.try_file(path).ok
    assert not tried.has_passed(whole, path)


def test_another_cache_another_trial(tmp_path, monkeypatch):
    path = write(tmp_path, text())
    assert trying.try_file(path).ok
    assert tried.has_passed(text(), path)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "elsewhere"))
    assert not tried.has_passed(text(), path)


@pytest.mark.skipif(sys.platform == "win32", reason="names of bytes")
def test_odd_names_and_records(tmp_path):
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff\xfe \xc3\xa4.py"))
    path.write_text(text(), encoding="utf-8")
    assert trying.try_file(path).ok
    assert tried.has_passed(text(), path)
    for record in (tmp_path / "cache").rglob("*.txt"):
        record.write_bytes(b"\x00nonsense\nwithout a second word\n\xff\n")
    assert not tried.has_passed(text(), path)
    assert trying.try_file(path).ok
    assert tried.has_passed(text(), path)
