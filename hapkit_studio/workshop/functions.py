"""Functions of a user's file, called in a separate process so that they cannot block the window or a run.

The process is ``function_process``: it receives a line of JSON with the text, then one line per call. Time is
limited on every system. Memory is limited on Linux; elsewhere only the limited time restricts allocation.
The studio's process also executes the file's module-level code, without limits, because it creates the law.
"""

import contextlib
import json
import math
import subprocess
import threading
import weakref
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from typing import Any

import numpy as np

from hapkit_studio.environments.base import Conditions, Environment
from hapkit_studio.worker import Worker
from hapkit_studio.workshop import isolated
from hapkit_studio.workshop.source import Source

START_SECONDS = 20.0
CALL_SECONDS = 1.0
MOST_BYTES = 1_000_000
_MODULE = "hapkit_studio.workshop.function_process"


def _pair(found: Any) -> tuple[float, float]:
    """Return an impedance as two finite numbers; raise TypeError or ValueError for any other value."""
    stiffness, damping = map(float, found)
    if not (math.isfinite(stiffness) and math.isfinite(damping)):
        raise ValueError
    return stiffness, damping


_CURVE = (partial(np.asarray, dtype=float), lambda values, along: np.full(len(along), math.nan), "numbers")
# For each function: a conversion of the result, which raises TypeError or ValueError; the default for an
# invalid result; a description of the type.
GIVES: Mapping[str, tuple[Callable, Callable, str]] = {
    "check": (str, lambda values: "", "text"),
    "warnings": (lambda found: tuple(map(str, found)), lambda values, conditions: (), "a list of text"),
    "unused": (
        lambda found: {str(key): str(text) for key, text in dict(found).items()},
        lambda values: {},
        "text by the names of parameters",
    ),
    "impedance": (_pair, lambda values: (0.0, 0.0), "(stiffness, damping)"),
    "over_position": _CURVE,
    "over_velocity": _CURVE,
}


def overridden(environment: Environment) -> list[str]:
    """Return the names of the functions that an environment overrides."""
    return [name for name in GIVES if getattr(environment, name) is not getattr(Environment, name)]


class Functions:
    """The functions of one file; the first one that exceeds its time or memory disables all of them."""

    def __init__(self, owner: Source):
        self._source = owner
        self.off = ""
        self._lock = threading.RLock()
        self._worker = Worker("own-functions")
        self._process: subprocess.Popen | None = None
        self._hello: Future[bytes] | None = None

    def begin(self) -> None:
        """Start the process unless it is running."""
        with self._lock:
            if self._process is not None or self.off:
                return
            try:
                self._process = isolated.begin(_MODULE, str(self._source.path))
            except OSError as error:
                self.off = f"The functions of {self._source.path.name} cannot be called: {error.strerror}."
                return
            weakref.finalize(self, _end, self._process)
            self._hello = self._request(self._source.text)

    @property
    def ready(self) -> bool:
        """Return True if a call does not have to wait until the process has started."""
        return bool(self.off) or (self._hello is not None and self._hello.done())

    def call(self, name: str, *args: Any) -> Any:
        """Return a function's result, or its default if it raises, returns a wrong type or is disabled."""
        convert, otherwise, _ = GIVES[name]
        found = self._answer(name, *args)
        return otherwise(*args) if found is None else convert(found)

    def _answer(self, name: str, *args: Any) -> Any:
        with self._lock:
            self.begin()
            if self.off:
                return None
            try:
                self._hello.result(START_SECONDS)  # type: ignore[union-attr]
                return json.loads(self._request([name, *args]).result(CALL_SECONDS))
            except (TimeoutError, OSError, ValueError, RecursionError):
                isolated.end(self._process)  # type: ignore[arg-type]
                self._process.wait()  # type: ignore[union-attr]
                self.off = (
                    f"`{name}` of {self._source.path.name} took more than {CALL_SECONDS:g} s or too much "
                    "memory: its functions except the law are switched off."
                )
                return None

    def _request(self, request: Any) -> "Future[bytes]":
        """Send a line; return a future of the reply, which is empty if the process has ended."""
        line = json.dumps(request, default=_plain).encode() + b"\n"
        return self._worker.submit(_exchange, self._process, line)


def _exchange(process: Any, line: bytes) -> bytes:
    process.stdin.write(line)
    process.stdin.flush()
    return process.stdout.readline(MOST_BYTES)


def _end(process: Any) -> None:
    """Kill a process that is no longer needed."""
    isolated.end(process)
    process.wait()
    with contextlib.suppress(OSError):
        process.stdin.close()
    process.stdout.close()


def _plain(value: Any) -> Any:
    """Return a function's argument as JSON data."""
    if isinstance(value, Conditions | Mapping):
        return vars(value) if isinstance(value, Conditions) else dict(value)
    return np.asarray(value).tolist()
