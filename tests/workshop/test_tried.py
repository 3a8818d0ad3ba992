"""What passed is remembered: this text of this file, with this Python and this cache."""

import os
import sys
import time
from pathlib import Path

import pytest

from hapkit_studio.workshop import trial
from hapkit_studio.workshop.source import typed
from tests.workshop.student import text

FILE = Path("mine.py")


def passed(text, file):
    trial.remember(typed(file, text), True)


def failed(text, file):
    trial.remember(typed(file, text), False)


def has_passed(text, file):
    return trial.has_passed(typed(file, text))


def has_failed(text, file):
    return trial.has_failed(typed(file, text))


def records(folder):
    return list((folder / "cache").rglob("*.txt"))


def test_only_this_text_of_this_file(tmp_path):
    passed("a = 1\n", FILE)
    assert has_passed("a = 1\n", FILE)
    assert not has_passed("a = 1 \n", FILE)
    assert not has_passed("a = 1\n", tmp_path / "mine.py")


def test_what_failed_is_known_until_it_passes(tmp_path):
    failed("a = 1\n", FILE)
    failed("a = 2\n", FILE)
    assert has_failed("a = 1\n", FILE)
    assert not has_passed("a = 1\n", FILE)
    assert not has_failed("a = 3\n", FILE)
    passed("a = 1\n", FILE)
    assert has_passed("a = 1\n", FILE)
    assert not has_failed("a = 1\n", FILE)
    assert has_failed("a = 2\n", FILE)
    failed("a = 1\n", FILE)
    assert not has_passed("a = 1\n", FILE)


def test_only_with_this_cache(tmp_path, monkeypatch):
    passed("a = 1\n", FILE)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "elsewhere"))
    assert not has_passed("a = 1\n", FILE)


def test_the_last_versions_are_known(tmp_path):
    for n in (*range(trial.KEPT), 0, 0, trial.KEPT):
        passed(f"a = {n}", FILE)
    known = [n for n in range(trial.KEPT + 1) if has_passed(f"a = {n}", FILE)]
    assert known == [0, *range(2, trial.KEPT + 1)]
    assert len(records(tmp_path)) == 1


def test_records_of_long_ago_go(tmp_path):
    passed("a = 1", Path("old.py"))
    (old,) = records(tmp_path)
    days = time.time() - trial.KEPT_SECONDS
    os.utime(old, (days + 3600, days + 3600))
    passed("a = 1", FILE)
    assert old.exists()
    os.utime(old, (days - 3600, days - 3600))
    passed("a = 2", FILE)
    assert not old.exists()
    assert has_passed("a = 1", FILE)


@pytest.mark.skipif(sys.platform == "win32", reason="names of bytes")
def test_odd_names_and_records(tmp_path):
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\xff\xfe \xc3\xa4.py"))
    passed(text(), path)
    assert has_passed(text(), path)
    for record in records(tmp_path):
        record.write_bytes(b"\x00nonsense\n\xff\n")
    assert not has_passed(text(), path)
    passed(text(), path)
    assert has_passed(text(), path)


def test_where_nothing_can_be_written_it_is_tried_again(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    passed("a = 1", FILE)
    assert not has_passed("a = 1", FILE)
