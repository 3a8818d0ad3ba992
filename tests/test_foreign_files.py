"""Every command that reads a foreign file ends in time, with a result or a one-line error."""

import io
import json
import os
import shutil
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path

import pytest

from hapkit_studio.analysis import survey
from hapkit_studio.cli import main
from hapkit_studio.errors import StudioError
from hapkit_studio.formatting import printable
from tests import foreign_files
from tests.analysis.sweep_tasks import Serial

COMMANDS: dict[str, tuple[tuple[str, ...], ...]] = {
    "session": (
        ("sessions", "list", "{folder}"),
        ("sessions", "show", "{file}"),
        ("sessions", "check", "{file}"),
        ("sessions", "export", "{file}", "--output", "{out}.csv"),
        ("sessions", "repair", "{file}", "--output", "{out}.hapkit"),
        ("identify", "{file}"),
    ),
    "calibration": (("calibrate", "no-such-port", "--from", "{file}"),),
    "csv": (
        ("identify", "{file}"),
        ("identify", "{file}", "--from", "0.01", "--released"),
    ),
    "survey": (("survey", "{file}", "--read"),),
    "lesson": (
        ("lessons", "check", "{file}"),
        ("lessons", "list", "--folder", "{folder}"),
    ),
    "handed in": (
        ("lessons", "grade", "{folder}", "--output", "{out}"),
        ("lessons", "report", "{file}", "--output", "{out}.html"),
    ),
    "review": (("lessons", "review", "{file}"),),
    "experiment": (("experiment", "pointing", "{file}"),),
}
"""Commands for each kind of file; {out} is a new path, which may be written."""
_OTHER_COMMANDS: dict[str, tuple[tuple[str, ...], ...]] = {
    "program": (("run", "{file}"), ("export", "{file}"), ("bode", "{file}")),
    "firmware": (("flash", "no-such-port", "--hex", "{file}"),),
}


class Hang(BaseException):
    """Raised when a command takes too long."""


@contextmanager
def limited(seconds: float = 2.0, waiting: float = 30.0) -> Iterator[None]:
    """Raise Hang after ``seconds`` of processor time, or after ``waiting`` seconds in all."""
    if sys.platform == "win32":
        yield
        return

    def end(number: int, _frame: object) -> None:
        raise Hang(signal.Signals(number).name)

    kept = [(number, signal.signal(number, end)) for number in (signal.SIGPROF, signal.SIGALRM)]
    signal.setitimer(signal.ITIMER_PROF, seconds)
    signal.setitimer(signal.ITIMER_REAL, waiting)
    try:
        yield
    finally:
        for timer in (signal.ITIMER_PROF, signal.ITIMER_REAL):
            signal.setitimer(timer, 0.0)
        for number, handler in kept:
            signal.signal(number, handler)


def run(args: list[str]) -> tuple[int, str, str]:
    """Run a command in this process; return its exit code and its output.

    The figures of a report take 0.5 to 1 s of processor time, and sometimes 2 s beside other programs.
    Therefore a report that exceeds the time limit runs a second time.
    """
    try:
        return run_once(args)
    except Hang:
        if "report" not in args:
            raise
        return run_once(args)


def run_once(args: list[str]) -> tuple[int, str, str]:
    out, error = io.StringIO(), io.StringIO()
    with limited(), redirect_stdout(out), redirect_stderr(error):
        try:
            code = main(args)
        except SystemExit as exit:
            code = exit.code
    return code, out.getvalue(), error.getvalue()


@pytest.fixture(scope="module")
def originals(tmp_path_factory) -> dict[str, bytes]:
    """Return a valid file of each kind, which its commands accept."""
    return foreign_files.originals(tmp_path_factory.mktemp("originals"))


@pytest.fixture
def try_file(originals, tmp_path) -> Callable[[str, int], list[str]]:
    """Return a function that gives one file to its commands, and returns a list of faults."""

    def try_one(kind: str, seed: int) -> list[str]:
        folder = tmp_path / f"{kind} {seed}"
        folder.mkdir()
        neighbour = folder / f"neighbour{foreign_files.SUFFIXES[kind]}"
        neighbour.write_bytes(originals[kind])
        file = foreign_files.write(kind, seed, originals[kind], folder)
        before, wrong = stamp(file), []
        for number, command in enumerate(COMMANDS[kind]):
            as_json = (seed + number) % 2 == 0
            places = {"folder": folder, "file": file, "out": folder / f"out{number}"}
            args = [*(word.format(**places) for word in command), *(["--json"] if as_json else [])]
            try:
                code, out, error = run(args)
            except (Exception, Hang) as failure:
                wrong.append(f"{command}: {type(failure).__name__}: {failure!s:.200}")
                continue
            wrong += [f"{command}: {text}" for text in complaints(code, out, error, as_json)]
            if "list" in command and neighbour.stem not in out:
                wrong.append(f"{command}: the neighbour is not listed")
        if stamp(file) != before:
            wrong.append("the file was changed")
        if neighbour.read_bytes() != originals[kind]:
            wrong.append("the neighbour was changed")
        shutil.rmtree(folder)
        return [f"{kind} {seed}: {text}" for text in wrong]

    return try_one


