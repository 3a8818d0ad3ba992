"""Tries out a file in a program of its own, ``python -m hapkit_studio.workshop.trial PATH``; it prints JSON.

Whatever the file does, the window that asked goes on: it only waits for words on a pipe. Knows no Qt.
"""

import contextlib
import json
import os
import subprocess
import sys
from pathlib import Path

from hapkit_studio.workshop import apart, source
from hapkit_studio.workshop.source import Source
from hapkit_studio.workshop.verdict import Verdict, failed

TIMEOUT = 20.0
NO_END = "does not come to an end"
_GONE = "ended the program that tried it: remove what exits"
_CRASHED = "crashed Python"
_LAST_WORDS_SECONDS = 0.02
_MODULE = "hapkit_studio.workshop.trial"


def begin(tried: Source) -> subprocess.Popen:
    """Start trying out a text; poll() the process, then take its `result`, or `stop` it after TIMEOUT."""
    process = apart.begin(_MODULE, str(tried.path))
    with contextlib.suppress(BrokenPipeError), process.stdin as its_input:  # type: ignore[union-attr]
        its_input.write(tried.text.encode())
    process.stdin = None
    return process


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
        apart.end(process)
        words, _ = process.communicate()
    return _verdict(words, _GONE if 0 <= process.returncode < 256 else _CRASHED)


def stop(process: subprocess.Popen) -> Verdict:
    """Kill a trial that takes too long, and what it started; return the verdict that says so."""
    apart.end(process)
    return _verdict(process.communicate()[0], NO_END)


def check(tried: Source, timeout: float = TIMEOUT) -> Verdict:
    """Try out a text and wait for the verdict, up to timeout in s."""
    return result(begin(tried), timeout)


def _verdict(words: bytes, otherwise: str) -> Verdict:
    """Return the verdict that was printed last; where there is none, what happened to whatever ran then."""
    name, line = "the file", 0
    try:
        found = json.loads(words.decode().splitlines()[-1])
        if "problems" in found:
            return Verdict.from_json(found)
        name, line = f"`{found['function']}`", int(found["line"])
    except (ValueError, KeyError, TypeError, IndexError):
        pass
    return failed(f"{name} {otherwise}", line)


def main(path: str) -> None:
    """Print the verdict on a text, whose file has this path, as JSON; before it, a line for each function."""
    heard, said = apart.pipes()
    apart.last_for(2 * TIMEOUT)
    if sys.platform != "win32":
        os.nice(10)
    apart.take_little_memory()
    from hapkit_studio.workshop import trying

    def tell(found: dict) -> None:
        said.write(json.dumps(found).encode() + b"\n")

    try:
        tried = source.typed(Path(path), heard.read().decode())
        tell(trying.try_out(tried, lambda name, line: tell({"function": name, "line": line})).as_json())
    finally:
        os._exit(0)  # not a moment longer: threads and exit functions of the file do not run on


if __name__ == "__main__":
    main(sys.argv[1])
