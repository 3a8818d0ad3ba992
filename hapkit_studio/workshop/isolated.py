"""A separate process for a user's file, which can be killed whatever the file does."""

import contextlib
import faulthandler
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import BinaryIO

from hapkit_studio.program import module_command

_MORE_MEMORY = 2 * 2**30


def begin(module: str, *args: str) -> subprocess.Popen:
    """Start a module of the studio in a process with pipes for its standard streams."""
    apart: dict = {"start_new_session": True}
    if sys.platform == "win32":
        apart = {"creationflags": subprocess.BELOW_NORMAL_PRIORITY_CLASS | subprocess.CREATE_NO_WINDOW}
    pipe = subprocess.PIPE
    return subprocess.Popen(
        module_command(module, *args), stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, **apart
    )


def end(process: subprocess.Popen) -> None:
    """Kill a process and its children."""
    if sys.platform == "win32":
        process.kill()
        return
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)


def take_pipes() -> tuple[BinaryIO, BinaryIO]:
    """Return the streams from and to the parent process; text that the user's file prints is discarded."""
    requests, replies = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb", 0)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(nothing, stream)
    return requests, replies


def exit_after(seconds: float | None) -> None:
    """Exit this process after a time in s, even if the parent has ended; None cancels the exit."""
    faulthandler.cancel_dump_traceback_later()
    if seconds is not None:
        faulthandler.dump_traceback_later(seconds, exit=True)


def limit_memory() -> None:
    """Limit this process to 2 GB of additional memory; only Linux enforces it."""
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        most = pages * resource.getpagesize() + _MORE_MEMORY
        resource.setrlimit(resource.RLIMIT_AS, (most, resource.getrlimit(resource.RLIMIT_AS)[1]))
