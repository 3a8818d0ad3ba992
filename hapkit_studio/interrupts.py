"""Ctrl+C at any time: exit code 130 without a traceback.

During imports and after its work, the program exits at once. During a command, Ctrl+C raises
KeyboardInterrupt, so that motors are stopped and files are closed. Python handles signals only between
bytecodes, not inside compiled code. But it writes a byte to a socket as soon as a signal arrives
(``signal.set_wakeup_fd``): compiled loops check for it, without reading it, and return.

Imports little, as Ctrl+C is not handled before.
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
    """Exit this process at once: the handler of SIGINT while no clean-up is needed."""
    os._exit(INTERRUPTED)


def begin() -> None:
    """Exit at once on Ctrl+C from now on, except inside ``raised``; for programs only."""
    # a parent that ignores SIGINT passes that on
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, exit_at_once)
        sys.unraisablehook = _raise_again
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT,))


@contextmanager
def deferred() -> Iterator[None]:
    """Block SIGINT in processes started inside, which a terminal sends to all, until they call ``begin``."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT,))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _raise_again(unraisable: "sys.UnraisableHookArgs") -> None:
    """Re-raise a KeyboardInterrupt from a destructor, where Python only prints it."""
    if issubclass(unraisable.exc_type, KeyboardInterrupt):
        import threading

        threading.Timer(_AGAIN_SECONDS, _interrupt).start()
    else:
        sys.__unraisablehook__(unraisable)


def _interrupt() -> None:
    """Interrupt the main thread, even in a wait."""
    import _thread
    import threading

    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
    else:
        _thread.interrupt_main()


@contextmanager
def raised() -> Iterator[None]:
    """Let Ctrl+C raise KeyboardInterrupt inside."""
    exits = signal.getsignal(signal.SIGINT) is exit_at_once
    if exits:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        if exits:
            signal.signal(signal.SIGINT, exit_at_once)


def listen() -> None:
    """Start or reset the signal socket for compiled code; main thread only."""
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
    signal.set_wakeup_fd(before)  # the host program has its own wakeup socket
    near.close()
    far.close()


def fileno() -> int:
    """Return the socket that is readable after a signal, -1 without one."""
    return _ends[0].fileno() if _ends else -1