def stamp(file: Path) -> tuple:
    """Return a fingerprint of a file; a sparse file is not read."""
    facts = file.stat()
    return facts.st_size, facts.st_mtime_ns, file.read_bytes() if facts.st_size < 1 << 24 else b""


def complaints(code: int, out: str, error: str, as_json: bool) -> Iterator[str]:
    """Yield the faults of a command's output."""
    if code not in (0, 2):
        yield f"exit code {code}"
    if "Traceback" in out + error:
        yield "traceback"
    if printable(out + error) != out + error:
        yield f"control characters: {out + error!r:.200}"
    if (
        code == 2
        and error
        and (error.count("\n") != 1 or len(error) > 600 or not error.startswith("hapkit-studio"))
    ):
        yield f"not one line: {error!r:.200}"
    if as_json and out:
        try:
            json.loads(out)
        except ValueError:
            yield f"no JSON: {out!r:.200}"


@pytest.mark.slow
@pytest.mark.parametrize("kind", COMMANDS)
def test_a_good_file_is_accepted(originals, tmp_path, kind):
    """This test has no time limit, because the commands may compile code."""
    file = tmp_path / f"good{foreign_files.SUFFIXES[kind]}"
    file.write_bytes(originals[kind])
    for number, command in enumerate(COMMANDS[kind]):
        places = {"folder": tmp_path, "file": file, "out": tmp_path / f"out {number}"}
        code = main([word.format(**places) for word in command])
        # a calibration fails, because its port does not exist
        assert code == (2 if kind == "calibration" else 0), command


@pytest.mark.parametrize("kind", COMMANDS)
def test_some_foreign_files_give_an_answer_or_one_line(try_file, kind):
    assert [text for seed in foreign_files.FEW for text in try_file(kind, seed)] == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", COMMANDS)
def test_many_foreign_files_give_an_answer_or_one_line(try_file, kind):
    found = [text for seed in range(foreign_files.COUNTS[kind]) for text in try_file(kind, seed)]
    assert not found, "\n".join([f"{len(found)} complaints", *found])


@pytest.mark.slow
def test_a_survey_is_resumed_or_rejected(originals, tmp_path):
    """Every seed writes a new copy of the file, because the survey extends the file."""
    for seed in range(100):
        file = foreign_files.write("survey", seed, originals["survey"], tmp_path)
        with limited():
            try:
                survey.compute(file, foreign_files.AXES, Serial())
                whole = survey.known(survey.read(file)[1]) == 32
            except StudioError as error:
                whole = "\n" not in str(error)
        assert whole, seed
        file.unlink()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no FIFO in its file system")
@pytest.mark.parametrize("kind", [*COMMANDS, "program", "firmware"])
def test_a_fifo_is_refused_at_once(tmp_path, kind):
    file = tmp_path / f"x{foreign_files.SUFFIXES.get(kind, '.py')}"
    os.mkfifo(file)
    for number, command in enumerate((COMMANDS | _OTHER_COMMANDS)[kind]):
        places = {"folder": tmp_path, "file": file, "out": tmp_path / f"out {number}"}
        code, out, error = run([word.format(**places) for word in command])
        assert not list(complaints(code, out, error, False)), command
        assert code == 2 or "list" in command


def test_a_foreign_name_is_shortened_in_every_message_of_a_table(tmp_path):
    """The names are 5,000 digits, and 5,000 control characters."""
    for name in ("9" * 5000, "\x1b" * 5000):
        file = tmp_path / "long.csv"
        rows = "".join(f"{k},{k},{k},1\n" for k in range(40))
        for header in (f"time_s,position_m,{name}x,a\n", f"time_s,position_m,force_applied_N,{name}x\n"):
            file.write_text(f"{header}{rows}")
            for column in ("a:N", f"{name}x:N", f"{name}:N", name, f"a:{name}"):
                code, out, error = run(["identify", str(file), "--force", column])
                assert not list(complaints(code, out, error, False)), (header[:60], column[:60])
