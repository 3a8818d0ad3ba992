"""The trial runs in a separate process: every file gets a verdict, and no process remains."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hapkit_studio.workshop import trial
from hapkit_studio.workshop.source import read, typed
from hapkit_studio.workshop.trying import Problem
from tests.waiting import PATIENCE, wait_until
from tests.wide import wide
from tests.workshop.student import line_of, saved, text, write

on_posix = pytest.mark.skipif(sys.platform == "win32", reason="processes are asked after as POSIX does")


def alive(number):
    """Return True if a process with this id still runs."""
    try:
        os.kill(number, 0)
        with open(f"/proc/{number}/stat", encoding="ascii") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except (OSError, ProcessLookupError):
        return False


@pytest.mark.slow
@on_posix
def test_an_endless_file_is_killed_with_its_children(tmp_path):
    child = tmp_path / "child"
    endless = (
        "import os, subprocess, sys\n"
        "made = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(600)'])\n"
        f"open({str(child)!r} + '.part', 'w').write(str(made.pid))\n"
        f"os.replace({str(child)!r} + '.part', {str(child)!r})\n"
        "while True:\n    pass\n"
    )
    process = trial.begin(saved(tmp_path, text(beside=endless)))
    wait_until(lambda: child.exists() or process.poll() is not None)
    assert process.poll() is None
    verdict = trial.result(process, timeout=0.2)
    assert verdict.problems == (Problem(0, "the file does not end"),)
    assert process.poll() is not None
    wait_until(lambda: not alive(int(child.read_text(encoding="ascii"))))


@on_posix
def test_the_trial_does_not_wait_for_a_child_that_holds_the_pipe(tmp_path):
    child = tmp_path / "child"
    beside = (
        "import os\n"
        "number = os.fork()\n"
        "if number == 0:\n    import time\n    time.sleep(600)\n"
        f"open({str(child)!r}, 'w').write(str(number))\n"
    )
    assert trial.check(saved(tmp_path, text(beside=beside))).ok  # waiting for the child would time out
    wait_until(lambda: not alive(int(child.read_text(encoding="ascii"))))


@pytest.mark.slow
def test_an_abandoned_trial_ends_by_itself():
    endless = text(beside="while True:\n    pass\n").encode()
    program = "from hapkit_studio.workshop import trial\ntrial.TIMEOUT = 0.2\ntrial.main('mine.py')"
    done = subprocess.run(
        [sys.executable, "-c", program], input=endless, capture_output=True, timeout=PATIENCE
    )
    assert (done.stdout, done.stderr) == (b"", b"")


ENDS = [
    ("import os\nos._exit(0)\n", "the file ended Python"),
    ("import os\nos.abort()\n", "the file crashed Python"),
    ("import os\nos.closerange(0, 100)\n", "the file ended Python"),
    ("raise KeyboardInterrupt\n", "the file ended Python"),
    ("input('name? ')\n", "a file must not end the program or ask for input"),
]  # fmt: skip


@pytest.mark.parametrize(("beside", "message"), wide(ENDS, lambda beside, message: "os._exit" in beside))
def test_a_file_that_ends_the_program_gets_a_verdict(tmp_path, beside, message):
    (problem,) = trial.check(saved(tmp_path, text(beside=beside))).problems
    assert message in problem.text


@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux")
def test_a_file_that_takes_all_memory_gets_a_verdict(tmp_path):
    whole = text(beside="A = bytes(4 * 10**9)\n")
    (problem,) = trial.check(saved(tmp_path, whole)).problems
    assert problem == Problem(line_of(whole, "A = bytes"), "the file needs too much memory")


@pytest.mark.slow
def test_a_trial_leaves_no_files_and_ignores_neighbouring_files(tmp_path, monkeypatch):
    """A neighbouring file with the name of a Python module is not imported."""
    folder = tmp_path / "mine"
    folder.mkdir()
    write(folder, "raise SystemExit('mistaken for the module')\n", "random.py")
    path = write(folder, text(beside="import random\nA = random.Random(1).random()\n"), "my file.py")
    monkeypatch.chdir(folder)
    assert trial.check(read(path)).ok
    assert sorted(f.name for f in folder.rglob("*")) == ["my file.py", "random.py"]


def test_an_invalid_verdict_is_a_problem():
    for output in ("", "{}", "[]", "null", '{"problems": [1]}'):
        process = subprocess.Popen(
            [sys.executable, "-c", f"print({output!r}, end='')"], stdout=subprocess.PIPE
        )
        assert not trial.result(process).ok


FILE = Path("mine.py")


def test_a_failure_is_stored_until_the_file_passes():
    first, second, third = (typed(FILE, f"a = {n}\n") for n in range(3))
    trial.remember(first, False)
    trial.remember(second, False)
    assert (trial.has_failed(first), trial.has_passed(first)) == (True, False)
    assert (trial.has_failed(third), trial.has_passed(third)) == (False, False)
    trial.remember(first, True)
    assert (trial.has_failed(first), trial.has_passed(first)) == (False, True)
    assert trial.has_failed(second)
    assert not trial.has_passed(typed(Path("other.py"), first.text))
    trial.remember(first, False)
    assert not trial.has_passed(first)


def test_old_records_are_removed(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    fresh = typed(FILE, "a = 1")
    trial.remember(typed(Path("old.py"), "a = 1"), True)
    (old,) = (tmp_path / "cache").rglob("*.txt")
    days = time.time() - trial.MAX_AGE_SECONDS
    os.utime(old, (days + 3600, days + 3600))
    trial.remember(fresh, True)
    assert old.exists()
    os.utime(old, (days - 3600, days - 3600))
    trial.remember(typed(FILE, "a = 2"), True)
    assert not old.exists()
    assert trial.has_passed(fresh)
