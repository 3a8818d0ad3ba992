"""Work that may take every core and disturbs nobody: its thread runs when nothing else wants to."""

import contextlib
import ctypes
import os
import sys
import threading

_NICEST = 19
# sys/resource.h: the calling thread, and the band that all other threads go before
_DARWIN_THREAD, _DARWIN_BACKGROUND = 3, 0x1000
# winbase.h
_WINDOWS_IDLE = -15


def low_priority() -> None:
    """Put the calling thread below everything else; where the system has no way to, it stays as it is."""
    with contextlib.suppress(OSError, AttributeError):
        if sys.platform == "linux":
            _below_all_on_linux()
        elif sys.platform == "darwin":
            os.setpriority(_DARWIN_THREAD, 0, _DARWIN_BACKGROUND)
        elif sys.platform == "win32":
            kernel = ctypes.WinDLL("kernel32")
            kernel.GetCurrentThread.restype = ctypes.c_void_p
            kernel.SetThreadPriority.argtypes = [ctypes.c_void_p, ctypes.c_int]
            kernel.SetThreadPriority(kernel.GetCurrentThread(), _WINDOWS_IDLE)


def _below_all_on_linux() -> None:
    """Take SCHED_IDLE for this thread alone; 0 is the calling thread here, not the program."""
    try:
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    except OSError:
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICEST)
