"""Tries out a file in a program of its own, ``python -m hapkit_studio.workshop.trial FILE``; it prints JSON.

Whatever the file does, the window that asked goes on: it only waits for words on a pipe. Knows no Qt.
"""

import contextlib
import faulthandler
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

from hapkit_studio.workshop.verdict import Verdict, failed

TIMEOUT = 20.0
NO_END = "the file does not come to an end"
_GONE = "the file ended the program that tried it: remove what exits"
_CRASHED = "the file crashed Python"
_LAST_WORDS_SECONDS = 0.02
_MORE_MEMORY = 2 * 2**30
_MODULE = "hapkit_studio.workshop.trial"


def begin(path: str | Path, digest: str = "") -> subprocess.Popen:
    """Start trying out a file; poll() the process, then take its `result`, or `stop` it after TIMEOUT.

    With a digest (trust.digest of the text that a person saw) any other text is refused, not executed.
    """
    apart: dict = {"start_new_session": True}
    if sys.platform == "win32":
        apart = {"creationflags": subprocess.BELOW_NORMAL_PRIORITY_CLASS | subprocess.CREATE_NO_WINDOW}
    # -P: a file named like a module of Python, in the folder we stand in, is not that module
    command = [sys.executable, "-P", "-m", _MODULE, str(Path(path).absolute()), digest]
    quiet = subprocess.DEVNULL
    return subprocess.Popen(command, stdin=quiet, stdout=subprocess.PIPE, stderr=quiet, **apart)


def result(process: subprocess.Popen, timeout: float = TIMEOUT) -> Verdict:
    """Return a trial's verdict; wait for it up to timeout in s, then kill it."""
    try:
        process.wait(timeout)
    except subprocess.TimeoutExpired:
        return stop(process)
    try:
        # what the file started may still hold the pipe
        words, _ = process.communicate(timeout=_LAST_WORDS_SECONDS)
    except subprocess.TimeoutExpired:
        _kill(process)
        words, _ = process.communicate()
    try:
        return Verdict.from_json(json.loads(words.decode()))
    except (ValueError, KeyError, TypeError):
        return failed(_GONE if 0 <= process.returncode < 256 else _CRASHED)


def stop(process: subprocess.Popen) -> Verdict:
    """Kill a trial that takes too long, and what it started; return the verdict that says so."""
    _kill(process)
    process.communicate()
    return failed(NO_END)


def check(path: str | Path, digest: str = "", timeout: float = TIMEOUT) -> Verdict:
    """Try out a file and wait for the verdict, up to timeout in s."""
    return result(begin(path, digest), timeout)


def _kill(process: subprocess.Popen) -> None:
    if sys.platform == "win32":
        process.kill()
        return
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)


def main(file: str, digest: str = "") -> None:
    """Print the verdict on a file as one JSON object; what the file itself prints goes nowhere."""
    out = os.dup(1)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nothing, stream)
    _stand_back()
    from hapkit_studio.workshop import trying

    try:
        verdict = trying.try_file(Path(file), digest)
        os.write(out, json.dumps(verdict.as_json()).encode() + b"\n")
    finally:
        os._exit(0)  # not a moment longer: threads and exit functions of the file do not run on


def _stand_back() -> None:
    """Take low priority, little memory, and an end even where nobody is left to kill it."""
    faulthandler.dump_traceback_later(2 * TIMEOUT, exit=True)
    if sys.platform == "win32":
        return
    os.nice(10)
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        most = pages * resource.getpagesize() + _MORE_MEMORY
        resource.setrlimit(resource.RLIMIT_AS, (most, resource.getrlimit(resource.RLIMIT_AS)[1]))


if __name__ == "__main__":
    main(*sys.argv[1:3])
