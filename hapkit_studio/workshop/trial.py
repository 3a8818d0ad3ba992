"""Try out a file in another process, ``python -m hapkit_studio.workshop.trial PATH``, which prints JSON.

Whatever the file does, the window that asked goes on: it only waits for words on a pipe. Knows no Qt. How a
text fared is remembered: going back to an older version of a file needs no trial.
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
from hapkit_studio.laws.native import KEPT_SECONDS
from hapkit_studio.version import __version__
from hapkit_studio.workshop import isolated, source, trying
from hapkit_studio.workshop.source import Source
from hapkit_studio.workshop.trying import TrialResult, failed

_PASSED, _FAILED = "passed", "failed"


def has_passed(source: Source) -> bool:
    """Say whether this text of a file passed its trial with this studio, this Python and this cache."""
    return _outcome(source) == _PASSED


def has_failed(source: Source) -> bool:
    """Say whether this text of a file failed its last trial, in the same surroundings."""
    return _outcome(source) == _FAILED


def remember(source: Source, passed: bool) -> None:
    """Remember how a trial ended; where nothing can be written, it is tried again another time.

    Records as old as the oldest compiled laws go.
    """
    record = _record(source)
    with contextlib.suppress(OSError):
        record.parent.mkdir(parents=True, exist_ok=True)
        record.write_text(_PASSED if passed else _FAILED, encoding="ascii")
        for other in record.parent.glob("*"):
            if time.time() - other.stat().st_mtime > KEPT_SECONDS:
                other.unlink(missing_ok=True)


def _outcome(source: Source) -> str:
    try:
        return files.read_text(_record(source))
    except FileError:
        return ""


def _record(source: Source) -> Path:
    cache, file = os.environ.get("NUMBA_CACHE_DIR", ""), str(source.path.absolute())
    facts = (file, source.digest, sys.version, sys.prefix, __version__, cache)
    name = hashlib.sha256("\n".join(facts).encode("utf-8", "surrogatepass")).hexdigest()[:20]
    return Path(platformdirs.user_cache_dir("hapkit-studio", appauthor=False)) / "tried" / f"{name}.txt"


TIMEOUT = 20.0
NO_END = "does not come to an end"
_GONE = "ended the program that tried it: remove what exits"
_CRASHED = "crashed Python"
_LAST_WORDS_SECONDS = 0.02
_MODULE = "hapkit_studio.workshop.trial"


def begin(tried: Source) -> subprocess.Popen:
    """Start trying out a text; poll() the process, then take its `result`, or `stop` it after TIMEOUT."""
    process = isolated.begin(_MODULE, str(tried.path))
    with contextlib.suppress(BrokenPipeError), process.stdin as its_input:  # type: ignore[union-attr]
        its_input.write(tried.text.encode())
    process.stdin = None
    return process


def result(process: subprocess.Popen, timeout: float = TIMEOUT) -> TrialResult:
    """Return a trial's verdict; wait for it up to timeout in s, then kill it."""
    try:
        process.wait(timeout)
    except subprocess.TimeoutExpired:
        return stop(process)
    try:
        # what the file started may still hold the pipe
        words, _ = process.communicate(timeout=_LAST_WORDS_SECONDS)
    except subprocess.TimeoutExpired:
        isolated.end(process)
        words, _ = process.communicate()
    return _verdict(words, _GONE if 0 <= process.returncode < 256 else _CRASHED)


def stop(process: subprocess.Popen) -> TrialResult:
    """Kill a trial that takes too long, and what it started; return the verdict that says so."""
    isolated.end(process)
    return _verdict(process.communicate()[0], NO_END)


def check(tried: Source, timeout: float = TIMEOUT) -> TrialResult:
    """Try out a text and wait for the verdict, up to timeout in s."""
    process = begin(tried)
    try:
        return result(process, timeout)
    except BaseException:  # Ctrl+C
        isolated.end(process)
        raise


def _verdict(words: bytes, otherwise: str) -> TrialResult:
    """Return the verdict that was printed last; where there is none, what happened to whatever ran then."""
    name, line = "the file", 0
    try:
        found = files.parse_json(words.decode().splitlines()[-1], "verdict")
        if "problems" in found:
            return TrialResult.from_json(found)
        name, line = f"`{found['function']}`", int(found["line"])
    except (ValueError, KeyError, TypeError, IndexError, OverflowError):
        pass
    return failed(f"{name} {otherwise}", line)


def main(path: str) -> None:
    """Print the verdict on a text, whose file has this path, as JSON; before it, a line for each function."""
    heard, said = isolated.take_pipes()
    isolated.exit_after(2 * TIMEOUT)
    if sys.platform != "win32":
        os.nice(10)
    isolated.limit_memory()

    def tell(found: dict) -> None:
        said.write(json.dumps(found).encode() + b"\n")

    try:
        tried = source.typed(Path(path), heard.read().decode())
        tell(asdict(trying.try_out(tried, lambda name, line: tell({"function": name, "line": line}))))
    finally:
        os._exit(0)  # not a moment longer: threads and exit functions of the file do not run on


if __name__ == "__main__":
    main(sys.argv[1])
