"""Handles Ctrl+C at any time: the exit code is 130, and there is no traceback.

During imports and after the program's work, Ctrl+C ends the process at once. During a command, Ctrl+C raises
KeyboardInterrupt, so that motors are stopped and files are closed. Python handles signals only between
bytecodes, not inside compiled code. However, Python writes a byte to a socket as soon as a signal arrives
(``signal.set_wakeup_fd``). Compiled loops check for this byte, without reading it, and return.

This module imports little, because Ctrl+C is not handled before its import has ended.
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

INTERRUPTED = 130  # exit code: 128 plus the number of SIGINT
_AGAIN_SECONDS = 0.02
_ends: "list[socket]" = []


def exit_at_once(_number: int, _frame: "FrameType | None") -> None:
    """Exit this process at once; this handles SIGINT while no clean-up is needed."""
    os._exit(INTERRUPTED)


def begin() -> None:
    """From now on, exit at once on Ctrl+C, except inside ``raised``; only programs may call this."""
    # If the parent process ignores SIGINT, this process inherits that.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, exit_at_once)
        sys.unraisablehook = _raise_again
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT,))


@contextmanager
def deferred() -> Iterator[None]:
    """Block SIGINT in processes started in the context until they call ``begin``.

    A terminal sends SIGINT to all its processes.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT,))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _raise_again(unraisable: "sys.UnraisableHookArgs") -> None:
    """Raise a KeyboardInterrupt from a destructor again, because Python would only print it."""
    if issubclass(unraisable.exc_type, KeyboardInterrupt):
        import threading

        threading.Timer(_AGAIN_SECONDS, _interrupt).start()
    else:
        sys.__unraisablehook__(unraisable)


def _interrupt() -> None:
    """Interrupt the main thread, even while it waits."""
    import _thread
    import threading

    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
    else:
        _thread.interrupt_main()


@contextmanager
def raised() -> Iterator[None]:
    """Within the context, let Ctrl+C raise KeyboardInterrupt."""
    exits = signal.getsignal(signal.SIGINT) is exit_at_once
    if exits:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        if exits:
            signal.signal(signal.SIGINT, exit_at_once)


def listen() -> None:
    """Start or reset the signal socket for compiled code; only the main thread may call this."""
    import threading

    if threading.current_thread() is not threading.main_thread():
        return
    if not _ends:
        _connect()
    try:
        while _ends and _ends[0].recv(1024):
            pass
    except BlockingIOError:
        pass  # the socket is empty


def _connect() -> None:
    import socket

    near, far = socket.socketpair()
    for end in (near, far):
        end.setblocking(False)
    before = signal.set_wakeup_fd(far.fileno(), warn_on_full_buffer=False)
    if before == -1:
        _ends[:] = near, far
        return
    signal.set_wakeup_fd(before)  # restore the wakeup socket of the host program
    near.close()
    far.close()


def fileno() -> int:
    """Return the file descriptor of the socket that a signal makes readable, or −1 without a socket."""
    return _ends[0].fileno() if _ends else -1
