"""Try a file in another process, ``python -m hapkit_studio.workshop.trial PATH``, which prints JSON.

The window stays responsive whatever the file does, because it only polls a pipe. The module does not depend
on Qt. Outcomes are cached by content, so returning to an older version needs no new trial.
"""

import contextlib
import hashlib
import json
import os
import subprocess
import sys
import time
from dataclasses import asdict
from pathlib import Path

import platformdirs

from hapkit_studio import files
from hapkit_studio.errors import FileError
from hapkit_studio.laws.native import MAX_AGE_SECONDS
from hapkit_studio.program import configured_cache
from hapkit_studio.version import __version__
from hapkit_studio.workshop import isolated, source, trying
from hapkit_studio.workshop.source import Source
from hapkit_studio.workshop.trying import TrialResult, failed

_PASSED, _FAILED = "passed", "failed"


def has_passed(source: Source) -> bool:
    """Return True if this content passed a trial with the same studio, Python version and cache."""
    return _outcome(source) == _PASSED


def has_failed(source: Source) -> bool:
    """Return True if this content failed its last trial with the same studio, Python version and cache."""
    return _outcome(source) == _FAILED


def remember(source: Source, passed: bool) -> None:
    """Store the outcome of a trial; if this fails, the trial is repeated next time.

    Outcomes are removed at the same age as compiled laws.
    """
    record = _record(source)
    with contextlib.suppress(OSError):
        record.parent.mkdir(parents=True, exist_ok=True)
        record.write_text(_PASSED if passed else _FAILED, encoding="ascii")
        for other in record.parent.glob("*"):
            if time.time() - other.stat().st_mtime > MAX_AGE_SECONDS:
                other.unlink(missing_ok=True)


def _outcome(source: Source) -> str:
    try:
        return files.read_text(_record(source))
    except FileError:
        return ""


def _record(source: Source) -> Path:
    cache, file = configured_cache(), str(source.path.absolute())
    facts = (file, source.digest, sys.version, sys.prefix, __version__, cache)
    name = hashlib.sha256("\n".join(facts).encode("utf-8", "surrogatepass")).hexdigest()[:20]
    return Path(platformdirs.user_cache_dir("hapkit-studio", appauthor=False)) / "tried" / f"{name}.txt"


TIMEOUT = 20.0
NO_END = "does not end"
_GONE = "ended Python: remove calls such as exit()"
_CRASHED = "crashed Python"
_LAST_WORDS_SECONDS = 0.02
_MODULE = "hapkit_studio.workshop.trial"


def begin(tried: Source) -> subprocess.Popen:
    """Start a trial. The caller polls the process, then calls ``result``, or ``stop`` after TIMEOUT."""
    process = isolated.begin(_MODULE, str(tried.path))
    with contextlib.suppress(BrokenPipeError), process.stdin as its_input:  # type: ignore[union-attr]
        its_input.write(tried.text.encode())
    process.stdin = None
    return process


def result(process: subprocess.Popen, timeout: float = TIMEOUT) -> TrialResult:
    """Return a trial's verdict; wait for it up to ``timeout`` in s, then kill the trial."""
    try:
        process.wait(timeout)
    except subprocess.TimeoutExpired:
        return stop(process)
    try:
        # a process that the file has started may still have the pipe open
        output, _ = process.communicate(timeout=_LAST_WORDS_SECONDS)
    except subprocess.TimeoutExpired:
        isolated.end(process)
        output, _ = process.communicate()
    return _verdict(output, _GONE if 0 <= process.returncode < 256 else _CRASHED)


def stop(process: subprocess.Popen) -> TrialResult:
    """Kill a trial and its children after a time-out; return the verdict."""
    isolated.end(process)
    return _verdict(process.communicate()[0], NO_END)


def check(tried: Source, timeout: float = TIMEOUT) -> TrialResult:
    """Run a trial, and wait up to ``timeout`` in s for its verdict."""
    process = begin(tried)
    try:
        return result(process, timeout)
    except BaseException:  # for example Ctrl+C
        isolated.end(process)
        raise


def _verdict(output: bytes, otherwise: str) -> TrialResult:
    """Return the last verdict in the output; without one, a verdict on the function that ran last."""
    name, line = "the file", 0
    try:
        found = files.parse_json(output.decode().splitlines()[-1], "verdict")
        if "problems" in found:
            return TrialResult.from_json(found)
        name, line = f"`{found['function']}`", int(found["line"])
    except (ValueError, KeyError, TypeError, IndexError, OverflowError):
        pass
    return failed(f"{name} {otherwise}", line)


def main(path: str) -> None:
    """Try the text from the standard input, and print the verdict as JSON.

    One line for each called function is printed before the verdict. ``path`` is the path of the text's file.
    """
    requests, replies = isolated.take_pipes()
    isolated.exit_after(2 * TIMEOUT)
    if sys.platform != "win32":
        os.nice(10)
    isolated.limit_memory()

    def report(found: dict) -> None:
        replies.write(json.dumps(found).encode() + b"\n")

    try:
        tried = source.typed(Path(path), requests.read().decode())
        report(asdict(trying.try_out(tried, lambda name, line: report({"function": name, "line": line}))))
    finally:
        os._exit(0)  # exit at once, because threads and exit handlers of the file must not run


if __name__ == "__main__":
    main(sys.argv[1])
