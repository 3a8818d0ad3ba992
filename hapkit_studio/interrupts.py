"""Ctrl+C at any time: the program ends with exit code 130, without a traceback.

While the program imports and when its work is done, it exits at once. While a command works, Ctrl+C raises
KeyboardInterrupt, so that motors are stopped and files are closed. Python does that only between two steps of
its own, not in the middle of compiled code. But it writes a byte into a socket as soon as a signal comes
(``signal.set_wakeup_fd``): compiled loops look whether one is there, without taking it, and return.

Imports little, as Ctrl+C before that is not caught.
"""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager

TYPE_CHECKING = False
if TYPE_CHECKING:
    from socket import socket
    from types import FrameType

INTERRUPTED = 130  # exit code: 128 and the number of SIGINT
_AGAIN_SECONDS = 0.02
_ends: "list[socket]" = []


def exit_at_once(_number: int, _frame: "FrameType | None") -> None:
    """End this process: the handler of SIGINT while nothing needs to be put in order."""
    os._exit(INTERRUPTED)


def begin() -> None:
    """Exit at once at Ctrl+C from now on, but where KeyboardInterrupt is ``raised``; for programs only."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # not where a parent has it ignored
        signal.signal(signal.SIGINT, exit_at_once)
        sys.unraisablehook = _raise_again
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT,))


@contextmanager
def held_back() -> Iterator[None]:
    """Start programs in here: Ctrl+C, which a terminal sends to all, waits in them until they ``begin``."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT,))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _raise_again(unraisable: "sys.UnraisableHookArgs") -> None:
    """Repeat an interrupt that came while an object was deleted, where Python can only report it."""
    if issubclass(unraisable.exc_type, KeyboardInterrupt):
        import threading

        threading.Timer(_AGAIN_SECONDS, _interrupt).start()
    else:
        sys.__unraisablehook__(unraisable)


def _interrupt() -> None:
    """Interrupt the main thread, whatever it waits for."""
    import _thread
    import threading

    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
    else:
        _thread.interrupt_main()


@contextmanager
def raised() -> Iterator[None]:
    """Let Ctrl+C raise KeyboardInterrupt in here."""
    exits = signal.getsignal(signal.SIGINT) is exit_at_once
    if exits:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        if exits:
            signal.signal(signal.SIGINT, exit_at_once)


def listen() -> None:
    """Begin to listen for compiled code, or forget what came until now; only the main thread may."""
    import threading

    if threading.current_thread() is not threading.main_thread():
        return
    if not _ends:
        _connect()
    try:
        while _ends and _ends[0].recv(1024):
            pass
    except BlockingIOError:
        pass  # nothing is left


def _connect() -> None:
    import socket

    near, far = socket.socketpair()
    for end in (near, far):
        end.setblocking(False)
    before = signal.set_wakeup_fd(far.fileno(), warn_on_full_buffer=False)
    if before == -1:
        _ends[:] = near, far
        return
    signal.set_wakeup_fd(before)  # whoever runs this program listens already
    near.close()
    far.close()


def fileno() -> int:
    """Return the socket that has a byte once a signal came, -1 while nobody listens."""
    return _ends[0].fileno() if _ends else -1
