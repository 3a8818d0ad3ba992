"""Real-time priority on macOS for the calling thread: Mach's time-constraint policy.

Source: <mach/thread_policy.h>; the kernel itself demotes a thread that exceeds what it asked for.
"""

import ctypes
from typing import Any

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.haptics import clib

_STANDARD_POLICY = 1
_TIME_CONSTRAINT_POLICY = 2
_PERIOD, _COMPUTATION, _CONSTRAINT = 1e-3, 0.2e-3, 0.5e-3


def obtain(library: Any = None) -> tuple[str, int]:
    """Ask for 0.2 ms of computing within 0.5 ms of every 1 ms; return the words and the level (0: none)."""
    library = library or ctypes.CDLL(None)
    ratio = (ctypes.c_uint32 * 2)()
    library.mach_timebase_info(ctypes.byref(ratio))
    per_second = 1e9 * ratio[1] / ratio[0]
    ticks = [round(seconds * per_second) for seconds in (_PERIOD, _COMPUTATION, _CONSTRAINT)]
    policy = (ctypes.c_uint32 * 4)(*ticks, 1)
    if library.thread_policy_set(_thread(library), _TIME_CONSTRAINT_POLICY, policy, 4) == 0:
        return "Real-time, time constraint", 1
    return "Normal priority", 0


def is_realtime(thread: int) -> bool:
    """Say yes: this system takes a thread's priority away only for moments, and never for good."""
    return True


def release(library: Any = None) -> None:
    """Give the calling thread the standard policy back."""
    library = library or ctypes.CDLL(None)
    library.thread_policy_set(_thread(library), _STANDARD_POLICY, (ctypes.c_uint32 * 1)(), 0)


@compiled
def demote() -> None:
    """Give the calling thread the standard policy at once, from compiled code."""
    clib.thread_policy_set(
        clib.pthread_mach_thread_np(clib.pthread_self()), _STANDARD_POLICY, clib.word_pair(), 0
    )


def how_to_get_more(level: int) -> str:
    """Return in one sentence what would raise the priority, empty at the top."""
    return (
        "" if level else "macOS refused the time-constraint policy; close what else uses it and start again."
    )


def _thread(library: Any) -> int:
    library.pthread_self.restype = ctypes.c_void_p
    library.pthread_mach_thread_np.argtypes = [ctypes.c_void_p]
    return library.pthread_mach_thread_np(library.pthread_self())
