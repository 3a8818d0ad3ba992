"""Ctrl+C ends the program at any time with exit code 130; a closed or full output ends it with code 2."""

import os
import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest

from hapkit_studio import files, interrupts
from hapkit_studio.cli import main
from hapkit_studio.commands import base

posix = pytest.mark.skipif(os.name != "posix", reason="signals and special files of POSIX")

# this program gets SIGINT at the import of a module or the call of a function
PROGRAM = """
import builtins, signal, sys
imported = builtins.__import__
def importing(name, *rest):
    if name == {module!r}:
        builtins.__import__ = imported
        signal.raise_signal(signal.SIGINT)
    return imported(name, *rest)
builtins.__import__ = importing
{first}
from hapkit_studio.cli import main
sys.argv[1:] = {args!r}
sys.exit(main())
"""


def program(folder, *args, module="", first=""):
    """Run the program in a folder; return the process's result."""
    code = PROGRAM.format(module=module, first=first, args=list(args))
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False, cwd=folder
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "args"),
    [
        ("json", ("environments",)),
        ("numpy", ("environments",)),
        ("numba", ("environments",)),
        ("hapkit_studio.commands.base", ("run", "wall", "--seconds", "0.1")),
        (
            "matplotlib.backend_bases",
            ("run", "wall", "--seconds", "0.1", "--plot", "run.png"),
        ),  # the signal arrives during a command
    ],
)
def test_an_interrupt_during_imports_exits_silently(module, args, tmp_path):
    done = program(tmp_path, *args, module=module)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


def test_an_interrupt_while_the_program_ends_gives_the_same_code(tmp_path):
    done = program(
        tmp_path, "environments", first="import atexit; atexit.register(signal.raise_signal, signal.SIGINT)"
    )
    assert (done.returncode, done.stderr) == (130, "")


def test_an_interrupt_in_a_destructor_is_raised_again():
    def deletes_and_waits():
        interrupts._raise_again(SimpleNamespace(exc_type=KeyboardInterrupt))
        threading.Event().wait(60.0)

    with pytest.raises(KeyboardInterrupt):
        deletes_and_waits()


def test_endless_threads_and_exit_functions_do_not_keep_the_program_alive():
    """A user's file may start such threads and functions; here a command starts them."""
    code = (
        "import atexit, sys, threading\n"
        "from hapkit_studio import cli\n"
        "def command(given):\n"
        "    {start}\n"
        "    print('result')\n"
        "    return 7\n"
        "cli._run, cli.EXIT_SECONDS = command, 0.05\n"
        "sys.exit(cli.main())"
    )
    for start in (
        "threading.Thread(target=threading.Event().wait).start()",
        "atexit.register(threading.Event().wait)",
    ):
        run = [sys.executable, "-c", code.format(start=start)]
        # the forced exit must not lose output that is still in a buffer
        buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
        done = subprocess.run(run, capture_output=True, text=True, timeout=60, check=False, env=buffered)
        assert (done.returncode, done.stdout, done.stderr) == (7, "result\n", "")


@posix
def test_child_processes_ignore_interrupts_until_they_begin():
    tell = "import signal; print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []))"
    with interrupts.deferred():
        held = subprocess.run([sys.executable, "-S", "-c", tell], capture_output=True, text=True, check=True)
    assert held.stdout == "True\n"
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])
    begin = f"from hapkit_studio import interrupts; interrupts.begin(); {tell}"
    with interrupts.deferred():
        begun = subprocess.run([sys.executable, "-c", begin], capture_output=True, text=True, check=True)
    assert begun.stdout == "False\n"


@pytest.mark.slow
@posix
def test_ctrl_c_in_a_survey_ends_its_processes_at_once(tmp_path):
    """The signal is sent to the whole process group, as a terminal does."""
    args = ["-m", "hapkit_studio", "survey", str(tmp_path / "s.db"), "--rates", "9", "--delays", "9"]
    pipe = subprocess.PIPE
    survey = subprocess.Popen([sys.executable, *args], stdout=pipe, stderr=pipe, start_new_session=True)
    try:
        while not (tmp_path / "s.db").exists():
            assert survey.poll() is None
        os.killpg(survey.pid, signal.SIGINT)
        # this call ends when all processes have closed their outputs
        out, err = survey.communicate(timeout=60)
    finally:
        survey.kill()
    assert (survey.returncode, out, err) == (130, b"", b"")


# --- outputs


class Closed:
    """An output that its reader has closed."""

    def write(self, text=""):
        raise BrokenPipeError(32, "Broken pipe")

    flush = write

    def fileno(self):
        raise OSError


def test_a_closed_reader_gives_a_code_without_message(monkeypatch, capsys):
    for args in (["environments"], ["environments", "--json"], ["--help"], ["--version"]):
        monkeypatch.setattr(sys, "stdout", SimpleNamespace(write=Closed().write, flush=lambda: None))
        assert main(args) == 2
        assert capsys.readouterr().err == ""


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is always full")
def test_a_full_output_is_reported_in_a_line(monkeypatch, capsys):
    for args in (["environments"], ["environments", "--json"], ["--help"]):
        with open("/dev/full", "w", encoding="utf-8") as full:
            monkeypatch.setattr(sys, "stdout", full)
            assert main(args) == 2
        assert capsys.readouterr().err == "hapkit-studio: output: No space left on device\n"


def test_a_closed_output_is_reported_in_a_line_before_any_work(monkeypatch, capsys):
    monkeypatch.setattr(base, "check_outputs", lambda _: pytest.fail("its start"))
    monkeypatch.setattr(sys, "stdout", None)
    assert main(["environments"]) == 2
    assert capsys.readouterr().err == "hapkit-studio: the output is closed.\n"


def test_errors_without_a_reader_keep_their_code(monkeypatch, capsys):
    for stream in (None, Closed()):
        monkeypatch.setattr(sys, "stderr", stream)
        assert main(["run", "nowhere"]) == 2
        assert capsys.readouterr().out == ""


# --- special files


@pytest.fixture
def fifo(tmp_path):
    """Return a FIFO's path and a future of its bytes; a thread reads them, as a pipe's buffer is small."""
    path = tmp_path / "pipe"
    os.mkfifo(path)
    with ThreadPoolExecutor(1) as pool:
        yield path, pool.submit(path.read_bytes)


@pytest.mark.slow
@posix
@pytest.mark.parametrize(
    ("args", "begins"),
    [
        (("run", "wall", "--seconds", "0.05", "--csv"), b"# "),
        (("run", "wall", "--seconds", "0.05", "--plot"), b"\x89PNG"),
        (("export", "wall", "-o"), b"//"),
    ],
)
def test_a_special_file_is_written_directly_without_a_temporary_file(args, begins, fifo, tmp_path, capsys):
    path, received = fifo
    assert main([*args, str(path)]) == 0
    assert received.result(timeout=60).startswith(begins)
    assert [one.name for one in tmp_path.iterdir()] == ["pipe"]
    assert f"wrote {path}\n" in capsys.readouterr().out


@posix
def test_writing_to_a_link_replaces_its_target(tmp_path):
    there, link = tmp_path / "there.csv", tmp_path / "link.csv"
    there.write_text("old")
    link.symlink_to(there)
    with files.replacing(link) as part:
        part.write_text("new")
    assert (link.is_symlink(), there.read_text()) == (True, "new")
    assert not files.is_special(there)
    assert not files.is_special(tmp_path)
    assert not files.is_special(tmp_path / "nowhere")
    assert files.is_special(os.devnull)
