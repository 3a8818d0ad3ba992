"""Real-time priority on Windows for the calling thread: the Multimedia Class Scheduler's "Pro Audio" task.

Source: avrt.h; the scheduler itself keeps a share of the processor for other threads.
"""

import ctypes
import threading
from typing import Any

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.haptics import clib

_PRIORITY_CRITICAL = 2
_PRIORITY_NORMAL = 0
_task = threading.local()


def obtain(library: Any = None) -> tuple[str, int]:
    """Join the task "Pro Audio" at critical priority; return the words and the level (0: none)."""
    library = _declared(library or ctypes.WinDLL("avrt"))  # type: ignore[attr-defined]
    index = ctypes.c_uint32(0)
    handle = library.AvSetMmThreadCharacteristicsW("Pro Audio", ctypes.byref(index))
    if not handle:
        return "Normal priority", 0
    _task.handle = handle
    library.AvSetMmThreadPriority(handle, _PRIORITY_CRITICAL)
    return "Real-time, Pro Audio", 1


def is_realtime(thread: int) -> bool:
    """Say yes: this system takes a thread's priority away only for moments, and never for good."""
    return True


def release(library: Any = None) -> None:
    """Leave the task."""
    handle = getattr(_task, "handle", None)
    if handle:
        _declared(library or ctypes.WinDLL("avrt")).AvRevertMmThreadCharacteristics(handle)  # type: ignore[attr-defined]
        _task.handle = None


@compiled
def demote() -> None:
    """Give the calling thread normal priority at once, from compiled code."""
    clib.SetThreadPriority(clib.GetCurrentThread(), _PRIORITY_NORMAL)


def how_to_get_more(level: int) -> str:
    """Return in one sentence what would raise the priority, empty at the top."""
    return (
        ""
        if level
        else "Start the Windows service 'Multimedia Class Scheduler' (MMCSS) and open the studio again."
    )


def _declared(library: Any) -> Any:
    handle = ctypes.c_void_p
    library.AvSetMmThreadCharacteristicsW.restype = handle
    library.AvSetMmThreadCharacteristicsW.argtypes = [ctypes.c_wchar_p, ctypes.c_void_p]
    library.AvSetMmThreadPriority.argtypes = [handle, ctypes.c_int]
    library.AvRevertMmThreadCharacteristics.argtypes = [handle]
    return library
