"""On each operating system, clock and sleep use absolute times, release the GIL, and work in cached code."""

import ctypes
import os
import struct
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from numba import njit

from hapkit_studio.haptics import clock
from hapkit_studio.haptics.clib import load_acquire, store_release
from tests.haptics.support import FakeLibrary
from tests.waiting import shortest, wait_until

linux_only = pytest.mark.skipif(sys.platform != "linux", reason="would replace the system's own functions")


def test_the_clock_is_the_performance_counter():
    before = time.perf_counter()
    between = clock.now()
    assert before <= between <= time.perf_counter()


def test_a_threads_processor_time_stops_while_it_sleeps():
    clock.until(clock.thread_time())  # this call ensures that the function is compiled or loaded
    before = time.thread_time()
    between = clock.thread_time()
    clock.until(clock.now() + 0.02)
    after = clock.thread_time()
    assert before <= between <= after <= time.thread_time()
    assert after - between < 0.01


def test_it_never_wakes_early_and_returns_at_once_after_a_past_deadline():
    for pause in (0.0, 1e-4, 2e-3):
        deadline = clock.now() + pause
        clock.until(deadline)
        assert clock.now() >= deadline

    def late():
        start = clock.now()
        for past in (start - 1.0, 0.0, -5.0, float("nan")):
            clock.until(past)
        return clock.now() - start

    assert shortest(late, 0.5) < 0.5


def test_sleep_releases_the_gil():
    """A thread sleeps repeatedly until it is told to stop.

    If it held the GIL, it would stop all other threads.
    """

    @njit(nogil=True)
    def sleep_on(words, most):
        for k in range(most):
            clock.until(clock.now() + 1e-3)
            words[1] = k + 1
            if load_acquire(words, 0):
                return

    words, most = np.zeros(2, dtype=np.int64), 20_000
    sleep_on(words, 0)
    thread = threading.Thread(target=sleep_on, args=(words, most))
    thread.start()
    wait_until(lambda: words[1] > 0)
    store_release(words, 0, 1)
    thread.join()
    assert words[1] < most


@pytest.mark.slow
def test_it_runs_uncompiled():
    code = (
        "from hapkit_studio.haptics import clib, clock; t = clock.now() + 0.01; clock.until(t);"
        "print(clock.now() >= t, clib.poll(0, 0, 0))"
    )
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.stdout.strip() == "True 0", done.stderr


def fill(address, form, *numbers):
    """Write 8 bytes to an address, like a C function that returns a value through a pointer."""
    ctypes.memmove(address, struct.pack(form, *numbers), 8)
    return 1


u64, u32, i32 = ctypes.c_uint64, ctypes.c_uint32, ctypes.c_int32


@linux_only
def test_macos_waits_for_the_deadlines_tick():
    fake = FakeLibrary()
    fake.add("mach_timebase_info", i32, u64)(lambda address: fill(address, "II", 125, 3))
    fake.add("mach_absolute_time", u64)(lambda: 24_000_000)
    fake.add("mach_wait_until", i32, u64)(lambda tick: 0)
    assert clock.macos_now() == pytest.approx(1.0, rel=1e-12)
    clock.macos_until(2.5)
    assert fake.calls[-1][0] == "mach_wait_until"
    assert fake.calls[-1][1] == pytest.approx(60_000_000, abs=1)
    before = len(fake.calls)
    clock.macos_until(float("nan"))
    assert len(fake.calls) == before


@linux_only
def test_windows_adds_kernel_and_user_time():
    fake = FakeLibrary()
    fake.add("GetCurrentThread", u64)(lambda: 0x44)

    def times(thread, created, ended, kernel, user):
        fill(kernel, "q", 2_000_000)
        return fill(user, "q", 5_000_000)

    fake.add("GetThreadTimes", i32, u64, u64, u64, u64, u64)(times)
    assert clock.windows_thread_time() == pytest.approx(0.7)
    assert fake.calls[-1][:2] == ("GetThreadTimes", 0x44)


@linux_only
def test_windows_waits_for_the_remaining_time_on_a_high_resolution_timer():
    fake, due = FakeLibrary(), []

    def set_timer(timer, address, period, routine, argument, resume):
        due.append(struct.unpack("q", ctypes.string_at(address, 8))[0])
        return 1

    fake.add("QueryPerformanceFrequency", i32, u64)(lambda address: fill(address, "q", 10_000_000))
    fake.add("QueryPerformanceCounter", i32, u64)(lambda address: fill(address, "q", 70_000_000))
    fake.add("CreateWaitableTimerExW", u64, u64, u64, u32, u32)(lambda *given: 0x44)
    fake.add("SetWaitableTimer", i32, u64, u64, i32, u64, u64, i32)(set_timer)
    fake.add("WaitForSingleObject", u32, u64, u32)(lambda handle, milliseconds: 0)
    fake.add("CloseHandle", i32, u64)(lambda handle: 1)
    assert clock.windows_now() == 7.0
    fake.calls.clear()
    clock.windows_until(7.0015)
    names = [call[0] for call in fake.calls if not call[0].startswith("Query")]
    assert names == ["CreateWaitableTimerExW", "SetWaitableTimer", "WaitForSingleObject", "CloseHandle"]
    assert due == [pytest.approx(-15_000, abs=1)]
    assert ("CreateWaitableTimerExW", 0, 0, 2, 0x1F0003) in fake.calls
    assert all(call[1] == 0x44 for call in fake.calls if call[0] in names[1:])
    fake.calls.clear()
    clock.windows_until(6.9)
    assert {call[0] for call in fake.calls} <= {"QueryPerformanceFrequency", "QueryPerformanceCounter"}
