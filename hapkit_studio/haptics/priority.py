"""Request the highest priority that the system grants to the loop's thread, and describe the result.

``obtain`` and ``release`` are called in the thread that they change, ``demote`` from compiled code. The
functions for Linux are in ``realtime_linux``. macOS uses a time-constraint policy (<mach/thread_policy.h>),
Windows the "Pro Audio" task of the Multimedia Class Scheduler (avrt.h). Both reserve processor time for other
threads.
"""

import ctypes
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.haptics import clib
from hapkit_studio.worker import Worker

_STANDARD_POLICY, _TIME_CONSTRAINT_POLICY = 1, 2
_PERIOD, _COMPUTATION, _CONSTRAINT = 1e-3, 0.2e-3, 0.5e-3
_PRIORITY_NORMAL, _PRIORITY_CRITICAL = 0, 2
_task = threading.local()


def macos_obtain(library: Any = None) -> tuple[str, int]:
    """Request 0.2 ms of computing within 0.5 ms of every 1 ms.

    Return a description and the level; 0 means that no priority was granted.
    """
    library = library or ctypes.CDLL(None)
    ratio = (ctypes.c_uint32 * 2)()
    library.mach_timebase_info(ctypes.byref(ratio))
    per_second = 1e9 * ratio[1] / ratio[0]
    ticks = [round(seconds * per_second) for seconds in (_PERIOD, _COMPUTATION, _CONSTRAINT)]
    policy = (ctypes.c_uint32 * 4)(*ticks, 1)
    if library.thread_policy_set(_macos_thread(library), _TIME_CONSTRAINT_POLICY, policy, 4) == 0:
        return "Real-time priority", 1
    return "Normal priority", 0


def macos_release(library: Any = None) -> None:
    """Restore the standard policy of the calling thread."""
    library = library or ctypes.CDLL(None)
    library.thread_policy_set(_macos_thread(library), _STANDARD_POLICY, (ctypes.c_uint32 * 1)(), 0)


@compiled
def macos_demote() -> None:
    """Restore the standard policy of the calling thread at once, from compiled code."""
    clib.thread_policy_set(
        clib.pthread_mach_thread_np(clib.pthread_self()), _STANDARD_POLICY, clib.word_pair(), 0
    )


def _macos_thread(library: Any) -> int:
    library.pthread_self.restype = ctypes.c_void_p
    library.pthread_mach_thread_np.argtypes = [ctypes.c_void_p]
    return library.pthread_mach_thread_np(library.pthread_self())


def windows_obtain(library: Any = None) -> tuple[str, int]:
    """Join the task "Pro Audio" at critical priority; return a description and the level (0: refused)."""
    library = _avrt(library)
    index = ctypes.c_uint32(0)
    handle = library.AvSetMmThreadCharacteristicsW("Pro Audio", ctypes.byref(index))
    if not handle:
        return "Normal priority", 0
    _task.handle = handle
    library.AvSetMmThreadPriority(handle, _PRIORITY_CRITICAL)
    return "Real-time priority", 1


def windows_release(library: Any = None) -> None:
    handle = getattr(_task, "handle", None)
    if handle:
        _avrt(library).AvRevertMmThreadCharacteristics(handle)
        _task.handle = None


@compiled
def windows_demote() -> None:
    """Restore normal priority of the calling thread at once, from compiled code."""
    clib.SetThreadPriority(clib.GetCurrentThread(), _PRIORITY_NORMAL)


def _avrt(library: Any) -> Any:
    library = library or ctypes.WinDLL("avrt")  # type: ignore[attr-defined]
    handle = ctypes.c_void_p
    library.AvSetMmThreadCharacteristicsW.restype = handle
    library.AvSetMmThreadCharacteristicsW.argtypes = [ctypes.c_wchar_p, ctypes.c_void_p]
    library.AvSetMmThreadPriority.argtypes = [handle, ctypes.c_int]
    library.AvRevertMmThreadCharacteristics.argtypes = [handle]
    return library


class System(NamedTuple):
    """The functions by which one operating system raises and restores the calling thread's priority."""

    obtain: Callable[[], tuple[str, int]]
    release: Callable[[], None]
    demote: Callable[[], None]
    how_to_get_more: str
    enough: int = 1  # at this level or a higher one, no more priority can be granted
    # by default, the system does not withdraw the priority during the thread's life
    is_realtime: Callable[[int], bool] = lambda thread: True


SYSTEMS = {
    "darwin": System(
        macos_obtain,
        macos_release,
        macos_demote,
        "macOS refused the time-constraint policy; close other programs that use it and start again.",
    ),
    "win32": System(
        windows_obtain,
        windows_release,
        windows_demote,
        "Start the Windows service 'Multimedia Class Scheduler' (MMCSS) and open the studio again.",
    ),
}
if sys.platform not in SYSTEMS:
    from hapkit_studio.haptics import realtime_linux as linux

    SYSTEMS[sys.platform] = System(
        linux.obtain, linux.release, linux.demote, linux.HOW_TO_GET_MORE, linux.FIFO_LEVEL, linux.is_realtime
    )
_system = SYSTEMS[sys.platform]
release, demote = _system.release, _system.demote


@dataclass(frozen=True)
class Priority:
    """A description of the priority, such as "Real-time priority (level 80 of 99)".

    It also states how to get a higher priority; this text may be empty.
    """

    text: str
    realtime: bool = False
    how: str = ""
    level: int = 0


def obtain() -> Priority:
    """Raise the calling thread's priority; call this after compiling everything, just before the loop."""
    text, level = _system.obtain()
    return Priority(text, level > 0, "" if level >= _system.enough else _system.how_to_get_more, level)


def current(obtained: Priority, thread: int) -> Priority:
    """Return the current priority; the system may have demoted a thread that did not block."""
    if not obtained.realtime or _system.is_realtime(thread):
        return obtained
    return Priority("Normal priority, lowered by the system", how="Lower the servo rate, then connect again.")


def probe() -> Priority:
    """Return the priority that a loop would obtain if it started now; a separate thread tries this."""
    with Worker("hapkit-priority") as worker:
        found = worker.submit(obtain).result()
        worker.submit(release)
    return found


def report() -> str:
    """Return a description of the priority of this user's loop, and how to get a higher one."""
    now = probe()
    lines = [f"For this user, the loop runs with: {now.text}."]
    if now.how:
        lines.append(now.how)
    if sys.platform == "linux" and now.how:
        lines += [
            "",
            "Choose one of these ways. The first one takes effect at your next login:",
            '    echo "$USER - rtprio 80" | sudo tee /etc/security/limits.d/hapkit-studio.conf',
            '    echo "$USER - memlock unlimited" | sudo tee -a /etc/security/limits.d/hapkit-studio.conf',
            "or (at once, up to priority 20, needs a desktop session):",
            "    sudo apt-get install rtkit",
        ]
    return "\n".join(lines)
