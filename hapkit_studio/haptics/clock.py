"""The loop's clocks and its sleep: three compiled functions per operating system, without the GIL.

``now()`` returns monotonic seconds (the clock of ``time.perf_counter``). ``until(deadline)`` sleeps until the
deadline, and returns at once if the deadline has passed. ``thread_time()`` returns the processor time used by
the calling thread (the clock of ``time.thread_time``), without the time in which other threads run. All
functions can be called from compiled code and from Python.
"""

import sys
import time

from numba import config

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.haptics import clib

_CLOCK_MONOTONIC = 1
_LINUX_THREAD_CPUTIME, _DARWIN_THREAD_CPUTIME = 3, 16
_TIMER_ABSTIME = 1
_EINTR = 4
_HIGH_RESOLUTION_TIMER = 2
_TIMER_ALL_ACCESS = 0x1F0003
_INFINITE = 0xFFFFFFFF


@compiled
def linux_now() -> float:
    """Return CLOCK_MONOTONIC in s."""
    spec = clib.word_pair()
    clib.clock_gettime(_CLOCK_MONOTONIC, spec)
    return clib.get_word(spec, 0) + 1e-9 * clib.get_word(spec, 1)


@compiled
def linux_thread_time() -> float:
    """Return CLOCK_THREAD_CPUTIME_ID in s; this system call takes about 0.2 µs."""
    spec = clib.word_pair()
    clib.clock_gettime(_LINUX_THREAD_CPUTIME, spec)
    return clib.get_word(spec, 0) + 1e-9 * clib.get_word(spec, 1)


@compiled
def linux_until(deadline: float) -> None:
    """Sleep until an absolute time in s; signals do not interrupt the sleep (clock_nanosleep(2))."""
    if not deadline > 0.0:
        return
    spec = clib.word_pair()
    seconds = int(deadline)
    clib.set_word(spec, 0, seconds)
    clib.set_word(spec, 1, min(int((deadline - seconds) * 1e9), 999_999_999))
    while clib.clock_nanosleep(_CLOCK_MONOTONIC, _TIMER_ABSTIME, spec, 0) == _EINTR:
        pass


@compiled
def macos_tick() -> float:
    """Return a Mach tick in s; mach_timebase_info returns two uint32: numerator and denominator."""
    pair = clib.word_pair()
    clib.mach_timebase_info(pair)
    word = clib.get_word(pair, 0)
    return 1e-9 * (word & 0xFFFFFFFF) / ((word >> 32) & 0xFFFFFFFF)


@compiled
def macos_now() -> float:
    """Return Mach's absolute time in s."""
    return clib.mach_absolute_time() * macos_tick()


@compiled
def macos_thread_time() -> float:
    """Return CLOCK_THREAD_CPUTIME_ID in s."""
    spec = clib.word_pair()
    clib.clock_gettime(_DARWIN_THREAD_CPUTIME, spec)
    return clib.get_word(spec, 0) + 1e-9 * clib.get_word(spec, 1)


@compiled
def macos_until(deadline: float) -> None:
    """Sleep until an absolute time in s (mach_wait_until)."""
    if deadline > 0.0:
        clib.mach_wait_until(int(deadline / macos_tick()))


@compiled
def windows_now() -> float:
    """Return the performance counter in s."""
    pair = clib.word_pair()
    clib.QueryPerformanceCounter(pair)
    clib.QueryPerformanceFrequency(pair + 8)
    return clib.get_word(pair, 0) / clib.get_word(pair, 1)


@compiled
def windows_thread_time() -> float:
    """Return kernel and user time in s, in steps of the system's tick of 15.6 ms (GetThreadTimes)."""
    life, used = clib.word_pair(), clib.word_pair()
    clib.GetThreadTimes(clib.GetCurrentThread(), life, life + 8, used, used + 8)
    return 1e-7 * (clib.get_word(used, 0) + clib.get_word(used, 1))


@compiled
def windows_until(deadline: float) -> None:
    """Sleep until an absolute time in s with a high-resolution waitable timer, in steps of 100 ns."""
    remaining = int((deadline - windows_now()) * 1e7)
    if remaining <= 0:
        return
    due = clib.word_pair()
    clib.set_word(due, 0, -remaining)
    timer = clib.CreateWaitableTimerExW(0, 0, _HIGH_RESOLUTION_TIMER, _TIMER_ALL_ACCESS)
    clib.SetWaitableTimer(timer, due, 0, 0, 0, 0)
    clib.WaitForSingleObject(timer, _INFINITE)
    clib.CloseHandle(timer)


if config.DISABLE_JIT:
    now, until = time.perf_counter, lambda deadline: time.sleep(max(0.0, deadline - time.perf_counter()))
    thread_time = time.thread_time
elif sys.platform == "darwin":
    now, until, thread_time = macos_now, macos_until, macos_thread_time
elif sys.platform == "win32":
    now, until, thread_time = windows_now, windows_until, windows_thread_time
else:
    now, until, thread_time = linux_now, linux_until, linux_thread_time
